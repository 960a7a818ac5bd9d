"""The table of several representations: means, ranks and agreement by hand, gaps, and what cannot be compared."""

import csv

import numpy as np
import pytest

from avs.report.collect import Episodes
from avs.report.formats.markdown import document_markdown
from avs.report.tables.representation_agreement import representation_agreement, write_agnostic_table
from avs.report.tables.representation_agreement_numbers import bootstrap_interval, chance_of_agreement
from avs.system.errors import UserError
from avs.system.reasons import Reason
from tests.report.test_setting_sensitivity import BASE, METHODS, SWAPPED, episodes_of, listed, marks_of


def document_of(episode, second=None, absent=None, first=None, **found):
    episodes = {
        "first": first or episodes_of(episode, BASE),
        "second": second or episodes_of(episode, SWAPPED),
        **found,
    }
    return representation_agreement(episodes, METHODS, "orbit", absent or {name: {} for name in episodes})


def test_means_ranks_and_agreement_by_hand(episode):
    document = document_of(episode)
    rows = {(row["representation"], row["method"]): row for row in listed(document.listing)}
    assert [rows["first", method]["rank"] for method in METHODS] == [4, 3, 2, 1]
    assert [rows["second", method]["rank"] for method in METHODS] == [3, 4, 2, 1]
    assert rows["first", "farthest"]["psnr"] == "21.2000"
    (order,) = listed(document.appendices["_agreement"])
    assert (order["first"], order["second"], order["kendall"]) == ("first", "second", "0.6667")  # (5 - 1) / 6
    assert order["chance"] == "0.1667"  # of 24 orders, 1 has no inversion and 3 have one
    assert order["low"] == ""
    text = document_markdown(document)
    assert "no interval of fewer than 3 scenes" in text
    assert "Incomplete" not in text


def test_a_missing_episode_is_a_reason_in_its_cell_and_no_mean_of_the_rest(episode):
    why = {"piqe": {("attic", 1): "it was killed"}}
    document = document_of(episode, episodes_of(episode, SWAPPED | {"piqe": (23.0,)}, missing=why))
    (row,) = (row for row in listed(document.listing) if (row["representation"], row["method"]) == ("second", "piqe"))
    assert (row["psnr"], row["ssim"], row["rank"]) == ("", "", "")
    assert row["note"] == "episodes missing: attic with seed 1: it was killed"
    assert document.caption[0] == "Incomplete: 1 of 8 means are missing."


def test_a_gap_on_one_representation_takes_no_mark_from_another(episode):
    first = episodes_of(episode, BASE | {"piqe": (23.0,)}, missing={"piqe": {("attic", 1): "it was killed"}})
    document = document_of(episode, first=first)
    rows = {(row["representation"], row["method"]): row for row in listed(document.listing)}
    assert [rows["first", method]["rank"] for method in METHODS] == [3, 2, 1, ""]
    assert [rows["second", method]["rank"] for method in METHODS] == [3, 4, 2, 1]
    marks = marks_of(document)
    assert (marks["piqe"][0], marks["piqe"][4]) == (None, 1)
    assert (marks["fisherrf"][0], marks["fisherrf"][4]) == (1, 2)


def test_a_representation_that_a_method_does_not_suit_says_so(episode):
    values = {method: value for method, value in SWAPPED.items() if method != "piqe"}
    absent = {"first": {}, "second": {"piqe": Reason(cause="representation fog lacks light", remedy="add some")}}
    document = document_of(episode, episodes_of(episode, values), absent)
    assert "PIQE (second): representation fog lacks light: add some" in document.notes


def test_a_representation_without_any_episode_keeps_its_columns(episode):
    document = document_of(episode, Episodes("orbit", {}))
    assert all(row["note"].startswith("no episode") for row in listed(document.listing)[4:])
    (order,) = listed(document.appendices["_agreement"])
    assert order["kendall"] == ""


def test_episodes_that_cannot_be_compared_are_refused(episode):
    other = Episodes("orbit", {"random": {("attic", 0): episode("random", scene_hash="another")}})
    with pytest.raises(UserError, match="third, random: was run on another version of the scene attic"):
        document_of(episode, third=other)


def test_the_interval_holds_the_value_of_places_that_agree():
    rng = np.random.default_rng(1)
    means, scenes = np.arange(6.0)[:, None], list("aabbccdd")
    same = [means + rng.normal(0, 0.01, (6, 8)) for _ in range(2)]
    assert bootstrap_interval(*same, scenes) == (1.0, 1.0)
    noisy = [means + rng.normal(0, 5, (6, 8)) for _ in range(2)]
    low, high = bootstrap_interval(*noisy, scenes)
    assert -1 <= low < high <= 1
    assert bootstrap_interval(*noisy, list("aaaabbbb")) is None


def test_seeds_of_a_scene_are_drawn_with_it():
    # Of three scenes, one turns the order of the two methods around, with all of its seeds: by the mean of three draws
    # the second is ahead where that scene came at least twice.
    first = np.array([[0.0] * 9, [1.0] * 6 + [-1.5] * 3])
    low, high = bootstrap_interval(np.array([[0.0] * 9, [1.0] * 9]), first, list("aaabbbccc"))
    assert (low, high) == (-1.0, 1.0)  # 7 of 27 draws; of single places less than 2.5 % would turn it


def test_the_chance_of_agreement_counts_orders():
    assert chance_of_agreement(3, 1.0) == pytest.approx(1 / 6)
    assert chance_of_agreement(4, 2 / 3) == pytest.approx(4 / 24)
    assert chance_of_agreement(6, -1.0) == pytest.approx(1.0)


def test_the_files(episode, written, tmp_path):
    paths = written(episodes_of(episode, BASE).all)
    write_agnostic_table({"first": paths, "second": paths}, METHODS, "orbit", tmp_path / "agnostic_orbit", {})
    with open(tmp_path / "agnostic_orbit_agreement.csv", newline="") as stream:
        assert [row["kendall"] for row in csv.DictReader(stream)] == ["1.0000"]
    assert {path.name for path in tmp_path.glob("agnostic_orbit*")} == {
        f"agnostic_orbit{ending}" for ending in (".csv", ".json", ".md", ".tex", "_agreement.csv", "_per_episode.csv")
    }
