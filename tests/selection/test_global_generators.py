"""A method that draws from generators of the whole process has the draws of its scene and seed."""

import random

import numpy as np
import pytest
import torch

from avs.selection.choice import select_views
from avs.selection.contract import Method

DRAWS = {
    "python": lambda count: [random.random() for _ in range(count)],
    "numpy": lambda count: np.random.rand(count),  # noqa: NPY002 -- what is tested
    "torch": lambda count: torch.rand(count).numpy(),
}


class Shown:
    """What is read of a state."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.candidates = range(4)


@pytest.mark.parametrize("draw", DRAWS.values(), ids=DRAWS)
def test_draws_are_those_of_the_state_whatever_came_before(draw):
    class Own:
        def score(self, state):
            return np.asarray(draw(len(state.candidates)))

    method = Method("Own", "2D-based", "A test.", "lowest", Own)

    def scores(seed):
        draw(3)
        state = Shown(seed)
        found = select_views(method, Own(), state, 1).scores
        assert state.rng.random() == np.random.default_rng(seed).random()  # nothing was drawn from it
        return found.tolist()

    first, again, other = scores(0), scores(0), scores(1)
    assert first == again
    assert first != other
