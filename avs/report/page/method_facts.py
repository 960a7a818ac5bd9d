"""What the page tells of each method: how it is presented, and its source and deviations as its metadata state them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from avs.report.document import Document
from avs.report.figures.method_lines import called, group_colours
from avs.report.methods import Presented, presented
from avs.selection import registry
from avs.system.reasons import Reason


def method_facts(shown: Sequence[Presented], absent: Mapping[str, Reason]) -> list[dict[str, Any]]:
    """Return how each method is presented, in order: name, group, colour, and why it does not run, if it does not.

    Args:
        shown: the methods.
        absent: why one does not run, by identifier.
    """
    groups = [called(each.identifier, each.group) for each in shown]
    colours = group_colours(groups)
    return [
        {
            "id": each.identifier,
            "label": each.label,
            "group": each.group,
            "proposed": each.proposed,
            "ranked": each.ranked,
            "colour": colours[group],
            "absent": str(absent[each.identifier]) if each.identifier in absent else None,
        }
        for each, group in zip(shown, groups, strict=True)
    ]


def method_sources(
    methods: Sequence[str], absent: Mapping[str, Reason], tables: Sequence[Document]
) -> list[dict[str, Any]]:
    """Return the methods of a run as ``method_facts`` does, each with its source and settings.

    Args:
        methods: identifiers.
        absent: why one does not run, by identifier.
        tables: of the run, from which a program of its own, which is nowhere registered, has its name and group.
    """
    rows = [(group.name, row) for table in tables for group in table.groups for row in group.rows]
    named = {row.identifier: (row.label, group) for group, row in reversed(rows) if row.identifier}
    programs = named.keys() - registry.methods().keys()
    shown = [Presented(method, *named[method]) if method in programs else presented(method) for method in methods]
    return [told | _metadata(told["id"]) for told in method_facts(shown, absent)]


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
