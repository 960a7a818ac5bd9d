"""Settings of an exploration in which nothing could be chosen are refused."""

import pytest
from pydantic import ValidationError

from avs.slam.exploration.exploration_settings import ExplorationSettings


@pytest.mark.parametrize("steps", [60, 72])
def test_turns_that_take_all_actions_are_refused(steps):
    with pytest.raises(ValidationError, match=f"the 72 turns at the start take all {steps} actions"):
        ExplorationSettings(steps=steps)
    assert ExplorationSettings(steps=steps, turns=steps - 1).steps == steps
