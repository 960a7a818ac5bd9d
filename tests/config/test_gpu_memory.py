"""The estimate of a GPU's memory: its constants against what others published and against torch's allocator."""

import numpy as np
import pytest
import yaml

from avs.config import gpu_memory
from avs.config.configuration import load
from tests.benchmarks import bench_memory
from tests.workflow.project import ROOT

# gsplat's published evaluation: millions of Gaussians and GB of training, 30,000 steps and then 7,000, on bicycle,
# bonsai, counter, garden, kitchen, room, stump.
MILLIONS = [6.26, 1.25, 1.21, 5.84, 1.79, 1.59, 4.81, 3.62, 1.17, 1.02, 4.48, 1.63, 1.11, 3.71]
GIGABYTES = [10.58, 2.29, 2.23, 9.88, 3.17, 2.79, 8.10, 6.10, 2.20, 1.93, 7.57, 2.89, 2.04, 6.25]


def config(name="paper", **changes):
    told = yaml.safe_load((ROOT / "workflows" / "config" / f"{name}.yaml").read_text())
    return load(told | {"scenes_dir": "scenes", "device": "cuda", "runtime": None} | changes, [])


@pytest.fixture(autouse=True)
def scenes(monkeypatch, tmp_path):
    """A folder where no weights are, and one of scenes that nobody reads."""
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path))


def test_a_gaussian_takes_what_gsplat_published():
    slope, beside = np.polyfit(MILLIONS, GIGABYTES, 1)
    assert pytest.approx(1000 * slope, rel=1e-3) == gpu_memory.FITTED
    told = gpu_memory.FITTED * np.array(MILLIONS) / 1000 + beside
    np.testing.assert_allclose(told, GIGABYTES, rtol=0.03)


def test_the_loss_takes_what_the_allocator_counts():
    assert bench_memory.loss(60, 80) == pytest.approx(gpu_memory._LOSS, rel=0.01)


@pytest.mark.parametrize("scorer", gpu_memory.NETWORKS)
def test_a_step_of_a_training_takes_what_the_allocator_counts(scorer):
    assert bench_memory.training(scorer, crop=266) == pytest.approx(gpu_memory.NETWORKS[scorer].trained, rel=0.05)


def test_an_episode_grows_with_gaussians_pixels_and_networks():
    ours = config(methods=["random", "ours-lite0"])
    first, training = gpu_memory.needs(ours)
    plain = gpu_memory.needs(config(methods=["random"]))[0]
    small = gpu_memory.needs(config(methods=["random"], representation={"densification": {"max_gaussians": 10_000}}))[0]
    assert 5e9 < plain.total < first.total < plain.total + 2e9
    assert small.total < 6e9
    assert max(small.moments, key=small.moments.get) == "LPIPS"  # VGG's first maps of 1,600 x 1,200 pixels
    assert training.job == "the training of lite0"
    assert str(plain).startswith("an episode of captures, 1,000,000 Gaussians: about ")


def test_images_without_a_limit_are_not_estimated():
    unlimited = {"captures": {"source": "captures", "long_side": None}}
    assert not gpu_memory.needs(config(methods=["random"], datasets=unlimited, distortions=None, scorers={}))


def test_a_run_is_told_of_what_will_hardly_fit():
    lines = gpu_memory.told(config(methods=["random"]), device=4 * 10**9)
    assert len(lines) == 1
    assert "the smallest GPU here has 4.0: should it run out, lower" in lines[0]
    assert gpu_memory.told(config(methods=["random"]), device=10**11) == gpu_memory.told(
        config(methods=["random"]), None
    )
