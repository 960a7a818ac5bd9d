"""Data as classic scripts: what a page that is opened from disk can load on demand, where it may fetch nothing.

A script calls the page's function ``receive`` with the name by which the page asked for it: its path in the page's
folder without suffix.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from avs.system.files import write_text

_DIGITS = 6


def script_text(name: str, value: object) -> str:
    """Return a script that hands ``value`` to the page under ``name``.

    Raises:
        ValueError: ``value`` holds NaN or an infinity.
    """
    told = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return f"avs.receive({json.dumps(name)},{told});\n"


def write_script(page: Path, name: str, value: object) -> int:
    """Write a script to ``<page>/<name>.js`` and return its number of bytes."""
    text = script_text(name, value)
    write_text(page / f"{name}.js", text)
    return len(text)


def rounded(values: Iterable[float | None], digits: int = _DIGITS) -> list[float | None]:
    """Return numbers with so many significant digits, which no drawing can tell from all of them."""
    return [None if value is None else float(f"{value:.{digits}g}") for value in values]


# Digits of scores; 17 tell all numbers apart.
_ENOUGH = (8, 12, 17)


def told_apart(values: Sequence[float | None]) -> list[float | None]:
    """Return numbers with as few significant digits as leave those that differ different: in the same order, that is.

    With six, two candidates of 48 shared a place in one selection of 3,250, and the wrong one came first.
    """
    shorter = (rounded(values, digits) for digits in _ENOUGH)
    return next(each for each in shorter if len(set(each)) == len(set(values)))


def encoded(content: bytes) -> str:
    """Return bytes as base64."""
    return base64.b64encode(content).decode("ascii")


def data_address(content: bytes, kind: str) -> str:
    """Return the content of a file as an address that an element of a page can show, such as a picture's."""
    return f"data:{kind};base64,{encoded(content)}"


def plain_tree(value: Any) -> Any:  # noqa: ANN401 (what JSON holds)
    """Return a tree of JSON in which every number has six significant digits."""
    if isinstance(value, dict):
        return {key: plain_tree(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain_tree(each) for each in value]
    return float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value
