"""The record of an exploration: every decision with its candidates, paths and scores, and what was measured.

``exploration.json`` is deterministic: the same code, settings, building and seed give the same bytes.
``exploration.meta.json`` holds what differs from run to run.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from avs.system.models import StrictModel

PoseNumbers = tuple[float, float, float, float]
"""x, y, height of the floor in metres, direction in radians."""

MAPS = "maps.safetensors"
"""Name of the file beside the record that figures are drawn from."""

MAPS_HEADER = "maps"
"""Name of its metadata entry."""

LETTERS = {"forward": "F", "left": "L", "right": "R"}
"""How a record writes actions."""


class FrontierEntry(StrictModel):
    """A frontier when a decision was made."""

    x: float = Field(description="of its centroid, metres")
    y: float
    cells: int = Field(description="its size")
    merit: float = Field(description="size / (mean distance + a constant), by which frontiers are ranked")


class PathEntry(StrictModel):
    """A path that was scored."""

    candidate: int = Field(description="index of the candidate that it leads to")
    actions: str = Field(description="F forward, L left, R right; up to the horizon")
    length: float = Field(description="of the whole way, metres")
    score: float = Field(description="the highest is taken")


class Decision(StrictModel):
    """One choice of a path."""

    step: int = Field(description="actions done before it")
    pose: PoseNumbers
    gaussians: int = Field(description="of the map")
    frontiers: list[FrontierEntry] = Field(description="the best first")
    candidates: list[PoseNumbers]
    frontier_of: list[int] = Field(description="index of each candidate's frontier; -1 without one")
    endpoint_scores: list[float] | None = Field(description="of each candidate by itself, where the method has such")
    paths: list[PathEntry]
    chosen: int = Field(description="index of the path that was taken")
    executed: int = Field(description="actions of it that were done")


class CoveragePoint(StrictModel):
    """What was covered at one moment."""

    step: int
    scr_means: float = Field(
        description="share of the visible surface nearer than the threshold to a Gaussian's centre"
    )
    seen: float = Field(description="share of it that the depth camera has seen")
    gaussians: int
    path_length: float = Field(description="metres")


class FinalMeasures(StrictModel):
    """What was measured at the end."""

    scr_means: float = Field(description="surface coverage ratio by the Gaussians' centres, as the paper has it")
    scr_fused: float = Field(description="by the depth that the map renders along the trajectory")
    seen: float = Field(description="share of the visible surface that the depth camera has seen")
    scr_area: float = Field(description="area under the curve of scr_means over the actions, divided by their number")
    depth_mae: float | None = Field(description="metres, over poses all over the floor; null without poses")
    psnr: float | None
    ssim: float | None
    empty: float | None = Field(description="share of the pixels of these poses where less than half is opaque")
    poses: int = Field(description="how many poses")
    trajectory_error: float | None = Field(
        description="root mean square error of tracked positions, metres, after rigid alignment; null for given poses"
    )
    path_length: float = Field(description="metres")
    collisions: int = Field(description="actions during which something was in the way")


class ExplorationRecord(StrictModel):
    """``exploration.json``."""

    schema_version: Literal[1] = 1
    building: str
    building_hash: str = Field(description="SHA-256 of the mesh's file, and of those that it names")
    method: str = Field(description="identifier of what chose the paths")
    label: str = Field(description="its printed name")
    seed: int
    settings: dict[str, Any]
    start: PoseNumbers
    floor_area: float = Field(description="of the storey that is explored, square metres")
    surface_points: int = Field(description="points of the surface that can be seen from there")
    steps: int = Field(description="actions done")
    ended: str = Field(description="why it ended")
    notes: list[str]
    decisions: list[Decision]
    curve: list[CoveragePoint]
    final: FinalMeasures


class ExplorationMeta(StrictModel):
    """``exploration.meta.json``: what differs from run to run."""

    schema_version: Literal[1] = 1
    seconds: dict[str, float] = Field(description="simulate, track, map, plan, score, measure")
    decision_seconds: list[float] = Field(description="from the grid to the choice, for each decision")
    score_seconds: list[float] = Field(description="the part of it that scoring took")
    memory_bytes: list[int] = Field(description="peak resident memory of the process at each point of the curve")
    total_seconds: float = Field(
        description="of the process that ended it; of one that was killed and gone on with, `seconds` count the whole"
    )
    machine: dict[str, str]
    packages: dict[str, str]
    revision: str | None
    started: str
    finished: str
