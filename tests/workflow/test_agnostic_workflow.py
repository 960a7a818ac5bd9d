"""The same methods on two representations, and data for scorers from one that is not the run's."""

import csv
import json
import shutil
import subprocess
import sys

import pytest
import yaml

from avs.commands.view import scene_of
from avs.system.errors import UserError
from tests.workflow.project import checkout, environment, run, tiny

FIELD = {
    "kind": "tensorf",
    "iterations": 12,
    "rays": 32,
    "samples": 12,
    "density_components": 2,
    "appearance_components": 2,
    "density_shift": -3,
    "decoder": "sh",
    "grid": {"initial": 8, "final": 8, "refine_at": []},
    "empty_space": {"every": 50, "cells": 8},
}
AGNOSTIC = {"representations": {"gaussians": {}, "field": FIELD}, "methods": ["random", "fisherrf"]}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("agnostic"))
    values = tiny() | {"methods": ["random", "fisherrf"], "common_states": None, "agnostic": AGNOSTIC}
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values, sort_keys=False))
    result = run(folder, "-j2", "agnostic")
    assert result.returncode == 0, result.stdout + result.stderr
    return folder


def rows(path):
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))


def test_each_method_has_its_numbers_or_the_reason(finished):
    found = {(row["representation"], row["method"]): row for row in rows(table(finished))}
    assert list(dict.fromkeys(name for name, _ in found)) == ["gaussians", "field"]  # as the configuration has them
    assert {row["kind"] for row in found.values()} == {"gaussians", "tensorf"}
    assert all(float(row["psnr"]) > 0 for key, row in found.items() if key != ("field", "fisherrf"))
    assert "representation tensorf lacks fisher_diagonal" in found["field", "fisherrf"]["note"]
    assert not (finished / "results/tiny/agnostic/field/episodes/orbit/orbit_0/fisherrf").exists()


def test_a_record_carries_its_representation(finished):
    episodes = finished / "results/tiny/agnostic"
    record = json.loads((episodes / "field/episodes/orbit/orbit_0/random/0/episode.json").read_text())
    other = json.loads((episodes / "gaussians/episodes/orbit/orbit_0/random/0/episode.json").read_text())
    assert (record["representation"]["kind"], other["representation"]["kind"]) == ("tensorf", "gaussians")
    assert record["initial"] == other["initial"]


def test_its_scene_is_the_one_of_the_run(finished, tmp_path):
    results = finished / "results/tiny"
    episode = "episodes/orbit/orbit_0/random/0/episode.json"
    assert scene_of(results / "agnostic/field" / episode) == results / "scenes/orbit/orbit_0"
    with pytest.raises(UserError, match=f"its scene is not in {tmp_path}/scenes/orbit/orbit_0; name the scene with"):
        scene_of(tmp_path / episode)


def test_an_unfinished_run_says_what_is_missing(finished, tmp_path):
    folder = tmp_path / "unfinished"
    shutil.copytree(finished, folder, symlinks=True)
    shutil.rmtree(folder / "results/tiny/agnostic/gaussians/episodes/orbit/orbit_0/random")
    words = [sys.executable, "-m", "avs", "report", "results/tiny"]
    told = subprocess.run(words, cwd=folder, env=environment(), capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stderr
    text = (folder / "results/tiny/tables_incomplete/agnostic_orbit.md").read_text()
    assert text.startswith("Incomplete: 2 of 4 means are missing.")


def test_a_change_of_one_representation_runs_its_episodes_and_no_other(finished, tmp_path):
    folder = tmp_path / "changed"
    shutil.copytree(finished, folder, symlinks=True)
    values = yaml.safe_load((folder / "tiny.yaml").read_text())
    values["agnostic"]["representations"]["field"]["rays"] = 16
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    told = run(folder, "-n", "agnostic").stdout
    assert "episode: random on orbit_0 of orbit, seed 0, representation field" in told
    assert "representation gaussians" not in told


def table(folder):
    return folder / "results/tiny/tables/agnostic_orbit.csv"


def test_a_table_that_is_not_made_again_is_set_aside_when_its_settings_change(finished, tmp_path):
    folder = tmp_path / "aside"
    shutil.copytree(finished, folder, symlinks=True)
    values = yaml.safe_load((folder / "tiny.yaml").read_text())
    values["agnostic"] |= {"with_tables": False}
    values["agnostic"]["representations"]["field"]["rays"] = 16
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    target = "results/tiny/tables/scenes_orbit.csv"
    result = run(folder, "-j2", target)
    assert result.returncode == 0, result.stdout + result.stderr
    assert not table(folder).exists()
    assert (folder / "results/tiny/set_aside/tables/agnostic_orbit.csv").exists()
