"""NIQE: the distance of an image's patch statistics from those of pristine pictures (Mittal et al., SPL 2013).

The statistics of a patch are 18 parameters of fitted distributions at each of two scales; pristine pictures are one
multivariate Gaussian of them. The features are pyiqa's functions; here they can have another size of patch than 96.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from avs.system.errors import UserError
from avs.system.weights.cache import COMMAND

if TYPE_CHECKING:
    from torch import Tensor

FEATURES = 36
PUBLISHED_PATCH = 96
"""Pixels of a side of the patches that the published parameters were fitted on."""

_REMEDY = f"{COMMAND} niqe"
Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Gaussian:
    """Patch statistics of pristine pictures.

    Attributes:
        mean: ``[36]``.
        covariance: ``[36, 36]``.
        patch: pixels of a patch's side.
    """

    mean: Array
    covariance: Array
    patch: int = PUBLISHED_PATCH


class NIQE:
    """The square root of equation 10, lower is better; in float64, as pyiqa computes it.

    An image with fewer than two patches that are not flat gets NaN: they have no covariance.

    Args:
        pristine: the statistics that images are compared with.
    """

    def __init__(self, pristine: Gaussian) -> None:
        self._pristine = pristine

    def __call__(self, images: Tensor) -> Tensor:
        """Return ``[n]`` scores of RGB images ``[n, 3, height, width]`` in 0..1.

        Raises:
            UserError: the images hold fewer than two patches.
        """
        import torch

        side = self._pristine.patch
        height, width = images.shape[-2:]
        if (height // side) * (width // side) < 2:
            fault = f"images of {width}x{height} pixels hold fewer than two patches of {side}"
            raise UserError("niqe", fault, "raise resize.pixels in the settings of the method")
        mean = torch.from_numpy(self._pristine.mean).to(images.device)
        covariance = torch.from_numpy(self._pristine.covariance).to(images.device)
        scores = []
        for features in patch_features(luminance(images), side):
            whole = features[torch.isfinite(features).all(dim=1)]
            if len(whole) < 2:
                scores.append(mean.new_tensor(float("nan")))
                continue
            difference = mean - torch.nanmean(features, dim=0)
            inverse = torch.linalg.pinv((covariance + torch.cov(whole.T)) / 2)
            scores.append(torch.sqrt(difference @ inverse @ difference))
        return torch.stack(scores)


def luminance(images: Tensor) -> Tensor:
    """Return the rounded luminance ``[n, 1, height, width]`` in 0..255, float64, of RGB images in 0..1."""
    import torch
    from pyiqa.utils.color_util import to_y_channel

    grey: Tensor = to_y_channel(images, 255, "yiq")
    return grey.round().to(torch.float64)


def patch_features(grey: Tensor, side: int) -> Tensor:
    """Return ``[n, patches, 36]`` features of the whole patches of ``[n, 1, height, width]`` luminance in 0..255.

    Patches go down the columns, as in MATLAB. A flat patch has features that are NaN.

    Args:
        grey: the images.
        side: pixels of a patch's side, even.
    """
    import torch
    from pyiqa.archs.niqe_arch import compute_feature
    from pyiqa.matlab_utils import blockproc, imresize

    height, width = (length // side * side for length in grey.shape[-2:])
    grey = grey[..., :height, :width]
    features = []
    for scale in (1, 2):
        mean, deviation = local_statistics(grey)
        normalized = (grey - mean) / (deviation + 1.0)
        features.append(blockproc(normalized, [side // scale, side // scale], fun=compute_feature))
        if scale == 1:
            grey = imresize(grey / 255.0, scale=0.5, antialiasing=True) * 255.0
    return torch.cat(features, dim=-1)


def local_statistics(grey: Tensor) -> tuple[Tensor, Tensor]:
    """Return the local mean and standard deviation of ``[n, 1, height, width]`` luminance, of its shape.

    The window is a Gaussian of 7x7 pixels and sigma 7/6. It is applied by rows and by columns, which takes half of the
    time that the whole of NIQE takes with pyiqa's 7x7 window in float64; pyiqa's is rounded to float32.
    """
    import torch
    from torch.nn import functional

    window = torch.exp(-0.5 * (torch.arange(-3, 4, dtype=grey.dtype, device=grey.device) / (7 / 6)) ** 2)
    window = window / window.sum()
    moments = functional.pad(torch.cat([grey, grey**2], dim=1), (3, 3, 3, 3), mode="replicate")
    rows = functional.conv2d(moments.flatten(0, 1)[:, None], window.view(1, 1, 1, 7))
    mean, square = functional.conv2d(rows, window.view(1, 1, 7, 1)).reshape(len(grey), 2, 1, *grey.shape[-2:]).unbind(1)
    return mean, ((square - mean**2).abs() + torch.finfo(grey.dtype).eps).sqrt()


def read_published(path: Path) -> Gaussian:
    """Return the parameters of a MATLAB file, as pyiqa loads it: ``mu_prisparam`` and ``cov_prisparam``.

    Raises:
        UserError: the file is damaged, or holds something else.
    """
    import scipy.io

    try:
        # Only numbers are read; a MATLAB object or function would come as another type, which the check refuses.
        values = scipy.io.loadmat(io.BytesIO(path.read_bytes()), variable_names=["mu_prisparam", "cov_prisparam"])
        mean = np.ravel(values["mu_prisparam"]).astype(np.float64)
        covariance = np.asarray(values["cov_prisparam"]).astype(np.float64)
    except Exception as error:  # scipy raises many types for a damaged file
        reason = " ".join(str(error).split())[:100]
        raise UserError(path, f"cannot be read as NIQE's parameters ({reason})", _REMEDY) from error
    return checked(Gaussian(mean, covariance), path, _REMEDY)


def checked(pristine: Gaussian, path: Path, remedy: str) -> Gaussian:
    """Return parameters that can be those of NIQE.

    Raises:
        UserError: wrong shapes, or numbers that are not finite.
    """
    shapes = (pristine.mean.shape, pristine.covariance.shape)
    if shapes != ((FEATURES,), (FEATURES, FEATURES)):
        raise UserError(path, f"not NIQE's parameters: shapes {shapes}, expected ((36,), (36, 36))", remedy)
    if not (np.isfinite(pristine.mean).all() and np.isfinite(pristine.covariance).all()):
        raise UserError(path, "holds numbers that are not finite", remedy)
    return pristine
