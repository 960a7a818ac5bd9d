"""The chooser of paths that settings make."""

from __future__ import annotations

from avs.selection.contract import Resources
from avs.selection.registry import create_settings, find, needed
from avs.slam.evaluation.seen_surface import SeenSurface
from avs.slam.scoring.able_methods import why_not_exploring
from avs.slam.scoring.fisher_path_scorer import FisherPathScorer
from avs.slam.scoring.oracle_scorer import OracleScorer
from avs.slam.scoring.path_scorer import PathScorer
from avs.slam.scoring.path_settings import (
    FisherPathSettings,
    NearestSettings,
    OracleSettings,
    PathScorerSettings,
    RandomPathSettings,
)
from avs.slam.scoring.plain_scorers import NearestScorer, RandomPathScorer
from avs.slam.scoring.selector_scorer import SelectorScorer
from avs.system.errors import UserError


def build_scorer(settings: PathScorerSettings, surface: SeenSurface, resources: Resources) -> PathScorer:
    """Return what chooses paths.

    Args:
        settings: which, and how.
        surface: what was seen of the building, for the oracle alone.
        resources: weights and device, for a method of Task A.

    Raises:
        UserError: a method is unknown, lacks its weights, or cannot score paths.
    """
    if isinstance(settings, NearestSettings):
        return NearestScorer()
    if isinstance(settings, RandomPathSettings):
        return RandomPathScorer()
    if isinstance(settings, OracleSettings):
        return OracleScorer(surface)
    if isinstance(settings, FisherPathSettings):
        return FisherPathScorer(settings)
    method = find(settings.method).method
    own = create_settings(settings.method, settings.settings)
    fault = why_not_exploring(method, needed(settings.method, own))
    if fault is not None:
        raise UserError(f"method {settings.method}", fault, "choose another method for the exploration")
    return SelectorScorer(method, method.selector(own, resources), settings)
