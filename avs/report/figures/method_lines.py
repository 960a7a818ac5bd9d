"""How the lines of methods look: a colour for each of the paper's groups, and emphasis for the few to be compared.

Colours are of the palette of Okabe and Ito, which readers with any colour vision tell apart. Methods that do not
compete are grey and dashed, so that print without colour parts them from the others as well.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from avs.report.figures.curves import Curve
from avs.report.methods import presented
from avs.selection.contract import ORACLE, OWN_SCHEDULE, UNRANKED

PROPOSED = "proposed by the paper"
"""What the legend calls those methods."""

_GROUP_COLOURS = {"Geometric": "#0072B2", "3D-based": "#009E73", "2D-based": "#E69F00", PROPOSED: "#D55E00"}
_OTHER_COLOURS = ("#CC79A7", "#56B4E9", "#000000")  # of groups that a plug-in adds
_GREY = "#8A8A8A"
_DASHES = {ORACLE: (0, (4, 1.5)), OWN_SCHEDULE: (0, (1, 1))}
_OTHER_DASHES = (0, (4, 1.2, 1, 1.2))
_THIN, _THICK = 0.7, 1.9  # points
_BEST = 2


def emphasised(curves: Sequence[Curve], reference: str | None) -> list[str]:
    """Return the methods to be compared: the reference, and the two with the highest last value that compete."""
    competing = [curve for curve in curves if curve.group not in UNRANKED and len(curve.mean)]
    best = sorted(competing, key=lambda curve: -float(curve.mean[-1]))[:_BEST]
    first = [curve.method for curve in curves if curve.method == reference]
    return list(dict.fromkeys([*first, *(curve.method for curve in best)]))


def line_styles(curves: Sequence[Curve], reference: str | None) -> dict[str, dict[str, Any]]:
    """Return the options of ``Axes.plot`` for the line of each method."""
    strong = emphasised(curves, reference)
    colours = group_colours([called(curve.method, curve.group) for curve in curves])
    styles = {}
    for curve in curves:
        group, competes = called(curve.method, curve.group), curve.group not in UNRANKED
        styles[curve.method] = {
            "color": colours[group],
            "linestyle": "-" if competes else _DASHES.get(curve.group, _OTHER_DASHES),
            "linewidth": _THICK if curve.method in strong else _THIN,
            "zorder": 5 if curve.method in strong else (3 if competes else 2),
        }
    return styles


def legend_styles(curves: Sequence[Curve]) -> dict[str, dict[str, Any]]:
    """Return the options of a line for each group that occurs, by its name, known groups first."""
    styles = line_styles(curves, None)
    found = {called(curve.method, curve.group): styles[curve.method] | {"linewidth": 1.4} for curve in curves}
    order = [name for name in (*_GROUP_COLOURS, *found) if name in found]
    return {name: found[name] for name in dict.fromkeys(order)}


def called(method: str, group: str) -> str:
    """Return the group by which figures colour a method: the one of its rows, or ``PROPOSED``."""
    return PROPOSED if group not in UNRANKED and presented(method).proposed else group


def group_colours(names: Iterable[str]) -> dict[str, str]:
    """Return the colour of each group by what it is called; other known groups are there as well."""
    names = dict.fromkeys(names)
    others = [name for name in names if name not in _GROUP_COLOURS and name not in UNRANKED]
    added = {name: _OTHER_COLOURS[place % len(_OTHER_COLOURS)] for place, name in enumerate(others)}
    return dict.fromkeys(UNRANKED, _GREY) | _GROUP_COLOURS | added
