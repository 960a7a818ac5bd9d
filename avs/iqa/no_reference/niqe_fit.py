"""Fits NIQE's Gaussian to pristine pictures, where the published parameters are absent (Mittal et al., SPL 2013)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avs.iqa.no_reference.niqe import FEATURES, Gaussian, checked, local_statistics, luminance, patch_features
from avs.iqa.no_reference.niqe_settings import FitSettings
from avs.iqa.resizing import Pixels, resized, target_size, to_tensor
from avs.scene.scene import read_scene
from avs.system.errors import UserError
from avs.system.tensor_files import read_tensors, write_tensors

if TYPE_CHECKING:
    from torch import Tensor

_FORMAT = "avs-niqe-2"
_REMEDY = "delete it and fit it again"


@dataclass(frozen=True)
class FittedParameters:
    """Parameters of NIQE with what they were fitted on.

    Attributes:
        gaussian: the parameters.
        settings: size of the photographs and choice of their patches.
        photographs: how many there were.
        left_out: how many more there were that are smaller than that size.
    """

    gaussian: Gaussian
    settings: FitSettings
    photographs: int
    left_out: int


def fit_scenes(scenes: Sequence[Path], settings: FitSettings, out: Path, progress: Callable[[str], None]) -> None:
    """Fit NIQE's parameters to all photographs of some scenes that are large enough, and write them.

    A photograph that would have to be enlarged is left out, for interpolated pixels are no pristine ones: of 736 at 176
    px the 64 that had 96 px had a mean first shape parameter of 2.2, others of 3.1, and changed one choice in five.

    Args:
        scenes: folders of scenes, none of which is evaluated later.
        settings: size of the pictures and choice of their patches.
        out: file to write, as ``read_fitted`` reads it.
        progress: receives one line about each scene.

    Raises:
        UserError: a scene is damaged, or the photographs are too small or hold too few sharp patches.
    """
    from avs.system.compatibility import prepare_torchvision

    prepare_torchvision()
    features, left_out, hashes = [], 0, {}
    for folder in scenes:
        scene = read_scene(folder)
        images = scene.views(range(len(scene.names))).images
        large = [image for image in images if not _enlarged(image, settings)]
        features += [sharp_features(image[None], settings) for image in large]
        left_out += len(images) - len(large)
        hashes[f"{scene.dataset}/{scene.name}"] = scene.content_hash
        progress(f"{scene.name}: {len(large)} photographs, {sum(map(len, features))} sharp patches so far")
    if not features:
        fault = f"all photographs would have to be enlarged to {settings.resize.pixels} pixels, which blurs them"
        raise UserError("niqe", fault, "lower selectors.niqe.resize.pixels")
    gaussian = fit(np.concatenate(features), settings.fit.patch)
    card = {
        "format": _FORMAT,
        "scenes": hashes,
        "photographs": len(features),
        "left_out": left_out,
        "patches": sum(map(len, features)),
        "settings": settings.model_dump(mode="json"),
    }
    write_fitted(out, gaussian, card)


def _enlarged(image: Pixels, settings: FitSettings) -> bool:
    height, width = image.shape[:2]
    return target_size(height, width, settings.resize) > (height, width)


def sharp_features(images: Pixels, settings: FitSettings) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return ``[patches, 36]`` features of the sharp patches of ``[n, height, width, 3]`` photographs.

    A patch is sharp if its mean local deviation, in windows of 7x7 pixels, is at least a part of that of its image's
    sharpest patch. Flat patches, which have no features, never count.
    """
    import torch

    side = settings.fit.patch
    with torch.inference_mode():
        grey = luminance(resized(to_tensor(images), settings.resize).clamp(0.0, 1.0))
        if min(grey.shape[-2:]) < side:
            fault = f"photographs of {grey.shape[-1]}x{grey.shape[-2]} pixels hold no patch of {side}"
            raise UserError("niqe", fault, "lower fit.patch or raise resize.pixels")
        features = patch_features(grey, side)
        sharpness = patch_sharpness(grey, side)
        sharp = sharpness >= settings.fit.sharpness * sharpness.amax(dim=1, keepdim=True)
        kept = features[sharp & torch.isfinite(features).all(dim=2)]
    return kept.numpy()


def patch_sharpness(grey: Tensor, side: int) -> Tensor:
    """Return the mean local deviation ``[n, patches]`` of the patches of ``patch_features``, in their order."""
    from pyiqa.matlab_utils import blockproc

    height, width = (length // side * side for length in grey.shape[-2:])
    _, deviation = local_statistics(grey[..., :height, :width])
    means: Tensor = blockproc(deviation, [side, side], fun=lambda block, _: block.mean((1, 2, 3)))
    return means


def fit(features: np.ndarray[tuple[int, int], np.dtype[np.float64]], patch: int) -> Gaussian:
    """Return the mean and the covariance of ``[patches, 36]`` features.

    Raises:
        UserError: there are not more patches than features, so that the covariance has no inverse.
    """
    if len(features) <= FEATURES:
        fault = f"{len(features)} sharp patches do not make a covariance of {FEATURES} features"
        raise UserError("niqe", fault, "fit more photographs, lower fit.patch or raise resize.pixels")
    return Gaussian(features.mean(axis=0), np.cov(features, rowvar=False), patch)


def write_fitted(path: Path, gaussian: Gaussian, card: dict[str, object]) -> None:
    """Write parameters with what they were fitted on; equal content gives equal bytes."""
    write_tensors(path, {"mean": gaussian.mean, "covariance": gaussian.covariance}, "niqe", card)


def read_fitted(path: Path) -> FittedParameters:
    """Read parameters that ``write_fitted`` wrote.

    Raises:
        UserError: the file is missing, truncated, or something else.
    """
    arrays, card = read_tensors(path, "niqe", _REMEDY)
    try:
        if card["format"] != _FORMAT:
            raise UserError(path, f"format {card['format']!r}, expected {_FORMAT!r}", _REMEDY)
        settings = FitSettings.model_validate(card["settings"])
        gaussian = Gaussian(arrays["mean"], arrays["covariance"], settings.fit.patch)
        photographs, left_out = int(card["photographs"]), int(card["left_out"])
    except (KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:100]
        raise UserError(path, f"not parameters that avs niqe_fit wrote ({reason})", _REMEDY) from error
    return FittedParameters(checked(gaussian, path, _REMEDY), settings, photographs, left_out)
