"""Whole episodes on CUDA, of every method that runs without pretrained weights."""

from pathlib import Path

import numpy as np
import pytest
import torch
import yaml
from factories import methods_that_run, ring, write_regression

from avs.config.configuration import load
from avs.iqa.cross_reference.network import build_network
from avs.iqa.cross_reference.scorer_checkpoint import save_network
from avs.nvs.episode_settings import EpisodeSettings
from avs.nvs.experiment import run_episode
from avs.nvs.protocol import ProtocolSettings
from avs.nvs.record import Episode, EpisodeMeta
from avs.representations.gaussians.gaussian_settings import GaussianSettings, InitialPoints
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.splats import GaussianSplats
from avs.scene.scene import Points, write_scene
from avs.selection import registry
from avs.system.records import read_record
from tests.tolerances import CUDA_EPISODE

pytestmark = pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU that torch can use")

# NIQE's windows of 96 pixels need two of them in each direction.
SIZE = (256, 192)
PROTOCOL = ProtocolSettings(initial_views=4, budget=7, additions=(20, 50, 90), iterations=150)
METHODS = methods_that_run()


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Sixteen views of a cloud of Gaussians."""
    generator, cameras = np.random.default_rng(0), ring(16, size=SIZE)
    cloud = PointCloud(generator.normal(size=(80, 3)) * 0.5, generator.random((80, 3)))
    settings = GaussianSettings(sh_degree=0, points=InitialPoints(opacity=0.9))
    images = GaussianSplats(cloud, 1.0, settings, generator, "cpu").render(cameras).rgb
    folder = tmp_path_factory.mktemp("scene") / "toy"
    write_scene(
        folder,
        name="toy",
        dataset="toys",
        names=tuple(f"{number:03d}.png" for number in range(16)),
        images=tuple(np.round(image * 255).astype(np.uint8) for image in images),
        cameras=cameras,
        test=np.arange(0, 16, 8),
        points=Points(
            positions=cloud.positions,
            colors=np.round(cloud.colors * 255).astype(np.uint8),
            observations=np.array([[point, view] for point in range(80) for view in range(16)], dtype=np.int64),
        ),
        source="made by a test",
        licence="none",
    )
    return folder


def scorers():
    """Return the scorers of the configuration ``ci``."""
    return load(yaml.safe_load((Path(__file__).parents[2] / "workflows/config/ci.yaml").read_text())).scorers


def settings_of(method, device):
    found = registry.find(method).method
    side = 112 if found.scorer is not None else 256
    resize = {"resize": {"side": "long", "pixels": side}}
    return EpisodeSettings(
        method=method,
        protocol=PROTOCOL,
        representation=GaussianSettings(iterations=150),
        selector=resize if "resize" in found.settings.model_fields else {},
        device=device,
    )


@pytest.mark.parametrize("method", METHODS)
def test_episode(scene, method, tmp_path):
    weights, scorer = None, registry.find(method).method.scorer
    if scorer is not None:
        weights = tmp_path / "scorer.safetensors"
        save_network(weights, build_network(scorers()[scorer].network, seed=0))
    elif registry.find(method).method.fallback == "statistics":
        weights = write_regression(tmp_path / "statistics.safetensors", 256)
    run_episode(scene, settings_of(method, "cuda"), 0, weights, tmp_path, print)
    episode = read_record(tmp_path / "episode.json", Episode)
    meta = read_record(tmp_path / "episode.meta.json", EpisodeMeta)
    assert len(episode.selected) == 3
    assert "gpu" in meta.machine
    assert meta.peak_memory_bytes > 0


def test_views_that_do_not_depend_on_renderings_are_those_of_the_cpu(scene, tmp_path):
    found = []
    for device in ("cpu", "cuda"):
        run_episode(scene, settings_of("farthest", device), 0, None, tmp_path / device, print)
        found.append(read_record(tmp_path / device / "episode.json", Episode))
    assert found[0].selected == found[1].selected
    reached = [np.mean([image.psnr for image in episode.curve[-1].images]) for episode in found]
    assert reached[1] == pytest.approx(reached[0], abs=CUDA_EPISODE)
