"""How busy others keep the machine while something is timed."""

from __future__ import annotations

import os
import time
from pathlib import Path

_LEAST_SECONDS = 1.0
"""The kernel counts in hundredths of a second: over a shorter time a share of a core cannot be told."""

_TOLERANCE = 0.05  # seconds

_STAT = Path("/proc/stat")
_BUSY = (0, 1, 2, 5, 6, 7)  # user, nice, system, irq, softirq, steal; guests are part of user
_ALL = range(8)


class LoadMeter:
    """Measures from its making on."""

    def __init__(self) -> None:
        """Begin."""
        self._start = time.perf_counter()
        self._before, self._own = _counters(), _own_seconds()

    def others(self) -> float | None:
        """Return how many cores other processes, or other guests of the hypervisor, kept busy on the mean since then.

        It waits until a second has passed. None where the kernel does not tell.
        """
        time.sleep(max(0.0, self._start + _LEAST_SECONDS - time.perf_counter()))
        elapsed, after, own = time.perf_counter() - self._start, _counters(), _own_seconds() - self._own
        if self._before is None or after is None:
            return None
        busy, total = (later - earlier for later, earlier in zip(after, self._before, strict=True))
        # Sandboxes show counters that stand still; those of a process and of the kernel differ by some hundredths.
        if total < elapsed / 2 or busy < own / 2 - _TOLERANCE:
            return None
        return max(0.0, busy - own) / elapsed


def _counters() -> tuple[float, float] | None:
    """Return the seconds that all cores have been busy, and those counted at all."""
    try:
        fields = [int(each) for each in _STAT.read_text(encoding="ascii").splitlines()[0].split()[1:]]
        ticks = os.sysconf("SC_CLK_TCK")
        return sum(fields[place] for place in _BUSY) / ticks, sum(fields[place] for place in _ALL) / ticks
    except (OSError, ValueError, IndexError):
        return None


def _own_seconds() -> float:
    """Return the processor time of this process and of the children that have ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system
