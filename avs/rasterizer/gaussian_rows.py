"""Sixteen Gaussians side by side in scratch memory: a row of sixteen numbers for each number of a Gaussian."""

from avs.rasterizer.kernels import Floats, Numbers, inline
from avs.rasterizer.simd_memory import load_rows
from avs.rasterizer.simd_types import LANES

# Where the rows begin: centre (3), quaternion (4), scale (3), conic (3), compensation; after those a kernel's own.
MEAN, QUAT, SCALE, CONIC, COMPENSATION, ROWS = (LANES * row for row in (0, 3, 7, 10, 13, 14))


# Without a loop: within one numba would count references to the arrays.
@inline
def gather_gaussian(rows: Floats, lane: int, means: Floats, quats: Floats, scales: Floats, i: int) -> None:
    """Set the centre, quaternion and scale of one of the sixteen to those of Gaussian ``i``."""
    rows[MEAN + lane] = means[i, 0]
    rows[MEAN + LANES + lane] = means[i, 1]
    rows[MEAN + 2 * LANES + lane] = means[i, 2]
    rows[QUAT + lane] = quats[i, 0]
    rows[QUAT + LANES + lane] = quats[i, 1]
    rows[QUAT + 2 * LANES + lane] = quats[i, 2]
    rows[QUAT + 3 * LANES + lane] = quats[i, 3]
    rows[SCALE + lane] = scales[i, 0]
    rows[SCALE + LANES + lane] = scales[i, 1]
    rows[SCALE + 2 * LANES + lane] = scales[i, 2]


@inline
def load_gaussian(rows: Floats) -> tuple[Numbers, Numbers, Numbers]:
    """Return centre, quaternion and scale as tuples of vectors."""
    return load_rows(rows, MEAN, 3), load_rows(rows, QUAT, 4), load_rows(rows, SCALE, 3)
