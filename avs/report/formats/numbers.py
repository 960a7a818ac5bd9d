"""Numbers as text, with an ASCII minus; each format puts its own in place."""

from __future__ import annotations

from avs.report.document import Cell, Difference

EXTRA_DECIMALS = 2
"""Digits of a csv file beyond the printed ones, so that differences and ranks can be recomputed."""


def measured(cell: Cell, decimals: int, plus_minus: str) -> str | None:
    """Return the value, with the spread where there is one, or None if the value is missing."""
    if cell.text is not None or cell.value is None:
        return cell.text
    value = f"{round(cell.value, decimals) + 0.0:.{decimals}f}"  # what rounds to zero has no sign
    return value if cell.spread is None else f"{value}{plus_minus}{cell.spread:.{decimals}f}"


def signed(value: float, decimals: int) -> str:
    """Return a difference with its sign; what rounds to zero has none."""
    text = f"{value:+.{decimals}f}"
    return text if float(text) else text[1:]


def compared(difference: Difference, decimals: int) -> str:
    """Return ``-0.31 [-0.80, +0.12]``: a difference with its interval, where it has one."""
    if difference.interval is None:
        return signed(difference.value, decimals)
    low, high = (signed(end, decimals) for end in difference.interval)
    return f"{signed(difference.value, decimals)} [{low}, {high}]"


def plain(value: float | None, decimals: int) -> str:
    """Return a number for a csv file, or an empty text if it is missing."""
    return "" if value is None else f"{value:.{decimals}f}"
