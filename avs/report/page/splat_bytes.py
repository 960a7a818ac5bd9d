"""A model of Gaussians in 32 bytes each, the layout ``.splat`` of viewers in browsers.

Each Gaussian is three float32 of its position, three of its scales, four bytes of red, green, blue and opacity, and
four of its rotation (w, x, y, z), 128 for zero. Colours are those of the harmonics of degree 0: what a Gaussian looks
like from all sides in the mean.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avs.report.page.exported_model import read_exported_model
from avs.scene.similarity import Similarity

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
    model = read_exported_model(path, to_capture)
    areas = (model.scales.prod(axis=1, keepdims=True) / model.scales).mean(axis=1)
    order = np.argsort(-model.opacities * areas, kind="stable")[:most]
    colors = np.concatenate([model.colors, model.opacities[:, None]], axis=1)
    turns = model.quats / np.maximum(np.linalg.norm(model.quats, axis=1, keepdims=True), 1e-12)
    rows = np.empty(len(order), dtype=_ROW)
    rows["position"], rows["scale"] = model.means[order], model.scales[order]
    rows["rgba"] = np.rint(colors[order] * 255)
    rows["rotation"] = np.clip(np.rint(turns[order] * 128 + 128), 0, 255)
    return rows.tobytes(), len(model.opacities)
