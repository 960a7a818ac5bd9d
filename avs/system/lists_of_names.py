"""Names in a line that must not grow with them."""

from __future__ import annotations

from collections.abc import Sequence


def some_of(names: Sequence[str], most: int = 3) -> str:
    """Return the first ``most`` names and how many more there are, such as ``a, b, c and 4 more``."""
    more = "" if len(names) <= most else f" and {len(names) - most} more"
    return ", ".join(names[:most]) + more
