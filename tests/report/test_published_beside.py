"""Published values beside a table: a difference for the paper's own scenes in its protocol, and for nothing else."""

import pytest

from avs.nvs.protocol import ProtocolSettings
from avs.report import published
from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.system.models import flat
from tests.report.view_synthesis_tables import PUBLISHED, TableWriter


@pytest.fixture
def table(tmp_path, written):
    return TableWriter(tmp_path, written)


PROTOCOL = ProtocolSettings().model_dump(mode="json")
REPRESENTATION = GaussianSettings().model_dump(mode="json")
PICTURES = {"source": "mipnerf360", "test_every": 8, "long_side": 1600, "short_side": None, "resample": "pil"}
NINE = ["bicycle", "bonsai", "counter", "flowers", "garden", "kitchen", "room", "stump", "treehill"]


def in_the_papers_protocol(episode, scenes=NINE, dataset="mipnerf360", representation=REPRESENTATION, **changes):
    told = {"protocol": PROTOCOL | changes, "representation": representation, "budget": 20}
    return [episode("random", scene, dataset=dataset, **told) for scene in scenes]


def test_the_papers_reconstruction_is_that_of_the_defaults():
    assert flat(REPRESENTATION) == published._REPRESENTATION


def test_the_papers_scenes_in_its_protocol_have_a_difference(episode, table):
    rows, markdown, _ = table(
        in_the_papers_protocol(episode), ["random"], PUBLISHED, dataset="mipnerf360", pictures=PICTURES
    )
    assert (rows["random", "psnr"]["published"], rows["random", "psnr"]["difference"]) == ("17.91", "3.0900")
    assert "| PSNR ↑ (dB) | published | difference |" in markdown
    assert "| Random | **21.00** | 17.91 | +3.09 |" in markdown
    assert "the paper's means on Mip-NeRF360, one run without a spread; the difference" in markdown


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"scenes": NINE[:3]}, "its mean is over bicycle, bonsai, counter, flowers, garden, kitchen, room, stump"),
        ({"scenes": [*NINE, "attic"]}, "its mean is over bicycle"),
        ({"dataset": "orbit"}, "orbit is a twin, with nothing in common but the kind of camera path"),
        ({"dataset": "captures"}, "captures is another data set"),
        ({"iterations": 2000}, "iterations 2000 in place of 30000"),
        ({"additions": [10, 20]}, "additions at other iterations"),
        ({"views_per_step": 4}, "views_per_step 4 in place of 1"),
        ({"views_per_choice": 4}, "views_per_choice 4 in place of 1"),
        ({"refit": "reinit"}, "refit reinit in place of continue"),
        ({"initial_start": 3}, "initial_start 3 in place of 0"),
        ({"lpips": {"net": "alex", "range": "minus_one"}}, "lpips.net alex in place of"),
        ({"representation": {"kind": "nerfacto"}}, "the paper's representation is gaussians, this one nerfacto"),
        (
            {"representation": REPRESENTATION | {"points": REPRESENTATION["points"] | {"choice": "selected"}}},
            "points.choice selected in place of",
        ),
    ],
)
def test_published_values_of_what_is_not_the_same_have_no_difference(episode, table, changes, why):
    episodes = in_the_papers_protocol(episode, **changes)
    rows, markdown, latex = table(episodes, ["random"], PUBLISHED, dataset=episodes[0].dataset, pictures=PICTURES)
    assert (rows["random", "psnr"]["published"], rows["random", "psnr"]["difference"]) == ("17.91", "")
    assert "| PSNR ↑ (dB) | published, Mip-NeRF360 | SSIM" in markdown
    assert f"for orientation alone: {why}" in markdown
    assert "diff" not in latex.replace("difference", "").replace("different", "")


@pytest.mark.parametrize(
    ("pictures", "why"),
    [
        (PICTURES | {"source": "captures"}, "source captures in place of mipnerf360"),
        (PICTURES | {"test_every": 4, "long_side": 480}, "test_every 4 in place of 8, long_side 480 in place of 1600"),
        (PICTURES | {"long_side": None, "short_side": 300}, "long_side null in place of 1600, short_side 300 in place"),
        ({}, "source is not known, test_every is not known, long_side is not known"),
    ],
)
def test_other_pictures_have_no_difference_to_the_papers(episode, table, pictures, why):
    episodes = in_the_papers_protocol(episode)
    rows, markdown, _ = table(episodes, ["random"], PUBLISHED, dataset="mipnerf360", pictures=pictures)
    assert rows["random", "psnr"]["difference"] == ""
    assert f"for orientation alone: {why}" in markdown


def test_published_values_stand_only_where_they_are_asked_for(episode, table):
    _, markdown, latex = table([episode("random", dataset="captures")], ["random"], dataset="captures")
    assert "published" not in markdown
    assert "paper" not in latex
