"""Records: what the tile lists and the blending loops read of one Gaussian, packed side by side in depth order."""

import numpy as np

from avs.rasterizer.constants import ALPHA_MIN
from avs.rasterizer.kernels import Floats, Integers, kernel
from avs.rasterizer.simd_memory import aligned_empty
from avs.rasterizer.simd_types import LANES

LOG2_ALPHA_MIN = float(np.log2(ALPHA_MIN))
LOG2_E = float(np.log2(np.e))

# Columns. The quadratic form (dx^2, dx dy, dy^2) and the logarithm of the opacity are in base 2, the former with the
# sign of the exponent. From COLOR on come the channels.
X, Y, XX, XY, YY, LOG_OPACITY, RADIUS_X, RADIUS_Y, COLOR = 0, 1, 2, 3, 4, 5, 6, 7, 8


@kernel
def pack_records(
    order: Integers, means2d: Floats, conics: Floats, opacities: Floats, colors: Floats, depths: Floats,
    radii: Integers, with_depth: bool,
) -> Floats:  # fmt: skip
    """Return the records ``[M, width]`` of the Gaussians in ``order``, colours and then depth as their channels."""
    channels = colors.shape[1]
    width = (COLOR + channels + (1 if with_depth else 0) + LANES - 1) // LANES * LANES
    records: Floats = aligned_empty(len(order) * width).reshape((len(order), width))
    for place in range(len(order)):
        i = order[place]
        records[place, X] = means2d[i, 0]
        records[place, Y] = means2d[i, 1]
        records[place, XX] = np.float32(-0.5 * LOG2_E) * conics[i, 0]
        records[place, XY] = np.float32(-LOG2_E) * conics[i, 1]
        records[place, YY] = np.float32(-0.5 * LOG2_E) * conics[i, 2]
        records[place, LOG_OPACITY] = np.log2(opacities[i])
        records[place, RADIUS_X] = radii[i, 0]
        records[place, RADIUS_Y] = radii[i, 1]
        for c in range(channels):
            records[place, COLOR + c] = colors[i, c]
        if with_depth:
            records[place, COLOR + channels] = depths[i]
    return records
