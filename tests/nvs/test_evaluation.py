"""The test metrics: LPIPS with weights that lie on this machine, and the reason where there are none."""

import dataclasses
import hashlib
import math

import pytest
from factories import MeanColor, small_scene

from avs.nvs.evaluation import Evaluator
from avs.nvs.protocol import LpipsSettings
from avs.system.errors import UserError
from avs.system.weights import cache
from avs.system.weights.manifest import MANIFEST

torch = pytest.importorskip("torch")

ALEX = LpipsSettings(net="alex")


@pytest.fixture(autouse=True)
def no_weights(tmp_path, monkeypatch):
    """An empty cache folder, and no other place where weights could lie."""
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path / "weights"))
    monkeypatch.setenv("TORCH_HOME", str(tmp_path / "torch"))


@pytest.fixture
def scene(tmp_path):
    return small_scene(tmp_path / "toy", size=(72, 64))


def put(state, monkeypatch):
    """Save a state dictionary as the backbone, and let the manifest expect it."""
    path = cache.folder() / cache.find("lpips-alex").path
    path.parent.mkdir(parents=True)
    torch.save(state, path)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    monkeypatch.setitem(MANIFEST, "lpips-alex", dataclasses.replace(MANIFEST["lpips-alex"], sha256=digest))


def test_a_metric_without_weights_is_null_with_the_reason(scene):
    evaluate = Evaluator(scene, LpipsSettings())
    assert evaluate.absent == {"lpips": "weights vgg16-397923af.pth absent: python -m avs weights fetch lpips-vgg"}
    representation = MeanColor()
    representation.fit(scene.views(scene.test), 1)
    assert {image.lpips for image in evaluate(representation)} == {None}


def test_local_weights_are_used(scene, monkeypatch):
    from avs.system.compatibility import prepare_torchvision

    prepare_torchvision()
    import torchvision

    torch.manual_seed(0)
    put(torchvision.models.alexnet().state_dict(), monkeypatch)
    evaluate = Evaluator(scene, ALEX)
    assert evaluate.absent == {}
    representation = MeanColor()
    representation.fit(scene.views(scene.test), 1)
    images = evaluate(representation)
    assert all(math.isfinite(image.lpips) for image in images)
    assert max(image.lpips for image in images) > 0


def test_weights_of_another_network_are_one_line(scene, monkeypatch):
    put({"features.0.weight": torch.ones(1)}, monkeypatch)
    with pytest.raises(UserError, match=r"LPIPS weights: features\.\d+\.\w+ is missing") as error:
        Evaluator(scene, ALEX)
    assert "\n" not in str(error.value)
