"""NIQE: the same as pyiqa's with its published parameters; the fit, and files that are something else."""

from types import SimpleNamespace

import numpy as np
import pytest
import safetensors.torch
from skimage import data

from avs.iqa.no_reference.niqe import NIQE, Gaussian, local_statistics, luminance, patch_features, read_published
from avs.iqa.no_reference.niqe_fit import (
    fit,
    fit_scenes,
    patch_sharpness,
    read_fitted,
    sharp_features,
    write_fitted,
)
from avs.iqa.no_reference.niqe_settings import FitSettings, PatchSettings
from avs.iqa.resizing import ResizeSettings
from avs.system.compatibility import prepare_torchvision
from avs.system.errors import UserError
from tests.tolerances import LOCAL_DEVIATION, LOCAL_MEAN, NIQE_PYIQA

torch = pytest.importorskip("torch")
prepare_torchvision()


def picture(name="chelsea"):
    return getattr(data, name)()[None]


def tensor(pixels):
    return torch.from_numpy(np.ascontiguousarray(pixels.transpose(0, 3, 1, 2))).float() / 255


def some_gaussian(patch=96):
    rng = np.random.default_rng(0)
    return fit(rng.random((60, 36)), patch)


def test_scores_are_those_of_pyiqa(shared_weights):
    import pyiqa

    path = shared_weights / "pyiqa/niqe_modelparameters.mat"
    images = torch.cat([tensor(picture()[:, :290, :400]), tensor(picture("coffee")[:, :290, :400])])
    expected = pyiqa.create_metric("niqe", device=torch.device("cpu"), pretrained_model_path=str(path))(images)
    torch.testing.assert_close(NIQE(read_published(path))(images), expected, rtol=NIQE_PYIQA, atol=0)


def test_local_statistics_are_those_of_the_whole_window():
    from scipy import ndimage

    grey = np.random.default_rng(0).integers(0, 256, (30, 40)).astype(np.float64)
    grey[:, :20] = 7
    offsets = np.arange(-3, 4)
    window = np.exp(-(offsets[:, None] ** 2 + offsets**2) / (2 * (7 / 6) ** 2))
    window /= window.sum()
    expected = ndimage.correlate(grey, window, mode="nearest")
    variance = ndimage.correlate(grey**2, window, mode="nearest") - expected**2
    mean, deviation = (values[0, 0].numpy() for values in local_statistics(torch.from_numpy(grey)[None, None]))
    np.testing.assert_allclose(mean, expected, atol=LOCAL_MEAN)
    np.testing.assert_allclose(deviation, np.sqrt(np.abs(variance)), atol=LOCAL_DEVIATION)


def test_image_with_flat_patches_is_scored_by_the_others():
    images = tensor(picture()[:, :192, :288])
    images[..., :96] = 0.5  # two of six patches
    images = torch.cat([images, torch.zeros_like(images)])
    score = NIQE(some_gaussian())(images)
    assert torch.isfinite(score[0])
    assert torch.isnan(score[1])


def test_image_of_fewer_than_two_patches_is_refused():
    with pytest.raises(UserError, match="120x100 pixels hold fewer than two patches of 96"):
        NIQE(some_gaussian())(torch.rand(1, 3, 100, 120))


def test_patches_of_another_size():
    features = patch_features(luminance(tensor(picture()[:, :100, :150])), 48)
    assert features.shape == (1, 6, 36)
    assert torch.isfinite(NIQE(some_gaussian(48))(torch.rand(2, 3, 100, 150))).all()


def test_sharpness_ranks_patches_and_selects_them():
    grey = np.zeros((96, 144), dtype=np.float64)
    rng = np.random.default_rng(0)
    for column, amplitude in enumerate((10, 100, 80)):
        grey[:, 48 * column : 48 * (column + 1)] = 128 + amplitude * (rng.random((96, 48)) - 0.5)
    sharpness = patch_sharpness(torch.from_numpy(grey)[None, None], 48)[0]
    assert set(sharpness.argsort()[:2].tolist()) == {0, 1}  # down the columns: the first column has the weakest texture
    colour = np.repeat(grey.round().astype(np.uint8)[None, ..., None], 3, axis=-1)
    settings = FitSettings(resize=ResizeSettings(pixels=144), fit=PatchSettings(patch=48, sharpness=0.75))
    kept = sharp_features(colour, settings)
    assert len(kept) == 4
    every = patch_features(luminance(tensor(colour)), 48)[0]
    np.testing.assert_array_equal(kept, every[2:].numpy())


def test_fit_is_mean_and_covariance():
    features = np.random.default_rng(0).normal(size=(50, 36))
    fitted = fit(features, 96)
    centred = features - fitted.mean
    np.testing.assert_allclose(fitted.mean, features.sum(axis=0) / 50)
    np.testing.assert_allclose(fitted.covariance, centred.T @ centred / 49, atol=1e-14)
    with pytest.raises(UserError, match="36 sharp patches"):
        fit(features[:36], 96)


def test_file_keeps_the_parameters_and_is_the_same_twice(tmp_path):
    gaussian, card = (
        some_gaussian(48),
        {
            "format": "avs-niqe-2",
            "photographs": 3,
            "left_out": 2,
            "settings": FitSettings(fit=PatchSettings(patch=48)).model_dump(mode="json"),
        },
    )
    path = tmp_path / "niqe.safetensors"
    write_fitted(path, gaussian, card)
    first = path.read_bytes()
    write_fitted(path, gaussian, card)
    assert path.read_bytes() == first
    back = read_fitted(path)
    assert back.gaussian.patch == back.settings.fit.patch == 48
    assert (back.photographs, back.left_out) == (3, 2)
    np.testing.assert_array_equal(back.gaussian.mean, gaussian.mean)
    np.testing.assert_array_equal(back.gaussian.covariance, gaussian.covariance)


@pytest.mark.parametrize("reader", [read_published, read_fitted])
def test_other_files_are_refused_in_one_line(reader, tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    with pytest.raises(UserError) as error:
        reader(path)
    assert "\n" not in str(error.value)
    safetensors.torch.save_file({"mean": torch.zeros(3)}, path)
    with pytest.raises(UserError):
        reader(path)


def test_parameters_of_a_wrong_shape_are_refused(tmp_path):
    import scipy.io

    path = tmp_path / "niqe.mat"
    scipy.io.savemat(path, {"mu_prisparam": np.zeros((1, 36)), "cov_prisparam": np.zeros((35, 36))})
    with pytest.raises(UserError, match="not NIQE's parameters"):
        read_published(path)
    scipy.io.savemat(path, {"mu_prisparam": np.full((1, 36), np.nan), "cov_prisparam": np.eye(36)})
    with pytest.raises(UserError, match="not finite"):
        read_published(path)
    assert Gaussian(np.zeros(36), np.eye(36)).patch == 96


@pytest.fixture
def fitted_to(tmp_path, monkeypatch):
    """Return what fits NIQE to photographs of one scene, resized to 96 pixels, and the lines that it prints."""

    def fitted(photographs):
        scene = SimpleNamespace(
            name="cat",
            dataset="pets",
            content_hash="0",
            names=range(len(photographs)),
            views=lambda rows: Photographs(photographs),
        )
        monkeypatch.setattr("avs.iqa.no_reference.niqe_fit.read_scene", lambda folder: scene)
        lines = []
        fit_scenes([tmp_path], SMALL, tmp_path / "niqe.safetensors", lines.append)
        return read_fitted(tmp_path / "niqe.safetensors"), lines

    return fitted


SMALL = FitSettings(resize=ResizeSettings(pixels=96), fit=PatchSettings(patch=32, sharpness=0.2))
CATS = tuple(data.chelsea()[:96, 32 * start : 32 * start + 96] for start in range(8))


def test_fit_of_a_scene_is_that_of_its_photographs(fitted_to):
    back, lines = fitted_to(CATS)
    features = np.concatenate([sharp_features(image[None], SMALL) for image in CATS])
    np.testing.assert_array_equal(back.gaussian.mean, features.mean(axis=0))
    assert back.settings == SMALL
    assert (back.photographs, back.left_out) == (8, 0)
    assert lines == [f"cat: 8 photographs, {len(features)} sharp patches so far"]


def test_photographs_that_would_be_enlarged_are_left_out_of_the_fit(fitted_to):
    small = tuple(image[:60, :95] for image in CATS)
    alone, _ = fitted_to(CATS)
    back, lines = fitted_to((*small, *CATS))
    np.testing.assert_array_equal(back.gaussian.mean, alone.gaussian.mean)
    assert (back.photographs, back.left_out) == (8, 8)
    assert lines[0].startswith("cat: 8 photographs")
    with pytest.raises(UserError, match="enlarged to 96 pixels"):
        fitted_to(small)


class Photographs(tuple):
    """Photographs as ``Views`` holds them, without cameras."""

    @property
    def images(self):
        return self
