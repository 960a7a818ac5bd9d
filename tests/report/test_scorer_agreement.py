"""The table of scorers, from made-up records."""

import csv

import numpy as np
import pytest

from avs.iqa.held_out.held_out_record import HeldOutScores, Scored
from avs.iqa.held_out.held_out_settings import HeldOutJob, ScoredMetric
from avs.report.formats.markdown import document_markdown
from avs.report.tables.scorer_agreement import scorer_agreement, write_scorer_table
from avs.report.tables.scorer_agreement_numbers import over_scenes, scene_numbers
from avs.system.computed_by import ComputedBy
from avs.system.errors import UserError
from avs.system.reasons import Reason
from avs.system.records import write_record

SETTINGS = HeldOutJob.model_validate(
    {"device": "cpu", "evaluation": {}, "networks": [], "metrics": [], "statistics": None}
)


def record(scene="a_1", dataset="a_held_out", seed=0, **predictors):
    """Return a record of three moments of five candidates and two captured views each; quality rises with moments."""
    rng = np.random.default_rng(seed)
    moment = np.repeat(np.arange(3), 7)
    candidate = np.tile([True] * 5 + [False] * 2, 3)
    ssim = 0.2 * moment + 0.1 * rng.random(21)
    scored = [
        Scored(identifier=name, label=name, kind=kind, worst=worst, scores=np.asarray(values(ssim, moment)).tolist())
        for name, (kind, worst, values) in predictors.items()
    ]
    return HeldOutScores(
        dataset=dataset,
        scene=scene,
        scene_hash="0" * 64,
        other_scene="other",
        settings=SETTINGS,
        moment=moment.tolist(),
        candidate=candidate.tolist(),
        ssim=ssim.tolist(),
        scored=scored,
    )


PERFECT = {"perfect": ("network", "lowest", lambda ssim, moment: ssim)}
REVERSED = {"reversed": ("metric", "highest", lambda ssim, moment: -ssim)}
MOMENTS = {"moments": ("plain", "lowest", lambda ssim, moment: moment)}
WITHIN = {"within": ("regression", "lowest", lambda ssim, moment: ssim - 0.6 * moment)}
ALL = {**PERFECT, **REVERSED, **MOMENTS, **WITHIN}


def numbers(found, name):
    return scene_numbers(found, next(each for each in found.scored if each.identifier == name))


def test_numbers_know_the_direction_of_a_score():
    found = record(**ALL)
    for name in ("perfect", "reversed"):
        values = numbers(found, name)
        for statistic in ("within", "within_kendall", "spearman", "kendall", "pearson"):
            assert values[statistic] == pytest.approx(1)


def test_moments_alone_order_renderings_and_no_candidates():
    values = numbers(record(**ALL), "moments")
    assert values["spearman"] > 0.9
    assert values["within"] is None  # all scores of a moment are equal


def test_order_within_moments_does_not_depend_on_their_levels():
    values = numbers(record(**ALL), "within")
    assert values["within"] == pytest.approx(1)
    assert values["spearman"] < 0


def test_captured_views_have_no_part_in_the_choice():
    found = record(**PERFECT)
    scores = [score if candidate else 9.0 for score, candidate in zip(found.ssim, found.candidate, strict=True)]
    found.scored[0] = found.scored[0].model_copy(update={"scores": scores})
    assert numbers(found, "perfect")["within"] == pytest.approx(1)


def test_an_error_needs_three_scenes_and_a_mean_all_of_them():
    assert over_scenes([0.1, 0.3]).error is None
    assert over_scenes([0.1, 0.2, 0.3]).error == pytest.approx(0.1 / np.sqrt(3))
    assert over_scenes([0.1, None]).mean is None


def records():
    return [
        record("a_1", seed=1, **ALL),
        record("a_2", seed=2, **ALL),
        record("b_1", "b_held_out", seed=3, **ALL),
    ]


def test_absent_methods_keep_their_rows_with_the_reason():
    absent = {"musiq": Reason(cause="weights musiq absent", remedy="fetch them")}
    text = document_markdown(scorer_agreement(records(), ["musiq"], absent))
    assert "| MUSIQ | weights musiq absent |" in text
    assert "- MUSIQ: weights musiq absent: fetch them" in text


def test_columns_by_data_set_come_where_there_are_several():
    assert [column.metric.name for column in scorer_agreement(records(), [], {}).columns][-2:] == ["a", "b"]
    one = scorer_agreement(records()[:2], [], {})
    assert [column.metric.identifier for column in one.columns][-1] == "within"


def test_other_references_compete_with_nothing():
    best = {"best": ("references", "lowest", lambda ssim, moment: ssim)}
    document = scorer_agreement([record(**WITHIN, **best)], [], {})
    by_group = {group.name: group.rows[0].cells for group in document.groups}
    assert by_group["Regressions on render statistics"][5].rank == 1
    assert all(cell.rank is None for cell in by_group["Networks with other references"])


def test_a_mean_over_other_moments_is_told_and_has_no_rank():
    steady = {"steady": ("metric", "lowest", lambda ssim, moment: np.where(moment == 1, ssim, 1.0))}
    found = [record("a_1", **WITHIN, **steady), record("b_1", "b_held_out", **WITHIN, **PERFECT)]
    found[1].scored[1] = found[1].scored[1].model_copy(update={"identifier": "steady", "kind": "metric"})
    document = scorer_agreement(found, [], {})
    rows = {row.identifier: row.cells for group in document.groups for row in group.rows}
    names = [column.metric.identifier for column in document.columns]
    ranks = {name: rows["steady"][names.index(name)].rank for name in names}
    assert rows["steady"][names.index("within")].value == pytest.approx(1)
    assert (ranks["within"], ranks["within_a_held_out"], ranks["within_b_held_out"]) == (None, None, 1)
    line = "within moments of 4 of 6; at the others it gives all candidates one score"
    assert f"steady: {line}; no rank" in document.notes
    told = {tuple(each[i] for i in (0, 3, 4)): each[-1] for each in document.listing.records}
    assert told["steady", "all data sets", "within"] == line
    assert told["steady", "all data sets", "pearson"] == told["steady", "b_held_out", "within"] == ""


def test_a_data_set_may_be_called_all():
    found = scorer_agreement([record("a_1", "all", **WITHIN), record("b_1", seed=1, **WITHIN)], [], {})
    assert [column.metric.name for column in found.columns][-2:] == ["all", "a"]


def write(folder, found):
    paths = [folder / f"{number}.json" for number in range(len(found))]
    for path, each in zip(paths, found, strict=True):
        write_record(path, each)
    return paths


def test_files_hold_every_number(tmp_path):
    paths = write(tmp_path, records())
    scenes = {"a_held_out": ["a_1", "a_2"], "b_held_out": ["b_1"]}
    for order in (paths, paths[::-1]):
        write_scorer_table(order, scenes, [], tmp_path / "scorer", {})
        texts = [(tmp_path / f"scorer{ending}").read_text() for ending in (".csv", ".md", ".tex", "_per_scene.csv")]
    rows = list(csv.DictReader(texts[0].splitlines()))
    within = {row["scenes_of"]: row for row in rows if (row["predictor"], row["metric"]) == ("within", "within")}
    assert within["all data sets"]["mean"] == "1.0000"
    assert within["all data sets"]["scenes"] == "3"
    assert within["a_held_out"]["standard_error"] == ""
    listed = list(csv.DictReader(texts[3].splitlines()))
    assert {row["scene"] for row in listed} == {"a_1", "a_2", "b_1"}
    assert "within a moment" in texts[2]


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"scene": "c_1"}, "the records are of others than the table is"),
        ({"settings": SETTINGS.model_copy(update={"device": "cuda"})}, "other settings or weights"),
        ({"scored": []}, "other settings or weights"),
    ],
)
def test_records_that_do_not_belong_together_are_refused(changes, fault, tmp_path):
    found = records()[:2]
    found[1] = found[1].model_copy(update=changes)
    with pytest.raises(UserError, match=fault):
        write_scorer_table(write(tmp_path, found), {"a_held_out": ["a_1", "a_2"]}, [], tmp_path / "scorer", {})


def test_what_scores_say_of_themselves_settings_and_versions_are_told(tmp_path):
    told = SETTINGS.model_copy(
        update={"metrics": (ScoredMetric(method="niqe", selector={"resize": {"side": "long", "pixels": 56}}),)}
    )
    made = record(niqe=("metric", "highest", lambda ssim, moment: -ssim))
    noted = made.scored[0].model_copy(update={"label": "NIQE", "notes": ["NIQE: fitted to 9 photographs"]})
    records = [
        made.model_copy(update={"scored": [noted], "settings": told, "scene": scene}) for scene in ("a_1", "a_2")
    ]
    paths = write(tmp_path, records)
    for path, numerics in zip(paths, ("native", "portable"), strict=True):
        facts = ComputedBy(device="cpu", machine={"numerics": numerics}, packages={"pyiqa": numerics}, revision=None)
        write_record(path.with_suffix(".meta.json"), facts)
    notes = scorer_agreement(records, ["niqe"], {}, paths).notes
    assert notes.count("NIQE: fitted to 9 photographs") == 1
    assert not any("ten photographs" in note for note in notes)
    shared = scorer_agreement(records, ["niqe"], {}, paths, ["a_held_out"]).notes
    assert any(note.startswith("a_held_out: the scenes trained nothing, but their surfaces show") for note in shared)
    assert "NIQE, not as by default: resize.pixels 56 instead of 518" in notes
    assert any(note.startswith("1 of 2 computed with native numerics") for note in notes)
    for name in ("numerics", "pyiqa"):
        assert any(note.startswith(f"{name} differs between records of held-out scenes") for note in notes)
