"""Captures in nerfstudio's form and Aria's two: geometry, axes, sizes, faults."""

import json

import numpy as np
import pycolmap
import pytest
from PIL import Image
from plyfile import PlyData, PlyElement

from avs.datasets.aria_dtc import AriaDtc
from avs.datasets.nerfstudio import Nerfstudio
from avs.datasets.transforms_file import model_of, read_transforms
from avs.system.errors import UserError
from tests import tolerances
from tests.datasets.reader_checks import assert_refused, first_scene
from tests.datasets.textured_factory import (
    CENTER,
    FLOOR,
    FOCAL,
    SIZE,
    assert_points_lie_on_the_surfaces,
    assert_poses_are,
    photograph,
    poses,
)

GL = np.diag([1.0, -1.0, -1.0, 1.0])


def make(folder, *, axes="opengl", shrink=1, per_frame=False, shift=0.0, keys=("fl_x", "fl_y", "file_path"), **more):
    """Write a capture; the pictures are ``shrink`` times smaller than the file says."""
    (folder / "images").mkdir(parents=True)
    width, height = SIZE
    intrinsics = {keys[0]: FOCAL[0], keys[1]: FOCAL[1], "cx": CENTER[0] - shift, "cy": CENTER[1] - shift}
    intrinsics |= {"w": width, "h": height}
    frames = []
    for number, pose in enumerate(poses()):
        pixels = Image.fromarray(photograph(pose)).resize((width // shrink, height // shrink), Image.Resampling.BOX)
        pixels.save(folder / "images" / f"{number:03d}.png")
        matrix = np.linalg.inv(pose) @ (GL if axes == "opengl" else np.eye(4))
        frame = {keys[2]: f"images/{number:03d}.png", "transform_matrix": matrix.tolist()}
        frames.append(frame | (intrinsics if per_frame else {}))
    told = {"frames": frames, **({} if per_frame else intrinsics), **more}
    (folder / "transforms.json").write_text(json.dumps(told))
    return folder


def cloud(folder, count=500):
    draw = np.random.default_rng(1)
    wall = np.stack([draw.uniform(-1, 1, count), draw.uniform(-0.6, FLOOR, count), np.zeros(count)], axis=1)
    rows = np.array(
        [(*point, 90, 80, 70 + row % 2) for row, point in enumerate(wall)],
        dtype=[*((axis, "f4") for axis in "xyz"), *((name, "u1") for name in ("red", "green", "blue"))],
    )
    PlyData([PlyElement.describe(rows, "vertex")]).write(folder / "cloud.ply")


def prepared(folder, tmp_path, reader=Nerfstudio, **settings):
    return first_scene(reader(folder=str(folder), **{"axes": "opengl", "long_side": None} | settings), tmp_path)


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return make(tmp_path_factory.mktemp("captures") / "Room 1")


def test_a_capture_becomes_a_scene_with_triangulated_points(room, tmp_path):
    scene = prepared(room, tmp_path)
    assert (scene.name, scene.dataset, len(scene.names), list(scene.test)) == ("room_1", "mine", 10, [0, 8])
    assert_poses_are(scene, poses(), tolerances.POSES_OF_TEXT)
    np.testing.assert_allclose(scene.cameras.intrinsics[3, (0, 1, 0, 1), (0, 1, 2, 2)], [*FOCAL, *CENTER])
    assert_points_lie_on_the_surfaces(scene.to_capture.points(scene.points.positions), tolerances.TRIANGULATED)
    assert len(scene.points.observations) > 2 * len(scene.points)
    assert any("points are triangulated from all pictures" in note for note in scene.notes)


def test_wrong_axes_are_found_and_the_right_ones_named(room, tmp_path):
    with pytest.raises(
        UserError, match=r"transforms\.json: with axes opencv, three pictures agree on \d+ points, .*; set axes: opengl"
    ):
        prepared(room, tmp_path, axes="opencv")


def test_axes_have_no_default():
    with pytest.raises(ValueError, match="axes"):
        Nerfstudio(folder=".")


def test_pictures_smaller_than_the_file_says_get_their_own_intrinsics(tmp_path):
    scene = prepared(make(tmp_path / "a", shrink=2), tmp_path)
    np.testing.assert_allclose(scene.cameras.intrinsics[0, 0, 0], FOCAL[0] / 2)
    assert tuple(scene.cameras.sizes[0]) == (120, 90)
    assert "all images have another size than transforms.json states, 120x90 and not 240x180: scaled" in scene.notes


def test_stored_points_are_read_and_wrong_axes_found(tmp_path):
    folder = make(tmp_path / "a", ply_file_path="cloud.ply", per_frame=True)
    cloud(folder)
    scene = prepared(folder, tmp_path, points="stored")
    assert len(scene.points) == 500
    assert tuple(scene.points.colors[0]) == (90, 80, 70)
    assert not len(scene.points.observations)
    with pytest.raises(UserError, match=r"a camera sees 0\.0% of the points on average, .*; set axes: opengl"):
        prepared(folder, tmp_path, points="stored", axes="opencv")


def test_metas_form_of_aria_has_other_axes_keys_and_pixel_centres(tmp_path):
    inner = tmp_path / "Dish_active" / "camera-rgb-rectified-600-h1000"
    make(inner, axes="opencv", per_frame=True, shift=0.5, keys=("fx", "fy", "image_path"), camera_model="linear")
    scene = prepared(tmp_path / "Dish_active", tmp_path, AriaDtc, axes="opencv")
    assert scene.name == "dish_active"
    assert_poses_are(scene, poses(), tolerances.POSES_OF_TEXT)
    np.testing.assert_allclose(scene.cameras.intrinsics[0, (0, 1), 2], CENTER)


def test_nerfstudios_form_of_aria(room, tmp_path):
    scene = prepared(room, tmp_path, AriaDtc, pixel_centers="half", long_side=120)
    assert_poses_are(scene, poses(), tolerances.POSES_OF_TEXT)
    assert tuple(scene.cameras.sizes[0]) == (120, 90)
    assert AriaDtc(folder=".", axes="opengl").long_side == 707


def test_the_parameters_of_aria_s_lens_are_in_colmap_s_order(tmp_path):
    """Projected once more by the formula that Aria's documentation gives."""
    lens = [0.2, -0.1, 0.03, 0.02, -0.01, 0.005, 0.003, -0.002, 0.001, 0.002, -0.001, 0.0005]
    folder = make(tmp_path / "a", camera_model="FISHEYE624", distortion_params=lens)
    told = read_transforms(folder / "transforms.json")
    camera = next(iter(model_of(told, dict.fromkeys(dict(told.frames), SIZE), "opengl", "half").cameras.values()))
    ours = pycolmap.Camera(model=camera.model, width=SIZE[0], height=SIZE[1], params=camera.params)
    x, y = 0.4, -0.3
    radius = np.hypot(x, y)
    angle = np.arctan(radius)
    bent = angle + sum(value * angle ** (2 * power + 3) for power, value in enumerate(lens[:6]))
    u, v = bent * x / radius, bent * y / radius
    square, (p0, p1, s0, s1, s2, s3) = u * u + v * v, lens[6:]
    expected = [
        u + (2 * u * u + square) * p0 + 2 * u * v * p1 + s0 * square + s1 * square**2,
        v + (2 * v * v + square) * p1 + 2 * u * v * p0 + s2 * square + s3 * square**2,
    ]
    np.testing.assert_allclose(ours.img_from_cam([x, y, 1.0]), np.array(expected) * FOCAL + CENTER, atol=1e-9)


def edit(**changes):
    def damage(folder):
        path = folder / "transforms.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | changes))

    return damage


def edit_frame(number=3, **changes):
    def damage(folder):
        path = folder / "transforms.json"
        told = json.loads(path.read_text())
        told["frames"][number] |= changes
        path.write_text(json.dumps(told))

    return damage


def cut(name):
    def damage(folder):
        content = (folder / name).read_bytes()
        (folder / name).write_bytes(content[: len(content) // 2])

    return damage


NAN = [[float("nan")] * 4] * 4
FAULTS = {
    "picture missing": (lambda folder: (folder / "images/002.png").unlink(), r"images/002\.png: the image is missing"),
    "picture cut": (cut("images/002.png"), r"images/002\.png: the image is damaged or cut off"),
    "cameras cut": (cut("transforms.json"), r"transforms\.json: is damaged or cut off: it is no JSON; copy"),
    "no frame": (edit(frames=[]), r"frames: must have at least 1"),
    "pose with NaN": (edit_frame(transform_matrix=NAN), r"frames\.3\.transform_matrix\.0\.0: must be a finite number"),
    "pose all zero": (edit_frame(transform_matrix=[[0.0] * 4] * 4), r"the pose of images/003\.png is all zero"),
    "pose that scales": (
        edit_frame(transform_matrix=(np.eye(4) * 0.01).tolist()),
        r"the pose of images/003\.png has no rotation, but a matrix that scales",
    ),
    "pose without a number": (edit_frame(transform_matrix=[[1.0, 0, 0]] * 4), r"x\.0: must have at least 4"),
    "picture twice": (edit_frame(file_path="images/001.png"), r"lists the picture images/001\.png twice"),
    "no picture": (edit_frame(file_path=""), r"frames\.3 has neither file_path nor image_path"),
    "leaving the folder": (edit_frame(file_path="../../x.png"), r"\.\./\.\./x\.png lies outside of its folder"),
    "another shape": (edit(w=100), r"000\.png: the image is 240 x 180 pixels, its camera 100 x 180"),
    "no size": (edit(w=None, h=None, cx=961.0), r"principal point \(961, 92\) lies outside of images/000\.png"),
    "no focal length": (edit(fl_x=None), r"states no focal length for images/000\.png"),
    "negative focal length": (edit(fl_x=-3.0), r"transforms\.json: camera 1 has a focal length that is not positive"),
    "panorama": (edit(camera_model="EQUIRECTANGULAR"), r"camera EQUIRECTANGULAR of images/000\.png, .* undistorted"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_in_one_line_and_leaves_nothing(fault, tmp_path):
    folder = make(tmp_path / "a")
    damage, message = FAULTS[fault]
    damage(folder)
    assert_refused(lambda: prepared(folder, tmp_path), message, tmp_path)


CLOUD_FAULTS = {
    "missing": (lambda folder: (folder / "cloud.ply").unlink(), r"cloud\.ply: the cloud is missing"),
    "cut": (cut("cloud.ply"), r"cloud\.ply: the cloud is damaged"),
    "behind a camera": (
        edit_frame(transform_matrix=(np.linalg.inv(poses()[3]) @ np.diag([-1.0, 1, -1, 1]) @ GL).tolist()),
        r"all points lie behind the cameras of 1 images \(images/003\.png\)",
    ),
    "not named": (edit(ply_file_path=None), r"names no cloud \(ply_file_path\); set points: triangulated"),
}


@pytest.mark.parametrize("fault", CLOUD_FAULTS)
def test_a_fault_of_the_cloud_is_told_in_one_line(fault, tmp_path):
    folder = make(tmp_path / "a", ply_file_path="cloud.ply")
    cloud(folder)
    damage, message = CLOUD_FAULTS[fault]
    damage(folder)
    with pytest.raises(UserError, match=message):
        prepared(folder, tmp_path, points="stored")


def test_scenes_are_chosen_by_name_and_missing_ones_told(tmp_path):
    for name in ("one", "two"):
        make(tmp_path / "all" / name)
    Image.new("RGB", SIZE, "red").save(tmp_path / "all" / "two" / "images" / "000.png")
    chosen = Nerfstudio(folder=str(tmp_path / "all"), axes="opengl", only=("two", "three"))
    assert list(chosen.scenes()) == ["two"]
    assert "is not there" in str(chosen.left_out()["three"])
    assert all(path.is_file() for path in chosen.scenes()["two"].files())
    with pytest.raises(UserError, match=r"holds none of the scenes that `only` names \(four\), but one, two"):
        Nerfstudio(folder=str(tmp_path / "all"), axes="opengl", only=("four",)).scenes()
