"""Map-Free Relocalisation: a miniature of its layout becomes a scene; faults; the stored split."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image
from scipy.spatial.transform import Rotation

from avs.datasets.map_free import EVALUATION, TRAINING, MapFree, drawn_split
from tests import tolerances
from tests.datasets.reader_checks import assert_refused, first_scene
from tests.datasets.textured_factory import (
    CENTER,
    FOCAL,
    SIZE,
    assert_points_lie_on_the_surfaces,
    assert_poses_are,
    photograph,
    poses,
)

CONFIG = Path(__file__).parents[2] / "workflows" / "config" / "datasets"
NUMBERS = [0, 1, 2, 5, 6, 9, 12, 13, 14, 20]  # frame numbers skip


def make(folder):
    """Write a scene; seq1 holds the first two photographs once more, brighter, with poses of their own."""
    intrinsics, told = [], ["# path qw qx qy qz tx ty tz"]
    for sequence, chosen in (("seq0", range(10)), ("seq1", range(2))):
        (folder / sequence).mkdir(parents=True)
        for index in chosen:
            pose, name = poses()[index], f"{sequence}/frame_{NUMBERS[index]:05d}.jpg"
            pixels = photograph(pose) if sequence == "seq0" else np.minimum(photograph(pose), 235) + 20
            Image.fromarray(pixels.astype(np.uint8)).save(folder / name, quality=95, subsampling=0)
            x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat()
            told.append(" ".join([name, *(f"{value:.12g}" for value in (w, x, y, z, *pose[:3, 3]))]))
            intrinsics.append(f"{name} {FOCAL[0]} {FOCAL[1]} {CENTER[0]} {CENTER[1]} {SIZE[0]} {SIZE[1]}")
    (folder / "poses.txt").write_text("\n".join(told) + "\n")
    (folder / "intrinsics.txt").write_text("\n".join(intrinsics) + "\n")
    return folder


def prepared(folder, tmp_path, **settings):
    return first_scene(MapFree(folder=str(folder), **settings), tmp_path, "mapfree")


def test_a_scene_has_the_poses_given_and_points_triangulated_from_its_frames(tmp_path):
    scene = prepared(make(tmp_path / "train" / "s00003").parent, tmp_path)
    assert (scene.name, scene.dataset) == ("s00003", "mapfree")
    assert scene.names == tuple(f"seq0/frame_{number:05d}.jpg" for number in NUMBERS)
    assert_poses_are(scene, poses(), tolerances.POSES_OF_TEXT)
    assert_points_lie_on_the_surfaces(scene.to_capture.points(scene.points.positions), tolerances.TRIANGULATED)
    np.testing.assert_allclose(scene.cameras.intrinsics[0, (0, 1, 0, 1), (0, 1, 2, 2)], [*FOCAL, *CENTER])


def test_both_sequences_and_every_second_frame(tmp_path):
    scene = prepared(make(tmp_path / "s00003"), tmp_path, sequences=("seq0", "seq1"), every=2)
    assert [name[:4] for name in scene.names] == ["seq0"] * 5 + ["seq1"]
    assert "6 frames of seq0, seq1, every 2" in scene.notes


def cut(name):
    def damage(folder):
        content = (folder / name).read_bytes()
        (folder / name).write_bytes(content[: len(content) // 2])

    return damage


def edit(name, old, new, count=1):
    def damage(folder):
        content = (folder / name).read_text()
        changed, made = re.subn(old, new, content, count=count, flags=re.MULTILINE)
        assert made
        (folder / name).write_text(changed)

    return damage


POSE = r"^(seq0/frame_00005.jpg) .*$"
FAULTS = {
    "frame missing": (lambda folder: (folder / "seq0/frame_00005.jpg").unlink(), r"00005\.jpg: the image is missing"),
    "frame cut": (cut("seq0/frame_00005.jpg"), r"00005\.jpg: the image is damaged or cut off"),
    "no intrinsics": (lambda folder: (folder / "intrinsics.txt").unlink(), r"intrinsics\.txt: is missing; get"),
    "intrinsics cut": (cut("intrinsics.txt"), r"intrinsics\.txt: (line \d+ has \d numbers|has no line)"),
    "pose with NaN": (edit("poses.txt", POSE, r"\1 1 0 0 0 nan 0 0"), r"poses\.txt: line 5 has a number that"),
    "pose all zero": (edit("poses.txt", POSE, r"\1 0 0 0 0 0 0 0"), r"the pose of seq0/frame_00005\.jpg is all zero"),
    "pose cut": (edit("poses.txt", POSE, r"\1 1 0 0"), r"line 5 has 3 numbers, not 7"),
    "pose with words": (edit("poses.txt", POSE, r"\1 1 0 0 0 x 0 0"), r"line 5 is damaged: 'seq0/frame_00005"),
    "long quaternion": (edit("poses.txt", POSE, r"\1 2 0 0 0 0 0 0"), r"the quaternion of image seq0/frame_00005\.jpg"),
    "test split": (
        edit("poses.txt", r"^(seq\d/\S+) .*$", r"\1 0 0 0 0 0 0 0", 0),
        r"poses\.txt: has no poses, as the test split; take the scenes of train or val",
    ),
    "frame twice": (edit("poses.txt", POSE, r"seq0/frame_00002.jpg 1 0 0 0 0 0 0"), r"00002\.jpg twice"),
    "no text": (lambda folder: (folder / "poses.txt").write_bytes(b"\xff\xfe\x00"), r"poses\.txt: is no text"),
    "leaving the folder": (
        lambda folder: [edit(f"{name}.txt", "frame_00005", "../../x")(folder) for name in ("poses", "intrinsics")],
        r"points outside the folder s00003",
    ),
    "one frame": (edit("poses.txt", r"^seq0/(?!frame_00000).*\n", "", 0), r"has 1 poses of seq0; take other sequences"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_in_one_line_and_leaves_nothing(fault, tmp_path):
    folder = make(tmp_path / "s00003")
    damage, message = FAULTS[fault]
    damage(folder)
    assert_refused(lambda: prepared(folder, tmp_path), message, tmp_path)


def test_the_stored_split_is_the_one_that_seed_0_draws():
    names = [f"s{number:05d}" for number in range(460)]
    training, evaluation = drawn_split(names, 0)
    assert (len(training), len(evaluation)) == (TRAINING, EVALUATION) == (348, 11)
    assert not set(training) & set(evaluation)
    stored = [
        yaml.safe_load((CONFIG / f"{name}.yaml").read_text())["datasets"][name]["only"]
        for name in ("mapfree_training", "mapfree")
    ]
    assert stored == [training, evaluation]
    assert drawn_split(names[::-1], 0) == (training, evaluation) != drawn_split(names, 1)
