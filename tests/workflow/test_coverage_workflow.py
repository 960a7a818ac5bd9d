"""Coverage in the workflow: what is made, what a change makes again, and what a back end that is not here leaves."""

import csv
import json
import re
import shutil
import subprocess
import sys

import pytest
import yaml

from tests.workflow.project import checkout, environment, run, tiny

RESULTS = "results/tiny"


def with_coverage(**changes):
    """The tiny scale with pictures in which there is something to match."""
    values = tiny() | {"coverage": {"views": [5]} | changes, "common_states": None, "distortions": None}
    values["datasets"] = {"orbit": values["datasets"]["orbit"] | {"capture": {"views": 16, "long_side": 96}}}
    return values


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("coverage"))
    (folder / "tiny.yaml").write_text(yaml.safe_dump(with_coverage()))
    result = run(folder, "-j2", "tables")
    assert result.returncode == 0, result.stdout + result.stderr
    return folder, result


@pytest.fixture
def copied(finished, tmp_path):
    shutil.copytree(finished[0], tmp_path / "run", symlinks=True)
    return tmp_path / "run"


def planned(folder):
    """Return the number of jobs by rule that a dry run names, without the target."""
    result = run(folder, "-n", "tables")
    assert result.returncode == 0, result.stdout + result.stderr
    found = {rule: int(count) for rule, count in re.findall(r"^(\w+) +(\d+)$", result.stdout, re.MULTILINE)}
    return {rule: count for rule, count in found.items() if rule not in ("total", "tables")}


def test_the_table_and_the_figures_are_made_and_the_table_is_printed(finished):
    folder, result = finished
    assert "Scene coverage by structure from motion on the data set orbit" in result.stdout
    with open(folder / RESULTS / "tables" / "coverage_orbit.csv", newline="") as stream:
        rows = {(row["method"], row["metric"]): row["mean"] for row in csv.DictReader(stream)}
    for method in ("random", "farthest"):
        assert 0 < float(rows[method, "scr_percent"]) <= 100
        assert 0 < float(rows[method, "true_scr_percent"]) <= 100
        assert float(rows[method, "cloud_points"]) > 0
    for figure in ("coverage_maps", "coverage_over_views"):
        assert (folder / RESULTS / "figures" / f"{figure}.pdf").exists()
    record = json.loads((folder / RESULTS / "coverage/orbit/orbit_0/random/0/coverage.json").read_text())
    assert [point["views"] for point in record["curve"]] == [5, 6]


def test_a_finished_run_has_nothing_left_to_do(copied):
    assert planned(copied) == {}


def test_a_changed_episode_has_its_own_coverage_made_again_and_no_other(copied):
    (copied / RESULTS / "coverage/orbit/orbit_0/random/0/cloud.ply").unlink()
    shown = {"coverage_table": 1, "coverage_maps": 1, "coverage_over_views": 1}
    assert planned(copied) == {"coverage": 1, **shown}


def test_other_settings_of_the_reference_leave_the_episodes(copied):
    (copied / "tiny.yaml").write_text(yaml.safe_dump(with_coverage(extent="bounding_box")))
    rules = planned(copied)
    assert {"coverage_reference": 1, "coverage": 2, "coverage_table": 1}.items() <= rules.items()
    assert rules.keys().isdisjoint({"scene", "episode", "nvs_table"})


def test_a_back_end_that_is_not_here_leaves_the_table_with_the_reason(copied):
    (copied / "tiny.yaml").write_text(yaml.safe_dump(with_coverage(sfm={"back_end": "mast3r"})))
    result = run(copied, "-j2", "tables")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "Not measured: mast3r is not installed" in result.stdout
    assert not (copied / RESULTS / "figures" / "coverage_maps.pdf").exists()


def test_what_is_there_of_a_run_is_tabulated(copied):
    shutil.rmtree(copied / RESULTS / "coverage/orbit/orbit_0/random")
    words = [sys.executable, "-m", "avs", "report", RESULTS]
    result = subprocess.run(words, cwd=copied, env=environment(), capture_output=True, text=True, check=True)
    assert "Scene coverage by structure from motion" in result.stdout
    assert "Incomplete: 1 of 2 records of coverage is missing" in result.stdout
    assert "no coverage: " in result.stdout
