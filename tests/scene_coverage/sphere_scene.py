"""A scene whose surface is a sphere, episodes on it, and a back end that sees it as it is."""

import numpy as np

from avs.coverage.coverage_settings import CoverageJob, CoverageSettings, ReferenceJob
from avs.scene.points import Points
from avs.scene.scene import read_scene, write_scene
from avs.sfm.back_end_registry import create_settings
from avs.sfm.cloud import Cloud, empty_cloud
from avs.sfm.reconstruction import Reconstruction
from avs.system.records import write_record
from tests.factories import ring
from tests.report.conftest import make_episode

COUNT = 16
SIZE = (48, 32)
NAMES = tuple(f"{index:03d}.png" for index in range(COUNT))
# Pixels are 0.03 extents apart on the sphere.
DEFAULTS = CoverageSettings(voxel=0.04, threshold=0.04).model_dump()


def depth_of(cameras, index):
    """Distances along the optical axis to the unit sphere at the origin, 0 beside it."""
    width, height = cameras.sizes[index]
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    rays = np.stack([x, y, np.ones_like(x)], axis=-1) @ np.linalg.inv(cameras.intrinsics[index]).T
    rays = rays @ cameras.world_to_camera[index, :3, :3]
    center = cameras.centers[index]
    a, b, c = (rays**2).sum(-1), 2 * rays @ center, center @ center - 1
    root = b**2 - 4 * a * c
    return np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / (2 * a), 0).astype(np.float32)


def write_sphere(folder, with_depth=True):
    cameras = ring(COUNT, size=SIZE)
    write_scene(
        folder,
        name="ball",
        dataset="toys",
        names=NAMES,
        images=[np.full((SIZE[1], SIZE[0], 3), 40 + 5 * index, dtype=np.uint8) for index in range(COUNT)],
        cameras=cameras,
        test=np.arange(0, COUNT, 8),
        points=Points(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.uint8), np.zeros((0, 2), dtype=np.int64)),
        source="made by a test",
        licence="none",
        depth=[depth_of(cameras, index) for index in range(COUNT)] if with_depth else None,
    )
    return read_scene(folder)


def write_episode(path, scene, method="random", seed=0, views=(1, 4, 7, 10, 2, 3), **changes):
    names = [NAMES[index] for index in views]
    facts = {"dataset": "toys", "scene_hash": scene.content_hash, "initial": names[:4], "selected": names[4:]}
    write_record(path, make_episode(method, "ball", seed, **(facts | changes)))
    return path


def reference_job(**changes):
    values = {name: DEFAULTS[name] for name in ReferenceJob.model_fields if name in DEFAULTS}
    return ReferenceJob(**(values | {"device": "cpu", "sfm": create_settings({})} | changes))


def coverage_job(**changes):
    values = {name: DEFAULTS[name] for name in CoverageJob.model_fields if name in DEFAULTS}
    return CoverageJob(**(values | {"device": "cpu", "sfm": create_settings({}), "views": (4,)} | changes))


def seen_by(scene_cameras, views, noise=0.0):
    """The cloud of all pixels of some views that show the sphere; a point of one pixel is the same in every cloud."""
    positions = []
    for index, name in enumerate(views.names):
        depth = np.load(scene_cameras.folder / "depth" / f"{name[:3]}.npy")
        y, x = np.nonzero(depth)
        matrix, pose = views.cameras.intrinsics[index], views.cameras.world_to_camera[index]
        rays = np.stack([x + 0.5, y + 0.5, np.ones(len(x))], axis=1) @ np.linalg.inv(matrix).T
        own = (rays * depth[y, x, None] - pose[:3, 3]) @ pose[:3, :3]
        positions.append(own + noise * np.random.default_rng(index).normal(size=own.shape))
    found = np.concatenate(positions)
    return Cloud(found, np.full((len(found), 3), 90, dtype=np.uint8), np.ones(len(found), dtype=np.float32))


def perfect(scene):
    """A back end with known poses that makes no error."""

    def reconstruct(views, settings, subject, device="cpu"):
        return Reconstruction(seen_by(scene, views), views.names)

    return reconstruct


def blind(views, settings, subject, device="cpu"):
    """A back end that finds nothing."""
    return Reconstruction(empty_cloud(), (), dict.fromkeys(views.names, "no matches"))
