"""No-reference metrics through pyiqa: known scores, choices, and images that have nothing to measure."""

import subprocess
import sys

import numpy as np
import pytest
from factories import OnlyRenders, named_views, ring, selected, state_of
from skimage import data, filters

from avs.iqa.no_reference.niqe_settings import FitSettings, PatchSettings
from avs.iqa.resizing import ResizeSettings
from avs.representations.base import Rendering
from avs.selection import registry
from avs.selection.contract import HasNotes, Resources
from avs.selectors.no_reference import METHODS, NoReferenceSettings
from avs.system.compatibility import prepare_torchvision
from avs.system.errors import UserError
from tests.tolerances import QUALITY_KNOWN


@pytest.fixture(scope="module")
def piqe():
    method = registry.find("piqe").method
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


SIGMAS = (0, 1, 3)
KNOWN = {  # of pyiqa 0.1.16 with the published parameters, for scikit-image's pictures blurred with SIGMAS
    ("niqe", "astronaut"): (3.06, 5.36, 8.71),
    ("niqe", "coffee"): (4.06, 5.35, 10.02),
    ("brisque", "astronaut"): (2.87, 37.45, 74.15),
    ("brisque", "chelsea"): (2.57, 35.05, 79.19),
    ("piqe", "astronaut"): (33.76, 75.52, 92.58),
}


@pytest.mark.parametrize(("identifier", "picture"), KNOWN)
def test_known_scores(identifier, picture, shared_weights, monkeypatch):
    monkeypatch.setenv("AVS_WEIGHTS", str(shared_weights))
    sharp = getattr(data, picture)().astype(np.float32) / 255
    method = registry.find(identifier).method
    selector = method.build(method.settings(resize=ResizeSettings(pixels=max(sharp.shape))), Resources())
    images = np.stack([_blurred(sharp, sigma) if sigma else sharp for sigma in SIGMAS])
    np.testing.assert_allclose(selector.quality(images), KNOWN[identifier, picture], atol=QUALITY_KNOWN)


def test_blurred_renderings_are_chosen_first(piqe):
    cat = data.chelsea()[:256, :256].astype(np.float32) / 255
    pictures = [_blurred(cat, sigma) for sigma in (1, 0, 4, 2, 0.5)]
    cameras = ring(6, size=(256, 256))
    views = named_views(cameras[:1], (np.zeros((256, 256, 3), np.uint8),))
    representation = OnlyRenders(Pictures(cameras[1:], pictures))
    selection = selected("piqe", piqe, state_of(representation, views, cameras[1:], np.random.default_rng(0), 0), 2)
    assert selection.indices.tolist() == [2, 3]
    alone = [piqe.quality(picture[None])[0] for picture in pictures]
    np.testing.assert_allclose(selection.scores, alone, atol=QUALITY_KNOWN)


@pytest.mark.parametrize("grey", [0.0, 1e-9, 0.3, 1.0])
def test_image_of_one_colour_is_the_worst(piqe, grey):
    images = np.full((2, 64, 96, 3), grey, dtype=np.float32)
    images[1] = np.random.default_rng(0).random((64, 96, 3), dtype=np.float32)
    flat, textured = piqe.quality(images)
    assert flat == 100
    assert textured < 100


def test_image_that_is_partly_black_has_a_number(piqe):
    image = np.random.default_rng(1).random((1, 96, 96, 3), dtype=np.float32)
    image[:, :60] = 0
    assert 0 < piqe.quality(image)[0] < 100


def test_directions_and_names_are_those_of_pyiqa(piqe):
    from pyiqa.default_model_configs import DEFAULT_CONFIGS

    assert set(METHODS) == {"brisque", "niqe", "piqe", "nima", "musiq", "maniqa", "tres", "topiq"}
    for identifier, method in METHODS.items():
        name = "topiq_nr" if identifier == "topiq" else identifier
        assert DEFAULT_CONFIGS[name]["metric_mode"] == "NR"
        assert method.chooses == ("highest" if DEFAULT_CONFIGS[name].get("lower_better", False) else "lowest")
        assert not method.label.islower()
        assert method.pretrained == (() if identifier == "piqe" else (identifier,))


@pytest.mark.parametrize(("identifier", "worst"), [("brisque", 153.591), ("niqe", 100.0)])
def test_black_rendering_is_the_worst_and_leaves_the_others_alone(identifier, worst, shared_weights, monkeypatch):
    monkeypatch.setenv("AVS_WEIGHTS", str(shared_weights))
    method = registry.find(identifier).method
    selector = method.build(method.settings(resize=ResizeSettings(pixels=192)), Resources())
    images = np.zeros((3, 96, 192, 3), dtype=np.float32)
    images[1] = np.random.default_rng(0).random(images.shape[1:], dtype=np.float32)
    images[2] = data.chelsea()[:96, :192] / np.float32(255)
    scores = selector.quality(images)
    assert scores[0] == worst > scores[2]
    np.testing.assert_allclose(selector.quality(images[1:]), scores[1:])


def test_renderings_that_are_not_finite_are_refused(piqe):
    images = np.full((1, 64, 64, 3), np.nan, dtype=np.float32)
    with pytest.raises(ValueError, match="not finite"):
        piqe.quality(images)


@pytest.fixture
def fitted(tmp_path):
    """Return parameters of NIQE that were fitted to patches of 48 pixels of one picture, as a file."""
    from avs.iqa.no_reference.niqe_fit import fit, sharp_features, write_fitted

    prepare_torchvision()
    settings = FitSettings(resize=ResizeSettings(pixels=451), fit=PatchSettings(patch=48, sharpness=0.2))
    card = {"format": "avs-niqe-2", "photographs": 1, "left_out": 0, "settings": settings.model_dump(mode="json")}
    path = tmp_path / "niqe.safetensors"
    write_fitted(path, fit(sharp_features(data.chelsea()[None], settings), 48), card)
    return path, {"resize": {"pixels": 451}, "fit": {"patch": 48, "sharpness": 0.2}}


def test_fitted_niqe_ranks_blur_and_says_that_it_was_fitted(fitted):
    path, settings = fitted
    selector = _niqe(path, settings)
    assert isinstance(selector, HasNotes)
    assert selector.notes == ("NIQE: fitted to 1 photographs of training scenes, not the published parameters",)
    sharp = data.chelsea().astype(np.float32) / 255
    scores = selector.quality(np.stack([sharp, _blurred(sharp, 1), _blurred(sharp, 3)]))
    assert (np.diff(scores) > 0).all()


def test_fitted_niqe_must_see_images_as_its_fit_did(fitted):
    path, settings = fitted
    with pytest.raises(UserError, match="fitted with other settings"):
        _niqe(path, settings | {"resize": {"pixels": 300}})


def test_published_parameters_need_no_note(shared_weights):
    selector = _niqe(shared_weights / "pyiqa/niqe_modelparameters.mat", {})
    assert selector.notes == ()


def _niqe(weights, settings):
    method = registry.find("niqe").method
    return method.build(registry.create_settings("niqe", settings), Resources(weights))


def test_listing_the_methods_imports_no_torch():
    code = "import sys; from avs.selection import registry; registry.methods(); sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_metric_is_made_without_the_network():
    code = (
        "import socket\n"
        "def refuse(*_): raise SystemExit('used the network')\n"
        "socket.socket.connect = refuse\n"
        "socket.getaddrinfo = refuse\n"
        "from avs.selection import registry\n"
        "from avs.selection.contract import Resources\n"
        "method = registry.find('piqe').method\n"
        "method.build(method.settings(), Resources())\n"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
