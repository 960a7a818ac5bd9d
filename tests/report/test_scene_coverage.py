"""The coverage table: means, the paper's values, differences, agreement with the truth, and what is missing."""

import csv
import shutil
from pathlib import Path

import pytest

from avs.coverage.coverage_record import CoverageMeta
from avs.report.published import COVERAGE_NAME
from avs.report.tables.episode_entries import FIELDS
from avs.report.tables.scene_coverage import write_coverage_table
from avs.system.errors import UserError
from avs.system.reasons import Reason
from avs.system.records import write_record
from tests.report.coverage_records import SETTINGS, make_coverage, numbers

METHODS = ["farthest", "random", "fisherrf", "ours-repvit"]
PUBLISHED = Path(__file__).resolve().parents[2] / "results" / "published" / COVERAGE_NAME


@pytest.fixture
def table(tmp_path, written):
    """Write the table of pairs of an episode and its coverage, and return the text and the records of its files."""

    def write(pairs, absent=None, lacking=None, published=PUBLISHED, methods=METHODS, dataset="orbit"):
        episodes = written([episode for episode, _ in pairs])
        records = []
        for number, (_, record) in enumerate(pairs):
            if record is not None:
                records.append(tmp_path / "coverage" / f"{number:03d}" / "coverage.json")
                write_record(records[-1], record)
        out = tmp_path / "tables" / "coverage_orbit"
        write_coverage_table(episodes, records, methods, dataset, published, out, absent or {}, lacking, "farthest")
        found = {}
        for suffix in ("", "_per_scene", "_differences", "_agreement"):
            with open(f"{out}{suffix}.csv", newline="") as stream:
                found[suffix] = list(csv.DictReader(stream))
        return out.with_suffix(".md").read_text(), found

    return write


def pair(episode, method, scene="attic", seed=0, views=0, **numbers):
    """An episode whose views differ from those of others by a number, and its coverage."""
    made = episode(method, scene, seed, selected=[f"{views}.png", f"{views + 1}.png"])
    return made, make_coverage(made, **numbers)


def facts(torch):
    return CoverageMeta(
        reconstruction_seconds=1.0,
        total_seconds=1.0,
        peak_memory_bytes=1,
        other_cores=None,
        device="cpu",
        machine={"numerics": "portable"},
        packages={"pycolmap": torch},
        revision=None,
        started="2026-01-01T00:00:00+00:00",
        finished="2026-01-01T00:00:01+00:00",
    )


def test_notes_of_episodes_and_what_computed_the_coverage_are_told(episode, written, tmp_path, table):
    made = [pair(episode, "random", scene) for scene in ("attic", "cellar")]
    noted = [(each.model_copy(update={"notes": ["Random: it is said"]}), record) for each, record in made]
    for number, version in enumerate(("4.2.1", "3.10.0")):
        write_record(tmp_path / "coverage" / f"{number:03d}" / "coverage.meta.json", facts(version))
    text, _ = table(noted)
    assert text.count("- Random: it is said\n") == 1
    assert "- pycolmap differs between records of coverage, and numbers may differ with it: 3.10.0 in 1" in text


def value(records, method, metric, field="mean"):
    return next(each[field] for each in records if (each["method"], each["metric"]) == (method, metric))


def test_means_are_over_scenes_and_seeds(episode, table):
    pairs = [
        pair(episode, "random", scene, seed, 2 * seed, scr=base + 0.1 * seed)
        for scene, base in (("attic", 0.2), ("cellar", 0.6))
        for seed in (0, 1)
    ]
    text, found = table(pairs)
    assert tuple(found[""][0]) == FIELDS
    assert float(value(found[""], "random", "scr_percent")) == pytest.approx(45.0)
    assert float(value(found[""], "random", "true_scr_percent")) == pytest.approx(40.0)
    assert float(value(found[""], "random", "registered_views")) == 6.0
    assert "| Random | **45.00** |" in text
    assert len(found["_per_scene"]) == 4 * 7


def test_the_papers_values_stand_beside_without_a_difference(episode, table):
    text, found = table([pair(episode, "fisherrf", scr=0.5088)])
    assert value(found[""], "fisherrf", "scr_percent", "published") == "50.88"
    assert value(found[""], "ours-repvit", "scr_percent", "published") == "53.89"
    assert value(found[""], "fisherrf", "scr_percent", "difference") == ""
    assert "published, RealEstate10K" in text
    assert "for orientation alone" in text
    assert "its clouds are MASt3R's" in text


def test_differences_are_paired_and_only_of_what_has_a_direction(episode, table):
    pairs = [
        pair(episode, method, scene, seed, scr=base + gain + 0.01 * seed)
        for method, gain in (("farthest", 0.0), ("random", 0.1))
        for scene, base in (("attic", 0.2), ("cellar", 0.6), ("hall", 0.4))
        for seed in (0, 1)
    ]
    _, found = table(pairs)
    rows = [each for each in found["_differences"] if each["metric"] == "scr_percent"]
    assert {float(each["difference"]) for each in rows} == {10.0}
    assert {each["over"] for each in rows} == {"scenes", "seeds"}
    assert not any(each["metric"] in ("cloud_points", "registered_views") for each in found["_differences"])


def test_agreement_with_the_truth_is_that_of_the_ranks_within_scenes(episode, table):
    """In one scene the two go together, in the other against each other; the scenes differ by more."""
    pairs = [
        pair(episode, method, scene, views=10 * step, scr=base + 0.1 * step, true_scr=base + sign * 0.1 * step)
        for scene, base, sign in (("attic", 0.0, 1), ("cellar", 0.5, -1))
        for step, method in enumerate(METHODS)
    ]
    text, found = table(pairs)
    rows = {
        (each["metric"], each["with"], each["scene"]): each["value"]
        for each in found["_agreement"]
        if each["metric"] == "scr_percent"
    }
    assert rows["scr_percent", "true_scr_percent", "attic"] == "1.0000"
    assert rows["scr_percent", "true_scr_percent", "cellar"] == "-1.0000"
    assert rows["scr_percent", "true_scr_percent", "mean over scenes"] == "0.0000"
    assert float(rows["scr_percent", "true_scr_percent", "all together"]) > 0.4
    assert "| Agreement | rho with the truth, within scenes | 0.00 |" in text


def test_equal_views_count_once_in_the_agreement(episode, table):
    pairs = [pair(episode, "farthest", seed=seed, scr=0.3, true_scr=0.3) for seed in (0, 1, 2)]
    pairs += [
        pair(episode, "random", seed=seed, views=4 + seed, scr=0.4 + 0.1 * seed, true_scr=0.4 + 0.1 * seed)
        for seed in (0, 1, 2)
    ]
    text, found = table(pairs)
    assert found["_agreement"][0]["count"] == "4"
    assert "FVS: the same views with every seed; so its numbers do not differ between seeds" in text


def test_without_a_true_surface_its_columns_are_left_out(episode, table):
    pairs = [pair(episode, method, views=step, true_scr=None) for step, method in enumerate(METHODS)]
    text, found = table(pairs)
    assert "true SCR" not in text
    assert {each["metric"] for each in found[""]} == {
        "scr_percent",
        "f_score",
        "toolbox_f_score",
        "cloud_points",
        "registered_views",
    }
    assert {each["with"] for each in found["_agreement"]} == {"psnr"}


def test_views_without_a_cloud_count_as_0_and_are_named(episode, table):
    made = episode("random")
    record = make_coverage(
        made,
        points=0,
        registered=[],
        against_reference=numbers(0.0, 0.0),
        notes=["Random, attic, seed 0: no cloud, SCR 0: no matches"],
    )
    text, found = table([(made, record)])
    assert float(value(found[""], "random", "scr_percent")) == 0.0
    assert "Random, attic, seed 0: no cloud, SCR 0: no matches" in text


def test_a_scene_without_a_reference_leaves_its_rows_empty_with_the_reason(episode, table):
    made = episode("random")
    why = {"against_reference": "the reference has no extent: attic: nothing registers"}
    record = make_coverage(made, true_scr=None, against_reference=None, extent=None, curve=[], absent=why)
    text, found = table([(made, record)])
    assert value(found[""], "random", "scr_percent") == ""
    assert "the reference has no extent: attic: nothing registers" in text


def test_a_back_end_that_is_not_here_is_the_reason_of_every_row(episode, table):
    lacking = Reason(cause="mast3r is not installed", remedy="pip install it")
    text, found = table([(episode("random"), None)], lacking=lacking, absent={"fisherrf": Reason(cause="no weights")})
    assert "Not measured: mast3r is not installed: pip install it." in text
    assert value(found[""], "random", "scr_percent", "note") == "mast3r is not installed: pip install it"
    assert value(found[""], "fisherrf", "scr_percent", "published") == "50.88"
    assert value(found[""], "fisherrf", "scr_percent", "note") == "no weights"


def test_residuals_of_alignments_are_told(episode, table):
    made = episode("random")
    placement = {"scale": 2.0, "residual": 0.05, "agreeing": 6, "shared": 6}
    text, _ = table([(made, make_coverage(made, placement=placement))])
    assert "the residual of their centres is 0.500 to 0.500 % of the extent" in text


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"dataset": "captures"}, "is of the data set captures"),
        ({"scene_hash": "another"}, "is of another version of the scene than the episode"),
        ({"views": ["a.png"]}, "is of other views than the episode's"),
        ({"method": "fisherrf"}, "is of an episode that is not here"),
    ],
)
def test_a_record_of_something_else_is_refused(changes, fault, episode, table):
    made = episode("random")
    with pytest.raises(UserError, match=fault):
        table([(made, make_coverage(made, **changes))])


def test_records_of_different_settings_are_refused(episode, table):
    first, second = pair(episode, "random"), pair(episode, "farthest", views=3)
    other = second[1].model_copy(update={"settings": SETTINGS | {"threshold": 0.02}})
    with pytest.raises(UserError, match="was measured with other settings than others"):
        table([first, (second[0], other)])


def test_equal_records_give_equal_bytes_whatever_their_order(episode, table, tmp_path):
    pairs = [pair(episode, method, views=3 * step, scr=0.1 * step) for step, method in enumerate(METHODS)]
    contents = []
    for order in (pairs, pairs[::-1]):
        shutil.rmtree(tmp_path / "tables", ignore_errors=True)
        table(order)
        contents.append({path.name: path.read_bytes() for path in (tmp_path / "tables").iterdir()})
    assert contents[0] == contents[1]
    assert len(contents[0]) == 7
