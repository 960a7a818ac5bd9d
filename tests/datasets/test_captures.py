"""Captures become scenes: geometry, sizes, names, split."""

import shutil
import struct

import numpy as np
import pycolmap
import pytest
from captures_factory import OPENCV, PINHOLE, SIMPLE_RADIAL, SIZE, centroid, make_capture, project, transforms
from PIL import Image

from avs.datasets.capture_folders import find_captures
from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.captures import prepare
from avs.scene.scene import read_scene
from avs.system.errors import UserError
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
    assert (scene.notes == ("all images are undistorted",)) == (camera is not PINHOLE)


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
    seen = [project(transform, PINHOLE, scene.points.positions) for transform in scene.cameras.world_to_camera]
    pairs = {(row, image) for row in range(12) for image in range(9)}
    inside = {(row, image) for row, image in pairs if (seen[image][row] >= 0).all() and (seen[image][row] < SIZE).all()}
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


def test_a_name_that_looks_like_a_changed_one_is_kept(tmp_path):
    make_capture(tmp_path / "capture", names=["a.bmp", "a.bmp.png", "a.png", "a.tif"])
    scene = prepared(tmp_path)
    assert scene.names == ("a.bmp.png", "a.bmp.png.png", "a.png", "a.tif.png")
    assert (tmp_path / "toy" / "images" / "a.bmp.png").read_bytes() == (
        tmp_path / "capture" / "images" / "a.bmp.png"
    ).read_bytes()


def test_two_images_of_one_file_are_refused(tmp_path):
    make_capture(tmp_path / "capture", names=["b.png", "./b.png"])
    with pytest.raises(UserError, match=r"b\.png: is two images of the model, \./b\.png and b\.png"):
        prepared(tmp_path)


def test_an_alpha_channel_without_transparency_is_not_told_of(tmp_path):
    make_capture(tmp_path / "capture")
    for path in (tmp_path / "capture" / "images").iterdir():
        Image.open(path).convert("RGBA").save(path)
    assert prepared(tmp_path, CaptureSettings(long_side=None)).notes == ()


def test_transparent_pixels_lie_on_the_background_and_a_note_tells(tmp_path):
    make_capture(tmp_path / "capture")
    path = tmp_path / "capture" / "images" / "image 0.png"
    image = Image.open(path).convert("RGBA")
    image.putalpha(0)
    image.save(path)
    scene = prepared(tmp_path, CaptureSettings(long_side=None, background=(0.2, 0.4, 1.0)))
    assert scene.notes == (
        "1 of 9 images are composited on the background (0.2, 0.4, 1), since they have transparency",
    )
    assert (scene.views([0]).images[0] == [51, 102, 255]).all()


def test_an_orientation_that_makes_no_sense_is_ignored_and_a_note_tells(tmp_path):
    make_capture(tmp_path / "capture")
    before = prepared(tmp_path)
    for path in (tmp_path / "capture" / "images").iterdir():
        exif = b"Exif\0\0II*\0" + struct.pack("<IHHHI4sI", 8, 1, 0x0112, 2, 1, b"six\0", 0)
        Image.open(path).save(path, exif=exif)
    scene = prepared(tmp_path)
    assert scene.hashes == before.hashes
    assert scene.notes == ("all images are read as they are stored, since their EXIF orientation makes no sense",)


def test_an_orientation_that_shape_cannot_decide_is_told_of(tmp_path):
    make_capture(tmp_path / "capture")
    before = prepared(tmp_path)
    for path in (tmp_path / "capture" / "images").iterdir():
        exif = Image.Exif()
        exif[0x0112] = 3  # upside down
        Image.open(path).save(path, exif=exif)
    scene = prepared(tmp_path)
    assert scene.hashes == before.hashes
    (note,) = scene.notes
    assert note.startswith("all images are read as they are stored, as structure from motion does, though")
    assert note.endswith("they would fit their cameras both ways: if the model was made of turned copies, give those")


def test_pictures_of_several_sizes_are_told_of(tmp_path):
    make_capture(tmp_path / "capture")
    path = tmp_path / "capture" / "images" / "image 3.png"
    Image.open(path).resize((80, 60), Image.Resampling.BOX).save(path)
    scene = prepared(tmp_path, CaptureSettings(long_side=None))
    (note,) = scene.notes
    assert note.startswith("pictures have 80 x 60 to 160 x 120 pixels: methods whose score is a sum over pixels")


def test_a_tiff_with_an_orientation_is_read_as_it_is_stored(tmp_path):
    """Pillow turns such files by itself."""
    names = [f"{index}.tif" for index in range(9)]
    make_capture(tmp_path / "capture", names=names)
    for path in sorted((tmp_path / "capture" / "images").iterdir()):
        exif = Image.Exif()
        exif[0x0112] = 6
        Image.open(path).save(path, exif=exif)
    assert_points_lie_on_their_dots(prepared(tmp_path), tolerances.DOT_CENTROID)


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


def test_a_model_without_points_is_noted(tmp_path):
    make_capture(tmp_path / "capture", points=False)
    assert prepared(tmp_path).notes == ("the model has no points",)


def test_captures_are_found_by_their_folders(tmp_path):
    for name in ("Garden-2", "my room", "notes", ".hidden"):
        (tmp_path / name / ("text" if name == "notes" else "images")).mkdir(parents=True)
    found = find_captures(tmp_path).folders
    assert found == {"garden_2": tmp_path / "Garden-2", "my_room": tmp_path / "my room"}
    assert find_captures(tmp_path / "Garden-2").folders == {"garden_2": tmp_path / "Garden-2"}


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
        landed = project(scene.cameras.world_to_camera[index], camera, scene.to_capture.points_back(positions))
        errors.append(np.linalg.norm(landed - seen, axis=1))
    assert np.median(np.concatenate(errors)) < tolerances.REAL_REPROJECTION
