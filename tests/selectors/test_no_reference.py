"""PIQE through pyiqa."""

import subprocess
import sys

import numpy as np
import pytest
from factories import OnlyRenders, ring
from skimage import data, filters

from avs import selectors
from avs.representations.base import Rendering
from avs.resizing import ResizeSettings
from avs.selectors.base import Resources, State
from avs.selectors.no_reference import METHODS, NoReferenceSettings
from avs.views import Views
from tests.tolerances import PIQE_PUBLISHED


@pytest.fixture(scope="module")
def piqe():
    method = selectors.find("piqe").method
    return method.build(NoReferenceSettings(resize=ResizeSettings(pixels=512), batch=2), Resources())


def _blurred(picture, sigma):
    return np.asarray(filters.gaussian(picture, sigma, channel_axis=-1), dtype=np.float32)


class Pictures:
    """Renders the pictures that it was given, by the cameras' heights in the ring."""

    def __init__(self, cameras, pictures):
        self._pictures = {
            tuple(center.round(6)): picture for center, picture in zip(cameras.centers, pictures, strict=True)
        }

    def render(self, cameras):
        rgb = np.stack([self._pictures[tuple(center.round(6))] for center in cameras.centers])
        return Rendering(rgb, np.ones(rgb.shape[:3], np.float32), np.ones(rgb.shape[:3], np.float32))


@pytest.mark.parametrize(("sigma", "expected"), [(0, 33.76), (1, 75.52), (3, 92.58)])
def test_known_values(piqe, sigma, expected):
    picture = data.astronaut().astype(np.float32) / 255
    if sigma:
        picture = _blurred(picture, sigma)
    assert piqe.score(picture[None])[0] == pytest.approx(expected, abs=PIQE_PUBLISHED)


def test_blurred_renderings_are_chosen_first(piqe):
    cat = data.chelsea()[:256, :256].astype(np.float32) / 255
    pictures = [_blurred(cat, sigma) for sigma in (1, 0, 4, 2, 0.5)]
    cameras = ring(6, size=(256, 256))
    views = Views(cameras[:1], (np.zeros((256, 256, 3), np.uint8),))
    representation = OnlyRenders(Pictures(cameras[1:], pictures))
    selection = piqe.select(State(representation, views, cameras[1:], np.random.default_rng(0), 0), 2)
    assert selection.indices.tolist() == [2, 3]
    alone = [piqe.score(picture[None])[0] for picture in pictures]
    np.testing.assert_allclose(selection.scores, alone, atol=PIQE_PUBLISHED)


@pytest.mark.parametrize("grey", [0.0, 1e-9, 0.3, 1.0])
def test_image_of_one_colour_is_the_worst(piqe, grey):
    images = np.full((2, 64, 96, 3), grey, dtype=np.float32)
    images[1] = np.random.default_rng(0).random((64, 96, 3), dtype=np.float32)
    flat, textured = piqe.score(images)
    assert flat == 100
    assert textured < 100


def test_image_that_is_partly_black_has_a_number(piqe):
    image = np.random.default_rng(1).random((1, 96, 96, 3), dtype=np.float32)
    image[:, :60] = 0
    assert 0 < piqe.score(image)[0] < 100


def test_directions_are_those_of_pyiqa(piqe):
    import pyiqa

    for identifier, method in METHODS.items():
        assert method.higher_is_worse == pyiqa.create_metric(identifier, device="cpu").lower_better
        assert not method.label.islower()


def test_listing_the_methods_imports_no_torch():
    code = "import sys; from avs import selectors; selectors.methods(); sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_metric_is_made_without_the_network():
    code = (
        "import socket\n"
        "def refuse(*_): raise SystemExit('used the network')\n"
        "socket.socket.connect = refuse\n"
        "socket.getaddrinfo = refuse\n"
        "from avs import selectors\n"
        "from avs.selectors.base import Resources\n"
        "method = selectors.find('piqe').method\n"
        "method.build(method.settings(), Resources())\n"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
