"""Which methods and scenes run under variants of the settings."""

import pytest

from avs.config.sensitivity_settings import SensitivitySettings
from avs.config.studied import studied_scenes
from avs.system.errors import UserError

SCENES = {"orbit": ["orbit_0", "orbit_1"], "captures": ["fox"]}


def settings(**changes):
    return SensitivitySettings.model_validate({"methods": ["random"], "variants": {"few": {}}} | changes)


def test_all_scenes_or_those_named():
    assert studied_scenes(None, SCENES) == {}
    assert studied_scenes(settings(), SCENES) == SCENES
    assert studied_scenes(settings(scenes=["orbit_1"]), SCENES) == {"orbit": ["orbit_1"]}


def test_a_scene_that_is_not_evaluated_is_one_line():
    with pytest.raises(UserError, match=r"sensitivity\.scenes: attic is not evaluated; name some of fox, orbit_0"):
        studied_scenes(settings(scenes=["attic"]), SCENES)
