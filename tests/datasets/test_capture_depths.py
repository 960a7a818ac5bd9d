"""Pictures of 16 bits that hold fewer are refused, whatever single pixels say."""

import cv2
import numpy as np
import pytest
from captures_factory import make_capture

from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.captures import prepare
from avs.scene.images import read_image
from avs.scene.scene import read_scene
from avs.system.errors import UserError


def deepened(folder, change):
    """Give all pictures 16 bits per channel and values that ``change`` makes of their share of the scale."""
    for seed, path in enumerate((folder / "images").iterdir()):
        shares = np.random.default_rng(seed).random((120, 160, 3))
        cv2.imwrite(str(path), change(shares).astype(np.uint16))


def stamped(samples):
    samples[:4, :40] = 65535  # a date of 160 pixels, 0.8 % of them
    return samples


@pytest.mark.parametrize(
    "change",
    [
        lambda shares: shares * 32768,
        lambda shares: stamped(shares * 4095),
        lambda shares: stamped(shares * 16383),
    ],
)
def test_fewer_than_sixteen_bits_are_refused_though_some_pixels_are_white(change, tmp_path):
    make_capture(tmp_path / "desk")
    deepened(tmp_path / "desk", change)
    with pytest.raises(
        UserError, match="of 9 images with 16 bits per channel none has 2% of its pixels above"
    ) as caught:
        prepare(tmp_path / "desk", tmp_path / "scene", CaptureSettings())
    assert "convert them to 8 bits per channel" in str(caught.value)
    assert not (tmp_path / "scene").exists()


def test_one_bright_picture_of_sixteen_bits_vouches_for_dark_ones(tmp_path):
    make_capture(tmp_path / "desk")
    deepened(tmp_path / "desk", lambda shares: shares * 30000)
    last = sorted((tmp_path / "desk/images").iterdir())[-1]
    cv2.imwrite(str(last), np.full((120, 160, 3), 50000, np.uint16))
    prepare(tmp_path / "desk", tmp_path / "scene", CaptureSettings())
    scene = read_scene(tmp_path / "scene")
    assert len(scene.names) == 9
    assert read_image(tmp_path / "scene/images" / scene.names[-1])[0, 0, 0] == round(50000 / 257)
