"""Settings of torch that hold for the whole process: a method that changes one would change all that follows it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

from avs.system.errors import UserError

_Setting = tuple[Callable[[], Any], Callable[[Any], object]]


def _settings() -> dict[str, _Setting]:
    """Return how each setting is read and written, by what it is called."""
    import torch

    return {
        "the gradient mode": (torch.is_grad_enabled, torch.set_grad_enabled),
        "the default type": (torch.get_default_dtype, torch.set_default_dtype),
        "the number of threads": (torch.get_num_threads, torch.set_num_threads),
        "the use of deterministic algorithms": (
            torch.are_deterministic_algorithms_enabled,
            torch.use_deterministic_algorithms,
        ),
    }


@contextlib.contextmanager
def kept() -> Iterator[list[str]]:
    """Restore the settings at the end of the block; what it changed is in the list then, and each stays as it was."""
    settings = _settings()
    before = {name: read() for name, (read, _) in settings.items()}
    changed: list[str] = []
    try:
        yield changed
    finally:
        for name, (read, write) in settings.items():
            if read() != before[name]:
                changed.append(f"{name} from {before[name]} to {read()}")
                write(before[name])


@contextlib.contextmanager
def unchanged(label: str) -> Iterator[None]:
    """Refuse a method that changes a setting in the block; each is restored.

    Args:
        label: printed name of the method.

    Raises:
        UserError: a setting was changed.
    """
    with kept() as changed:
        yield
    if changed:
        fault = f"changed settings of torch for all that follows: {', '.join(changed)}"
        raise UserError(f"method {label}", fault, "change them within a block that ends, such as torch.no_grad()")
