"""Intrinsics and clouds that do not go with the pictures are told of, whoever stated them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from plyfile import PlyData, PlyElement

from avs.datasets.aria_dtc import AriaDtc
from avs.datasets.capture_geometry import geometry_notes
from avs.datasets.captures import Captures
from avs.datasets.stored_points import read_ply
from avs.datasets.transforms_file import model_of, read_transforms
from avs.scene.scene import read_scene
from avs.system.errors import UserError
from tests.datasets.test_nerfstudio import make, prepared
from tests.datasets.textured_factory import FLOOR, FOCAL, SIZE

DOUBTS = ("times the focal lengths", "principal point", "points on which pictures agree", "on hardly any point")


def doubts(scene):
    return [word for word in DOUBTS if any(word in note for note in scene.notes)]


def changed(folder, change):
    path = folder / "transforms.json"
    told = json.loads(path.read_text())
    change(told)
    path.write_text(json.dumps(told))
    return folder


def surfaces(count=2000):
    """Points of the wall and the floor."""
    draw = np.random.default_rng(1)
    wall = np.stack([draw.uniform(-2, 2, count), draw.uniform(-1, FLOOR, count), np.zeros(count)], axis=1)
    floor = np.stack([draw.uniform(-2, 2, count), np.full(count, FLOOR), draw.uniform(-2, 0, count)], axis=1)
    return np.concatenate([wall, floor])


def write_cloud(path, positions, color=(90, 80, 70), kind="u1"):
    names = [*((axis, "f8") for axis in "xyz"), *((name, kind) for name in ("red", "green", "blue"))]
    rows = np.array([(*point, *color) for point in positions], dtype=names)
    PlyData([PlyElement.describe(rows, "vertex")]).write(path)


def test_right_intrinsics_are_not_doubted(tmp_path):
    assert doubts(prepared(make(tmp_path / "a"), tmp_path)) == []


@pytest.mark.parametrize("scale", [0.6, 1.5])
def test_other_focal_lengths_are_told_of(tmp_path, scale):
    def change(told):
        told["fl_x"], told["fl_y"] = FOCAL[0] * scale, FOCAL[1] * scale

    scene = prepared(changed(make(tmp_path / "a"), change), tmp_path)
    assert "times the focal lengths" in doubts(scene)


def test_intrinsics_of_half_the_picture_are_told_of(tmp_path):
    def change(told):
        for key in ("fl_x", "fl_y", "cx", "cy"):
            told[key] /= 2
        del told["w"], told["h"]

    assert "principal point" in doubts(prepared(changed(make(tmp_path / "a"), change), tmp_path))


@pytest.mark.parametrize(
    ("move", "expected"),
    [
        (lambda cloud: cloud, []),
        (lambda cloud: cloud * 10, ["points on which pictures agree"]),
        (lambda cloud: cloud + np.array([0, 0, 1.5]), ["points on which pictures agree"]),
        (lambda cloud: cloud[:3], ["points on which pictures agree"]),
    ],
)
def test_a_stored_cloud_that_lies_beside_what_pictures_show_is_told_of(tmp_path, move, expected):
    folder = make(tmp_path / "a", ply_file_path="cloud.ply")
    write_cloud(folder / "cloud.ply", move(surfaces()))
    assert doubts(prepared(folder, tmp_path, points="stored")) == expected


@pytest.mark.parametrize("exchanged", [False, True])
def test_two_pictures_exchanged_are_both_named(tmp_path, shared_scenes, exchanged):
    captures = Captures(folder=str(shared_scenes), only=("fox",), long_side=160).scenes()
    captures["fox"].prepare("mine", tmp_path / "fox")
    scene = read_scene(tmp_path / "fox")
    views = scene.views(np.arange(25))
    order = np.arange(25)
    if exchanged:
        order[[4, 12]] = order[[12, 4]]
    notes = geometry_notes(replace(views, cameras=views.cameras[order]), scene.points.positions)
    if not exchanged:
        assert notes == []
        return
    (note,) = notes
    assert note.startswith("2 of 25 pictures agree with their neighbours on hardly any point")
    assert views.names[4] in note
    assert views.names[12] in note


def test_pictures_that_the_file_does_not_list_are_counted(tmp_path):
    scene = prepared(changed(make(tmp_path / "a"), lambda told: told["frames"].__delitem__(slice(7, None))), tmp_path)
    assert any("3 of 10" in note for note in scene.notes), scene.notes


def test_one_picture_is_refused(tmp_path):
    folder = changed(make(tmp_path / "a"), lambda told: told["frames"].__delitem__(slice(1, None)))
    with pytest.raises(UserError, match="use two pictures or more"):
        prepared(folder, tmp_path)


def camera_of(folder):
    transforms = read_transforms(folder / "transforms.json")
    model = model_of(transforms, {name: SIZE for name, _ in transforms.frames}, "opengl", "half")
    return model.cameras[1]


def test_instant_ngp_s_fisheye_is_one(tmp_path):
    folder = changed(make(tmp_path / "a"), lambda told: told.update(is_fisheye=True, k1=0.05, k2=0.01))
    camera = camera_of(folder)
    assert (camera.model, camera.params[4:]) == ("OPENCV_FISHEYE", (0.05, 0.01, 0.0, 0.0))


def test_what_a_frame_says_goes_before_what_the_file_says_under_another_name(tmp_path):
    def change(told):
        told["fl_x"] *= 1.3
        for frame in told["frames"]:
            frame["fx"] = FOCAL[0]

    assert camera_of(changed(make(tmp_path / "a"), change)).params[:2] == FOCAL


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda told: told.pop("h"), "states one of w and h alone"),
        (lambda told: told.update(fl_y=0), "focal"),
        (lambda told: told["frames"][0].update(file_path="images"), "is a folder, not a picture"),
    ],
)
def test_contradictions_are_refused(tmp_path, change, message):
    with pytest.raises(UserError, match=message):
        prepared(changed(make(tmp_path / "a"), change), tmp_path)


def test_two_rectified_exports_are_not_chosen_between(tmp_path):
    one = make(tmp_path / "recording" / "camera-rgb-rectified-600-h1000", axes="opencv", shift=0.5)
    prepared(tmp_path / "recording", tmp_path, AriaDtc, axes="opencv")
    make(one.with_name("camera-rgb-rectified-1200-h1000"), axes="opencv", shift=0.5)
    with pytest.raises(UserError, match="has several exports: camera-rgb-rectified-1200-h1000, camera-rgb-rectified-6"):
        prepared(tmp_path / "recording", tmp_path, AriaDtc, axes="opencv")


@pytest.mark.parametrize(
    ("color", "kind"),
    [((90, 80, 70), "u1"), ((90 * 257, 80 * 257, 70 * 257), "u2"), ((90 / 255, 80 / 255, 1.001), "f4")],
)
def test_colours_of_clouds_come_in_bytes_16_bits_or_shares(tmp_path, color, kind):
    write_cloud(tmp_path / "cloud.ply", surfaces(5), color, kind)
    expected = (90, 80, 255) if kind == "f4" else (90, 80, 70)
    assert (read_ply(tmp_path / "cloud.ply").colors == expected).all()


def test_other_colours_of_clouds_are_refused(tmp_path):
    write_cloud(tmp_path / "cloud.ply", surfaces(5), (300.0, 0.0, 0.0), "f4")
    with pytest.raises(UserError, match=r"neither in 0\.\.1 nor in 0\.\.255"):
        read_ply(tmp_path / "cloud.ply")
