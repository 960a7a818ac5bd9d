"""Settings of the table `agnostic`: the same methods on several representations of the same scenes."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from avs.system.models import Different, Seed, StrictModel

RepresentationName = Annotated[str, Field(pattern=r"^[a-z0-9_]+$")]


class AgnosticSettings(StrictModel):
    """Which methods run on which representations of which scenes."""

    representations: dict[RepresentationName, dict[str, Any]] = Field(
        min_length=2,
        description="settings of each representation by its name, in order of columns: laid over those of the run's "
        "reconstruction where kind is the same, else over the defaults of kind",
    )
    methods: Annotated[tuple[str, ...], Different] = Field(
        min_length=1, description="methods in the order of rows; those that the run leaves out are left out here, too"
    )
    datasets: Annotated[tuple[str, ...], Different] | None = Field(
        default=None,
        min_length=1,
        description="names of data sets, which get a table each: one that lists no methods (methods: []) has no other "
        "tables; null for all evaluated ones",
    )
    seeds: Annotated[tuple[Seed, ...], Different] | None = Field(
        default=None, min_length=1, description="seeds of the episodes; null for those of the run"
    )
    protocol: dict[str, Any] = Field(
        default_factory=dict, description="partial settings of the loop of these episodes, laid over the run's"
    )
    with_tables: bool = Field(
        default=True, description="whether the target tables makes it too; otherwise the target agnostic alone does"
    )
