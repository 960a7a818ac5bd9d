"""What a method changes of torch for the whole process is told of and undone."""

import contextlib

import numpy as np
import pytest
import torch

from avs.selection.global_state import kept
from avs.selection.session import timed_selection
from avs.system.errors import UserError


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda: torch.set_grad_enabled(False), "the gradient mode from True to False"),
        (lambda: torch.set_default_dtype(torch.float64), "the default type from torch.float32 to torch.float64"),
        (lambda: torch.use_deterministic_algorithms(True), "the use of deterministic algorithms from False to True"),
    ],
)
def test_a_change_is_told_of_and_undone_after_a_fault_as_well(change, told):
    with kept() as changed:
        change()
    assert changed == [told]
    with contextlib.suppress(ValueError), kept():
        change()
        raise ValueError
    with kept() as changed, torch.no_grad():
        pass
    assert changed == []


def test_a_method_that_changes_one_ends_its_episode_with_one_line(monkeypatch):
    from avs.selection import session, untouched

    for name in ("_progress", "_tensors", "_pixels"):
        monkeypatch.setattr(untouched, name, lambda state: 0)
    monkeypatch.setattr(session, "replace", lambda state, **_: state)
    monkeypatch.setattr(session, "select_views", lambda *_: torch.set_grad_enabled(False))
    method = type("Own", (), {"label": "Own"})()
    state = type("Shown", (), {"representation": None, "rng": np.random.default_rng(0)})()
    with pytest.raises(UserError, match=r"method Own: changed settings of torch .*: the gradient mode from True to Fa"):
        timed_selection(method, None, state, 1, "cpu")
    assert torch.is_grad_enabled()
