"""Settings of Nerfacto; the defaults are those of nerfstudio's code (Tancik et al. 2023, arXiv 2302.04264)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from avs.representations.base import RepresentationSettings
from avs.system.models import Color, StrictModel


class HashGrid(StrictModel):
    """Grids of features from coarse to fine; those with more corners than entries share them by a hash."""

    levels: int = Field(default=16, ge=1, description="number of grids")
    coarsest: int = Field(default=16, ge=1, description="cells a side of the contracted cube on the first")
    finest: int = Field(default=2048, ge=1, description="cells a side on the last; in between, equal factors")
    log2_entries: int = Field(default=19, ge=4, le=24, description="logarithm of the number of entries of each")


class Proposal(StrictModel):
    """A small density field that says where the next samples of a ray are worth taking."""

    samples: int = Field(ge=2, description="samples that it is asked for on each ray")
    grid: HashGrid = Field(description="what it is made of")


class NerfactoSettings(RepresentationSettings):
    """Nerfacto. The defaults are nerfstudio's; a scale of the benchmark replaces numbers."""

    kind: Literal["nerfacto"] = Field(default="nerfacto", description="Nerfacto, hashed grids with proposal sampling")
    iterations: int = Field(default=30_000, ge=1, description="length of the schedule of the learning rate, in steps")
    rays: int = Field(default=4096, ge=1, description="pixels of one step")
    near: float = Field(default=0.045, gt=0, description="where rays begin, in units of the scene extent")
    far: float = Field(default=909.0, gt=0, description="where rays end, in units of the scene extent")
    background: Color = Field(default=(0.0, 0.0, 0.0), description="colour behind the field, in 0..1")
    grid: HashGrid = Field(default=HashGrid(), description="grids of the field")
    proposals: tuple[Proposal, ...] = Field(
        default=(
            Proposal(samples=256, grid=HashGrid(levels=5, finest=128, log2_entries=17)),
            Proposal(samples=96, grid=HashGrid(levels=5, finest=256, log2_entries=17)),
        ),
        min_length=1,
        description="in the order in which they are asked",
    )
    samples: int = Field(default=48, ge=2, description="samples of the field on each ray")
    hidden: int = Field(default=64, ge=1, description="width of the hidden layers of density and colour")
    proposal_hidden: int = Field(default=16, ge=1, description="width of the hidden layer of a proposal")
    appearance: int = Field(default=32, ge=0, description="numbers that each photograph has of its own")
    initial_density: float = Field(
        default=0.01, gt=0, description="factor of the density, whose unit of length is the inner box's half side"
    )
    annealing: int = Field(
        default=1000, ge=0, description="steps until the weights of proposals count fully when samples are placed"
    )
    distortion: float = Field(default=0.002, ge=0, description="weight of the distortion loss")
    interlevel: float = Field(default=1.0, ge=0, description="weight of the loss by which proposals learn")
    learning_rate: float = Field(default=1e-2, gt=0, description="Adam's rate at the start")
    final_rate: float = Field(default=0.5, gt=0, le=1, description="share of the rate that is left at the end")
