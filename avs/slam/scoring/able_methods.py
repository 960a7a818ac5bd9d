"""Which methods of Task A can choose paths; read without torch."""

from __future__ import annotations

from avs.selection.contract import Method

OFFERS = frozenset({"fisher_diagonal", "fisher_probes", "blending_weights"})
"""Capabilities of ``avs.representations.capabilities`` that a map has; a method may need no others."""


def why_not_exploring(method: Method, needs: tuple[str, ...]) -> str | None:
    """Return why a method cannot choose paths, or None if it can.

    Args:
        method: its metadata.
        needs: the capabilities that it needs with its settings.
    """
    absent = sorted(set(needs) - OFFERS)
    if absent:
        return f"needs the capability {', '.join(absent)}, which the map of an exploration lacks"
    if method.oracle:
        return "looks at hidden photographs, which an exploration has not"
    if method.scene_units:
        return "takes lengths for parts of a scene's extent, which an exploration measures in metres"
    if method.follows is not None:
        return "captures another method's views and chooses none"
    return None
