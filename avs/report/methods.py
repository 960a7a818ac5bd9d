"""How a method is presented: its printed name, its group, and whether the paper proposes it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from avs.report.collect import Episodes
from avs.report.labels import group_of, told_apart
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
        whole: whether it has every episode that another method has; a mean over fewer is not to be ranked.
    """

    identifier: str
    label: str
    group: str = ""
    proposed: bool = False
    whole: bool = True

    @property
    def competes(self) -> bool:
        """Whether its choices are its own and its numbers those of the common schedule (``UNRANKED``)."""
        return self.group not in UNRANKED

    @property
    def ranked(self) -> bool:
        """Whether its mean has a place among the others'."""
        return self.competes and self.whole


def presented_in_columns(identifier: str, columns: Iterable[Episodes]) -> Presented:
    """Return how a method is presented in a table whose columns are of other episodes each.

    That is as the first says in which it competes, or in which it ran. Whether it competes, and is whole, in one of
    them is a matter of its cells there (``avs.report.document.Cell.ranked``): a gap in one says nothing of another.
    """
    all_columns = list(columns)
    found = [presented(identifier, each) for each in all_columns if each.cells.get(identifier)]
    if not found:
        return replace(presented(identifier), whole=True)
    first = next((each for each in found if each.competes), found[0])
    return replace(first, label=_labels(all_columns)[identifier], whole=True)


def presented(identifier: str, episodes: Episodes | None = None) -> Presented:
    """Return how a method is presented: as its records say or, without any, its metadata."""
    registered = registry.methods().get(identifier)
    proposed = registered is not None and registered.method.proposed
    if episodes is not None and (cells := episodes.cells.get(identifier)):
        group = next(iter(cells.values())).group
        return Presented(identifier, _labels([episodes])[identifier], group, proposed, not episodes.lacking(identifier))
    if registered is None:
        return Presented(identifier, identifier)
    return Presented(identifier, _labels([])[identifier], group_of(registered.method.group), proposed)


def _labels(columns: Sequence[Episodes]) -> dict[str, str]:
    """Return the printed names of the methods that have episodes or are registered, by identifier.

    Several programs can call themselves the same, and like a method that is not there.
    """
    labels = {name: each.method.label for name, each in registry.methods().items()}
    for episodes in reversed(columns):
        labels |= {name: next(iter(cells.values())).label for name, cells in episodes.cells.items() if cells}
    return told_apart(labels)
