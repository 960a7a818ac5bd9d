"""The episode record: two files, typed, schema-versioned.

``episode.json`` is deterministic: the same code, settings, scene and seed give the same bytes. ``episode.meta.json``
holds what differs from run to run. Tables are computed from these files and nothing else.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from avs.system.models import StrictModel


class ImageMetrics(StrictModel):
    """Metrics of one test image against its photograph."""

    name: str = Field(description="image file name")
    psnr: float = Field(description="decibels, over all pixels and channels")
    psnr_per_channel: float = Field(
        description="decibels, mean of the three channels' PSNR, as FisherRF's loop prints it"
    )
    ssim: float = Field(description="structural similarity, 11x11 Gaussian window, sigma 1.5, zero padding")
    lpips: float | None = Field(description="LPIPS, or null where its weights are absent (see Episode.absent)")


class CurvePoint(StrictModel):
    """The test metrics at one moment: before a selection, or at the end."""

    iteration: int = Field(description="optimisation steps done so far")
    views: int = Field(description="number of captured views")
    primitives: int = Field(description="number of Gaussians")
    images: list[ImageMetrics] = Field(description="one entry per test image, by name")


class Step(StrictModel):
    """One selection."""

    step: int = Field(description="from 0")
    iteration: int = Field(description="optimisation steps done before the selection")
    primitives: int = Field(description="number of Gaussians")
    candidates: list[str] = Field(description="image names of the candidates, in pool order")
    scores: list[float | None] | None = Field(
        description="one score per candidate, null for those that a method of samples left out; null in a replay"
    )
    chosen: list[str] = Field(description="image names, in order of preference, which is that of capture")
    captured: list[int] = Field(
        description="optimisation steps done when each of them was captured: those of the selection for the first, "
        "later ones for views that were chosen together with it and waited (see protocol.views_per_choice)"
    )


class KeptPictures(StrictModel):
    """What lies in ``pictures.zip`` beside the record (``avs.nvs.pictures``)."""

    sha256: str = Field(description="SHA-256 of the archive")
    test: list[str] = Field(description="test images whose final renderings it holds, in order")


class Episode(StrictModel):
    """``episode.json``: one run of one method on one scene with one seed."""

    schema_version: Literal[2] = 2
    scene: str
    dataset: str
    scene_hash: str = Field(description="content hash of the scene")
    image_size: tuple[int, int] | None = Field(
        default=None, description="width and height of the largest image in pixels; null if not known"
    )
    method: str = Field(description="identifier, such as fisherrf; 'replay' in a replay")
    label: str = Field(description="printed name, such as FisherRF")
    group: str = Field(description="row group of the table, such as 3D-based")
    chooses: Literal["lowest", "highest"] = Field(description="which scores were captured first")
    seed: int
    protocol: dict[str, Any] = Field(description="the settings of the loop")
    own: list[str] = Field(default=[], description="those of them that the method has for itself: the run's are others")
    representation: dict[str, Any] = Field(description="the settings of the reconstruction")
    selector: dict[str, Any] = Field(description="the settings of the method")
    weights_hash: str | None = Field(description="SHA-256 of the scorer's weights, or null")
    weights_file: str | None = Field(
        default=None, description="their file name: weights.safetensors if the run trained them, else a published one's"
    )
    initial: list[str] = Field(description="the views before the first selection")
    selected: list[str] = Field(description="the views selected, in order")
    budget: int = Field(description="views at the end")
    notes: list[str] = Field(description="deviations that the table repeats, such as a capped budget")
    absent: dict[str, str] = Field(description="metrics that could not be computed, with the reason")
    steps: list[Step]
    curve: list[CurvePoint] = Field(description="before each selection and at the end")
    pictures: KeptPictures | None = Field(default=None, description="the pictures that were kept, or null for none")


class StepTimes(StrictModel):
    """Measured at one selection."""

    render_seconds: float
    score_seconds: float = Field(description="selection time without rendering")
    total_seconds: float
    fit_seconds: float = Field(description="optimisation before the selection")
    peak_memory_bytes: int = Field(
        description="peak resident memory of the process so far; on CUDA the allocator's peak"
    )


class EpisodeMeta(StrictModel):
    """``episode.meta.json``: what differs from run to run."""

    schema_version: Literal[1] = 1
    steps: list[StepTimes]
    total_seconds: float
    peak_memory_bytes: int
    device: str
    machine: dict[str, str] = Field(description="processor, cores, operating system")
    packages: dict[str, str] = Field(description="versions of the packages that compute")
    revision: str | None = Field(description="git revision of the code, with '+' where the tree had changes")
    started: str = Field(description="ISO 8601, UTC")
    finished: str
