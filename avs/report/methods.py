"""How a method is presented: its printed name, its group, and whether the paper proposes it."""

from __future__ import annotations

from dataclasses import dataclass

from avs.report.collect import Episodes
from avs.selection import registry
from avs.selection.contract import UNRANKED


@dataclass(frozen=True)
class Presented:
    """One method as tables and figures show it.

    Attributes:
        identifier: such as ``fisherrf``.
        label: printed name.
        group: heading of its rows; empty for a method of which nothing is known.
        proposed: whether the paper proposes it.
    """

    identifier: str
    label: str
    group: str = ""
    proposed: bool = False

    @property
    def ranked(self) -> bool:
        """Whether it competes: an oracle, for one, looks at photographs that no method can see."""
        return self.group not in UNRANKED


def presented(identifier: str, episodes: Episodes | None = None) -> Presented:
    """Return how a method is presented: as its records say or, without any, its metadata."""
    registered = registry.methods().get(identifier)
    proposed = registered is not None and registered.method.proposed
    if episodes is not None and (cells := episodes.cells.get(identifier)):
        episode = next(iter(cells.values()))
        labels = [next(iter(each.values())).label for each in episodes.cells.values() if each]
        # several programs can call themselves the same
        label = episode.label if labels.count(episode.label) == 1 else f"{episode.label} ({identifier})"
        return Presented(identifier, label, episode.group, proposed)
    if registered is None:
        return Presented(identifier, identifier)
    return Presented(identifier, registered.method.label, registered.method.group, proposed)
