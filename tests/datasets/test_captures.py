"""Captures become scenes: geometry, sizes, names, split; and every fault is one line."""

import re
import shutil
import struct

import numpy as np
import pycolmap
import pytest
from captures_factory import OPENCV, PINHOLE, SIMPLE_RADIAL, SIZE, centroid, make_capture, project, transforms
from PIL import Image

from avs.datasets.captures import list_captures, prepare
from avs.datasets.settings import CaptureSettings
from avs.errors import UserError
from avs.files import explained
from avs.scene import read_scene
from tests import tolerances

FULL = CaptureSettings(long_side=None)


def prepared(tmp_path, settings=FULL):
    prepare(tmp_path / "capture", tmp_path / "toy", settings)
    return read_scene(tmp_path / "toy")


def pixels_of_points(scene, index):
    """Where the points lie in image ``index`` after its camera."""
    camera = {
        "model": "PINHOLE",
        "params": scene.cameras.intrinsics[index][(0, 1, 0, 1), (0, 1, 2, 2)],
    }
    return project(scene.cameras.world_to_camera[index], camera, scene.points.positions)


def assert_points_lie_on_their_dots(scene, tolerance):
    views = scene.views(np.arange(len(scene.names)))
    distances = [
        np.linalg.norm(centroid(image, pixel) - pixel)
        for index, image in enumerate(views.images)
        for pixel in pixels_of_points(scene, index)
        if (pixel > 10).all() and (pixel < scene.cameras.sizes[index] - 10).all()
    ]
    assert len(distances) > 60
    assert np.max(distances) < tolerance


@pytest.mark.parametrize("camera", [PINHOLE, SIMPLE_RADIAL, OPENCV], ids=lambda camera: camera["model"])
@pytest.mark.parametrize("settings", [FULL, CaptureSettings(long_side=140)], ids=["full", "resized"])
def test_points_lie_where_the_image_shows_them(camera, settings, tmp_path):
    make_capture(tmp_path / "capture", [camera])
    scene = prepared(tmp_path, settings)
    assert_points_lie_on_their_dots(scene, tolerances.DOT_CENTROID)
    assert (scene.notes == ("9 images are undistorted",)) == (camera is not PINHOLE)


def test_the_distortion_of_the_test_is_no_trifle():
    straight = {"model": "PINHOLE", "params": OPENCV["params"][:4]}
    shift = np.linalg.norm(project(transforms(9)[0], OPENCV) - project(transforms(9)[0], straight), axis=1)
    assert shift.max() > 10 * tolerances.DOT_CENTROID


def test_mixed_cameras_and_sizes(tmp_path):
    wide = {"model": "PINHOLE", "params": [150.0, 150.0, 100.0, 60.0]}
    make_capture(tmp_path / "capture", [PINHOLE, wide, SIMPLE_RADIAL], sizes=[SIZE, (200, 120), SIZE])
    scene = prepared(tmp_path, CaptureSettings(long_side=None, short_side=110))
    assert_points_lie_on_their_dots(scene, tolerances.DOT_CENTROID)
    assert tuple(scene.cameras.sizes[0]) == (147, 110)
    assert tuple(scene.cameras.sizes[1]) == (183, 110)
    assert scene.cameras.intrinsics[1, 0, 0] == pytest.approx(150 * 183 / 200)
    assert scene.cameras.intrinsics[1, 1, 1] == pytest.approx(150 * 110 / 120)


def test_observations_are_kept(tmp_path):
    make_capture(tmp_path / "capture")
    scene = prepared(tmp_path)
    assert len(scene.points) == 12
    pairs = {(row, image) for row in range(12) for image in range(9)}
    inside = {
        (row, image)
        for row, image in pairs
        if (project(scene.cameras.world_to_camera[image], PINHOLE)[row] >= 0).all()
        and (project(scene.cameras.world_to_camera[image], PINHOLE)[row] < SIZE).all()
    }
    assert {tuple(pair) for pair in scene.points.observations.tolist()} == inside
    assert list(scene.points.colors[5]) == [200, 100, 5]


def test_text_and_binary_give_the_same_scene(tmp_path):
    for form in ("bin", "txt"):
        make_capture(tmp_path / form / "capture", [OPENCV], text=form == "txt")
        prepare(tmp_path / form / "capture", tmp_path / form / "toy", FULL)
    binary, text = (read_scene(tmp_path / form / "toy") for form in ("bin", "txt"))
    np.testing.assert_allclose(binary.cameras.world_to_camera, text.cameras.world_to_camera, atol=1e-12)
    np.testing.assert_array_equal(binary.points.observations, text.points.observations)
    assert binary.hashes == text.hashes


def test_unchanged_images_keep_their_bytes_and_zero_distortion_changes_nothing(tmp_path):
    still = {"model": "OPENCV", "params": [*PINHOLE["params"], 0, 0, 0, 0]}
    names = [f"Dir {i % 2}/IMG_{i}.JPG" for i in range(9)]
    make_capture(tmp_path / "capture", [still, PINHOLE], names)
    scene = prepared(tmp_path)
    assert scene.names == tuple(sorted(names))
    for name in names:
        stored = (tmp_path / "toy" / "images" / name).read_bytes()
        assert stored == (tmp_path / "capture" / "images" / name).read_bytes()
    np.testing.assert_array_equal(scene.cameras.intrinsics[0], scene.cameras.intrinsics[1])


def test_every_eighth_image_by_name_is_a_test_image(tmp_path):
    names = [f"{i:02d}.png" for i in range(18)]
    make_capture(tmp_path / "capture", names=names[::-1])
    scene = prepared(tmp_path)
    assert [scene.names[i] for i in scene.test] == ["00.png", "08.png", "16.png"]
    assert len(scene.pool) == 15


def test_changed_images_whose_names_collide_keep_both(tmp_path):
    make_capture(tmp_path / "capture", names=["a.jpg", "a.png", "a.bmp", "b.bmp"])
    scene = prepared(tmp_path, CaptureSettings(long_side=80))
    assert scene.names == ("a.bmp.png", "a.jpg.png", "a.png.png", "b.png")


def test_images_that_are_not_registered_are_noted(tmp_path):
    make_capture(tmp_path / "capture", names=["a.png", "b.png"])
    shutil.copy(tmp_path / "capture" / "images" / "a.png", tmp_path / "capture" / "images" / "z.png")
    assert prepared(tmp_path).notes == ("1 of 3 images are left out: the model does not register them",)


def test_images_of_another_resolution_scale_their_camera(tmp_path):
    make_capture(tmp_path / "capture")
    for path in (tmp_path / "capture" / "images").iterdir():
        Image.open(path).resize((81, 60), Image.Resampling.BOX).save(path)
    scene = prepared(tmp_path)
    assert tuple(scene.cameras.sizes[0]) == (81, 60)
    assert scene.cameras.intrinsics[0, 0, 0] == pytest.approx(150 * 81 / 160)


def test_exif_orientation_is_applied_where_the_camera_says_so(tmp_path):
    make_capture(tmp_path / "capture")
    for path in sorted((tmp_path / "capture" / "images").iterdir()):
        image, exif = Image.open(path), Image.Exif()
        exif[0x0112] = 6  # to be turned by 90 degrees clockwise
        image.transpose(Image.Transpose.ROTATE_90).save(path, exif=exif)
    scene = prepared(tmp_path)
    assert_points_lie_on_their_dots(scene, tolerances.DOT_CENTROID)


def test_exif_orientation_is_dropped_where_the_camera_has_the_stored_size(tmp_path):
    make_capture(tmp_path / "capture")
    for path in sorted((tmp_path / "capture" / "images").iterdir()):
        exif = Image.Exif()
        exif[0x0112] = 6
        Image.open(path).save(path, exif=exif)
    scene = prepared(tmp_path)
    assert_points_lie_on_their_dots(scene, tolerances.DOT_CENTROID)
    stored = Image.open(tmp_path / "toy" / "images" / scene.names[0])
    assert stored.getexif().get(0x0112, 1) == 1  # another program would turn it


def overwrite(name, offset, layout, value):
    def apply(capture):
        path = capture / "sparse" / "0" / name
        content = bytearray(path.read_bytes())
        struct.pack_into(layout, content, offset, value)
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
MODEL, FIRST_PARAMETER = 8 + 4, 8 + 4 + 4 + 16
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
    "16-bit image": (
        lambda capture: Image.new("I;16", SIZE).save(capture / "images" / "image 3.png"),
        r"image 3\.png: the image has more than 8 bits per channel \(mode I;16\); convert it",
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
    "missing points": (
        lambda capture: (capture / "sparse" / "0" / "points3D.bin").write_bytes(bytes(8)),
        r"images\.bin: image image \d\.png observes a point that does not exist",
    ),
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


TEXT_FAULTS = {
    "unknown model": (edit("cameras.txt", "PINHOLE", "FISHBOWL"), r"cameras\.txt: camera 1 has the unknown camera"),
    "NaN": (edit("cameras.txt", "150", "nan"), r"cameras\.txt: camera 1 has a parameter that is not finite"),
    "lost parameter": (edit("cameras.txt", " 60", ""), r"cameras\.txt: is damaged: cannot read the line '1 PINHOLE"),
    "cut": (cut("sparse/0/images.txt", 0.55), r"images\.txt: is damaged"),
    "words": (edit("points3D.txt", " 200 100 3 ", " 200 x 3 "), r"points3D\.txt: is damaged: cannot read the line"),
    "leaving the folder": (edit("images.txt", "image 3", "../image 3"), r"image name \.\./image 3\.png leaves"),
}


@pytest.mark.parametrize("fault", TEXT_FAULTS)
def test_a_fault_of_the_text_form_is_told_in_one_line(fault, tmp_path):
    make_capture(tmp_path / "capture", text=True)
    damage, message = TEXT_FAULTS[fault]
    damage(tmp_path / "capture")
    line = refused(tmp_path / "capture", tmp_path)
    assert re.search(message, line)


def test_a_panorama_is_refused(tmp_path):
    make_capture(tmp_path / "capture", text=True)
    edit("cameras.txt", "PINHOLE 160 120 150 155 81 60", "EQUIRECTANGULAR 160 120 160 120")(tmp_path / "capture")
    assert "cannot be undistorted; use images of a perspective" in refused(tmp_path / "capture", tmp_path)


def test_a_model_without_points_is_noted(tmp_path):
    make_capture(tmp_path / "capture", points=False)
    assert prepared(tmp_path).notes == ("the model has no points",)


def test_captures_are_found_by_their_folders(tmp_path):
    for name in ("Garden-2", "my room", "notes", ".hidden"):
        (tmp_path / name / ("text" if name == "notes" else "images")).mkdir(parents=True)
    found = list_captures(tmp_path)
    assert found == {"garden_2": tmp_path / "Garden-2", "my_room": tmp_path / "my room"}
    assert list_captures(tmp_path / "Garden-2") == {"garden_2": tmp_path / "Garden-2"}


def test_captures_that_cannot_be_named_are_refused(tmp_path):
    with pytest.raises(UserError, match="holds no capture"):
        list_captures(tmp_path)
    with pytest.raises(UserError, match="no such folder"):
        list_captures(tmp_path / "absent")
    for name in ("a b", "a_B"):
        (tmp_path / name / "images").mkdir(parents=True)
    with pytest.raises(UserError, match=r"a_B: has the same scene name, a_b, as .*a b; rename"):
        list_captures(tmp_path)


@pytest.mark.parametrize("name", ["fern", "fox", "kitchen", "monstree"])
def test_real_photographs(name, shared_scenes, tmp_path):
    """Points of a real capture land where the structure from motion saw them, after resizing."""
    prepare(shared_scenes / name, tmp_path / name, CaptureSettings())
    scene = read_scene(tmp_path / name)
    assert scene.cameras.sizes.max() == 480
    assert len(scene.test) == -(-len(scene.names) // 8)
    model = pycolmap.Reconstruction(shared_scenes / name / "sparse" / "0")
    errors = []
    for image in model.images.values():
        index = [name.rsplit(".", 1)[0] for name in scene.names].index(image.name.rsplit(".", 1)[0])
        keypoints = image.get_observation_points2D()
        positions = np.array([model.points3D[keypoint.point3D_id].xyz for keypoint in keypoints])
        camera = {"model": "PINHOLE", "params": scene.cameras.intrinsics[index][(0, 1, 0, 1), (0, 1, 2, 2)]}
        ratio = scene.cameras.sizes[index] / [image.camera.width, image.camera.height]
        seen = np.array([keypoint.xy for keypoint in keypoints]) * ratio
        errors.append(np.linalg.norm(project(scene.cameras.world_to_camera[index], camera, positions) - seen, axis=1))
    assert np.median(np.concatenate(errors)) < tolerances.REAL_REPROJECTION
