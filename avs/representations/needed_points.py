"""What a reconstruction needs of a scene's points, checked once when the scene is prepared and not in every episode."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from avs.scene.scene import Scene
from avs.system.errors import UserError
from avs.system.models import StrictModel


class NeededPoints(StrictModel):
    """Points that a scene must have."""

    count: int = Field(ge=1, description="at least so many points")
    views: int = Field(ge=0, description="each seen by at least so many images of the pool")
    setting: str = Field(description="what of the configuration needs them")
    otherwise: str = Field(description="a setting that needs no images that see them")
    without: str = Field(description="a setting that needs no points")


def check_points(scene: Scene, needed: NeededPoints) -> None:
    """Raise a ``UserError`` if ``scene`` lacks what is needed. An episode may lack it still: it captures few images."""
    points = scene.points
    of_pool = np.unique(points.observations[np.isin(points.observations[:, 1], scene.pool)], axis=0)
    seen = int((np.bincount(of_pool[:, 0], minlength=len(points)) >= needed.views).sum())
    if seen >= needed.count:
        return
    enough = len(points) >= needed.count and needed.views > 0
    fault = f"{seen} of {len(points)} points are seen by {needed.views} or more images of the pool"
    if not enough:
        fault = f"the model has {len(points)} points"
    doubt = next((note for note in scene.notes if "poses" in note), None)
    if enough and doubt is not None:  # with poses that are wrong, no choice of points helps
        raise UserError(scene.source, f"{fault}, but {needed.setting} needs {needed.count}", f"correct it: {doubt}")
    remedy = f"set {needed.otherwise if enough else needed.without}, or run the structure from motion again"
    raise UserError(scene.source, f"{fault}, but {needed.setting} needs {needed.count}", remedy)
