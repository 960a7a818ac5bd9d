"""The sensitivity table: means, ranks, agreement of the orders by hand; gaps with their reason; equal bytes."""

import csv
import re

import pytest

from avs.report.collect import Episodes
from avs.report.formats.markdown import document_markdown
from avs.report.tables.setting_sensitivity import setting_sensitivity, write_sensitivity_table
from avs.selection.contract import OWN_SCHEDULE, UNRANKED
from avs.system.errors import UserError
from avs.system.reasons import Reason

METHODS = ("random", "farthest", "fisherrf", "piqe")
BASE = {"random": (20.0, 20.2), "farthest": (21.0, 21.4), "fisherrf": (22.0, 22.0), "piqe": (23.0, 23.0)}
SWAPPED = BASE | {"random": (21.3, 21.5), "farthest": (21.0, 21.4)}  # one of six pairs


def episodes_of(episode, values, scenes=("attic",), missing=None):
    """One episode a method, scene and seed, from each method's PSNR by seed."""
    cells = {
        method: {
            (scene, seed): episode(method, scene, seed, psnr=(value, value))
            for scene in scenes
            for seed, value in enumerate(by_seed)
        }
        for method, by_seed in values.items()
    }
    return Episodes("orbit", cells, missing or {})


def marks_of(document):
    """Return the ranks of the cells of each row, by the method."""
    return {row.identifier: [cell.rank for cell in row.cells] for group in document.groups for row in group.rows}


def listed(listing):
    return [dict(zip(listing.fields, record, strict=True)) for record in listing.records]


def test_means_ranks_and_agreement_by_hand(episode):
    document = setting_sensitivity(episodes_of(episode, BASE), {"other": episodes_of(episode, SWAPPED)}, METHODS, {})
    rows = {(row["setting"], row["method"]): row for row in listed(document.listing)}
    assert [rows["base", method]["rank"] for method in METHODS] == [4, 3, 2, 1]
    assert [rows["other", method]["rank"] for method in METHODS] == [3, 4, 2, 1]
    assert rows["base", "farthest"]["psnr"] == "21.2000"
    base, other = listed(document.appendices["_agreement"])
    assert (base["kendall_with_base"], other["kendall_with_base"]) == ("", "0.6667")  # (5 - 1) / 6
    assert base["kendall_between_seeds"] == "1.0000"
    # Two seeds that are d apart have the variance d^2 / 2: (0.02 + 0.08 + 0 + 0) / 4.
    assert base["noise"] == "0.1581"
    text = document_markdown(document)
    assert "Kendall's tau with base" in text
    assert "Incomplete" not in text


def test_it_says_what_a_variant_has_otherwise(episode):
    base, other = episodes_of(episode, BASE), episodes_of(episode, SWAPPED)
    for cells in other.cells.values():
        for place, each in cells.items():
            loop, kept = each.protocol | {"budget": 5}, {"kind": "gaussians", "densification": {"max_gaussians": 50}}
            cells[place] = each.model_copy(update={"budget": 5, "protocol": loop, "representation": kept})
    for cells in base.cells.values():
        for place, each in cells.items():
            kept = {"kind": "gaussians", "densification": {"max_gaussians": 90}}
            cells[place] = each.model_copy(update={"protocol": each.protocol | {"budget": 8}, "representation": kept})
    document = setting_sensitivity(base, {"other": other, "same": base}, METHODS, {})
    caption, budget = " ".join(document.caption), base.all[0].budget
    assert re.search(rf"Columns: base, same: .*, {budget} views, .*; other: .*, 5 views, ", caption)
    assert "Representations: base: gaussians, " in caption
    told = "protocol.budget 5 instead of 8, representation.densification.max_gaussians 50 instead of 90"
    assert [note for note in document.notes if "not as base" in note] == [f"other, not as base: {told}"]


def test_a_schedule_of_its_own_under_a_variant_alone_has_no_rank_there(episode):
    other = episodes_of(episode, SWAPPED)
    for place, each in other.cells["piqe"].items():
        other.cells["piqe"][place] = each.model_copy(update={"group": OWN_SCHEDULE, "notes": ["of one colour"]})
    document = setting_sensitivity(episodes_of(episode, BASE), {"other": other}, METHODS, {})
    rows = {(row["setting"], row["method"]): row for row in listed(document.listing)}
    assert [rows["base", method]["rank"] for method in METHODS] == [4, 3, 2, 1]
    assert [rows["other", method]["rank"] for method in METHODS] == [2, 3, 1, ""]
    assert listed(document.appendices["_agreement"])[1]["methods"] == 3
    assert f"other: PIQE: {UNRANKED[OWN_SCHEDULE]}" in document.notes
    assert "other: of one colour" in document.notes


def test_a_missing_episode_is_a_reason_in_its_cell_and_no_mean_of_the_rest(episode):
    why = {"piqe": {("attic", 1): "it was killed"}}
    varied = episodes_of(episode, SWAPPED | {"piqe": (23.0,)}, missing=why)
    document = setting_sensitivity(episodes_of(episode, BASE), {"other": varied}, METHODS, {})
    (row,) = (row for row in listed(document.listing) if (row["setting"], row["method"]) == ("other", "piqe"))
    assert (row["psnr"], row["rank"], row["note"]) == (
        "",
        "",
        "episodes missing: attic with seed 1: it was killed",
    )
    assert document.caption[0] == "Incomplete: 1 of 8 means are missing."
    assert "other: tau compares 3 of 4 methods" in document.notes
    assert "episodes missing" in document_markdown(document)


def test_a_gap_under_the_runs_own_settings_takes_no_mark_from_a_variant(episode):
    base = episodes_of(episode, BASE | {"piqe": (23.0,)}, missing={"piqe": {("attic", 1): "it was killed"}})
    document = setting_sensitivity(base, {"other": episodes_of(episode, SWAPPED)}, METHODS, {})
    rows = {(row["setting"], row["method"]): row for row in listed(document.listing)}
    assert [rows["base", method]["rank"] for method in METHODS] == [3, 2, 1, ""]
    assert [rows["other", method]["rank"] for method in METHODS] == [3, 4, 2, 1]
    marks = marks_of(document)
    assert (marks["piqe"][0], marks["piqe"][2]) == (None, 1)
    assert (marks["fisherrf"][0], marks["fisherrf"][2]) == (1, 2)


def test_a_variant_without_any_episode_keeps_its_columns(episode):
    document = setting_sensitivity(episodes_of(episode, BASE), {"other": Episodes("orbit", {})}, METHODS, {})
    assert all(row["note"].startswith("no episode") for row in listed(document.listing) if row["setting"] == "other")
    assert "other, no tau with base: fewer than 3 methods have both" in document.notes


def test_a_method_that_could_not_run_says_why(episode):
    values = {method: value for method, value in BASE.items() if method != "piqe"}
    found = episodes_of(episode, values)
    absent = {"piqe": Reason(cause="no weights", remedy="fetch them")}
    document = setting_sensitivity(found, {"other": found}, METHODS, absent)
    assert "PIQE: no weights: fetch them" in document.notes


def test_one_seed_tells_nothing_of_noise(episode):
    found = episodes_of(episode, {method: value[:1] for method, value in BASE.items()})
    document = setting_sensitivity(found, {"other": found}, METHODS, {})
    assert listed(document.appendices["_agreement"])[1]["noise"] == ""
    assert "base, no tau between single seeds: one seed" in document.notes


def test_episodes_on_two_versions_of_a_scene_are_refused(episode):
    other = Episodes("orbit", {"random": {("attic", 0): episode("random", scene_hash="another")}})
    with pytest.raises(UserError, match="other, random: was run on another version of the scene attic"):
        setting_sensitivity(episodes_of(episode, BASE), {"other": other}, METHODS, {})


def test_the_files(episode, written, tmp_path):
    paths = written(episodes_of(episode, BASE).all)
    write_sensitivity_table(paths, {"other": paths}, METHODS, "orbit", tmp_path / "sensitivity_orbit", {})
    with open(tmp_path / "sensitivity_orbit_agreement.csv", newline="") as stream:
        assert [row["kendall_with_base"] for row in csv.DictReader(stream)] == ["", "1.0000"]
    assert {path.name for path in tmp_path.glob("sensitivity_orbit*")} == {
        f"sensitivity_orbit{ending}"
        for ending in (".csv", ".json", ".md", ".tex", "_agreement.csv", "_per_episode.csv")
    }
