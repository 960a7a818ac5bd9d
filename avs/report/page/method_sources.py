"""What the page tells of each method: its source and its deviations, as its metadata state them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from avs.report.figures.method_lines import called, group_colours
from avs.report.methods import presented
from avs.selection import registry
from avs.system.reasons import Reason

GREY = "#8A8A8A"
"""Colour of a group that has none of its own."""


def method_sources(methods: Sequence[str], absent: Mapping[str, Reason]) -> list[dict[str, Any]]:
    """Return the methods of a run in order, each with its metadata and why it does not run, if it does not.

    Args:
        methods: identifiers.
        absent: why one does not run, by identifier.
    """
    shown = [presented(method) for method in methods]
    groups = [called(each.identifier, each.group) for each in shown]
    colours = group_colours(groups)
    return [
        {
            "id": each.identifier,
            "label": each.label,
            "group": each.group,
            "proposed": each.proposed,
            "ranked": each.ranked,
            "colour": colours.get(group, GREY),
            "absent": str(absent[each.identifier]) if each.identifier in absent else None,
            **_metadata(each.identifier),
        }
        for each, group in zip(shown, groups, strict=True)
    ]


def _metadata(identifier: str) -> dict[str, Any]:
    """Return what a method that is registered says of itself; of a program of its own nothing is known."""
    found = registry.methods().get(identifier)
    if found is None:
        return {"source": "a program of its own", "module": None, "chooses": None, "needs": [], "settings": []}
    method = found.method
    fields = method.settings.model_fields
    return {
        "source": method.source,
        "module": found.module,
        "chooses": method.chooses,
        "needs": list(method.needs),
        "scorer": method.scorer,
        "pretrained": list(method.pretrained),
        "settings": [
            [name, _plain(field.get_default(call_default_factory=True)), field.description or ""]
            for name, field in fields.items()
        ],
    }


def _plain(value: object) -> str:
    return "null" if value is None else str(value)
