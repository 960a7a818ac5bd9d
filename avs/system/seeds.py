"""Seeds that depend on names, not on the order in which jobs run."""

from __future__ import annotations

import hashlib
import random

import numpy as np


def seed_of(*parts: object) -> int:
    """Return a 63-bit seed that depends on the parts alone, not on the order in which jobs run."""
    digest = hashlib.sha256("\0".join(map(str, parts)).encode()).digest()
    return int.from_bytes(digest[:8], "big") >> 1


def seed_global_generators(*parts: object) -> None:
    """Seed the generators of Python, NumPy and torch that a whole process shares, by ``seed_of(*parts)``.

    Nothing here draws from them, but somebody's method may: its numbers then are those of its scene and seed, whatever
    the process has done before, or the one that it was forked from.
    """
    import torch

    seed = seed_of(*parts)
    random.seed(seed)
    np.random.seed(seed % 2**32)  # noqa: NPY002 -- the very generator that others may use
    torch.manual_seed(seed)


def seed_global_generators_from(rng: np.random.Generator) -> None:
    """Seed them by the state of ``rng``, from which nothing is drawn."""
    seed_global_generators("global", rng.bit_generator.state)
