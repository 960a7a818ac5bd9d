"""The photographs of a scene, decoded once, that nobody can change."""

import numpy as np
import pytest
from factories import small_scene

from avs.scene.photographs import Photographs
from avs.scene.scene import read_scene


def test_a_method_cannot_write_to_what_the_reconstruction_learns_from(tmp_path):
    small_scene(tmp_path / "toy", count=16)
    views = Photographs(read_scene(tmp_path / "toy")).views(np.array([1, 2]))
    with pytest.raises(ValueError, match="read-only"):
        views.images[0][:] = 0
