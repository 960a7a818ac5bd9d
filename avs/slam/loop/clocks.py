"""How long each module of an exploration takes."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field


@dataclass
class Clocks:
    """Seconds by module."""

    seconds: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("simulate", "plan", "score", "measure"), 0.0)
    )
    decisions: list[float] = field(default_factory=list)
    scores: list[float] = field(default_factory=list)
    memory: list[int] = field(default_factory=list)

    @contextmanager
    def of(self, module: str) -> Iterator[None]:
        """Count the time of the block for ``module``."""
        start = time.perf_counter()
        yield
        self.seconds[module] += time.perf_counter() - start
