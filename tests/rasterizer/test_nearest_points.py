"""The sweep finds what SciPy's KD-tree finds, with the same bits."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from avs.rasterizer.nearest_points import nearest_distances

RNG = np.random.default_rng(0)
CLOUDS = {
    "four": RNG.normal(size=(4, 3)),
    "cube": RNG.uniform(-3, 3, (2000, 3)),
    "clusters": np.repeat(RNG.normal(size=(20, 3)), 50, axis=0) + 0.01 * RNG.normal(size=(1000, 3)),
    "plane": RNG.uniform(size=(500, 3)) * [1, 0, 4],
    "grid of ties": np.stack(np.meshgrid(*[np.arange(6.0)] * 3), axis=-1).reshape(-1, 3),
    "one place": np.ones((9, 3)),
    "far from the origin": 1e6 + RNG.normal(size=(300, 3)),
}


@pytest.mark.parametrize("cloud", CLOUDS.values(), ids=CLOUDS)
def test_distances_are_those_of_a_tree(cloud):
    expected, _ = cKDTree(cloud).query(cloud, k=4)
    np.testing.assert_array_equal(nearest_distances(cloud), expected[:, 1:])
