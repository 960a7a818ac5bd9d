"""The settings of the loop: how many views, when they are added, what happens to the reconstruction then."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, Self

from pydantic import Field, PositiveInt, model_validator

from avs.selection.contract import Batches
from avs.system.errors import UserError
from avs.system.models import StrictModel


class LpipsSettings(StrictModel):
    """Which LPIPS is computed; the paper does not say."""

    net: Literal["vgg", "alex"] = Field(default="vgg", description="backbone; 3DGS and FisherRF use vgg")
    range: Literal["zero_one", "minus_one"] = Field(
        default="zero_one",
        description="range of the images that the network is fed: 0..1 as 3DGS does, or -1..1 as its weights expect",
    )


class ProtocolSettings(StrictModel):
    """Algorithm 1 of the paper, with its ambiguous points as fields."""

    initial_views: PositiveInt = Field(default=4, description="views before the first selection")
    initial_start: int = Field(
        default=0, ge=0, description="pool index from which farthest-view sampling of the initial views starts"
    )
    budget: PositiveInt = Field(default=20, description="views at the end")
    pool_share: float = Field(
        default=0.5,
        gt=0,
        le=1,
        description="largest part of the pool that the budget takes; with all of it, methods end with the same views",
    )
    views_per_step: PositiveInt = Field(default=1, description="views captured at each of the additions")
    views_per_choice: PositiveInt = Field(
        default=1,
        description="views chosen together, where more than views_per_step: they are captured at this and the "
        "following additions, in the order of the choice, and the next choice comes when all of them are",
    )
    additions: tuple[PositiveInt, ...] = Field(
        default=(400, 900, 1500, 2200, 3000, 3900, 4900, 6000, 7200, 8500, 9900, 11400, 13000, 14700, 16500, 18400),
        description="iterations at which views are captured, ascending",
    )
    iterations: PositiveInt = Field(default=30000, description="optimisation steps in all")
    refit: Literal["continue", "reinit"] = Field(
        default="continue",
        description="after a selection: continue the reconstruction (paper) or start from scratch (FisherRF's code)",
    )
    lpips: LpipsSettings = Field(default_factory=LpipsSettings, description="the LPIPS metric")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if any(later <= earlier for earlier, later in zip(self.additions, self.additions[1:], strict=False)):
            raise ValueError("additions must ascend")
        if self.additions and self.additions[-1] >= self.iterations:
            raise ValueError("additions must lie before the last iteration")
        if self.views_together % self.views_per_step:
            fault = f"views_per_choice {self.views_per_choice} is no multiple of views_per_step {self.views_per_step}"
            raise ValueError(f"{fault}: a choice would be captured at a part of an addition")
        if self.initial_views >= self.budget:
            raise ValueError(f"initial_views {self.initial_views} leave nothing to select of a budget of {self.budget}")
        if self.initial_views + len(self.additions) * self.views_per_step < self.budget:
            raise ValueError(f"{len(self.additions)} additions cannot fill a budget of {self.budget} views")
        return self

    @property
    def views_together(self) -> int:
        """Number of views that are chosen together."""
        return max(self.views_per_choice, self.views_per_step)


OWN_SETTINGS = ("additions", "views_per_step", "views_per_choice", "refit")
"""Settings of the loop that a method may have for itself: they belong to it, as the batches of FisherRF4 do."""

SCHEDULE = ("additions", "views_per_step", "refit")
"""Those of them that change the result by themselves, whichever views are chosen."""


def check_own_settings(method: str, own: Mapping[str, object], common: ProtocolSettings) -> None:
    """Refuse settings of one method by which it could not be compared with the others.

    Raises:
        UserError: the budget, the number of iterations or the like is another one than that of all.
    """
    for key, value in own.items():
        if key not in OWN_SETTINGS and value != getattr(common, key, value):
            fault = f"{key} of one method alone makes its episodes incomparable with the others"
            raise UserError(f"configuration: method_protocols.{method}", fault, f"set protocol.{key} for all of them")


def protocol_of_method(common: ProtocolSettings, batches: Batches | None, own: Mapping[str, Any]) -> ProtocolSettings:
    """Return the settings of the loop for one method.

    Args:
        common: those of all methods.
        batches: what the method changes by its definition, scaled to the number of iterations; or None.
        own: what the configuration changes for this method alone, which has the last word.

    Raises:
        ValidationError: a key is unknown, or a value does not fit.
    """
    values = common.model_dump() | dict(own)
    if batches is not None and batches.additions is None:
        values |= {"views_per_choice": batches.views}
    elif batches is not None and isinstance(values["iterations"], int):
        values |= {"views_per_step": batches.views, "additions": batches.scaled(values["iterations"])}
    return ProtocolSettings.model_validate(values | dict(own))
