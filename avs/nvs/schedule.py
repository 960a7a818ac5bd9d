"""Which views an episode begins with, when more are captured, and how many it ends with."""

from __future__ import annotations

from avs.nvs.protocol import ProtocolSettings
from avs.scene.cameras import IndexArray
from avs.scene.sampling import initial_views
from avs.scene.scene import Scene
from avs.system.errors import UserError


def initial_captures(scene: Scene, protocol: ProtocolSettings, count: int | None = None) -> IndexArray:
    """Return the indices of the views that are captured at the start, by farthest-view sampling of the pool.

    Args:
        scene: the capture.
        protocol: the settings of the loop.
        count: how many views; ``protocol.initial_views`` if None. More of them begin with the same ones.

    Raises:
        UserError: the pool has no image of the number ``protocol.initial_start``.
    """
    pool = scene.pool
    wanted = protocol.initial_views if count is None else count
    if protocol.initial_start >= len(pool):
        fault = f"its pool of {len(pool)} images has none of number {protocol.initial_start}, from 0"
        raise UserError(f"scene {scene.name}", fault, "lower protocol.initial_start")
    return pool[initial_views(scene.cameras[pool].centers, wanted, protocol.initial_start)]


def selections(protocol: ProtocolSettings, budget: int) -> list[tuple[int, int]]:
    """Return the views captured and the steps done before each capture of an episode.

    Args:
        protocol: the settings of the loop.
        budget: number of views at the end, after ``capped_budget``.
    """
    views = range(protocol.initial_views, budget, protocol.views_per_step)
    return list(zip(views, protocol.additions, strict=False))


def selection_number(protocol: ProtocolSettings, views: int, together: int) -> int:
    """Return which selection of an episode, from 0, comes at ``views`` captured views where ``together`` are chosen.

    Of a number between two selections that is the one before.
    """
    return max(0, views - protocol.initial_views) // together


def capped_budget(protocol: ProtocolSettings, pool: int, scene: str) -> tuple[int, list[str]]:
    """Return the number of views at the end, and a note if the pool is too small for the configured budget.

    Args:
        protocol: the settings of the loop.
        pool: number of images in the pool.
        scene: the name of the scene, for the note.

    Raises:
        UserError: the pool has fewer images than the initial views and one candidate.
    """
    if pool <= protocol.initial_views:
        fault = f"its pool of {pool} images leaves no candidate after {protocol.initial_views} initial views"
        raise UserError(f"scene {scene}", fault, "add images, or lower protocol.initial_views")
    allowed = max(int(pool * protocol.pool_share), protocol.initial_views + 1)
    if allowed >= protocol.budget:
        return protocol.budget, []
    return allowed, [f"{scene}: budget {allowed} instead of {protocol.budget}, because its pool has {pool} views"]
