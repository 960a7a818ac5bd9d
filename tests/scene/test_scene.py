"""Scenes on disk: what comes back, what other tools read, what the hash covers, what damage does."""

import json
import shutil

import numpy as np
import pycolmap
import pytest
from PIL import Image
from plyfile import PlyData, PlyElement

from avs.scene.cameras import Cameras, look_at
from avs.scene.scene import Points, SceneFile, read_scene, write_scene
from avs.system.errors import UserError
from avs.system.records import read_record
from tests import tolerances

NAMES = ["a b.png", "deep/c.png", "z.png"]
SIZES = np.array([[12, 8], [10, 6], [12, 8]])


def parts(**changes):
    """The arguments of ``write_scene`` for three images of two cameras."""
    generator = np.random.default_rng(0)
    centers = [np.array([3.0, 0, 1]), np.array([0, 3.0, 1]), np.array([-3.0, 0, 2])]
    up = np.array([0, 0, 1.0])
    intrinsics = np.tile(np.array([[9.0, 0, 6], [0, 9.5, 4], [0, 0, 1]]), (3, 1, 1))
    return {
        "name": "toy_1",
        "dataset": "toys",
        "names": NAMES,
        "images": [generator.integers(0, 256, (height, width, 3), dtype=np.uint8) for width, height in SIZES],
        "cameras": Cameras(np.stack([look_at(center, np.zeros(3), up) for center in centers]), intrinsics, SIZES),
        "test": np.array([2]),
        "points": Points(
            generator.normal(size=(4, 3)) / 4,
            generator.integers(0, 256, (4, 3), dtype=np.uint8),
            np.array([[0, 0], [0, 2], [2, 1], [2, 2], [3, 0]]),
        ),
        "source": "a test",
        "licence": "none",
    } | changes


@pytest.fixture
def folder(tmp_path):
    write_scene(tmp_path / "toy", **parts())
    return tmp_path / "toy"


def test_what_is_written_comes_back(folder):
    given, scene = parts(), read_scene(folder)
    assert (scene.name, scene.dataset, scene.names, scene.source) == ("toy_1", "toys", tuple(NAMES), "a test")
    assert list(scene.test) == [2]
    assert list(scene.pool) == [0, 1]
    views = scene.views(np.array([2, 0]))
    np.testing.assert_array_equal(views.images[0], given["images"][2])
    np.testing.assert_array_equal(views.images[1], given["images"][0])
    np.testing.assert_array_equal(scene.cameras.sizes, given["cameras"].sizes)
    np.testing.assert_array_equal(scene.cameras.intrinsics, given["cameras"].intrinsics)
    np.testing.assert_allclose(
        scene.to_capture.cameras(scene.cameras).world_to_camera,
        given["cameras"].world_to_camera,
        atol=tolerances.FLOAT64_GEOMETRY,
    )
    np.testing.assert_allclose(
        scene.to_capture.points(scene.points.positions), given["points"].positions, atol=tolerances.FLOAT64_GEOMETRY
    )
    for field in ("colors", "observations"):
        np.testing.assert_array_equal(getattr(scene.points, field), getattr(given["points"], field))


def test_pycolmap_opens_it(folder):
    given, model = parts(), pycolmap.Reconstruction(folder / "sparse" / "0")
    cameras = read_scene(folder).cameras
    assert {camera.model_name for camera in model.cameras.values()} == {"PINHOLE"}
    assert model.num_cameras() == 2  # images that share intrinsics and size share a camera
    assert [model.images[i].name for i in sorted(model.images)] == NAMES
    assert model.compute_num_observations() == len(given["points"].observations)
    for index in range(3):
        image = model.images[index + 1]
        expected = cameras.world_to_camera[index, :3]
        np.testing.assert_allclose(image.cam_from_world().matrix(), expected, atol=tolerances.FLOAT64_GEOMETRY)
        for keypoint in image.get_observation_points2D():
            projected = image.project_point(model.points3D[keypoint.point3D_id].xyz)
            np.testing.assert_allclose(keypoint.xy, projected, atol=tolerances.FLOAT64_PIXELS)
    track = {(element.image_id - 1) for element in model.points3D[3].track.elements}
    assert track == {1, 2}


def test_equal_content_gives_equal_bytes(folder, tmp_path):
    write_scene(tmp_path / "again" / "toy", **parts())
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert len(files) == 7
    for path in files:
        assert (folder / path).read_bytes() == (tmp_path / "again" / "toy" / path).read_bytes(), path


def change_pixel():
    images = parts()["images"]
    images[1][0, 0, 0] ^= 1
    return {"images": images}


def change_camera():
    cameras = parts()["cameras"]
    cameras.intrinsics[0, 0, 2] += 1e-9
    return {"cameras": cameras}


def change_point():
    points = parts()["points"]
    points.colors[3, 0] ^= 1
    return {"points": points}


def change_observation():
    points = parts()["points"]
    return {"points": Points(points.positions, points.colors, points.observations[1:])}


CHANGES = {
    "pixel": change_pixel,
    "camera": change_camera,
    "point": change_point,
    "observation": change_observation,
    "split": lambda: {"test": np.array([1])},
    "name": lambda: {"names": ["a.png", *NAMES[1:]]},
    "depth": lambda: {"depth": [np.zeros((height, width), np.float32) for width, height in SIZES]},
}


@pytest.mark.parametrize("change", CHANGES)
def test_the_hash_covers(change, folder, tmp_path):
    write_scene(tmp_path / "other", **parts(**CHANGES[change]()))
    assert read_scene(tmp_path / "other").content_hash != read_scene(folder).content_hash


def test_the_hash_does_not_cover_how_pixels_are_packed(folder):
    path = folder / "images" / NAMES[0]
    Image.open(path).save(path, compress_level=9)
    assert len(read_scene(folder).views([0])) == 1


def test_files_are_copied_as_they_are(tmp_path):
    path = tmp_path / "in.jpg"
    Image.fromarray(parts()["images"][0]).save(path, quality=80)
    images = [path, *parts()["images"][1:]]
    write_scene(tmp_path / "toy", **parts(images=images, names=["a.jpg", *NAMES[1:]]))
    assert (tmp_path / "toy" / "images" / "a.jpg").read_bytes() == path.read_bytes()
    np.testing.assert_array_equal(read_scene(tmp_path / "toy").views([0]).images[0], np.array(Image.open(path)))


def test_depth_and_mesh_are_kept(tmp_path):
    vertices = np.array([(1, 2, 3, 7), (-1, 0, 2, 8)], dtype=[*((axis, "<f4") for axis in "xyz"), ("red", "u1")])
    PlyData([PlyElement.describe(vertices, "vertex")]).write(tmp_path / "in.ply")
    depth = [np.full((height, width), 2.5, np.float32) for width, height in SIZES]
    write_scene(tmp_path / "toy", **parts(depth=depth, mesh=tmp_path / "in.ply"))
    to_capture = read_scene(tmp_path / "toy").to_capture
    stored = np.load(tmp_path / "toy" / "depth" / "deep" / "c.npy")
    np.testing.assert_allclose(stored * to_capture.scale, depth[1], rtol=tolerances.FLOAT32_STORAGE)
    moved = PlyData.read(tmp_path / "toy" / "mesh.ply")["vertex"].data
    np.testing.assert_array_equal(moved["red"], vertices["red"])
    positions = to_capture.points(np.stack([moved[axis] for axis in "xyz"], axis=1).astype(np.float64))
    np.testing.assert_allclose(positions, [[1, 2, 3], [-1, 0, 2]], atol=10 * tolerances.FLOAT32_STORAGE)
    listed = read_record(tmp_path / "toy" / "scene.json", SceneFile)
    assert {"mesh.ply", "depth/a b.npy"} < set(listed.files)


def test_points_may_be_absent(tmp_path):
    none = Points(np.zeros((0, 3)), np.zeros((0, 3), np.uint8), np.zeros((0, 2), np.int64))
    write_scene(tmp_path / "toy", **parts(points=none))
    assert len(read_scene(tmp_path / "toy").points) == 0
    assert pycolmap.Reconstruction(tmp_path / "toy" / "sparse" / "0").num_points3D() == 0


CONTRADICTIONS = {
    "image names": {"names": NAMES[::-1]},
    "below images": {"names": ["../a.png", *NAMES[1:]]},
    "scene name": {"name": "Toy 1"},
    "behind its camera": {
        "points": Points(np.full((1, 3), 9.0), np.zeros((1, 3), np.uint8), np.array([[0, 0], [0, 1], [0, 2]]))
    },
    "does not exist": {"points": Points(np.zeros((1, 3)), np.zeros((1, 3), np.uint8), np.array([[1, 0]]))},
    "test holds": {"test": np.array([3])},
    "has shape": {"images": parts()["images"][1:] + parts()["images"][:1]},
}


@pytest.mark.parametrize("message", CONTRADICTIONS)
def test_parts_that_contradict_one_another_are_refused(message, tmp_path):
    with pytest.raises(ValueError, match=message):
        write_scene(tmp_path / "toy", **parts(**CONTRADICTIONS[message]))
    assert list(tmp_path.iterdir()) == []


def cut_model(folder):
    path = folder / "sparse" / "0" / "points3D.bin"
    path.write_bytes(path.read_bytes()[:-1])


FORGED = {
    "name": "other",
    "dataset": "others",
    "test": [NAMES[0]],
    "extent": 9.2,
    "to_capture": {"scale": 2.0, "translation": [0.0, 0.0, 0.0]},
    "notes": ["all is well"],
    "source": "elsewhere",
    "licence": "other",
}


@pytest.mark.parametrize("field", FORGED)
def test_nothing_in_the_scene_file_lies_outside_its_hash(field, folder):
    content = json.loads((folder / "scene.json").read_text())
    content[field] = FORGED[field]
    (folder / "scene.json").write_text(json.dumps(content))
    with pytest.raises(UserError, match=r"scene\.json: .*; prepare the scene again"):
        read_scene(folder)


DAMAGE = {
    r"scene\.json: is missing": lambda folder: (folder / "scene.json").unlink(),
    r"scene\.json: is not a JSON object": lambda folder: (folder / "scene.json").write_text("{"),
    r"scene\.json: its digest is missing": lambda folder: (folder / "scene.json").write_text("{}"),
    r"cameras\.bin: is missing": lambda folder: (folder / "sparse" / "0" / "cameras.bin").unlink(),
    r"points3D\.bin: is not the file that scene\.json lists": cut_model,
}


@pytest.mark.parametrize("message", DAMAGE)
def test_damage_of_a_scene_is_told_in_one_line(message, folder):
    DAMAGE[message](folder)
    with pytest.raises(UserError, match=message) as caught:
        read_scene(folder)
    assert "prepare the scene again" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_damage_of_an_image_is_told_when_it_is_read(folder):
    scene = read_scene(folder)
    path = folder / "images" / NAMES[0]
    shutil.copyfile(folder / "images" / NAMES[2], path)
    with pytest.raises(UserError, match=r"a b\.png: is not the image that scene\.json lists"):
        scene.views([0])
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(UserError, match=r"a b\.png: the image is damaged or cut off"):
        scene.views([0])
    path.unlink()
    with pytest.raises(UserError, match=r"a b\.png: the image is missing"):
        scene.views([0])
