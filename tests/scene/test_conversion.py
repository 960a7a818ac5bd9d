"""Poses of a COLMAP model."""

import numpy as np
from scipy.spatial.transform import Rotation

from avs.scene.colmap.conversion import rotation_matrix


def test_rotations_have_the_bits_of_scipy():
    rng = np.random.default_rng(0)
    quaternions = [*rng.normal(size=(500, 4)), *np.eye(4), -np.eye(4)[0], np.array([1.0, -2.0, 0.0, 1e-3])]
    for quaternion in quaternions:
        expected = Rotation.from_quat(np.roll(quaternion, -1)).as_matrix()
        np.testing.assert_array_equal(rotation_matrix(quaternion), expected)
