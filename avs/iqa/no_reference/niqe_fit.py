"""Fits NIQE's Gaussian to pristine pictures, where the published parameters are absent (Mittal et al., SPL 2013)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avs.iqa.no_reference.niqe import FEATURES, Gaussian, checked, local_statistics, luminance, patch_features
from avs.iqa.no_reference.niqe_settings import FitSettings
from avs.iqa.resizing import Pixels, resized, to_tensor
from avs.scene.scene import read_scene
from avs.system.errors import UserError
from avs.system.tensor_files import read_tensors, write_tensors

if TYPE_CHECKING:
    from torch import Tensor

_FORMAT = "avs-niqe-1"
_REMEDY = "delete it and fit it again"


@dataclass(frozen=True)
class FittedParameters:
    """Parameters of NIQE with what they were fitted on.

    Attributes:
        gaussian: the parameters.
        settings: size of the photographs and choice of their patches.
        photographs: how many there were.
    """

    gaussian: Gaussian
    settings: FitSettings
    photographs: int


def fit_scenes(scenes: Sequence[Path], settings: FitSettings, out: Path, progress: Callable[[str], None]) -> None:
    """Fit NIQE's parameters to all photographs of some scenes, and write them.

    Args:
        scenes: folders of scenes, none of which is evaluated later.
        settings: size of the pictures and choice of their patches.
        out: file to write, as ``read_fitted`` reads it.
        progress: receives one line about each scene.

    Raises:
        UserError: a scene is damaged, or the photographs hold too few sharp patches.
    """
    from avs.system.compatibility import prepare_torchvision

    prepare_torchvision()
    features, pictures, hashes = [], 0, {}
    for folder in scenes:
        scene = read_scene(folder)
        views = scene.views(range(len(scene.names)))
        features += [sharp_features(image[None], settings) for image in views.images]
        pictures += len(views)
        hashes[f"{scene.dataset}/{scene.name}"] = scene.content_hash
        progress(f"{scene.name}: {len(views)} photographs, {sum(map(len, features))} sharp patches so far")
    gaussian = fit(np.concatenate(features), settings.fit.patch)
    card = {
        "format": _FORMAT,
        "scenes": hashes,
        "photographs": pictures,
        "patches": sum(map(len, features)),
        "settings": settings.model_dump(mode="json"),
    }
    write_fitted(out, gaussian, card)


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
        photographs = int(card["photographs"])
    except (KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:100]
        raise UserError(path, f"not parameters that avs niqe_fit wrote ({reason})", _REMEDY) from error
    return FittedParameters(checked(gaussian, path, _REMEDY), settings, photographs)
