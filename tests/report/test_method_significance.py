"""Which methods differ: by hand on three scenes, honest where there is too little, the diagram of average ranks."""

import csv

import numpy as np
import pytest
from scipy import stats

from avs.report.figures.critical_difference import unseparated, write_critical_difference
from avs.report.published import read_published
from avs.report.tables.method_significance import write_significance_table
from avs.report.tables.significance_numbers import pairs_of
from avs.report.tables.significance_words import PAPER_DIFFERENCE
from avs.system.reasons import Reason
from tests.workflow.project import ROOT

METHODS = ("random", "farthest", "fisherrf", "oracle-ssim", "musiq")
SCENES = ("attic", "cellar", "garden", "hall")


@pytest.fixture
def table(tmp_path, written):
    def write(episodes):
        out = tmp_path / "tables" / "significance_orbit"
        absent = {"musiq": Reason(cause="weights musiq absent", remedy="fetch them")}
        write_significance_table(written(episodes), METHODS, "orbit", out, absent)
        read = []
        for ending in (".csv", "_pairs.csv", "_ranks.csv"):
            with open(f"{out}{ending}", newline="") as stream:
                read.append(list(csv.DictReader(stream)))
        return *read, out.with_suffix(".md").read_text()

    return write


def some(episode, values, seeds=(0,)):
    """One episode for each method, scene and seed; ``values`` are what each seed adds, then those of the scenes."""
    return [
        episode(method, scene, seed, psnr=(value + noise * seed,), group="Oracle" if "oracle" in method else "2D-based")
        for method, (noise, *told) in values.items()
        for scene, value in zip(SCENES, told, strict=False)
        for seed in seeds
    ]


VALUES = {
    "random": (0.0, 20.0, 20.1, 20.0, 20.1),
    "farthest": (0.0, 24.0, 24.0, 24.1, 24.0),
    "fisherrf": (0.0, 24.6, 23.5, 24.0, 24.1),
    "oracle-ssim": (0.0, 30.0, 30.0, 30.0, 30.0),
}


def test_pairs_by_hand(episode, table):
    rows, pairs, ranks, markdown = table(some(episode, VALUES))
    found = {(pair["first"], pair["second"]): pair for pair in pairs if pair["metric"] == "psnr"}
    assert set(found) == {("random", "farthest"), ("random", "fisherrf"), ("farthest", "fisherrf")}
    pair = found["farthest", "fisherrf"]
    differences = np.array([-0.6, 0.5, 0.1, -0.1])
    expected = stats.ttest_1samp(differences, 0.0)
    assert float(pair["difference"]) == pytest.approx(differences.mean(), abs=1e-4)
    assert float(pair["p"]) == pytest.approx(expected.pvalue, rel=1e-2)
    assert float(pair["low"]) == pytest.approx(expected.confidence_interval().low, abs=1e-3)
    assert (pair["over"], pair["differs"], pair["scenes"], pair["seeds"]) == ("scenes", "no", "4", "1")
    assert (pair["scenes_needed"], pair["scenes_needed_high"]) == ("", "")
    assert [found["random", other]["differs"] for other in ("farthest", "fisherrf")] == ["yes", "yes"]
    psnr = {row["method"]: row for row in rows if row["metric"] == "psnr" and row["over"] == "scenes"}
    assert [(psnr[each]["better_than"], psnr[each]["worse_than"]) for each in ("random", "farthest")] == [
        ("0", "2"),
        ("1", "0"),
    ]
    assert psnr["farthest"]["average_rank"] == "1.5000"
    assert psnr["musiq"]["note"] == "weights musiq absent: fetch them"
    assert ranks[0]["scenes"] == "4"
    lines = markdown.splitlines()
    told = "2 of 3 pairs differ, FVS better than Random; FisherRF better than Random; the other 1 cannot be told apart"
    assert f"- on other scenes of this kind (test over scenes): {told}, which does not make them equal" in lines
    assert (
        "- with other seeds on these very scenes (test over seeds): cannot be told, for lack of a second seed" in lines
    )
    assert not any("oracle-ssim" in line for line in lines)


def test_lower_is_better_for_lpips(episode, table):
    episodes = [
        episode(method, scene, lpips=base + 0.001 * number)
        for method, base in (("random", 0.5), ("farthest", 0.3))
        for number, scene in enumerate(SCENES)
    ]
    rows, *_ = table(episodes)
    found = {row["method"]: row for row in rows if row["metric"] == "lpips" and row["over"] == "scenes"}
    assert (found["farthest"]["better_than"], found["farthest"]["average_rank"]) == ("1", "1.0000")


def test_one_scene_and_seed_tell_nothing(episode, table):
    few = {method: told[:2] for method, told in VALUES.items()}
    rows, pairs, ranks, markdown = table(some(episode, few))
    assert {pair["over"] for pair in pairs} == {""}
    assert {row["better_than"] for row in rows} == {""}
    assert ranks[0]["friedman_p"] == ""
    assert "cannot be told, for lack of a second scene" in markdown
    assert "average ranks of one scene are its order alone: no test of them" in markdown
    assert "| FVS | 24.00 (2) | 2.00 (2) | – | – | – | – |" in markdown  # noqa: RUF001


def test_the_paper_s_difference_has_the_scenes_that_it_would_take(episode, table):
    *_, markdown = table(some(episode, VALUES, seeds=(0, 1)))
    paper = read_published(ROOT / "results" / "published" / "nvs_mipnerf360.csv").values
    ours, fisher = (float(paper[method, "psnr"]) for method in ("ours-repvit", "fisherrf"))
    assert round(ours - fisher, 2) == PAPER_DIFFERENCE
    assert "to tell 0.63 dB from zero" in markdown
    assert "with 2 seeds each" in markdown


def test_what_the_published_values_tell_by_themselves():
    """The numbers of docs/tables.md."""
    with open(ROOT / "results" / "published" / "nvs_mipnerf360_per_scene.csv", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["metric"] == "psnr" and row["scene"] != "mean"]
    grid = {row["method"]: {} for row in rows}
    for row in rows:
        grid[row["method"]][row["scene"], 0] = float(row["value"])
    pairs = {(pair.first, pair.second): pair for pair in pairs_of(grid)}
    assert len(pairs) == 45
    found = {pair for pair, each in pairs.items() if each.tests["scenes"].differs}
    assert found == {
        *(("fisherrf", other) for other in ("niqe", "piqe")),
        *(("ours-repvit", other) for other in ("topiq", "tres", "nima", "niqe", "piqe")),
    }
    test, needed = pairs["fisherrf", "ours-repvit"].tests["scenes"], pairs["fisherrf", "ours-repvit"].needed
    told = (-test.interval.difference, -test.interval.high, -test.interval.low, test.p_value, test.corrected)
    assert told == pytest.approx((0.627, 0.183, 1.071, 0.0116, 0.302), abs=5e-4)
    assert (needed.scenes, needed.low, needed.high) == (9, 6, 27)


def test_equal_records_give_equal_bytes(episode, table, tmp_path):
    episodes = some(episode, VALUES)
    contents = []
    for each in (episodes, episodes[::-1]):
        table(each)
        contents.append({path.name: path.read_bytes() for path in (tmp_path / "tables").iterdir()})
    assert contents[0] == contents[1]


def test_bars_are_the_longest_runs_within_the_critical_difference():
    assert unseparated([4.0, 1.0, 2.0, 6.0], 2.5) == [(1.0, 2.0), (2.0, 4.0), (4.0, 6.0)]
    assert unseparated([1.0, 2.0, 3.0], 5.0) == [(1.0, 3.0)]
    assert unseparated([1.0, 3.0], 1.0) == []
    assert unseparated([2.0, 2.0, 2.0], 1.0) == []


@pytest.mark.parametrize("scenes", [1, 4])
def test_the_diagram_is_the_same_to_the_byte(episode, written, tmp_path, scenes):
    few = {method: told[: 1 + scenes] for method, told in VALUES.items()}
    paths, contents = written(some(episode, few)), []
    for name in ("first", "second"):
        out = tmp_path / name / "critical_difference_orbit"
        write_critical_difference(paths if name == "first" else paths[::-1], METHODS, "orbit", out)
        contents.append({path.name: path.read_bytes() for path in out.parent.iterdir()})
    assert contents[0] == contents[1]
    assert len(contents[0]) == 3
    caption = contents[0]["critical_difference_orbit.md"].decode()
    assert ("critical difference" in caption) == (scenes > 1)


def test_a_method_that_lacks_an_episode_has_pairs_and_no_rank(episode, table):
    """Its mean is of other seeds than those of the methods that it would stand among."""
    episodes = some(episode, VALUES, seeds=(0, 1))
    rows, pairs, ranks, markdown = table([each for each in episodes if (each.method, each.seed) != ("farthest", 1)])
    psnr = {row["method"]: row for row in rows if row["metric"] == "psnr" and row["over"] == "scenes"}
    assert {method: psnr[method]["average_rank"] for method in ("random", "farthest", "fisherrf")} == {
        "random": "2.0000",
        "farthest": "",
        "fisherrf": "1.0000",
    }
    assert next(each["methods"] for each in ranks if each["metric"] == "psnr") == "2"
    assert any(pair["first"] == "farthest" for pair in pairs)
    assert "FVS: mean of seed 0 only, not to be ranked" in markdown
    assert "with 1 to 2 seeds each" in markdown
