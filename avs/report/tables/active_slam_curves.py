"""What explorations covered over the actions of the robot, for a csv file."""

from __future__ import annotations

from avs.report.collect_explorations import Explorations
from avs.report.document import Listing
from avs.report.formats.numbers import plain

CURVE_FIELDS = ("building", "method", "seed", "step", "scr_means", "seen", "gaussians", "path_length")
"""Columns of the csv file of curves."""


def curves(explorations: Explorations) -> Listing:
    """Return one record for each moment of each exploration."""
    rows: list[tuple[str | int, ...]] = []
    for place, record in sorted(explorations.cells.items()):
        for point in record.curve:
            shares = plain(point.scr_means, 6), plain(point.seen, 6)
            rows.append((*place, point.step, *shares, point.gaussians, plain(point.path_length, 3)))
    return Listing(CURVE_FIELDS, tuple(rows))
