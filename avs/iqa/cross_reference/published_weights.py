"""Scorers that others have trained: used instead of training one, where their weights are at hand."""

from __future__ import annotations

from pathlib import Path

from avs.iqa.cross_reference.scorer_settings import PUBLISHED, ScorerSettings
from avs.system.weights import locate


def published_weights(name: str, settings: ScorerSettings) -> Path | None:
    """Return the local file of the published weights that take the place of a trained scorer, or None.

    The file is not read here, so that the workflow can ask; who loads it compares its hash.

    Args:
        name: of the scorer, such as dinov2.
        settings: of the scorer.
    """
    if not settings.published or name not in PUBLISHED:
        return None
    return locate(PUBLISHED[name])
