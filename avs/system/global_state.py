"""Settings of torch that hold for the whole process: code that changes one would change all that follows it."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import Any

from avs.system.errors import UserError

# How a setting is read and written, and what it is when torch is imported; None where the environment decides.
_Setting = tuple[Callable[[], Any], Callable[[Any], object], Any]


def _settings() -> dict[str, _Setting]:
    """Return each setting by what it is called."""
    import torch

    return {
        "the gradient mode": (torch.is_grad_enabled, torch.set_grad_enabled, True),
        "the default type": (torch.get_default_dtype, torch.set_default_dtype, torch.float32),
        "the precision of products": (
            torch.get_float32_matmul_precision,
            torch.set_float32_matmul_precision,
            "highest",
        ),
        "the number of threads": (torch.get_num_threads, torch.set_num_threads, None),
        "the use of deterministic algorithms": (
            torch.are_deterministic_algorithms_enabled,
            torch.use_deterministic_algorithms,
            False,
        ),
    }


@contextlib.contextmanager
def kept() -> Iterator[list[str]]:
    """Restore the settings at the end of the block; what it changed is in the list then, and each stays as it was.

    Torch is not imported for it: a block that does so finds it as it is when it is imported.
    """
    loaded = "torch" in sys.modules
    before = {name: read() for name, (read, _, _) in _settings().items()} if loaded else {}
    changed: list[str] = []
    try:
        yield changed
    finally:
        for name, (read, write, first) in _settings().items() if "torch" in sys.modules else ():
            expected = before.get(name, first)
            if expected is not None and read() != expected:
                changed.append(f"{name} from {expected} to {read()}")
                write(expected)


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
