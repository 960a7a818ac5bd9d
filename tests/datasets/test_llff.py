"""Captures in LLFF's form: geometry and faults."""

import numpy as np
import pytest
from PIL import Image

from avs.datasets.llff import Llff
from tests import tolerances
from tests.datasets.reader_checks import assert_refused, first_scene
from tests.datasets.textured_factory import (
    FOCAL,
    SIZE,
    assert_points_lie_on_the_surfaces,
    assert_poses_are,
    photograph,
    poses,
)


def make(folder, count=10):
    (folder / "images").mkdir(parents=True)
    rows = []
    for number, pose in enumerate(poses(count)):
        pixels = photograph(pose, focal=(FOCAL[0],) * 2, center=(SIZE[0] / 2, SIZE[1] / 2))
        Image.fromarray(pixels).save(folder / "images" / f"IMG_{number:04d}.png")
        right, down, forward = pose[:3, :3]
        matrix = np.stack([down, right, -forward, -pose[:3, :3].T @ pose[:3, 3], [SIZE[1], SIZE[0], FOCAL[0]]], axis=1)
        rows.append([*matrix.ravel(), 1.0, 9.0])
    np.save(folder / "poses_bounds.npy", np.array(rows))
    return folder


def prepared(folder, tmp_path):
    return first_scene(Llff(folder=str(folder), long_side=None), tmp_path)


def test_poses_and_intrinsics_are_read(tmp_path):
    folder = make(tmp_path / "Fern")
    scene = prepared(folder, tmp_path)
    assert_poses_are(scene, poses(), tolerances.POSES_OF_TEXT)
    assert_points_lie_on_the_surfaces(scene.to_capture.points(scene.points.positions), tolerances.TRIANGULATED)
    np.testing.assert_allclose(scene.cameras.intrinsics[0, (0, 1, 0, 1), (0, 1, 2, 2)], [FOCAL[0], FOCAL[0], 120, 90])
    assert Llff(folder=str(folder)).examine() == "10 pictures with poses, 240 x 180 pixels in the scene"


def change(rows):
    def damage(folder):
        table = np.load(folder / "poses_bounds.npy")
        np.save(folder / "poses_bounds.npy", rows(table))

    return damage


def with_value(value, *place):
    def changed(table):
        table[place] = value
        return table

    return changed


FAULTS = {
    "another number of pictures": (lambda folder: (folder / "images/IMG_0003.png").unlink(), r"has 10 poses, .* 9 p"),
    "NaN": (change(with_value(np.nan, 3, 2)), r"poses_bounds\.npy: the pose 3 is not finite"),
    "all zero": (change(with_value(0, 3, slice(15))), r"the pose of IMG_0003\.png is all zero|no size"),
    "mirrored": (change(with_value(0.5, 3, 0)), r"the pose of IMG_0003\.png has no rotation"),
    "another shape": (change(lambda table: table[:, :15]), r"holds float64 of shape \(10, 15\), not n x 17 numbers"),
    "objects": (
        lambda folder: np.save(folder / "poses_bounds.npy", np.array([{}]), allow_pickle=True),
        r"poses_bounds\.npy: is damaged or cut off, or no table of numbers",
    ),
    "cut": (
        lambda folder: (folder / "poses_bounds.npy").write_bytes((folder / "poses_bounds.npy").read_bytes()[:300]),
        r"poses_bounds\.npy: is damaged or cut off",
    ),
    "picture cut": (
        lambda folder: (folder / "images/IMG_0002.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(9)),
        r"IMG_0002\.png: the image is damaged or cut off",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_in_one_line_and_leaves_nothing(fault, tmp_path):
    folder = make(tmp_path / "a")
    damage, message = FAULTS[fault]
    damage(folder)
    assert_refused(lambda: prepared(folder, tmp_path), message, tmp_path)
