"""Scenes in rows and methods in columns: values by hand, ranks within a row, the paper's values, what is missing."""

import csv

import pytest

from avs.report.tables.scene_by_scene import write_scene_table
from avs.system.reasons import Reason

PER_SCENE = """table,dataset,scene,method,metric,value
t,mipnerf360,garden,fisherrf,psnr,21.33
t,mipnerf360,garden,fisherrf,ssim,0.61
"""
MEANS = """table,dataset,scene,method,metric,value
t,mipnerf360,mean,fisherrf,psnr,20.34
t,mipnerf360,mean,random,psnr,17.91
"""
METHODS = ("random", "fisherrf", "musiq", "oracle-ssim")
NINE = ("bicycle", "bonsai", "counter", "flowers", "garden", "kitchen", "room", "stump", "treehill")


@pytest.fixture
def table(tmp_path, written):
    def write(episodes, absent=None, left_out=None):
        (tmp_path / "scenes.csv").write_text(PER_SCENE)
        (tmp_path / "means.csv").write_text(MEANS)
        published = [tmp_path / "scenes.csv", tmp_path / "means.csv"]
        out = tmp_path / "tables" / "scenes_orbit"
        write_scene_table(written(episodes), METHODS, "orbit", published, out, absent or {}, left_out)
        with open(f"{out}.csv", newline="") as stream:
            rows = {(row["metric"], row["scene"], row["method"]): row for row in csv.DictReader(stream)}
        return rows, *(out.with_suffix(ending).read_text() for ending in (".md", ".tex"))

    return write


def some(episode):
    found = [
        episode(method, scene, seed, psnr=(base + seed,), ssim=0.5)
        for method, base in (("random", 20.0), ("fisherrf", 22.0))
        for scene in ("attic", "garden")
        for seed in (0, 1)
    ]
    return found + [episode("oracle-ssim", scene, psnr=(30.0,), group="Oracle") for scene in ("attic", "garden")]


def test_values_by_hand(episode, table):
    rows, markdown, latex = table(some(episode), {"musiq": Reason(cause="weights musiq absent", remedy="fetch them")})
    assert rows["psnr", "garden", "fisherrf"]["value"] == "22.5000"
    assert (rows["psnr", "garden", "fisherrf"]["published"], rows["psnr", "garden", "random"]["published"]) == (
        "21.33",
        "",
    )
    assert rows["psnr", "mean over scenes", "oracle-ssim"] | {"published": ""} == {
        "metric": "psnr",
        "scene": "mean over scenes",
        "method": "oracle-ssim",
        "value": "30.0000",
        "seeds": "1",
        "published": "",
    }
    assert rows["psnr", "garden", "musiq"]["value"] == ""
    lines = markdown.splitlines()
    assert "|  | Scene | FisherRF | Random | MUSIQ | oracle-ssim |" in lines
    assert "| PSNR ↑ (dB) | attic | **22.50** | 20.50 (2) | – | 30.00 |" in lines  # noqa: RUF001
    # The digits are the paper's own, also where the column has others.
    assert "|  | published, Mip-NeRF360 | 0.61 | – | – | – |" in lines  # noqa: RUF001
    assert "|  | Mean over scenes | **22.50** | 20.50 (2) | – | 30.00 |" in lines  # noqa: RUF001
    assert "- MUSIQ: weights musiq absent: fetch them" in lines
    assert r"\multirow{4}{*}{PSNR $\uparrow$ (dB)} & attic & \cellcolor[HTML]{F4CCCC}22.50 &" in latex


def test_the_papers_mean_stands_beside_its_own_nine_scenes_alone(episode, table):
    """Those of its methods, too, of which it has no values of single scenes."""
    rows, markdown, _ = table([episode(method, scene) for method in ("fisherrf", "random") for scene in NINE])
    means = {method: rows["psnr", "mean over scenes", method]["published"] for method in ("fisherrf", "random")}
    assert means == {"fisherrf": "20.34", "random": "17.91"}
    assert "the paper's values on garden and their mean" in markdown
    rows, markdown, _ = table([episode("fisherrf", scene) for scene in NINE[1:]])
    assert rows["psnr", "mean over scenes", "fisherrf"]["published"] == ""
    assert "20.34" not in markdown
    assert f"the paper's mean is left out: it is over {', '.join(NINE)}" in markdown


def test_what_the_first_table_tells_of_scenes_and_episodes_stands_here_too(episode, table):
    absent = {"musiq": Reason(cause="weights musiq absent", remedy="fetch them")}
    _, markdown, _ = table(some(episode), absent, {"lost": Reason(cause="is not there", remedy="get it")})
    assert "- left out, lost: is not there: get it" in markdown


def test_a_metric_without_values_says_why_once(episode, table):
    _, markdown, _ = table([episode("random", lpips=None)])
    assert markdown.count("vgg16") == 1
    assert "| LPIPS ↓ | attic | – | – | – | – |" in markdown  # noqa: RUF001


def test_equal_records_give_equal_bytes(episode, table):
    found = some(episode)
    assert table(found)[1:] == table(found[::-1])[1:]


def test_a_scene_may_be_called_mean(episode, table):
    values = {"mean": 10.0, "garden": 20.0}
    rows, markdown, _ = table([episode("fisherrf", scene, psnr=(value,)) for scene, value in values.items()])
    found = {scene: rows["psnr", scene, "fisherrf"] for scene in (*values, "mean over scenes")}
    assert [row["value"] for row in found.values()] == ["10.0000", "20.0000", "15.0000"]
    assert [row["published"] for row in found.values()] == ["", "21.33", ""]
    assert markdown.count("15.00") == 1
