"""The model of Gaussians that an episode exports, as viewers show it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from avs.representations.gaussians import KIND
from avs.representations.gaussians.initialization import SH_DEGREE_0
from avs.representations.gaussians.ply import read_ply
from avs.scene.similarity import Similarity

FloatArray = npt.NDArray[np.float64]

SPLATS = KIND.exports
"""Name of the model beside the record of an episode of Gaussians."""


@dataclass(frozen=True)
class ExportedModel:
    """n Gaussians in the scene's coordinates.

    Attributes:
        means: ``[n, 3]`` positions.
        scales: ``[n, 3]`` standard deviations.
        quats: ``[n, 4]`` rotations as (w, x, y, z), of any length.
        opacities: ``[n]`` in 0..1.
        colors: ``[n, 3]`` of the harmonics of degree 0, in 0..1: what a Gaussian looks like from all sides in the mean.
    """

    means: FloatArray
    scales: FloatArray
    quats: FloatArray
    opacities: FloatArray
    colors: FloatArray


def read_exported_model(path: Path, to_capture: Similarity) -> ExportedModel:
    """Read a model.

    Args:
        path: the file that an episode exports.
        to_capture: from the scene's coordinates to those of the capture, which the file has.

    Raises:
        UserError: the file is missing or damaged.
    """
    found = {name: values.numpy().astype(np.float64) for name, values in read_ply(path, to_capture).items()}
    return ExportedModel(
        means=found["means"],
        scales=np.exp(found["scales"]),
        quats=found["quats"],
        opacities=1 / (1 + np.exp(-found["opacities"])),
        colors=np.clip(0.5 + SH_DEGREE_0 * found["sh"][:, 0], 0, 1),
    )
