"""Settings of TensoRF; the defaults are those of Chen et al. 2022 (arXiv 2203.09517) and of its public code."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from avs.representations.base import RepresentationSettings
from avs.system.models import Color, StrictModel


class Grid(StrictModel):
    """Cells of the planes and lines along each side of the contracted cube."""

    initial: int = Field(default=128, ge=4, description="cells a side at the start")
    final: int = Field(default=300, ge=4, description="cells a side after the last refinement")
    refine_at: tuple[int, ...] = Field(
        default=(2000, 3000, 4000, 5500, 7000),
        description="steps at which there are more cells from then on; the number of voxels grows by equal factors",
    )

    @model_validator(mode="after")
    def _ascending(self) -> Self:
        if any(later <= earlier for earlier, later in zip((0, *self.refine_at), self.refine_at, strict=False)):
            raise ValueError("refine_at must ascend, from above 0")
        if self.final < self.initial:
            raise ValueError("final must not be below initial")
        return self


class EmptySpace(StrictModel):
    """Where no samples are taken, because nothing is there."""

    every: int = Field(default=2000, ge=1, description="steps between looks at what is empty; views that come undo it")
    cells: int = Field(default=128, ge=4, description="cells a side of what is looked at")
    opacity: float = Field(
        default=1e-4,
        gt=0,
        lt=1,
        description="a cell is empty that has less opacity over a side, as its neighbours have",
    )


class TensorfSettings(RepresentationSettings):
    """TensoRF with vectors and matrices. The defaults are the paper's; a scale of the benchmark replaces numbers."""

    kind: Literal["tensorf"] = Field(default="tensorf", description="TensoRF, vector-matrix decomposition")
    iterations: int = Field(default=30_000, ge=1, description="length of the schedule of the learning rates, in steps")
    rays: int = Field(default=4096, ge=1, description="pixels of one step")
    samples: int = Field(default=512, ge=2, description="places on each ray at which empty space is not passed over")
    near: float = Field(default=0.02, gt=0, description="where rays begin, in units of the scene extent")
    background: Color = Field(default=(0.0, 0.0, 0.0), description="colour behind the field, in 0..1")
    density_components: int = Field(default=16, ge=1, description="components of the density, for each of three axes")
    appearance_components: int = Field(
        default=48, ge=1, description="components of the appearance, for each of three axes"
    )
    density_shift: float = Field(default=-10.0, description="added to the density before the softplus")
    density_scale: float = Field(
        default=25.0, gt=0, description="factor of the density, whose unit of length is the inner box's half side"
    )
    decoder: Literal["mlp", "sh"] = Field(
        default="mlp", description="from appearance to colour: a network, or spherical harmonics of degree 2"
    )
    hidden: int = Field(default=128, ge=1, description="width of the network's two hidden layers")
    frequencies: int = Field(
        default=2,
        ge=0,
        description="frequencies of the waves that the network reads of appearance and direction",
    )
    grid: Grid = Field(default=Grid(), description="coarse to fine")
    empty_space: EmptySpace = Field(default=EmptySpace(), description="where no samples are taken")
    least_weight: float = Field(
        default=1e-4, ge=0, lt=1, description="samples of less weight have no colour; rays end at this transmittance"
    )
    grid_rate: float = Field(default=0.02, gt=0, description="Adam's rate of planes and lines at the start")
    network_rate: float = Field(default=1e-3, gt=0, description="Adam's rate of the basis and the network at the start")
    final_rate: float = Field(default=0.1, gt=0, le=1, description="share of the rates that is left at the end")
    sparsity: float = Field(default=8e-5, ge=0, description="weight of the mean size of the density's numbers")
    smoothness_density: float = Field(default=0.0, ge=0, description="weight of the total variation of density planes")
    smoothness_appearance: float = Field(
        default=0.0, ge=0, description="weight of the total variation of appearance planes"
    )

    @model_validator(mode="after")
    def _final_grid_is_reached(self) -> Self:
        if self.grid.refine_at and self.grid.refine_at[-1] >= self.iterations:
            fault = f"grid.refine_at ends at step {self.grid.refine_at[-1]}, iterations at {self.iterations}"
            raise ValueError(f"{fault}, so that grid.final is never reached; refine earlier")
        return self
