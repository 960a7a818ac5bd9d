"""Table and figures of explorations: values beside the paper's, ranks, gaps, equal bytes, records that do not fit."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter

from avs.report.collect_explorations import printed_name, read_explorations
from avs.report.figures.slam_maps import write_slam_maps
from avs.report.figures.slam_over_steps import write_slam_over_steps
from avs.report.incomplete_explorations import WantedExploration, WantedExplorations, incomplete_explorations
from avs.report.tables.active_slam import active_slam, write_active_slam
from avs.slam.loop.exploration_record import (
    MAPS_HEADER,
    CoveragePoint,
    Decision,
    ExplorationMeta,
    ExplorationRecord,
    FinalMeasures,
    PathEntry,
)
from avs.slam.loop.slam_settings import SlamSettings
from avs.slam.scoring.path_settings import PathScorerSettings
from avs.system.errors import UserError
from avs.system.reasons import Reason
from avs.system.records import read_record, write_record
from avs.system.tensor_files import write_tensors

PUBLISHED = Path(__file__).resolve().parents[2] / "results" / "published" / "slam_gibson.csv"
LABELS = {
    "nearest": "Nearest frontier",
    "fisherrf": "FisherRF",
    "ours-repvit": "Ours-RepViT",
    "oracle": "Greedy oracle",
}


def write(
    folder,
    building="flat",
    method="nearest",
    seed=0,
    scr=0.5,
    steps=100,
    digest="a" * 64,
    seconds=1.0,
    area=10.0,
    start=(1, 1, 0, 0),
    label=None,
    kind=None,
    **more,
):
    """Write the records of an exploration, and return the path of the first."""
    kind = kind or (method if method in ("nearest", "oracle", "fisherrf") else "nearest")
    settings = SlamSettings.model_validate({"scorer": {"kind": kind}, "exploration": {"steps": steps}} | more)
    points = [
        CoveragePoint(step=step, scr_means=scr * step / steps, seen=scr, gaussians=10, path_length=1.0)
        for step in (0, steps // 2, steps)
    ]
    final = FinalMeasures(
        scr_means=scr, scr_fused=scr + 0.1, seen=scr + 0.2, scr_area=scr / 2, depth_mae=0.3, psnr=20.0, ssim=0.8,
        empty=0.1, poses=5, trajectory_error=None, path_length=12.0, collisions=1,
    )  # fmt: skip
    path = PathEntry(candidate=1, actions="FF", length=1.0, score=1.0)
    decision = Decision(
        step=72, pose=(1, 1, 0, 0), gaussians=10, frontiers=[], candidates=[(1, 1, 0, 0), (2, 1, 0, 0)],
        frontier_of=[0, 0], endpoint_scores=None, paths=[path], chosen=0, executed=2,
    )  # fmt: skip
    record = ExplorationRecord(
        building=building, building_hash=digest, method=method, label=label or LABELS[method], seed=seed,
        settings=settings.model_dump(mode="json"), start=start, floor_area=area, surface_points=4, steps=steps,
        ended="all actions were done", notes=["a note"], decisions=[decision], curve=points, final=final,
    )  # fmt: skip
    meta = ExplorationMeta(
        seconds={"map": 2.0}, decision_seconds=[seconds], score_seconds=[0.5], memory_bytes=[1], total_seconds=3.0,
        machine={}, packages={}, revision=None, started="", finished="",
    )  # fmt: skip
    out = folder / building / method / str(seed) / "exploration.json"
    write_record(out, record)
    write_record(out.with_name("exploration.meta.json"), meta)
    return out


def choosers(methods):
    """Return what chooses the paths by identifier: the kind of that name, or the method of Task A."""
    kinds = [kind for kind in methods if kind in ("nearest", "random", "oracle", "fisherrf")]
    told = {name: {"kind": name} if name in kinds else {"kind": "selector", "method": name} for name in methods}
    return {name: TypeAdapter(PathScorerSettings).validate_python(each) for name, each in told.items()}


def rows_of(paths, methods, buildings=("flat",)):
    told = methods if isinstance(methods, dict) else choosers(methods)
    document = active_slam(read_explorations(paths), buildings, told, PUBLISHED)
    return {(group.name, row.label): row for group in document.groups for row in group.rows}, document


def test_values_stand_beside_the_papers_without_a_difference(tmp_path):
    rows, document = rows_of([write(tmp_path, method="fisherrf", scr=0.9)], ["fisherrf"])
    cell = rows["flat", "FisherRF"].cells[0]
    assert (cell.value, cell.published, cell.spread) == (pytest.approx(90.0), "92.89", None)
    assert not any(column.difference for column in document.columns)
    assert any("for orientation alone" in note for note in document.notes)
    assert "a note" in document.notes


def test_the_papers_values_are_beside_what_chooses_the_paths_and_not_beside_a_name(tmp_path):
    told = {
        "fisherrf": {"kind": "nearest"},
        "ours-close": {"kind": "selector", "method": "farthest"},
        "far": {"kind": "selector", "method": "ours-repvit"},
        "views": {"kind": "selector", "method": "fisherrf"},
        "released": {"kind": "fisherrf"},
    }
    methods = {name: TypeAdapter(PathScorerSettings).validate_python(each) for name, each in told.items()}
    paths = [write(tmp_path, method=name, label=name, kind="nearest") for name in told if name != "far"]
    rows, _ = rows_of(paths, methods)
    found = {label: (row.cells[0].published, row.proposed, row.identifier) for (_, label), row in rows.items()}
    assert found == {
        "fisherrf": (None, False, ""),
        "ours-close": (None, False, "farthest"),
        "far": ("93.71", True, "ours-repvit"),
        "views": (None, False, "fisherrf"),
        "released": ("92.89", False, "fisherrf"),
    }


def test_a_building_that_cannot_be_read_has_rows_without_values_and_its_reason(tmp_path):
    reason = Reason(cause="own.glb: is no file; check the path")
    document = active_slam(
        read_explorations([write(tmp_path)]), ("own", "flat"), choosers(["nearest"]), PUBLISHED, {}, {"own": reason}
    )
    own, flat = document.groups
    assert (own.name, own.rows[0].cells[0].value, own.rows[0].cells[0].cause) == ("own", None, "building not read")
    assert flat.rows[0].cells[0].value == pytest.approx(50.0)
    assert f"own: {reason}" in document.notes


def test_seeds_have_a_mean_and_a_spread_and_the_oracle_no_rank(tmp_path):
    paths = [write(tmp_path, seed=seed, scr=scr) for seed, scr in ((0, 0.4), (1, 0.6), (2, 0.5))]
    two, _ = rows_of(paths[:2], ["nearest"])
    assert two["flat", "Nearest frontier"].cells[0].spread is None
    paths += [write(tmp_path, method="oracle", seed=seed, scr=0.9) for seed in (0, 1, 2)]
    rows, _ = rows_of(paths, ["nearest", "oracle"])
    cell = rows["flat", "Nearest frontier"].cells[0]
    assert (cell.value, cell.rank) == (pytest.approx(50.0), 1)
    assert cell.spread == pytest.approx(np.std([40, 60, 50], ddof=1))
    assert rows["flat", "Greedy oracle"].cells[0].rank is None


def test_other_packages_of_some_explorations_are_told_of(tmp_path):
    paths = [write(tmp_path, seed=seed) for seed in (0, 1)]
    meta = paths[1].with_name("exploration.meta.json")
    told = read_record(meta, ExplorationMeta)
    write_record(meta, told.model_copy(update={"packages": told.packages | {"torch": "0.1"}}))
    _, document = rows_of(paths, ["nearest"])
    assert any(note.startswith("torch differs between explorations") for note in document.notes)


def test_means_over_different_storeys_are_told_of(tmp_path):
    paths = [
        write(tmp_path, seed=seed, start=(1, seed, 0, 0), area=area) for seed, area in ((0, 10.0), (1, 20.0), (2, 10.0))
    ]
    _, document = rows_of(paths, ["nearest"])
    assert any("flat: seeds start on different storeys (10.0, 20.0 square metres)" in note for note in document.notes)
    assert "each with a start of its own" in document.caption[-1]
    _, document = rows_of([write(tmp_path, seed=seed) for seed in (0, 1, 2)], ["nearest"])
    assert not any("storeys" in note for note in document.notes)
    assert "not all with a start of their own" in document.caption[-1]


def test_settings_of_what_chooses_that_are_not_the_defaults_are_told(tmp_path):
    fisher = {"kind": "fisherrf", "endpoint_weight": 0.0, "keyframes": 16}
    ours = {"kind": "selector", "method": "farthest", "aggregate": "worst"}
    niqe = {"kind": "selector", "method": "niqe", "settings": {"resize": {"side": "long", "pixels": 160}}}
    paths = [
        write(tmp_path, method=str(number), label=label, scorer=scorer)
        for number, (label, scorer) in enumerate(
            {"FisherRF": fisher, "FVS": ours, "NIQE": niqe, "Plain": {"kind": "fisherrf"}}.items()
        )
    ]
    _, document = rows_of(paths, choosers(["nearest"]))
    told = [note for note in document.notes if "not as by default" in note]
    assert told[:2] == [
        "FisherRF, not as by default: endpoint_weight 0.0 instead of 30.0, keyframes 16 instead of None",
        "FVS, not as by default: aggregate worst instead of mean",
    ]
    assert told[2].startswith("NIQE, not as by default: resize.")
    assert len(told) == 3


def test_a_method_that_chose_nothing_has_no_rank(tmp_path):
    paths = [write(tmp_path, scr=0.9), write(tmp_path, method="fisherrf", scr=0.5)]
    record = read_record(paths[0], ExplorationRecord)
    write_record(paths[0], record.model_copy(update={"decisions": [], "ended": "no way is left"}))
    rows, document = rows_of(paths, ["nearest", "fisherrf"])
    assert [rows["flat", label].cells[0].rank for label in ("Nearest frontier", "FisherRF")] == [None, 1]
    told = "Nearest frontier in flat: chose no path with any seed, so that its row has no rank; no way is left"
    assert told in document.notes


def test_methods_of_one_name_are_told_apart(tmp_path):
    paths = [write(tmp_path, method=method, label="FisherRF") for method in ("nearest", "fisherrf")]
    rows, _ = rows_of([*paths, write(tmp_path, method="oracle")], ["nearest", "fisherrf", "oracle"])
    assert {label for _, label in rows} == {"FisherRF (nearest)", "FisherRF (fisherrf)", "Greedy oracle"}
    records = [read_record(path, ExplorationRecord) for path in paths]
    assert printed_name("nearest", records) == "FisherRF (nearest)"  # on the maps
    assert printed_name("nearest", records[:1]) == "FisherRF"


def test_a_method_without_a_record_keeps_its_row(tmp_path):
    rows, _ = rows_of([write(tmp_path)], ["nearest", "ours-repvit"])
    assert rows["flat", "ours-repvit"].cells[0].cause == "no exploration"
    assert rows["flat", "ours-repvit"].cells[0].published == "93.71"


def test_buildings_are_groups_of_their_own(tmp_path):
    paths = [write(tmp_path, building=building, scr=scr) for building, scr in (("flat", 0.4), ("house", 0.8))]
    rows, _ = rows_of(paths, ["nearest"], ["flat", "house"])
    assert rows["house", "Nearest frontier"].cells[0].value == pytest.approx(80)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"digest": "b" * 64}, "was made with another mesh than"),
        ({"steps": 200}, "was made with other settings of the robot than"),
        ({"camera": {"width": 64, "height": 48}}, "was made with other settings of the robot than"),
        ({"building": "house", "steps": 200}, "was made with other settings of the robot than"),
        ({"start": (2, 1, 0, 0)}, "started at another place than"),
    ],
)
def test_records_of_another_mesh_robot_or_start_are_refused(tmp_path, change, told):
    paths = [write(tmp_path), write(tmp_path, method="oracle", **change)]
    for order in (paths, paths[::-1]):
        with pytest.raises(UserError, match=told):
            read_explorations(order)


@pytest.mark.parametrize("place", [{"seed": 1}, {"building": "house"}])
def test_a_row_of_other_settings_of_what_chooses_is_refused(tmp_path, place):
    first, other = {"kind": "selector", "method": "random"}, {"kind": "selector", "method": "farthest"}
    paths = [write(tmp_path, method="oracle"), write(tmp_path, scorer=first), write(tmp_path, scorer=other, **place)]
    for order in (paths, paths[::-1]):
        with pytest.raises(UserError, match="chose its paths with other settings than"):
            read_explorations(order)


def test_a_second_record_of_one_exploration_is_refused(tmp_path):
    paths = [write(tmp_path / "first"), write(tmp_path / "second")]
    with pytest.raises(UserError, match=r"second/.*: repeats .*first/.*; pass one record for each"):
        read_explorations(paths)


def test_equal_records_give_equal_bytes_in_any_order(tmp_path):
    paths = [write(tmp_path, seed=seed, method=method) for seed in (0, 1) for method in ("nearest", "fisherrf")]
    for name, order in (("a", paths), ("b", paths[::-1])):
        write_active_slam(order, ["flat"], choosers(["nearest", "fisherrf"]), PUBLISHED, tmp_path / name)
        write_slam_over_steps(order, ["flat"], ["nearest", "fisherrf"], tmp_path / f"curves_{name}")
    for ending in (".csv", ".md", ".tex", "_per_run.csv", "_curves.csv"):
        assert (tmp_path / f"a{ending}").read_bytes() == (tmp_path / f"b{ending}").read_bytes(), ending
    assert (tmp_path / "curves_a.pdf").read_bytes() == (tmp_path / "curves_b.pdf").read_bytes()
    listed = list(csv.DictReader(io.StringIO((tmp_path / "a_per_run.csv").read_text())))
    assert {row["metric"] for row in listed} >= {"scr_percent", "map_seconds", "decision_seconds"}


def test_maps_are_drawn_and_equal(tmp_path):
    path = write(tmp_path)
    rng = np.random.default_rng(0)
    arrays = {
        "trajectory": rng.uniform(0, 3, (20, 4)),
        "surface": rng.uniform(0, 3, (500, 3)).astype(np.float32),
        "above_rgb": rng.integers(0, 255, (75, 75, 3)).astype(np.uint8),
        "above_origin": np.zeros(2),
        "distance": rng.uniform(0, 0.1, 500).astype(np.float32),
        "frontiers": np.zeros((0, 2)),
    }
    maps = path.with_name("maps.safetensors")
    write_tensors(maps, arrays, MAPS_HEADER, {})
    for name in ("a", "b"):
        write_slam_maps([path], [maps], tmp_path / name)
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()


@pytest.mark.parametrize("change", [{"seed": 1}, {"building": "house"}, {"steps": 200}, {"start": (2, 1, 0, 0)}])
def test_maps_of_what_does_not_belong_together_are_refused(tmp_path, change):
    paths = [write(tmp_path), write(tmp_path, method="oracle", **change)]
    maps = [path.with_name("maps.safetensors") for path in paths]
    for path in maps:
        write_tensors(path, {"trajectory": np.zeros((1, 4))}, MAPS_HEADER, {})
    with pytest.raises(UserError, match=r"is of another building or seed|other settings of the robot|another place"):
        write_slam_maps(paths, maps, tmp_path / "maps")


def wanted(path, building, method, seed, **changes):
    """Return what a run asks for at ``path``; the settings are those of the record, where there is one."""
    settings = read_record(path, ExplorationRecord).settings if path.exists() else {}
    told = {"place": (building, method, seed), "path": path, "logs": (path.with_suffix(".log"),), "settings": settings}
    return WantedExploration(**told | changes)


def unfinished_table(records, absent=None):
    methods = tuple(dict.fromkeys(each.place[1] for each in records)) + tuple(absent or ())
    document = incomplete_explorations(
        WantedExplorations(("flat",), choosers(methods), tuple(records), PUBLISHED, absent or {}, {})
    )
    return {row.label: row for row in document.groups[0].rows}, document


def test_a_gap_of_an_unfinished_run_is_told_with_its_cause_and_has_no_rank(tmp_path):
    there = [write(tmp_path, method=method, seed=seed) for method in ("nearest", "fisherrf") for seed in (0, 1)]
    records = [wanted(path, "flat", path.parts[-3], int(path.parts[-2])) for path in there]
    there[3].unlink()
    there[3].with_suffix(".log").write_text("step\nerror: flat: out of memory; buy some\n")
    rows, document = unfinished_table(records, {"ours-repvit": Reason(cause="weights of repvit", remedy="get them")})
    assert document.caption[0] == "Incomplete: 1 of 4 explorations is missing."
    assert "FisherRF in flat, seed 1: flat: out of memory; buy some" in document.notes
    assert "FisherRF in flat: mean of seed 0 only, not to be ranked" in document.notes
    assert rows["FisherRF"].cells[0].rank is None
    assert rows["Nearest frontier"].cells[0].rank == 1
    assert rows["ours-repvit"].cells[0].cause == "weights of repvit"


def test_a_mean_of_fewer_seeds_than_others_have_says_so_and_has_no_rank(tmp_path):
    paths = [write(tmp_path, seed=seed) for seed in (0, 1)] + [write(tmp_path, method="fisherrf", scr=0.9)]
    rows, document = rows_of(paths, ["nearest", "fisherrf"])
    assert rows["flat", "FisherRF"].cells[0].rank is None
    assert document.caption[0] == "Incomplete: 1 of 4 explorations is missing."
    assert "FisherRF in flat, seed 1: no record" in document.notes
    assert "FisherRF in flat: mean of seed 0 only, not to be ranked" in document.notes


def test_explorations_of_other_settings_or_code_do_not_count(tmp_path):
    paths = [write(tmp_path, seed=seed) for seed in (0, 1, 2)]
    changes = ({}, {"settings": {"camera": 1}}, {"stale": "its code has changed"})
    records = [wanted(path, "flat", "nearest", seed, **changes[seed]) for seed, path in enumerate(paths)]
    _, document = unfinished_table(records)
    assert "Nearest frontier in flat, seed 1: it was run with other settings" in document.notes
    assert "Nearest frontier in flat, seed 2: its code has changed" in document.notes
    with pytest.raises(UserError, match="no exploration yet; its code has changed"):
        unfinished_table(records[2:])


def test_without_records_there_is_one_line(tmp_path):
    with pytest.raises(UserError, match="no record"):
        read_explorations([])
    with pytest.raises(UserError, match="no record"):
        write_slam_maps([], [], tmp_path / "a")
