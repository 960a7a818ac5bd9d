"""Settings of a scorer that would not be heard are refused."""

import pytest
from pydantic import ValidationError

from avs.iqa.cross_reference.scorer_settings import ScorerSettings


@pytest.mark.parametrize(
    ("settings", "fault"),
    [
        ({"network": {"backbone": "tf_efficientnet_lite0"}, "training": {"backbone_tag": "other"}}, "but one set"),
        ({"training": {"backbone_tag": "other", "backbone_weights": "scratch"}}, "scratch takes no weights"),
    ],
)
def test_a_tag_that_names_nothing_is_refused(settings, fault):
    with pytest.raises(ValidationError, match=fault):
        ScorerSettings.model_validate(settings)


def test_a_tag_of_timm_is_taken():
    assert ScorerSettings.model_validate({"training": {"backbone_tag": "dist_300e_in1k"}}).training.backbone_tag
