"""Settings of the sensitivity table: the run's own settings varied one at a time, for some of its methods."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, field_validator

from avs.report.report_settings import BASE
from avs.system.models import Different, Seed, StrictModel

VariantName = Annotated[str, Field(pattern=r"^[a-z0-9_]+$")]


class Variant(StrictModel):
    """What differs from the run's own settings; all that is not named stays."""

    representation: dict[str, Any] = Field(
        default_factory=dict, description="partial settings, laid over those of the run's reconstruction"
    )
    protocol: dict[str, Any] = Field(default_factory=dict, description="partial settings, laid over those of the loop")


class SensitivitySettings(StrictModel):
    """Which methods are run again under which variants of the settings."""

    methods: Annotated[tuple[str, ...], Different] = Field(
        min_length=1, description="methods in the order of rows; those that the run leaves out are left out here, too"
    )
    variants: dict[VariantName, Variant] = Field(min_length=1, description="the variants by name, in order of columns")
    seeds: Annotated[tuple[Seed, ...], Different] | None = Field(
        default=None, min_length=1, description="seeds of the episodes; null for those of the run"
    )
    scenes: Annotated[tuple[str, ...], Different] | None = Field(
        default=None, min_length=1, description="names of evaluated scenes; null for all of them"
    )
    with_tables: bool = Field(
        default=False, description="whether the target tables makes it too; otherwise the target sensitivity alone does"
    )

    @field_validator("variants")
    @classmethod
    def _base_is_the_run(cls, variants: dict[str, Variant]) -> dict[str, Variant]:
        if BASE in variants:
            raise ValueError(f"no variant can be called {BASE}, which is the run itself")
        return variants
