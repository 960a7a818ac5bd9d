"""Whether a method left what it was shown as it was: the reconstruction that is fitted further, and the photographs."""

from __future__ import annotations

import contextlib
import zlib
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Protocol, runtime_checkable

from avs.representations.base import unwrapped
from avs.scene.views import Views
from avs.selection.contract import State
from avs.system.errors import UserError
from avs.system.global_state import unchanged

_REMEDY = "let it work on a copy (capability copy, numpy.array)"

_PHOTOGRAPHS = "wrote into the photographs that it was shown"


@runtime_checkable
class Fingerprinted(Protocol):
    """What a representation may offer so that a change of it is found, whatever way it was made."""

    def fingerprint(self) -> int:
        """Return a checksum of all that a rendering depends on; it takes milliseconds."""
        ...


@contextlib.contextmanager
def untouched(
    label: str,
    state: State,
    *,
    disposable: bool = False,
    aside: Callable[[], AbstractContextManager[None]] = contextlib.nullcontext,
) -> Iterator[None]:
    """Refuse a method that changes in the block what it is shown in ``state``: the episode goes on with it.

    Photographs are marked read-only, but a tensor that shares their memory is not, and the mark can be taken off.

    Args:
        label: printed name of the method.
        state: what the method is shown.
        disposable: whether the reconstruction is used for nothing else, so that it may change.
        aside: stops a clock that runs around the block while the check looks.

    Raises:
        UserError: the reconstruction was fitted further or written into, a photograph was, or a setting of torch that
            holds for the whole process was changed; it is restored.
    """
    with aside():
        progress, tensors, pixels = _progress(state), _tensors(state), _pixels(state)
    with unchanged(label):
        yield
    with aside():
        faults = {
            "went on fitting the reconstruction that it was shown": _progress(state) != progress,
            "wrote into the reconstruction that it was shown": _tensors(state) != tensors,
            _PHOTOGRAPHS: _pixels(state) != pixels,
        }
    for fault, found in faults.items():
        if found and (not disposable or fault == _PHOTOGRAPHS):
            raise UserError(f"method {label}", fault, _REMEDY)


def _progress(state: State) -> tuple[object, ...]:
    """Return what tells of a reconstruction that was fitted further, as far as its kind counts that."""
    inner = unwrapped(state.representation)
    return tuple(getattr(inner, name, None) for name in ("iteration", "primitives"))


def _tensors(state: State) -> int:
    inner = unwrapped(state.representation)
    return inner.fingerprint() if isinstance(inner, Fingerprinted) else 0


def _pixels(state: State) -> int:
    """Return a checksum of all photographs that a method is shown, hidden ones too."""
    shown: list[Views] = [state.captured]
    if state.truth is not None:
        shown += [state.truth.candidates, state.truth.test]
    found = 0
    for views in shown:
        for image in views.images:
            found = zlib.crc32(image.data if image.flags.c_contiguous else image.tobytes(), found)
    return found
