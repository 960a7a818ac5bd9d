"""Clouds of a scene whose geometry is known: depth against the truth, equal bytes, known and free poses."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from factories import named_views, ring
from tolerances import DENSE_COVERED, DENSE_DEPTH, DENSE_WITHIN, DENSE_WITHIN_CLOUD

from avs.datasets.embedded import make_scene
from avs.datasets.embedded.embedded_settings import EmbeddedSettings
from avs.scene.scene import read_scene
from avs.sfm import back_end_registry as registry
from avs.sfm.alignment import placed
from avs.sfm.dense_stereo import depth_maps
from avs.sfm.guided_points import guided_points
from avs.sfm.sfm_settings import FusionSettings, GuidedSettings, StereoSettings

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scene") / "handheld_0"
    make_scene("handheld", 0, EmbeddedSettings(views=16, long_side=160, gather_rays=8), folder)
    return read_scene(folder)


@pytest.fixture(scope="module")
def views(scene):
    return scene.views(range(16))


@pytest.fixture(scope="module")
def dense(views):
    return registry.reconstruct(views, registry.create_settings({}), "the test")


def true_depth(scene, name):
    return np.load(scene.folder / "depth" / f"{Path(name).stem}.npy")


def test_depth_is_that_of_the_scene(scene, views):
    maps = depth_maps(views, guided_points(views, GuidedSettings()), StereoSettings(), seed=0)
    relative, absolute, seen = [], [], 0
    for row, found in maps.items():
        truth = true_depth(scene, views.names[row])
        kept = (truth > 0) & (found.cost <= FusionSettings().worst_cost)
        errors = np.abs(found.depth - truth)[kept]
        relative.append(errors / truth[kept])
        absolute.append(errors / scene.extent)
        seen += (truth > 0).sum()
    relative, absolute = np.concatenate(relative), np.concatenate(absolute)
    assert np.median(relative) < DENSE_DEPTH
    assert (absolute < 0.01).mean() > DENSE_WITHIN
    assert len(relative) / seen > DENSE_COVERED


def test_fused_points_lie_on_surfaces_that_views_show(scene, views, dense):
    """A point is right if in some view it lies at the depth that is true there."""
    right = np.zeros(len(dense.cloud), dtype=bool)
    for row, name in enumerate(views.names):
        truth, transform = true_depth(scene, name), views.cameras.world_to_camera[row]
        local = dense.cloud.positions @ transform[:3, :3].T + transform[:3, 3]
        pixels = local @ views.cameras.intrinsics[row].T
        with np.errstate(divide="ignore", invalid="ignore"):
            columns, rows = np.floor(pixels[:, :2] / pixels[:, 2:]).T
        inside = (local[:, 2] > 0) & (columns >= 0) & (rows >= 0)
        inside &= (columns < truth.shape[1]) & (rows < truth.shape[0])
        at = rows[inside].astype(int), columns[inside].astype(int)
        right[inside] |= np.abs(truth[at] - local[inside, 2]) < 0.01 * scene.extent
    assert right.mean() > DENSE_WITHIN_CLOUD
    assert dense.cloud.confidence.min() >= FusionSettings().views


@pytest.mark.parametrize("name", ["dense", "colmap"])
@pytest.mark.parametrize("poses", ["known", "free"])
def test_equal_views_give_equal_bytes(name, poses, views):
    settings = registry.create_settings({"back_end": name, "poses": poses})
    first, second = (registry.reconstruct(views, settings, "the test") for _ in range(2))
    for part in ("positions", "colors", "confidence"):
        assert getattr(first.cloud, part).tobytes() == getattr(second.cloud, part).tobytes()
    assert first.registered == second.registered
    assert set(first.registered) | set(first.left_out) == set(views.names)
    assert not set(first.registered) & set(first.left_out)
    assert (first.cameras is None) == (poses == "known")
    assert len(first.cloud)


IN_A_PROCESS_OF_ITS_OWN = """
import hashlib, sys
from pathlib import Path
from avs.scene.scene import read_scene
from avs.sfm.back_end_registry import create_settings, reconstruct
views = read_scene(Path(sys.argv[1])).views(range(16))
cloud = reconstruct(views, create_settings({"back_end": sys.argv[2], "poses": sys.argv[3]}), "the test").cloud
print(len(cloud), hashlib.sha256(cloud.positions.tobytes() + cloud.colors.tobytes()).hexdigest())
"""


@pytest.mark.parametrize("name", ["dense", "colmap"])
@pytest.mark.parametrize("poses", ["known", "free"])
def test_neither_the_process_nor_its_threads_change_a_byte(name, poses, scene):
    said = set()
    for threads in ("1", "3"):
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
        words = [sys.executable, "-c", IN_A_PROCESS_OF_ITS_OWN, scene.folder, name, poses]
        environment = os.environ | dict.fromkeys(names, threads)
        result = subprocess.run(words, env=environment, cwd=ROOT, capture_output=True, text=True, check=True)
        said.add(result.stdout)
    assert len(said) == 1
    assert not said.pop().startswith("0 ")


def test_free_poses_are_placed_in_the_scene(views):
    settings = registry.create_settings({"back_end": "colmap", "poses": "free"})
    found = registry.reconstruct(views, settings, "the test")
    moved, alignment = placed(found, views)
    assert alignment is not None
    assert alignment.residual < 0.05 * np.ptp(views.cameras.centers, axis=0).max()
    assert len(moved.cloud) == len(found.cloud)


@pytest.mark.parametrize("name", ["dense", "colmap"])
@pytest.mark.parametrize("poses", ["known", "free"])
def test_pictures_that_show_nothing_are_a_result(name, poses):
    flat = named_views(ring(3, size=(48, 32)), [np.full((32, 48, 3), 128, dtype=np.uint8)] * 3)
    settings = registry.create_settings({"back_end": name, "poses": poses})
    found = registry.reconstruct(flat, settings, "the test")
    assert len(found.cloud) == 0
    assert set(found.left_out) == set(flat.names)
