"""Which weights the workflow gives to a metric: published ones, those that it fits itself, or none."""

import re

import pytest
import yaml

from tests.workflow.project import checkout, run, tiny


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A project with three metrics, and no weights anywhere."""
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path / "weights"))
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    made = checkout(tmp_path / "project")
    (made / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"methods": ["random", "niqe", "musiq"]}))
    return made


def jobs(folder):
    """Return the number of jobs by rule that a dry run names."""
    result = run(folder, "-n", "tables")
    assert result.returncode == 0, result.stderr
    return {rule: int(count) for rule, count in re.findall(r"^(\w+)\s+(\d+)$", result.stdout, re.MULTILINE)}


def test_absent_parameters_are_fitted_or_the_method_has_no_episode(folder):
    found = jobs(folder)
    assert found["niqe_fit"] == 1
    assert found["episode"] == 2  # random and niqe


def test_published_parameters_are_used_where_they_are(folder, tmp_path):
    published = tmp_path / "weights/pyiqa/niqe_modelparameters.mat"
    published.parent.mkdir(parents=True)
    published.touch()
    found = jobs(folder)
    assert "niqe_fit" not in found
    assert found["episode"] == 2
