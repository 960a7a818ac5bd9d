"""The adapters of feed-forward networks, by stand-ins with the public signatures."""

import sys
import types

import numpy as np
import pytest
from factories import named_views, ring
from tolerances import FLOAT32_STORAGE

from avs.sfm import back_end_registry as registry
from avs.sfm.alignment import placed
from avs.system.compatibility import prepare_torchvision
from avs.system.errors import UserError
from tests.sfm import network_stand_ins

NETWORKS = ("mast3r", "vggt", "mapanything", "da3")
CAMERAS = ring(5, size=(24, 16))


@pytest.fixture
def views():
    return named_views(CAMERAS, [np.full((16, 24, 3), 128, dtype=np.uint8)] * 5)


@pytest.fixture
def weights(tmp_path):
    (tmp_path / "model.safetensors").touch()
    return tmp_path


@pytest.mark.parametrize("name", NETWORKS)
def test_points_come_to_lie_where_they_are(name, views, weights, monkeypatch):
    seen = getattr(network_stand_ins, f"install_{name}")(monkeypatch, CAMERAS)
    settings = registry.create_settings({"back_end": name, "weights": weights, "every": 1})
    found = registry.reconstruct(views, settings, "the test")
    if settings.poses == "free":
        assert found.cameras is not None
        found, alignment = placed(found, views)
        assert alignment.scale == pytest.approx(1 / network_stand_ins.SCALE, rel=FLOAT32_STORAGE)
    points, _, _ = network_stand_ins.world_points(CAMERAS, (24, 16))
    np.testing.assert_allclose(found.cloud.positions, points[:, 1:].reshape(-1, 3), atol=1e2 * FLOAT32_STORAGE)
    assert (found.cloud.colors == 128).all()
    assert found.registered == views.names
    assert seen["weights"] == str(weights)


@pytest.mark.parametrize("name", ["mapanything", "da3"])
def test_known_poses_are_given_and_free_ones_are_not(name, views, weights, monkeypatch):
    seen = getattr(network_stand_ins, f"install_{name}")(monkeypatch, CAMERAS)
    for poses in ("known", "free"):
        settings = registry.create_settings({"back_end": name, "weights": weights, "poses": poses})
        found = registry.reconstruct(views, settings, "the test")
        given = seen["views"][0].get("camera_poses") if name == "mapanything" else seen["extrinsics"]
        assert (given is not None) == (poses == "known")
        assert (found.cameras is None) == (poses == "known")
        assert any("from those given" in note for note in found.notes) == (poses == "known")


def test_cameras_that_do_not_fit_are_a_result_with_its_reason(views, weights, monkeypatch):
    wrong = CAMERAS[[0, 1, 2, 3, 4]]
    wrong.world_to_camera[:, :3, 3] = np.random.default_rng(0).normal(size=(5, 3)) * 9
    network_stand_ins.install_da3(monkeypatch, wrong)
    settings = registry.create_settings({"back_end": "da3", "weights": weights})
    found = registry.reconstruct(views, settings, "the test")
    assert len(found.cloud) == 0
    assert set(found.left_out) == set(views.names)


@pytest.mark.parametrize("name", NETWORKS)
def test_what_is_lacking_is_told(name, views, tmp_path, monkeypatch):
    settings = registry.create_settings({"back_end": name})
    monkeypatch.setattr(registry, "_is_installed", lambda module: module in sys.modules)
    assert "is not installed" in registry.why_not(settings).cause
    with pytest.raises(UserError, match="is not installed"):
        registry.reconstruct(views, settings, "the test")
    getattr(network_stand_ins, f"install_{name}")(monkeypatch, CAMERAS)
    assert "no weights" in registry.why_not(settings).cause
    assert "does not exist" in registry.why_not(registry.create_settings({"back_end": name, "weights": tmp_path})).cause


@pytest.mark.parametrize("name", NETWORKS)
def test_a_version_with_other_functions_is_one_line(name, views, weights, monkeypatch):
    getattr(network_stand_ins, f"install_{name}")(monkeypatch, CAMERAS)
    module = {"mast3r": "mast3r.model", "vggt": "vggt.models.vggt", "mapanything": "mapanything.models"}.get(name)
    monkeypatch.setitem(sys.modules, module or "depth_anything_3.api", types.ModuleType("another_version"))
    settings = registry.create_settings({"back_end": name, "weights": weights})
    with pytest.raises(UserError, match=f"back end {name}: does not work with the version that is installed"):
        registry.reconstruct(views, settings, "the test")


@pytest.mark.parametrize("poses", ["known", "free"])
def test_the_real_depth_anything_with_random_weights(poses, tmp_path):
    """Its pictures and poses go in and its points come out; with random weights these mean nothing."""
    pytest.importorskip("depth_anything_3", reason="depth-anything-3 needs an environment of its own")
    prepare_torchvision()
    from depth_anything_3.api import DepthAnything3

    DepthAnything3("da3-small").save_pretrained(tmp_path)
    pictures = [np.random.default_rng(row).integers(0, 256, (42, 56, 3), dtype=np.uint8) for row in range(3)]
    views = named_views(ring(3, size=(56, 42)), pictures)
    values = {"weights": tmp_path, "poses": poses, "side": 56, "every": 1, "least_confidence": 0.0}
    found = registry.reconstruct(views, registry.create_settings({"back_end": "da3", **values}), "the test")
    assert found.registered == views.names
    assert len(found.cloud) == 3 * 42 * 56
    assert (found.cameras is None) == (poses == "known")


@pytest.mark.parametrize("name", ["mast3r", "vggt"])
def test_networks_without_known_poses_refuse_them(name):
    with pytest.raises(UserError, match="poses"):
        registry.create_settings({"back_end": name, "poses": "known"})
