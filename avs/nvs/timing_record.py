"""The record of one method's selection times: ``runtime/<scene>/<method>.json``."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from avs.system.models import StrictModel


class SelectionTimes(StrictModel):
    """One timed selection, after the work queued on the device has ended."""

    render_seconds: float = Field(description="rendering of candidates; 0 for a method that does not tell it apart")
    score_seconds: float = Field(description="all the rest")
    total_seconds: float


class Runtime(StrictModel):
    """Selection times of one method on one scene."""

    schema_version: Literal[3] = 3
    scene: str
    scene_hash: str = Field(description="content hash of the scene")
    method: str = Field(description="identifier, such as fisherrf")
    label: str = Field(description="printed name, such as FisherRF")
    group: str = Field(description="row group of the table, such as 3D-based")
    selector: dict[str, Any] = Field(description="the settings of the method")
    seed: int
    iteration: int = Field(description="optimisation steps of the reconstruction")
    primitives: int = Field(description="number of Gaussians")
    own_fit: bool = Field(description="whether the method changes the optimisation, so that it has a fit of its own")
    captured: int = Field(description="number of captured views")
    candidates: int = Field(description="number of candidates, all of which are scored unless the method samples them")
    chosen: int = Field(description="number of views that one selection chooses")
    image_sizes: list[tuple[int, int]] = Field(
        min_length=1, description="width and height of the candidates in pixels, each once, in ascending order of area"
    )
    selections: list[SelectionTimes] = Field(min_length=1)
    peak_memory_bytes: int = Field(
        description="peak resident memory of the process, libraries included; on CUDA the allocator's peak since the "
        "reconstruction was loaded"
    )
    device: str = Field(description="where the reconstruction is rendered")
    computed_on: str = Field(
        description="where the method computes; cpu beside a device cuda if it needs a capability that runs there only"
    )
    other_cores: float | None = Field(
        description="cores that other programs kept busy on the mean while selections were timed; null if not known"
    )
    machine: dict[str, str] = Field(description="processor, cores, operating system")
    threads: int = Field(description="threads that torch uses")
    packages: dict[str, str] = Field(description="versions of the packages that compute")
    revision: str | None = Field(description="git revision of the code, with '+' where the tree had changes")
    started: str = Field(description="ISO 8601, UTC")
    finished: str
