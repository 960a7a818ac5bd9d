"""The records of coverage: of a scene's reference, and of one episode.

``reference.json`` and ``coverage.json`` are deterministic; ``*.meta.json`` holds what differs from run to run. Beside
them lie clouds as ``.ply``, with distances as fields of their points, in scene units.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from avs.system.models import Share, StrictModel


class Placement(StrictModel):
    """How a reconstruction that finds its own poses was brought to where its distances are taken."""

    scale: float = Field(gt=0, description="scene units in one unit of the reconstruction")
    residual: float = Field(ge=0, description="root mean square distance of the camera centres that agree, scene units")
    agreeing: int = Field(description="number of cameras that agree")
    shared: int = Field(description="number of cameras that were compared")


class FreeCamera(StrictModel):
    """A camera that the reference found by itself, in scene coordinates."""

    world_to_camera: tuple[tuple[float, float, float, float], ...] = Field(
        min_length=4, max_length=4, description="4 x 4"
    )
    intrinsics: tuple[tuple[float, float, float], ...] = Field(min_length=3, max_length=3, description="3 x 3, pixels")


class Reference(StrictModel):
    """``reference.json``: what the views of a scene's episodes are held against."""

    schema_version: Literal[1] = 1
    scene: str
    dataset: str
    scene_hash: str = Field(description="content hash of the scene")
    settings: dict[str, Any] = Field(description="the settings it was made with")
    views: list[str] = Field(description="the views of the cloud, ascending")
    registered: list[str] = Field(description="those that the cloud is made of")
    left_out: dict[str, str] = Field(description="why each of the others is not")
    points: int = Field(description="points of the cloud, reference.ply")
    extent: float | None = Field(description="size of the cloud, scene units; null for a cloud without one")
    surface_points: int = Field(description="points of the true surface, surface.ply; 0 where it is not known")
    placement: Placement | None = Field(description="into the scene, by the scene's cameras; null for known poses")
    cameras: dict[str, FreeCamera] | None = Field(description="by name of the view; null for known poses")
    notes: list[str] = Field(description="what a reader of the numbers should know")
    files: dict[str, str] = Field(description="SHA-256 of the clouds, by file name")


class AtThreshold(StrictModel):
    """Agreement of two clouds at one threshold."""

    threshold: float = Field(description="in extents")
    precision: Share = Field(description="share of the cloud nearer to the reference than the threshold")
    recall: Share = Field(description="share of the reference nearer to the cloud than the threshold")
    f_score: Share = Field(description="their harmonic mean")


class Numbers(StrictModel):
    """How a cloud covers a reference, over one point for each voxel."""

    scr: Share = Field(description="surface coverage ratio: share of the reference nearer than the threshold")
    f_score: Share = Field(description="mean of the F-scores at all thresholds, as the paper has it")
    toolbox_f_score: Share = Field(description="at the threshold of the SCR, by the Tanks and Temples toolbox")
    at: list[AtThreshold] = Field(description="each threshold of the mean")


class CoveragePoint(StrictModel):
    """Coverage by the first views of an episode."""

    views: int = Field(description="number of views")
    registered: int = Field(description="number of them that the cloud is made of")
    points: int = Field(description="points of the cloud")
    scr: Share = Field(description="against the reference cloud")
    true_scr: Share | None = Field(description="against the true surface; null where it is not known")


class Coverage(StrictModel):
    """``coverage.json``: what the views of one episode cover."""

    schema_version: Literal[1] = 1
    scene: str
    dataset: str
    scene_hash: str = Field(description="content hash of the scene")
    method: str = Field(description="identifier, such as fisherrf")
    seed: int
    settings: dict[str, Any] = Field(description="the settings it was measured with")
    reference: dict[str, Any] = Field(description="the settings of the reference")
    views: list[str] = Field(description="the views of the episode, in the order of capture")
    registered: list[str] = Field(description="those that the cloud is made of, ascending")
    left_out: dict[str, str] = Field(description="why each of the others is not")
    points: int = Field(description="points of the cloud, cloud.ply")
    extent: float | None = Field(description="of the reference, scene units, of which thresholds are shares")
    placement: Placement | None = Field(description="onto the reference, by shared cameras; null for known poses")
    against_reference: Numbers | None = Field(description="null where the scene's reference has no extent")
    against_surface: Numbers | None = Field(description="against the true surface; null where it is not known")
    curve: list[CoveragePoint] = Field(description="by numbers of views, ascending, the last with all")
    absent: dict[str, str] = Field(description="why a group of numbers is null, by its name")
    notes: list[str] = Field(description="what a reader of the numbers should know")


class CoverageMeta(StrictModel):
    """``*.meta.json``: what differs from run to run."""

    schema_version: Literal[1] = 1
    reconstruction_seconds: float = Field(description="of the cloud of all views")
    total_seconds: float
    peak_memory_bytes: int = Field(description="peak resident memory of the process; on CUDA the allocator's peak")
    other_cores: float | None = Field(
        description="cores that other programs kept busy on the mean meanwhile; null if not known"
    )
    device: str
    machine: dict[str, str] = Field(description="processor, cores, operating system")
    packages: dict[str, str] = Field(description="versions of the packages that compute")
    revision: str | None = Field(description="git revision of the code, with '+' where the tree had changes")
    started: str = Field(description="ISO 8601, UTC")
    finished: str
