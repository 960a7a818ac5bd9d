"""A model whose parts do not belong together is told of: every part by itself is whole."""

import numpy as np
import pycolmap
import pytest
from captures_factory import OPENCV, PINHOLE, SIMPLE_RADIAL, make_capture

from avs.datasets.capture_consistency import consistency_notes
from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.captures import prepare
from avs.scene.colmap import read_model
from avs.scene.scene import read_scene


@pytest.fixture
def model(tmp_path):
    """The folder of a sound model with distortion."""
    make_capture(tmp_path / "capture", cameras=(SIMPLE_RADIAL, OPENCV))
    return tmp_path / "capture" / "sparse" / "0"


def changed(folder, change):
    """The model after ``change`` of pycolmap's form of it."""
    reconstruction = pycolmap.Reconstruction(folder)
    change(reconstruction)
    for path in folder.iterdir():
        path.unlink()
    reconstruction.write(folder)
    return read_model(folder)


def test_a_sound_model_has_no_note(model):
    assert consistency_notes(read_model(model)) == []


def test_a_pose_of_another_image_is_told(model):
    def swap(reconstruction):
        first, last = reconstruction.images[1], reconstruction.images[9]
        poses = first.cam_from_world(), last.cam_from_world()
        first.frame.set_cam_from_world(first.camera_id, poses[1])
        last.frame.set_cam_from_world(last.camera_id, poses[0])

    (note,) = consistency_notes(changed(model, swap))
    assert note.startswith("2 of 9 images (image 0.png, image 8.png) see their points more than 1% of their side from")


def test_a_wrong_camera_is_told(model):
    def move(reconstruction):
        reconstruction.cameras[2].principal_point_x += 10

    (note,) = consistency_notes(changed(model, move))
    assert note.startswith("4 of 9 images (image 1.png, image 3.png, image 5.png, image 7.png) see their points")


def test_keypoints_that_no_program_measured_say_nothing(tmp_path):
    """Models made of known poses have no keypoints, or zeros."""
    make_capture(tmp_path / "capture", cameras=(PINHOLE,))
    model = read_model(tmp_path / "capture" / "sparse" / "0")
    for image in model.images.values():
        image.keypoints[:] = 0
    assert consistency_notes(model) == []
    for image in model.images.values():
        image.keypoints[:] = np.nan
    assert consistency_notes(model) == []


def test_inverted_poses_without_keypoints_are_told(tmp_path):
    """The points then lie behind the cameras; no keypoint tells where they should be seen."""
    make_capture(tmp_path / "capture")
    folder = tmp_path / "capture" / "sparse" / "0"
    reconstruction = pycolmap.Reconstruction(folder)
    turned = pycolmap.Rigid3d(pycolmap.Rotation3d(np.array([0.0, 1.0, 0.0, 0.0])), np.zeros(3))  # half a turn about y
    for identifier, image in reconstruction.images.items():
        for keypoint in image.points2D:
            keypoint.xy = np.zeros(2)
        if identifier in (2, 3):
            image.frame.set_cam_from_world(image.camera_id, turned * image.cam_from_world())
    reconstruction.write(folder)
    prepare(tmp_path / "capture", tmp_path / "toy", CaptureSettings(long_side=None))
    notes = read_scene(tmp_path / "toy").notes
    assert [note for note in notes if "behind them or outside the picture" in note] == [
        "2 of 9 images (image 1.png, image 2.png) have most of the points that they observe behind them or outside the "
        "picture: their poses may be wrong or inverted"
    ]
