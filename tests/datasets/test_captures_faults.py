"""Every fault of a capture ends with one line that names the file, the fault and the remedy, and leaves nothing."""

import os
import re
import shutil
import struct

import pytest
from captures_factory import SIZE, make_capture
from PIL import Image

from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.captures import prepare
from avs.system.errors import UserError
from avs.system.files import explained

FULL = CaptureSettings(long_side=None)


def overwrite(name, offset, layout, *values):
    def apply(capture):
        path = capture / "sparse" / "0" / name
        content = bytearray(path.read_bytes())
        struct.pack_into(layout, content, offset, *values)
        path.write_bytes(content)

    return apply


def cut(name, share):
    def apply(capture):
        path = capture / name
        content = path.read_bytes()
        path.write_bytes(content[: int(len(content) * share)])

    return apply


def edit(name, old, new):
    def apply(capture):
        path = capture / "sparse" / "0" / name
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))

    return apply


def empty_sparse(capture):
    shutil.rmtree(capture / "sparse" / "0")


# A camera's record in cameras.bin: number of cameras, identifier, model, width, height, parameters.
MODEL, SIZES, FIRST_PARAMETER = 8 + 4, 8 + 4 + 4, 8 + 4 + 4 + 16
QUATERNION, CAMERA_OF_IMAGE = 8 + 4, 8 + 4 + 56
FAULTS = {
    "truncated image": (cut("images/image 3.png", 0.7), r"image 3\.png: the image is damaged or cut off"),
    "empty image": (cut("images/image 3.png", 0), r"image 3\.png: the image is damaged or cut off"),
    "missing image": (
        lambda capture: (capture / "images" / "image 3.png").unlink(),
        r"image 3\.png: the image is missing, but the model names it; restore the file",
    ),
    "other image": (
        lambda capture: Image.new("RGB", (50, 50)).save(capture / "images" / "image 3.png"),
        r"image 3\.png: the image is 50 x 50 pixels, its camera 160 x 120; use the images",
    ),
    "12 bits in 16": (
        lambda capture: Image.new("I;16", SIZE, 4095).save(capture / "images" / "image 3.png"),
        r"image 3\.png: the image has 16 bits per channel but no value above 4095 of 65535, .*; convert it",
    ),
    "pipe as image": (
        lambda capture: (capture / "images" / "image 3.png").unlink() or os.mkfifo(capture / "images" / "image 3.png"),
        r"image 3\.png: is a pipe or a device, not a file; put a file in its place",
    ),
    "endless model": (
        lambda capture: [
            (capture / "sparse" / "0" / "images.bin").unlink(),
            (capture / "sparse" / "0" / "images.bin").symlink_to("/dev/zero"),
        ],
        r"images\.bin: is a pipe or a device",
    ),
    "folder as image": (
        lambda capture: (capture / "images" / "image 3.png").unlink() or (capture / "images" / "image 3.png").mkdir(),
        r"image 3\.png: is a directory; check the path",
    ),
    "empty sparse": (empty_sparse, r"sparse/0: there is no such folder; put cameras, images and points3D there"),
    "empty sparse/0": (
        lambda capture: [path.unlink() for path in (capture / "sparse" / "0").iterdir()],
        r"sparse/0: holds no COLMAP model; put cameras, images and points3D there",
    ),
    "half a model": (
        lambda capture: (capture / "sparse" / "0" / "images.bin").unlink(),
        r"images\.bin: is missing; copy the whole folder",
    ),
    "NaN focal length": (
        overwrite("cameras.bin", FIRST_PARAMETER, "<d", float("nan")),
        r"cameras\.bin: camera 1 has a parameter that is not finite",
    ),
    "zero focal length": (
        overwrite("cameras.bin", FIRST_PARAMETER, "<d", 0.0),
        r"cameras\.bin: camera 1 .*focal length that is not positive",
    ),
    "NaN pose": (overwrite("images.bin", QUATERNION, "<d", float("nan")), r"images\.bin: the pose of image image \d"),
    "unknown model": (
        overwrite("cameras.bin", MODEL, "<i", 99),
        r"cameras\.bin: camera 1 has the unknown camera model 99; write the model",
    ),
    "panorama": (overwrite("cameras.bin", MODEL, "<i", 17), r"cameras\.bin: is damaged"),
    "unknown camera": (
        overwrite("images.bin", CAMERA_OF_IMAGE, "<I", 7),
        r"images\.bin: image image \d\.png names camera 7, which does not exist",
    ),
    "huge count": (overwrite("images.bin", 0, "<Q", 2**60), r"images\.bin: is damaged or cut off: it ends at byte"),
    "no image": (
        lambda capture: (capture / "sparse" / "0" / "images.bin").write_bytes(bytes(8)),
        r"images\.bin: registers no image; run the structure from motion again",
    ),
    "trailing bytes": (
        lambda capture: (capture / "sparse" / "0" / "points3D.bin").open("ab").write(b"xx"),
        r"points3D\.bin: is damaged: 2 bytes follow the last record",
    ),
    "giant camera": (
        overwrite("cameras.bin", SIZES, "<QQ", 2**63, 2**63),
        r"camera 1 has sides of more than 1048576 pix",
    ),
    "tiny rotation": (
        overwrite("images.bin", QUATERNION, "<4d", 5e-324, 0, 0, 0),
        r"the quaternion of image .* has the length 4\.941e-324, not 1",
    ),
    "huge rotation": (overwrite("images.bin", QUATERNION, "<4d", 1e308, 0, 0, 0), r"has the length 1e\+308, not 1"),
    "pose beyond the sky": (overwrite("images.bin", QUATERNION + 32, "<d", 1e300), r"the pose of .* lies beyond"),
    "focal length of an atom": (
        overwrite("cameras.bin", FIRST_PARAMETER, "<d", 1e-9),
        r"focal length of .* for images",
    ),
    "point without number": (overwrite("points3D.bin", 8, "<Q", 2**64 - 1), r"points3D\.bin: .* more than 63 bits"),
    "point twice": (overwrite("points3D.bin", 8, "<Q", 2), r"points3D\.bin: is damaged: the point 2 occurs twice"),
    "point beyond the sky": (overwrite("points3D.bin", 16, "<d", 1e300), r"points3D\.bin: a point's position is not"),
} | {
    f"{name} cut to {share:.0%}": (cut(f"sparse/0/{name}", share), rf"{name}: is damaged or cut off: it ends at byte")
    for name in ("cameras.bin", "images.bin", "points3D.bin")
    for share in (0, 0.4, 0.97)
}


@pytest.fixture(scope="module")
def good_capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("good") / "capture"
    make_capture(folder)
    return folder


def explained_prepare(capture, folder):
    """Prepare as the command line does it."""
    with explained():
        prepare(capture, folder, FULL)


def refused(capture, tmp_path):
    """Prepare and return the line that it fails with."""
    with pytest.raises(UserError) as caught:
        explained_prepare(capture, tmp_path / "toy")
    assert not (tmp_path / "toy").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["capture"]
    return str(caught.value)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_in_one_line_and_leaves_nothing(fault, good_capture, tmp_path):
    shutil.copytree(good_capture, tmp_path / "capture")
    damage, message = FAULTS[fault]
    damage(tmp_path / "capture")
    line = refused(tmp_path / "capture", tmp_path)
    assert "\n" not in line
    assert re.search(message, line)


def images_line(capture):
    """The first keypoints of a text model."""
    lines = (capture / "sparse" / "0" / "images.txt").read_text().split("\n")
    return next(line for line in lines if line and not line.startswith("#") and ".png" not in line)


TEXT_FAULTS = {
    "unknown model": (edit("cameras.txt", "PINHOLE", "FISHBOWL"), r"cameras\.txt: camera 1 has the unknown camera"),
    "NaN": (edit("cameras.txt", "150", "nan"), r"cameras\.txt: camera 1 has a parameter that is not finite"),
    "lost parameter": (edit("cameras.txt", " 60", ""), r"cameras\.txt: is damaged: cannot read the line '1 PINHOLE"),
    "cut": (cut("sparse/0/images.txt", 0.55), r"images\.txt: is damaged"),
    "words": (edit("points3D.txt", " 200 100 3 ", " 200 x 3 "), r"points3D\.txt: is damaged: cannot read the line"),
    "side of many digits": (
        edit("cameras.txt", " 160 ", f" 1{'0' * 400} "),
        r"cameras\.txt: camera 1 has sides of more than",
    ),
    "side of too many digits": (
        edit("cameras.txt", " 160 ", f" 1{'0' * 5000} "),
        r"cameras\.txt: is damaged: cannot read the line",
    ),
    "point of many digits": (edit("points3D.txt", "\n2 ", f"\n1{'0' * 400} "), r"points3D\.txt: .* more than 63 bits"),
    "name that is none": (edit("images.txt", "image 3", "image\0 3"), r"the image name image\\x00 3\.png is no name"),
    "principal point of another camera": (edit("cameras.txt", " 81 60", " 81 1e5"), r"principal point far outside"),
    "endless identifier": (
        lambda capture: edit("images.txt", images_line(capture), "1 2 -inf")(capture),
        r"images\.txt: is damaged: cannot read the line",
    ),
    "leaving the folder": (
        edit("images.txt", "image 3", "../image 3"),
        r"image name \.\./image 3\.png points outside the folder",
    ),
}


@pytest.mark.parametrize("fault", TEXT_FAULTS)
def test_a_fault_of_the_text_form_is_told_in_one_line(fault, tmp_path):
    make_capture(tmp_path / "capture", text=True)
    damage, message = TEXT_FAULTS[fault]
    damage(tmp_path / "capture")
    line = refused(tmp_path / "capture", tmp_path)
    assert re.search(message, line)


def test_a_pose_that_lost_a_number_is_told(tmp_path):
    make_capture(tmp_path / "capture", text=True, names=[f"{index}.png" for index in range(9)])
    lines = (tmp_path / "capture" / "sparse" / "0" / "images.txt").read_text().split("\n")
    pose = next(line for line in lines if line.endswith(" 3.png"))
    edit("images.txt", pose, " ".join(pose.split()[:7] + pose.split()[8:]))(tmp_path / "capture")
    assert re.search(r"images\.txt: is damaged: cannot read the line", refused(tmp_path / "capture", tmp_path))


def test_a_panorama_is_refused(tmp_path):
    make_capture(tmp_path / "capture", text=True)
    edit("cameras.txt", "PINHOLE 160 120 150 155 81 60", "EQUIRECTANGULAR 160 120 160 120")(tmp_path / "capture")
    assert "cannot be undistorted; use images of a perspective" in refused(tmp_path / "capture", tmp_path)
