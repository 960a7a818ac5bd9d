"""The same capture in other units and elsewhere: the same reconstruction, exported to where the capture is."""

import numpy as np
import pytest
import torch
from plyfile import PlyData

from avs.representations.gaussians.gaussian_settings import GaussianSettings, InitialPoints
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.ply import read_ply
from avs.representations.gaussians.splats import GaussianSplats, build
from avs.scene.points import Points
from avs.scene.scene import read_scene, write_scene
from avs.scene.similarity import Similarity
from metrics.image import psnr
from tests import tolerances
from tests.factories import ring

SETTINGS = GaussianSettings.model_validate(
    {
        "iterations": 120,
        "points": {"choice": "sfm"},
        "densification": {"start": 20, "every": 20, "until": 100, "max_gaussians": 200},
    }
)
MOVES = (
    (1.0, (0, 0, 0)),
    (1e-3, (0, 0, 0)),
    (1e3, (0, 0, 0)),
    (1.0, (4.1e6, 6.3e5, 4.8e6)),
    (1.0, (5e5, 4.5e6, 120)),
    (1e3, (4e6, 4e6, 4e6)),
    (1e-3, (4e6, -4e6, 4e6)),
    (7.3, (-300, 20, 1e4)),
    (0.037, (0, 0, 1e5)),
    (123.4, (1, 2, 3)),
)
CAMERAS = ring(16, size=(48, 32))


@pytest.fixture(scope="module")
def capture():
    """Photographs of a cloud of Gaussians, and its points."""
    rng = np.random.default_rng(0)
    cloud = PointCloud(rng.normal(size=(80, 3)) / 1.5, rng.random((80, 3)))
    opaque = GaussianSettings(points=InitialPoints(opacity=0.9), background=(0.3, 0.5, 0.4))
    rendered = GaussianSplats(cloud, 1.0, opaque, rng, "cpu").render(CAMERAS).rgb
    observations = np.array([[p, i] for p in range(80) for i in range(16)])
    points = Points(cloud.positions, np.rint(255 * cloud.colors).astype(np.uint8), observations)
    return np.rint(255 * rendered).astype(np.uint8), points


def moved_scene(folder, capture, move):
    """Write the capture after ``move`` and read it."""
    images, points = capture
    to_there = Similarity(scale=move[0], translation=move[1])
    seen = ring(16, size=(48, 32)).world_to_camera[:, 2]
    ahead = points.positions[points.observations[:, 0]]
    depth = (seen[points.observations[:, 1], :3] * ahead).sum(axis=1) + seen[points.observations[:, 1], 3]
    write_scene(
        folder,
        name="toy",
        dataset="toys",
        names=[f"{index:02d}.png" for index in range(16)],
        images=list(images),
        cameras=to_there.cameras(CAMERAS),
        test=np.array([0, 8]),
        points=Points(to_there.points(points.positions), points.colors, points.observations[depth > 0]),
        source="a test",
        licence="none",
    )
    return read_scene(folder)


def fitted(scene, seed=0):
    """Return the reconstruction and its PSNR on the test images."""
    splats = build(scene, scene.pool, SETTINGS, seed, "cpu")
    splats.fit(scene.views(scene.pool), SETTINGS.iterations)
    rendered = np.rint(255 * splats.render(scene.cameras[scene.test]).rgb).astype(np.uint8)
    truth = scene.views(scene.test).images
    return splats, float(np.mean([psnr(a, b) for a, b in zip(rendered, truth, strict=True)]))


@pytest.fixture(scope="module")
def seeds(capture, tmp_path_factory):
    """PSNR of the capture as it is, for three seeds."""
    scene = moved_scene(tmp_path_factory.mktemp("scenes") / "toy", capture, MOVES[0])
    return [fitted(scene, seed)[1] for seed in range(3)]


@pytest.mark.parametrize("move", MOVES)
def test_ten_units_and_origins_give_one_psnr(move, capture, seeds, tmp_path):
    scene = moved_scene(tmp_path / "toy", capture, move)
    splats, found = fitted(scene)
    assert abs(found - seeds[0]) <= max(seeds) - min(seeds)
    # The coordinates that the capture came with still hold these digits, relative to its extent; float32 has 1e-7.
    lost = 1e-15 * np.linalg.norm(move[1]) / move[0]
    if lost < 1e-9:
        assert found == seeds[0]
    splats.export(tmp_path)
    read = read_ply(tmp_path / "splats.ply", scene.to_capture)
    for name in ("means", "scales"):
        np.testing.assert_allclose(read[name], splats.parameters[name].detach(), atol=1e-4, err_msg=name)


def positions_of(path):
    """Return the positions of a ``.ply`` file, and its offset."""
    vertex = PlyData.read(path)["vertex"]
    offset = [np.array(line.split()[1:], dtype=float) for line in vertex.comments if line.startswith("offset ")]
    return np.stack([vertex[axis] for axis in "xyz"], axis=1).astype(np.float64), offset


def exported(folder, to_capture):
    """Export two Gaussians of a scene."""
    cloud = PointCloud(np.array([[1.0, 2, 3], [-4, 0, 2], [0, 0, 0], [1, 1, 1]]), np.full((4, 3), 0.5))
    splats = GaussianSplats(cloud, 5.0, GaussianSettings(), np.random.default_rng(0), "cpu", to_capture)
    splats.export(folder)
    return splats


def test_exports_have_the_coordinates_of_the_capture(tmp_path):
    to_capture = Similarity(scale=3.0, translation=(10.0, -20.0, 0.5))
    splats = exported(tmp_path, to_capture)
    positions, offset = positions_of(tmp_path / "splats.ply")
    assert not offset
    np.testing.assert_allclose(positions[0], [13, -14, 9.5], rtol=tolerances.FLOAT32_STORAGE)
    scales = PlyData.read(tmp_path / "splats.ply")["vertex"]["scale_0"]
    expected = splats.parameters["scales"][:, 0].detach().numpy() + np.log(3)
    np.testing.assert_allclose(scales, expected, rtol=tolerances.FLOAT32_STORAGE)


def test_exports_far_from_the_origin_tell_their_offset_and_lose_nothing(tmp_path):
    to_capture = Similarity(scale=0.01, translation=(4100000.125, 630000.3, 4.8e6))
    splats = exported(tmp_path, to_capture)
    positions, (offset,) = positions_of(tmp_path / "splats.ply")
    np.testing.assert_allclose(positions + offset, to_capture.points(splats.centres.astype(float)), atol=1e-8)
    assert torch.allclose(read_ply(tmp_path / "splats.ply", to_capture)["means"], splats.parameters["means"], atol=1e-6)
    # the viewer of the 3DGS code takes the third line for the number of vertices
    assert (tmp_path / "splats.ply").read_bytes().split(b"\n")[2] == b"element vertex 4"


def test_black_points_learn_their_colours(capture, tmp_path):
    images, points = capture
    colors = np.zeros_like(points.colors)
    colors[0] = 1  # so that they are not taken for points without colours
    unseen = Points(points.positions, colors, points.observations[:0])  # so that no photograph tells their colour
    scene = moved_scene(tmp_path / "black", (images, unseen), MOVES[0])
    assert (scene.points.colors[1:] == 0).all()
    black = build(scene, scene.pool, SETTINGS, 0, "cpu")
    before = black.parameters["sh"][1:, 0].detach().clone()
    black.fit(scene.views(scene.pool), 20)
    moved = (black.parameters["sh"][1 : len(before) + 1, 0].detach() - before).abs().amax(dim=1)
    assert (moved > 0).float().mean() > 0.9


def test_the_extent_of_3dgs_is_a_choice(capture, tmp_path):
    scene = moved_scene(tmp_path / "toy", capture, MOVES[0])
    transforms = scene.cameras.world_to_camera
    transforms[3, :3, 3] = transforms[3, :3, :3] @ [-3000, 0, 0]
    assert build(scene, scene.pool, SETTINGS, 0, "cpu").extent == scene.extent
    original = SETTINGS.model_copy(update={"extent": "all_cameras"})
    assert build(scene, scene.pool, original, 0, "cpu").extent > 1000
