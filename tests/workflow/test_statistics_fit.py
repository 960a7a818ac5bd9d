"""What a run makes for the regressions on render statistics, and that it makes nothing of it without them."""

import shutil

import pytest
import yaml

from tests.workflow.project import checkout, run, tiny
from tests.workflow.test_niqe_fit import jobs


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A project without weights anywhere."""
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path / "weights"))
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    return checkout(tmp_path / "project")


def asked(folder, *methods):
    """Return the number of jobs by rule of a run of these methods."""
    (folder / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"methods": list(methods)}))
    return jobs(folder)


def test_regressions_are_fitted_and_measured_on_the_scenes_for_scorers(folder):
    found = asked(folder, "random", "statistics")
    rules = ("distortions", "statistics_fit", "held_out_scores", "scorer_table")
    assert [found[rule] for rule in rules] == [6, 1, 2, 1]  # four scenes train, two are held out
    assert found["episode"] == 2


def test_a_run_without_a_scorer_makes_no_data_for_the_table(folder):
    found = asked(folder, "random", "piqe")
    assert not {"distortions", "statistics_fit", "held_out_scores", "scorer_table"} & found.keys()


def test_scenes_that_change_their_use_are_fitted_to_anew(folder):
    """The same files, whose commands alone say which of them train."""
    values = tiny() | {"methods": ["random", "statistics"]}
    values["distortions"]["renders"] = {"cameras": 12, "views": [4, 8], "iterations": [4, 8]}
    for name in ("handheld_training", "handheld_held_out"):
        values["datasets"][name]["seeds"] = values["datasets"][name]["seeds"][:1]
    fitted = "results/tiny/parameters/statistics.safetensors"
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    result = run(folder, "-j2", fitted)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "statistics_fit" not in jobs(folder)
    values["distortions"] |= {"training": ["handheld_held_out"], "held_out": ["handheld_training"]}
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    assert jobs(folder)["statistics_fit"] == 1
    shutil.rmtree(folder / ".snakemake")
    assert jobs(folder)["statistics_fit"] == 1
