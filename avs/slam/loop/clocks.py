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
    _aside: float = 0.0

    def now(self) -> float:
        """Return a moment in seconds; between two moments nothing is counted of what was done aside."""
        return time.perf_counter() - self._aside

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Leave the time of the block out of every count: a check, which is no part of what is measured."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self._aside += time.perf_counter() - start

    @contextmanager
    def of(self, module: str) -> Iterator[None]:
        """Count the time of the block for ``module``."""
        start = self.now()
        yield
        self.seconds[module] += self.now() - start
