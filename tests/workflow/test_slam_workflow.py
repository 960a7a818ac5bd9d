"""Explorations in the workflow: the table with the others or alone, gaps of an unfinished run, nothing stale."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from avs.config.run_plan import RunPlan
from avs.config.slam_config import SlamFigureJob
from avs.config.unfinished_run import unfinished
from avs.slam.loop.exploration_record import ExplorationRecord
from avs.slam.mapping.mapper_settings import MapperSettings
from avs.system.records import read_record
from tests.workflow.project import checkout, environment, run, tiny

SPLATAM = MapperSettings().model_dump(mode="json")
SLAM = {
    "buildings": {"flat": {"source": "apartment", "seed": 3}},
    "methods": {"nearest": {"kind": "nearest"}, "fvs": {"kind": "selector", "method": "farthest", "every": 10}},
    "seeds": [0],
    "robot": {
        "simulator": {"samples": 1},
        "camera": {"width": 32, "height": 24},
        "mapper": {**SPLATAM, "map_every": 20, "iterations": 2},
        "exploration": {
            "steps": 90,
            "occupancy": {"cells": 200},
            "frontiers": {"candidates": 8},
            "paths": {"shortlist": 2},
        },
        "evaluation": {"points": 500, "poses": 2, "every": 45},
    },
}
RECORD = "results/tiny/slam/flat/nearest/0/exploration.json"
TABLE = "results/tiny/tables/active_slam.md"


def configure(folder, **changes):
    (folder / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"slam": SLAM | changes}, sort_keys=False))


@pytest.fixture(scope="module")
def explored(tmp_path_factory):
    """A folder in which the explorations have run."""
    folder = checkout(tmp_path_factory.mktemp("slam") / "project")
    configure(folder)
    result = run(folder, "-j2", "explore")
    assert result.returncode == 0, result.stderr
    return folder


def copied(explored, tmp_path):
    shutil.copytree(explored, tmp_path / "run", symlinks=True)
    return tmp_path / "run"


def planned(folder, target):
    result = run(folder, "-n", target)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_the_target_makes_table_and_figures_and_then_has_nothing_to_do(explored):
    table = (explored / TABLE).read_text()
    assert "Nearest frontier" in table
    assert "FVS" in table
    made = {path.name for path in (explored / "results/tiny/figures").glob("slam_*")}
    assert {"slam_maps_flat.png", "slam_over_steps.png", "slam_flat_fvs_0.gif"} <= made
    assert "Nothing to be done" in run(explored, "-j1", "explore").stderr


def test_the_plan_finds_the_explorations_and_their_logs(explored, monkeypatch):
    monkeypatch.chdir(explored)
    wanted = unfinished(read_record(Path("results/tiny/plan.json"), RunPlan)).explorations
    assert {each.place for each in wanted.records} == {("flat", name, 0) for name in SLAM["methods"]}
    for each in wanted.records:
        assert each.path.exists()
        assert each.stale is None
        assert read_record(each.path, ExplorationRecord).settings == each.settings
        assert all(log.exists() for log in each.logs)


def test_an_unfinished_run_tells_of_the_gap_in_the_table(explored, tmp_path):
    folder = copied(explored, tmp_path)
    for name in (RECORD, RECORD.replace("exploration.json", "maps.safetensors")):
        (folder / name).unlink()
    log = folder / "results/tiny/logs/slam/flat/nearest/0.log"
    log.write_text("error: flat: out of memory; buy some\n")
    words = [sys.executable, "-m", "avs", "report", "results/tiny"]
    result = subprocess.run(words, cwd=folder, env=environment(), capture_output=True, text=True, check=False)
    told = (folder / "results/tiny/tables_incomplete/active_slam.md").read_text()
    assert told.startswith("Incomplete: 1 of 2 explorations is missing."), result.stderr
    assert "out of memory; buy some" in told


def test_tables_makes_it_too_unless_told_otherwise_and_keeps_no_old_one(explored, tmp_path):
    folder = copied(explored, tmp_path)
    assert "exploration" not in planned(folder, "tables")  # all is there
    changed = {"robot": SLAM["robot"] | {"agent": {"radius": 0.11}}}
    configure(folder, **changed)
    assert "exploration" in planned(folder, "tables")
    configure(folder, **changed, with_tables=False)
    assert "exploration" not in planned(folder, "tables")
    result = run(folder, "-j2", "tables")
    assert result.returncode == 0, result.stderr
    assert f"{TABLE}: is of an earlier run; set aside" in result.stderr
    assert not (folder / TABLE).exists()


def test_an_outdated_table_that_is_not_asked_for_is_set_aside(explored, tmp_path):
    folder = copied(explored, tmp_path)
    with open(folder / "results/published/slam_gibson.csv", "a") as stream:
        stream.write("\n")
    figure = "results/tiny/figures/slam_over_steps.pdf"
    result = run(folder, "-j1", figure)
    assert result.returncode == 0, result.stderr
    assert f"{TABLE}: is of an earlier run; set aside" in result.stderr
    assert not list((folder / TABLE).parent.glob("active_slam*"))
    assert (folder / "results/tiny/figures/slam_maps_flat.png").is_file()  # nothing of it has changed
    assert "Nothing to be done" in run(folder, "-j1", figure).stderr


def test_a_building_that_cannot_be_read_stops_nobody_else(tmp_path):
    folder = checkout(tmp_path / "project")
    (folder / "cut.glb").write_bytes(b"glT")
    lost = {name: {"source": "mesh", "file": f"{name}.glb"} for name in ("gone", "cut")}
    configure(folder, buildings=lost | SLAM["buildings"])
    result = run(folder, "-n", "tables")
    assert result.returncode == 0, result.stderr
    assert result.stderr.count("left out of slam.buildings: gone: gone.glb: is no file; check the path\n") == 1
    assert "left out of slam.buildings: cut: cut.glb: is no readable glTF file" in result.stderr
    assert "exploration of flat by nearest, seed 0" in result.stdout
    assert "exploration of gone" not in result.stdout
    result = run(folder, "-j1", "results/tiny/settings/slam_figure.json")
    assert result.returncode == 0, result.stderr
    told = read_record(folder / "results/tiny/settings/slam_figure.json", SlamFigureJob)
    assert (told.explored, set(told.absent_buildings)) == (("flat",), set(lost))


def test_where_no_building_can_be_read_the_other_tables_are_made_and_explore_says_why(tmp_path):
    folder = checkout(tmp_path / "project")
    configure(folder, buildings={"gone": {"source": "mesh", "file": "gone.glb"}})
    result = run(folder, "-n", "tables")
    assert result.returncode == 0, result.stderr
    assert "left out: slam: nothing can be explored here (gone: gone.glb: is no file; check the path)" in result.stderr
    assert "table of active SLAM" not in result.stdout
    result = run(folder, "-j1", "explore")
    assert result.returncode != 0
    assert "slam: nothing can be explored here, as a line above says why" in result.stderr + result.stdout


def test_without_buildings_the_target_says_what_to_do(tmp_path):
    folder = checkout(tmp_path / "project")
    result = run(folder, "-j1", "explore")
    assert result.returncode != 0
    assert "slam: no building is named; add one (docs/active-slam.md)" in result.stderr + result.stdout
