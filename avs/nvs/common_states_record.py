"""The record of the states at which all methods scored the same candidates; deterministic, as an episode's is."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from avs.system.models import StrictModel


class CommonState(StrictModel):
    """One moment of the reconstruction, and what the hidden photographs say of its candidates, in their order."""

    views: int = Field(description="number of captured views")
    iteration: int = Field(description="optimisation steps done so far")
    primitives: int = Field(description="number of Gaussians")
    reconstruction: str = Field(
        description="SHA-256 of the checkpoint from which every method but those with a fit of their own got its "
        "reconstruction"
    )
    candidates: list[str] = Field(description="image names, in pool order")
    psnr: list[float] = Field(description="decibels, each candidate's rendering against its photograph")
    ssim: list[float] = Field(description="structural similarity of the same pairs")
    gains: list[list[float | None]] | None = Field(
        description="two measurements with independent random streams of the decibels by which the mean test PSNR is "
        "higher if a copy of the reconstruction is fitted with the candidate than without it; null for candidates that "
        "are not in the sample, and for all where the reconstruction cannot be copied"
    )


class ScoredMethod(StrictModel):
    """The scores of one method."""

    method: str = Field(description="identifier, such as fisherrf")
    label: str = Field(description="printed name, such as FisherRF")
    group: str = Field(description="row group of the table, such as 3D-based")
    chooses: Literal["lowest", "highest"] = Field(description="which scores are captured first")
    selector: dict[str, Any] = Field(description="the settings of the method")
    weights_hash: str | None = Field(description="SHA-256 of its weights, or null")
    own_fit: bool = Field(
        description="whether it changes how a reconstruction is optimised, so that it scored a twin, fitted its way on "
        "the same views"
    )
    notes: list[str] = Field(description="what the method tells its readers")
    scores: list[list[float | None] | None] = Field(
        description="for each state one score per candidate, null for those that a method of samples left out; null "
        "for a state without scores"
    )
    failure: str | None = Field(description="why there are no scores of a state, or null")


class CommonStates(StrictModel):
    """``common_states/<data set>/<scene>/<seed>.json``."""

    schema_version: Literal[1] = 1
    scene: str
    dataset: str
    scene_hash: str = Field(description="content hash of the scene")
    seed: int
    protocol: dict[str, Any] = Field(description="the settings of the loop")
    representation: dict[str, Any] = Field(description="the settings of the reconstruction")
    settings: dict[str, Any] = Field(description="which states, and how the gain is measured")
    captured: list[str] = Field(description="image names in the order of capture, up to the last state")
    device: str = Field(default="cpu", description="where it was computed")
    notes: list[str] = Field(description="deviations that the table repeats, such as a capped budget")
    states: list[CommonState]
    methods: list[ScoredMethod]
