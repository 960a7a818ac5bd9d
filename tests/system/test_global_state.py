"""What a method changes of torch for the whole process is told of and undone."""

import contextlib

import numpy as np
import pytest
import torch

from avs.selection.choice import notes_of
from avs.selection.contract import Method, Resources, Settings
from avs.selection.session import preparing, timed_selection
from avs.system.errors import UserError
from avs.system.global_state import kept


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda: torch.set_grad_enabled(False), "the gradient mode from True to False"),
        (lambda: torch.set_default_dtype(torch.float64), "the default type from torch.float32 to torch.float64"),
        (lambda: torch.set_float32_matmul_precision("medium"), "the precision of products from highest to medium"),
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


class Careless:
    """Changes a setting whenever it is asked for anything."""

    def __init__(self, *_):
        torch.set_default_dtype(torch.float64)

    def prepare(self, representation):
        torch.set_grad_enabled(False)

    @property
    def notes(self):
        torch.set_grad_enabled(False)
        return ("a note",)


def test_a_selector_that_changes_one_when_it_is_made_ends_at_once():
    method = Method("Own", "2D-based", "A test.", "lowest", Careless)
    with pytest.raises(UserError, match=r"method Own: changed settings .*: the default type from torch.float32 to to"):
        method.selector(Settings(), Resources())
    assert torch.get_default_dtype() == torch.float32


def test_preparing_a_reconstruction_and_telling_notes_change_none():
    method = Method("Own", "2D-based", "A test.", "lowest", Careless)
    with kept():
        careless = Careless()
    with pytest.raises(UserError, match=r"method Own: changed settings of .*: the gradient mode from True to Fal"):
        preparing(lambda captured: None, method, careless)(np.arange(3))
    assert torch.is_grad_enabled()
    with pytest.raises(UserError, match=r"method Own: changed settings of .*: the gradient mode from True to Fal"):
        notes_of(method, careless)
    assert torch.is_grad_enabled()


def test_a_reconstruction_is_prepared_by_what_asks_for_it_alone():
    method = Method("Own", "2D-based", "A test.", "lowest", Careless)
    prepared = []
    own = type("Own", (), {"prepare": lambda self, representation: prepared.append(representation)})()
    assert preparing(tuple, method, own)([1, 2]) == (1, 2)
    assert prepared == [(1, 2)]
    assert preparing(tuple, method, object()) is tuple
