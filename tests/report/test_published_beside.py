"""Published values beside a table: a difference for the paper's own scenes in its protocol, and for nothing else."""

import pytest

from tests.report.view_synthesis_tables import PUBLISHED, TableWriter


@pytest.fixture
def table(tmp_path, written):
    return TableWriter(tmp_path, written)


NINE = ["bicycle", "bonsai", "counter", "flowers", "garden", "kitchen", "room", "stump", "treehill"]


def in_the_papers_protocol(episode, scenes=NINE, dataset="mipnerf360", **changes):
    protocol = episode("random").protocol | {"budget": 20, "iterations": 30_000} | changes
    return [episode("random", scene, dataset=dataset, protocol=protocol, budget=20) for scene in scenes]


def test_the_papers_scenes_in_its_protocol_have_a_difference(episode, table):
    rows, markdown, _ = table(in_the_papers_protocol(episode), ["random"], PUBLISHED, dataset="mipnerf360")
    assert (rows["random", "psnr"]["published"], rows["random", "psnr"]["difference"]) == ("17.91", "3.0900")
    assert "| PSNR ↑ (dB) | published | difference |" in markdown
    assert "| Random | **21.00** | 17.91 | +3.09 |" in markdown
    assert "the paper's means on Mip-NeRF360, one run without a spread; the difference" in markdown


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"scenes": NINE[:3]}, "its mean is over bicycle, bonsai, counter, flowers, garden, kitchen, room, stump"),
        ({"scenes": [*NINE, "attic"]}, "its mean is over bicycle"),
        ({"dataset": "orbit"}, "orbit has other scenes, with the same kind of camera path"),
        ({"dataset": "captures"}, "captures is another data set"),
        ({"iterations": 2000}, "iterations 2000 in place of 30000"),
    ],
)
def test_published_values_of_what_is_not_the_same_have_no_difference(episode, table, changes, why):
    episodes = in_the_papers_protocol(episode, **changes)
    rows, markdown, latex = table(episodes, ["random"], PUBLISHED, dataset=episodes[0].dataset)
    assert (rows["random", "psnr"]["published"], rows["random", "psnr"]["difference"]) == ("17.91", "")
    assert "| PSNR ↑ (dB) | published, Mip-NeRF360 | SSIM" in markdown
    assert f"for orientation alone: {why}" in markdown
    assert "diff" not in latex.replace("difference", "").replace("different", "")


def test_published_values_stand_only_where_they_are_asked_for(episode, table):
    _, markdown, latex = table([episode("random", dataset="captures")], ["random"], dataset="captures")
    assert "published" not in markdown
    assert "paper" not in latex
