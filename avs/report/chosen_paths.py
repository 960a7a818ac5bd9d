"""How a table presents what chooses paths: by its kind and method, since a configuration names it freely."""

from __future__ import annotations

from avs.selection import registry
from avs.slam.scoring.path_settings import FisherPathSettings, PathScorerSettings, SelectorPathSettings

_FISHERRF = FisherPathSettings().kind


def method_of(chooser: PathScorerSettings) -> str:
    """Return the identifier in Task A of the method that chooses, or an empty text for what is no method there."""
    match chooser:
        case SelectorPathSettings():
            return chooser.method
        case FisherPathSettings():
            return _FISHERRF
        case _:
            return ""


def published_as(chooser: PathScorerSettings) -> str | None:
    """Return the identifier under which the paper may have values of what chooses, or None if it has none.

    Its FisherRF sums the information along paths, as FisherRF's mapping was released; FisherRF of Task A, which scores
    single views, is another chooser of paths.
    """
    method = method_of(chooser)
    by_views = isinstance(chooser, SelectorPathSettings) and method == _FISHERRF
    return None if by_views or not method else method


def is_proposed(chooser: PathScorerSettings) -> bool:
    """Return whether the paper proposes what chooses."""
    found = registry.methods().get(method_of(chooser))
    return found is not None and found.method.proposed
