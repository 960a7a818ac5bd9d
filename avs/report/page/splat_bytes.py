"""A model of Gaussians in 32 bytes each, the layout ``.splat`` of viewers in browsers.

Each Gaussian is three float32 of its position, three of its scales, four bytes of red, green, blue and opacity, and
four of its rotation (w, x, y, z), 128 for zero. Colours are those of the harmonics of degree 0: what a Gaussian looks
like from all sides in the mean.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avs.representations.gaussians.ply import read_ply
from avs.scene.similarity import Similarity

_HARMONIC = 0.28209479177387814  # of degree 0
_ROW = np.dtype([("position", "<f4", 3), ("scale", "<f4", 3), ("rgba", "u1", 4), ("rotation", "u1", 4)])


def splat_bytes(path: Path, to_capture: Similarity, most: int) -> tuple[bytes, int]:
    """Return the Gaussians of a ``.ply`` file in the scene's coordinates, the most visible first.

    Args:
        path: the file that an episode exports.
        to_capture: from the scene's coordinates to those of the capture, which the file has.
        most: how many are kept: those with the largest product of opacity and mean area of their section.

    Returns:
        32 bytes for each that is kept, and the number of all.

    Raises:
        UserError: the file is missing or damaged.
    """
    found = {name: values.numpy().astype(np.float64) for name, values in read_ply(path, to_capture).items()}
    opacities, scales = 1 / (1 + np.exp(-found["opacities"])), np.exp(found["scales"])
    areas = (scales.prod(axis=1, keepdims=True) / scales).mean(axis=1)
    order = np.argsort(-opacities * areas, kind="stable")[:most]
    colors = np.concatenate([0.5 + _HARMONIC * found["sh"][:, 0], opacities[:, None]], axis=1)
    turns = found["quats"] / np.maximum(np.linalg.norm(found["quats"], axis=1, keepdims=True), 1e-12)
    rows = np.empty(len(order), dtype=_ROW)
    rows["position"], rows["scale"] = found["means"][order], scales[order]
    rows["rgba"] = np.rint(np.clip(colors[order], 0, 1) * 255)
    rows["rotation"] = np.clip(np.rint(turns[order] * 128 + 128), 0, 255)
    return rows.tobytes(), len(opacities)
