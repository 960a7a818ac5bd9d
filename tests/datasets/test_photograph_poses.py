"""Poses of plain photographs and of a video, against the ones that they were made with."""

import json
import re
import shutil

import numpy as np
import pytest
from PIL import Image

from avs.datasets.captures import Captures
from avs.datasets.photograph_origin import Origin
from avs.datasets.photograph_poses import write_capture
from avs.scene.cameras import look_at
from avs.scene.colmap import read_model
from avs.scene.colmap.conversion import rotation_matrix, sorted_images
from avs.system.errors import UserError
from avs.system.records import write_record
from tests import tolerances
from tests.datasets.test_realestate10k import write_video
from tests.datasets.textured_factory import SIZE, photograph, poses

WALK = poses(12)
LENS = {"focal": (212.0, 212.0), "center": (SIZE[0] / 2, SIZE[1] / 2)}  # as structure from motion supposes it


def photographs(folder, count=12):
    (folder / "some").mkdir(parents=True)
    for number, pose in enumerate(WALK[:count]):
        Image.fromarray(photograph(pose, **LENS)).save(folder / "some" / f"{number:02d}.png")
    return folder


def found(source, out, **settings):
    lines = []
    write_capture(
        source, out, **{"lens": "SIMPLE_RADIAL", "ordered": False, "rate": 2.0, "tell": lines.append} | settings
    )
    return lines


def assert_poses_agree(capture, expected):
    """After the best similarity, rotations and centres are those of ``expected``, in the order of names."""
    images = sorted_images(read_model(capture / "sparse" / "0"))
    assert len(images) == len(expected)
    rotations = np.stack([rotation_matrix(image.quaternion) for image in images])
    centers = np.stack([-rotation.T @ image.translation for rotation, image in zip(rotations, images, strict=True)])
    wanted = np.stack([-pose[:3, :3].T @ pose[:3, 3] for pose in expected])
    ours, theirs = centers - centers.mean(axis=0), wanted - wanted.mean(axis=0)
    left, scales, right = np.linalg.svd(theirs.T @ ours)
    sign = np.diag([1, 1, np.linalg.det(left @ right)])
    turn, scale = left @ sign @ right, (scales * np.diag(sign)).sum() / (ours**2).sum()
    errors = np.linalg.norm(scale * ours @ turn.T - theirs, axis=1) / np.linalg.norm(theirs, axis=1).max()
    assert errors.max() < tolerances.FOUND_CENTERS
    traces = np.einsum("nij,jk,nik->n", expected[:, :3, :3], turn, rotations)
    assert np.degrees(np.arccos(np.clip((traces - 1) / 2, -1, 1))).max() < tolerances.FOUND_ROTATIONS


def test_photographs_become_a_capture_that_is_read(tmp_path):
    lines = found(photographs(tmp_path / "in"), tmp_path / "out" / "room")
    assert lines[0].startswith("12 photographs in")
    assert any(
        re.search(r"12 of 12 photographs have a pose, with \d+ points and a mean reprojection", line) for line in lines
    )
    assert_poses_agree(tmp_path / "out" / "room", WALK)
    assert list(Captures(folder=str(tmp_path / "out")).scenes()) == ["room"]
    assert (tmp_path / "out" / "room" / "images" / "some" / "00.png").is_file()


def test_a_photograph_of_something_else_is_told(tmp_path):
    photographs(tmp_path / "in", 8)
    Image.fromarray(np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)).save(tmp_path / "in" / "some" / "99.png")
    lines = found(tmp_path / "in", tmp_path / "room")
    assert any("8 of 9 photographs have a pose" in line for line in lines)
    assert "without a pose: some/99.png" in lines


def test_a_video_becomes_a_capture(tmp_path):
    write_video(tmp_path / "walk.mp4", [photograph(pose, **LENS) for pose in WALK])
    lines = found(tmp_path / "walk.mp4", tmp_path / "room", rate=10.0)
    assert lines[0].startswith("12 frames of")
    assert_poses_agree(tmp_path / "room", WALK)


def test_fewer_frames_a_second_are_taken(tmp_path):
    write_video(tmp_path / "walk.mp4", [photograph(pose, **LENS) for pose in WALK])
    assert found(tmp_path / "walk.mp4", tmp_path / "room", rate=5.0)[0].startswith("6 frames of")


def flat(folder):
    """Photographs without texture."""
    folder.mkdir()
    for number in range(4):
        Image.new("RGB", SIZE, (number * 9, 90, 90)).save(folder / f"{number}.png")


def damaged(folder):
    photographs(folder, 4)
    (folder / "some" / "02.png").write_bytes(b"\x89PNG no")


def cut(folder):
    """A photograph whose header is whole."""
    photographs(folder, 4)
    content = (folder / "some" / "02.png").read_bytes()
    (folder / "some" / "02.png").write_bytes(content[: len(content) // 2])


FAULTS = {
    "no folder": (lambda folder: None, r"in: there is no such folder or video"),
    "few": (lambda folder: photographs(folder, 2), r"in: holds 2 photographs, fewer than 3; take more"),
    "empty": (lambda folder: folder.mkdir(), r"in: holds 0 photographs"),
    "no texture": (flat, r"in: no two of its 4 photographs could be placed; take photographs that overlap"),
    "damaged": (damaged, r"02\.png: the image is damaged or cut off"),
    "cut": (cut, r"02\.png: the image is damaged or cut off"),
    "a single picture": (
        lambda folder: Image.new("RGB", SIZE).save(folder.with_suffix(".jpg")),
        r"in\.jpg: is a single picture; give the folder with all photographs, or a video",
    ),
    "no video": (lambda folder: folder.write_bytes(bytes(999)), r"in: the video cannot be decoded"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_one_line_and_leaves_nothing(fault, tmp_path):
    make, message = FAULTS[fault]
    make(tmp_path / "in")
    source = next(tmp_path.iterdir(), tmp_path / "in")
    with pytest.raises(UserError, match=message):
        found(source, tmp_path / "out")
    assert {path.name for path in tmp_path.iterdir()} <= {source.name}


def test_a_capture_that_does_not_tell_what_it_was_made_of_is_kept(tmp_path):
    (tmp_path / "out").mkdir()
    with pytest.raises(UserError, match=r"out: is there already, and no made_of\.json in it tells"):
        found(photographs(tmp_path / "in"), tmp_path / "out")


def replaced_photograph(folder):
    Image.fromarray(photograph(WALK[9], **LENS)).save(folder / "some" / "01.png")


OTHERS = {
    "replaced": (replaced_photograph, {}, r"was made before these changed, came or went: some/01\.png; remove it"),
    "new": (
        lambda folder: shutil.copy(folder / "some" / "01.png", folder / "z.png"),
        {},
        r"changed, came or went: z\.png; ",
    ),
    "gone": (lambda folder: (folder / "some" / "01.png").unlink(), {}, r"came or went: some/01\.png; "),
    "another lens": (lambda folder: None, {"lens": "OPENCV"}, r"other options \(lens SIMPLE_RADIAL, not ordered\); "),
    "ordered": (lambda folder: None, {"ordered": True}, r"was made with other options"),
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Photographs in ``one/trip``, and the capture of them, ``out``."""
    folder = tmp_path_factory.mktemp("made")
    found(photographs(folder / "one" / "trip", 6), folder / "out")
    return folder


@pytest.fixture
def again(made, tmp_path):
    shutil.copytree(made, tmp_path / "again")
    told = json.loads((tmp_path / "again" / "out" / "made_of.json").read_text())
    del told["digest"]
    write_record(
        tmp_path / "again" / "out" / "made_of.json",
        Origin(**told | {"place": str(tmp_path / "again" / "one" / "trip")}),
    )
    return tmp_path / "again"


def test_the_same_photographs_and_options_are_used_as_they_are(again):
    before = (again / "out" / "sparse" / "0" / "images.bin").read_bytes()
    lines = found(again / "one" / "trip", again / "out", rate=9.0)
    assert lines == [f"{again / 'out'}: is there already, made of the same as now; it is used as it is"]
    shutil.copytree(again / "one" / "trip", again / "copy")
    assert found(again / "copy", again / "out") == lines
    assert (again / "out" / "sparse" / "0" / "images.bin").read_bytes() == before
    told = json.loads((again / "out" / "made_of.json").read_text())
    assert sorted(told["files"]) == [f"some/{number:02d}.png" for number in range(6)]


@pytest.mark.parametrize("other", OTHERS)
def test_another_source_or_option_is_one_line_and_the_capture_stays(other, again):
    change, settings, message = OTHERS[other]
    change(again / "one" / "trip")
    before = {path: path.read_bytes() for path in (again / "out").rglob("*") if path.is_file()}
    with pytest.raises(UserError, match=rf"out: .*{message}"):
        found(again / "one" / "trip", again / "out", **settings)
    assert {path: path.read_bytes() for path in (again / "out").rglob("*") if path.is_file()} == before


def _brightened(path):
    with Image.open(path) as image:
        pixels = np.minimum(np.asarray(image).astype(int) * 3 // 2, 255).astype(np.uint8)
    Image.fromarray(pixels).save(path)


@pytest.mark.parametrize("earlier", [False, True])
@pytest.mark.parametrize(
    "change",
    [
        lambda out: (out / "images" / "some" / "03.png").unlink(),
        lambda out: _brightened(out / "images" / "some" / "00.png"),
        lambda out: shutil.copyfile(out / "images" / "some" / "00.png", out / "images" / "new.png"),
        lambda out: (out / "sparse" / "0" / "images.bin").write_bytes(b"others"),
    ],
)
def test_a_capture_whose_own_files_changed_is_refused(again, change, earlier, request):
    out = again / "out"
    if earlier:  # of a version that kept no account of them: the photographs tell of the pictures
        told = json.loads((out / "made_of.json").read_text())
        del told["digest"]
        write_record(out / "made_of.json", Origin(**told | {"made": {}}))
        assert "used as it is" in found(again / "one" / "trip", out)[0]
    change(out)
    if earlier and (out / "sparse" / "0" / "images.bin").read_bytes() == b"others":
        return  # which nothing tells of there
    with pytest.raises(UserError, match="out: its own files have changed, come or gone since its poses were found"):
        found(again / "one" / "trip", out)


def test_a_folder_of_the_same_name_elsewhere_is_another(again):
    photographs(again / "two" / "trip", 5)
    with pytest.raises(UserError, match=rf"out: was made of {again}/one/trip; remove it"):
        found(again / "two" / "trip", again / "out")


def test_a_changed_account_of_the_source_is_refused(again):
    path = again / "out" / "made_of.json"
    path.write_text(path.read_text().replace("SIMPLE_RADIAL", "OPENCV"))
    with pytest.raises(UserError, match=r"made_of\.json: was changed after it was written; remove"):
        found(again / "one" / "trip", again / "out", lens="OPENCV")


def test_a_capture_in_its_own_source_is_no_photographs_of_it(tmp_path):
    photographs(tmp_path / "in", 6)
    left = tmp_path / "in" / "captures" / ".room-0123456789ab" / "images"  # as a killed job leaves it
    shutil.copytree(tmp_path / "in" / "some", left)
    lines = found(tmp_path / "in", tmp_path / "in" / "captures" / "room")
    assert lines[0].startswith("6 photographs in")
    assert "used as it is" in found(tmp_path / "in", tmp_path / "in" / "captures" / "room")[0]
    with pytest.raises(UserError, match=r"room/images: lies in .*room, the capture to be made of it"):
        found(tmp_path / "in" / "captures" / "room" / "images", tmp_path / "in" / "captures" / "room")


def test_a_video_is_told_from_another_and_from_other_options(tmp_path):
    write_video(tmp_path / "walk.mp4", [photograph(pose, **LENS) for pose in WALK[:6]])
    found(tmp_path / "walk.mp4", tmp_path / "room", rate=10.0)
    assert "used as it is" in found(tmp_path / "walk.mp4", tmp_path / "room", rate=10.0, ordered=True)[0]
    with pytest.raises(UserError, match=r"room: was made with other options \(.* 10 frames a second\)"):
        found(tmp_path / "walk.mp4", tmp_path / "room", rate=5.0)
    write_video(tmp_path / "walk.mp4", [photograph(pose, **LENS) for pose in WALK[1:7]])
    with pytest.raises(UserError, match=r"room: was made before these changed, came or went: walk\.mp4"):
        found(tmp_path / "walk.mp4", tmp_path / "room", rate=10.0)


def test_the_comparison_of_poses_sees_a_turned_camera(tmp_path):
    found(photographs(tmp_path / "in"), tmp_path / "room")
    turned = WALK.copy()
    turned[4] = look_at(-WALK[4, :3, :3].T @ WALK[4, :3, 3], np.array([0.5, 0.0, 0.0]), np.array([0.0, -1.0, 0.0]))
    with pytest.raises(AssertionError):
        assert_poses_agree(tmp_path / "room", turned)


def test_photographs_of_a_form_that_is_not_read_are_named(tmp_path):
    source = tmp_path / "phone"
    source.mkdir()
    for number in range(4):
        (source / f"IMG_{number}.HEIC").write_bytes(b"ftypheic")
    told = []
    with pytest.raises(
        UserError, match=r"holds 4 pictures of a form that is not read \(\.heic\); convert them to JPEG"
    ):
        write_capture(source, tmp_path / "out", lens="SIMPLE_RADIAL", ordered=False, rate=1.0, tell=told.append)
    Image.new("RGB", (64, 48)).save(source / "one.jpg")
    with pytest.raises(UserError, match="holds 1 photographs"):
        write_capture(source, tmp_path / "out", lens="SIMPLE_RADIAL", ordered=False, rate=1.0, tell=told.append)
    assert any("4 pictures of a form that is not read (.heic) are left out" in line for line in told)
