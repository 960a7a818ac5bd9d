import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from avs.datasets.embedded import make_scene
from avs.datasets.embedded.camera.render import pixel_rays
from avs.datasets.embedded.camera.surface_points import inside, project
from avs.datasets.embedded.capture import PATTERNS, Capture, build_capture, write_capture
from avs.datasets.embedded.embedded_settings import EmbeddedSettings
from avs.datasets.embedded.geometry.raycast import Caster
from avs.scene.scene import read_scene
from avs.system.errors import UserError
from tests import tolerances

SMALL = EmbeddedSettings(views=16, long_side=64, texture_levels=6, gather_rays=8, bounces=1, points=500)
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def room() -> Capture:
    return build_capture("orbit", 1, SMALL)


@pytest.fixture(scope="module")
def garden() -> Capture:
    return build_capture("orbit", 0, SMALL)


@pytest.fixture(scope="module")
def facade() -> Capture:
    return build_capture("handheld", 1, SMALL)


@pytest.fixture(scope="module")
def room_caster(room: Capture) -> Caster:
    return Caster(room.mesh.vertices, room.mesh.triangles)


def _digest(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        digest.update(path.relative_to(folder).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


def test_same_seed_gives_same_bytes_on_any_number_of_threads(room, tmp_path):
    write_capture(room, "orbit", 1, tmp_path / "here")
    code = (
        "import sys; from pathlib import Path; from avs.datasets.embedded import make_scene;"
        "from avs.datasets.embedded.embedded_settings import EmbeddedSettings;"
        "make_scene('orbit', 1, EmbeddedSettings.model_validate_json(sys.argv[1]), Path(sys.argv[2]))"
    )
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    subprocess.run(
        [sys.executable, "-c", code, SMALL.model_dump_json(), str(tmp_path / "there")],
        check=True,
        cwd=ROOT,
        env=os.environ | threads | {"PYTHONHASHSEED": "7"},
    )
    assert _digest(tmp_path / "here") == _digest(tmp_path / "there")
    scene = read_scene(tmp_path / "here")
    assert (scene.name, scene.dataset) == ("orbit_1", "orbit")
    assert len(scene.views(scene.pool)) == len(scene.pool) == 14
    assert (tmp_path / "here" / "mesh.ply").is_file()
    assert len(list((tmp_path / "here" / "depth").iterdir())) == SMALL.views


def test_every_eighth_image_by_name_is_a_test_image(room):
    assert list(room.names) == sorted(room.names)
    assert room.test.tolist() == [0, 8]


def test_seeds_and_patterns_differ(room, garden, facade):
    images = [capture.images[0] for capture in (room, garden)]
    assert images[0].shape == images[1].shape
    assert np.abs(images[0].astype(int) - images[1]).mean() > 15
    vertices = {len(capture.mesh.vertices) for capture in (room, garden, facade)}
    assert len(vertices) == 3


@pytest.mark.parametrize(
    ("pattern", "shape"),
    [("orbit", (128, 192)), ("walkthrough", (108, 192)), ("handheld", (192, 108)), ("egocentric", (192, 192))],
)
def test_image_sizes_are_those_of_the_data_sets(pattern, shape):
    width, height = PATTERNS[pattern].lens.size(192)
    assert (height, width) == shape


def test_egocentric_field_of_view():
    lens = PATTERNS["egocentric"].lens
    focal = lens.cameras(np.eye(4)[None], 192).intrinsics[0, 0, 0]
    assert np.degrees(2 * np.arctan(96 / focal)) == pytest.approx(95)


def test_photographs_are_well_exposed(room, garden, facade):
    for capture in (room, garden, facade):
        values = np.stack(capture.images).astype(float)
        assert 60 < values.mean() < 190
        assert values.std() > 30
        assert (values < 3).mean() < 0.1
        assert (values > 252).mean() < 0.15


def test_orbit_looks_inwards_from_all_sides(room):
    centers = room.cameras.centers
    forward = room.cameras.world_to_camera[:, 2, :3]
    toward = np.array([0, 0, 0.8]) - centers
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    assert np.all(np.einsum("ij,ij->i", forward, toward) > np.cos(np.radians(30)))
    assert np.ptp(centers[:, 2]) > 0.5
    azimuth = np.sort(np.arctan2(centers[:, 1], centers[:, 0]))
    assert np.diff(np.append(azimuth, azimuth[0] + 2 * np.pi)).max() < np.radians(120)


def test_cameras_keep_clear_of_surfaces(room, room_caster):
    assert room_caster.clearance(room.cameras.centers.astype(np.float32)).min() > 0.1


def test_depth_is_that_of_the_mesh(room, room_caster):
    rng = np.random.default_rng(0)
    for index in (0, 5):
        height, width = room.depth[index].shape
        pixels = np.stack([rng.integers(width, size=200), rng.integers(height, size=200)], axis=1)
        center, directions = pixel_rays(room.cameras, index, pixels + 0.5)
        along = room_caster.nearest(np.broadcast_to(center, directions.shape), directions).distance
        along = np.where(np.isfinite(along), along, 0)
        np.testing.assert_allclose(room.depth[index][pixels[:, 1], pixels[:, 0]], along, rtol=tolerances.EMBEDDED_DEPTH)


def test_points_of_one_view_land_on_their_colour_in_another(garden):
    """Depth, poses and pixels belong together: what both views see has much the same colour."""
    pairs = [_pair(garden, first, first + 1) for first in range(6)]
    one, other = (np.concatenate(side) for side in zip(*pairs, strict=True))
    assert len(one) > 1000
    random = np.abs(one - np.random.default_rng(0).permutation(other)).mean()
    assert np.abs(one - other).mean() < tolerances.EMBEDDED_REPROJECTION * random


def _pair(capture: Capture, first: int, second: int) -> tuple[np.ndarray, np.ndarray]:
    """Colours of the surface points that both views see, in the one and in the other."""
    depth = capture.depth[first]
    rows, columns = np.nonzero(depth > 0)
    center, directions = pixel_rays(capture.cameras, first, np.stack([columns, rows], 1) + 0.5)
    spots = center + directions * depth[rows, columns][:, None]
    pixels, along = project(capture.cameras, second, spots)
    x, y = np.floor(pixels).astype(int).T
    there = inside(capture.cameras, second, pixels, along)
    there[there] &= np.abs(capture.depth[second][y[there], x[there]] / along[there] - 1) < 0.02
    one = capture.images[first][rows[there], columns[there]].astype(float)
    return one, capture.images[second][y[there], x[there]].astype(float)


def test_sparse_points_are_seen_where_they_say(room, room_caster):
    points = room.points
    assert 100 < len(points) <= SMALL.points
    rows, images = points.observations.T
    assert np.bincount(rows, minlength=len(points)).min() >= 3
    hidden = []
    for index in np.unique(images):
        spots = points.positions[rows[images == index]]
        pixels, along = project(room.cameras, index, spots)
        assert (along > 0).all()
        assert (np.abs(pixels - np.clip(pixels, 0, room.cameras.sizes[index])) < 3).all()
        # Pulled towards the camera by more than the points' error, nothing lies before them.
        center = room.cameras.centers[index].astype(np.float32)
        way = ((spots - center) * 0.93).astype(np.float32)
        hidden.append(room_caster.blocked(np.broadcast_to(center, way.shape), way, 1.0))
    assert np.concatenate(hidden).mean() < tolerances.EMBEDDED_HIDDEN


def test_four_views_do_not_see_everything(room):
    """Coverage of surface cells by four farthest views against all pool views."""

    def cells(index: int) -> set[bytes]:
        depth = room.depth[index]
        rows, columns = np.nonzero(depth > 0)
        center, directions = pixel_rays(room.cameras, index, np.stack([columns, rows], 1) + 0.5)
        spots = center + directions * depth[rows, columns][:, None]
        near = np.abs(spots).max(axis=1) < 3.5
        return {row.tobytes() for row in np.floor(spots[near] / 0.15).astype(np.int16)}

    pool = np.setdiff1d(np.arange(SMALL.views), room.test)
    chosen = [0]
    centers = room.cameras.centers[pool]
    while len(chosen) < 4:
        distance = np.linalg.norm(centers[:, None] - centers[chosen], axis=2).min(axis=1)
        chosen.append(int(distance.argmax()))
    everything = set().union(*(cells(index) for index in pool))
    four = set().union(*(cells(int(pool[k])) for k in chosen))
    assert 0.2 < len(four) / len(everything) < 0.85


def test_handheld_exposure_varies(facade):
    assert facade.images[0].shape == (64, 36, 3)
    means = np.array([image.mean() for image in facade.images])
    assert means.std() > 1


def test_unknown_pattern_is_refused(tmp_path):
    with pytest.raises(UserError, match="choose one of egocentric, handheld"):
        make_scene("panorama", 0, SMALL, tmp_path / "scene")
    assert not (tmp_path / "scene").exists()


def test_distances_and_weights_give_one_point(room, room_caster):
    generator = np.random.default_rng(0)
    origins = np.tile(np.asarray(room.mesh.vertices.mean(axis=0), np.float32), (5000, 1))
    directions = generator.normal(size=(5000, 3)).astype(np.float32)
    hits = room_caster.nearest(origins, directions)
    met = hits.triangle >= 0
    assert met.mean() > 0.9
    assert np.isinf(hits.distance[~met]).all()
    corners = room.mesh.vertices[room.mesh.triangles[hits.triangle[met]]]
    points = origins[met] + hits.distance[met, None] * directions[met]
    np.testing.assert_allclose((hits.weights[met, :, None] * corners).sum(axis=1), points, atol=1e-4)
