"""The typed configuration of a run; ``workflows/schemas/config.json`` is generated from it."""

from __future__ import annotations

import functools
import operator
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, field_validator, model_validator

from avs.config.agnostic_settings import AgnosticSettings
from avs.config.distortion_config import DistortionConfig
from avs.config.sensitivity_settings import SensitivitySettings
from avs.config.slam_config import SlamConfig
from avs.coverage.coverage_settings import CoverageSettings
from avs.datasets.reader import FurtherTable, Reader
from avs.datasets.reader_registry import readers
from avs.iqa.cross_reference.scorer_settings import BACKBONE_OF, ScorerSettings
from avs.iqa.held_out.held_out_settings import ScorerEvaluationSettings
from avs.nvs.common_states_settings import CommonStatesSettings
from avs.nvs.picture_settings import PictureSettings
from avs.nvs.protocol import ProtocolSettings
from avs.nvs.timing_settings import RuntimeSettings
from avs.report.published import PRINTED_NAMES, STAND_INS
from avs.report.report_settings import ENDINGS, ReportSettings
from avs.representations import kinds
from avs.representations.kinds import AnyRepresentationSettings
from avs.system.models import Different, Seed, StrictModel
from avs.system.numerics import Numerics

ScorerName = Literal["lite0", "repvit", "dinov2"]
DataSetName = Annotated[str, Field(pattern=r"^[a-z0-9_]+$")]

# The settings of a data set: those of any reader, told apart by ``source``.
if TYPE_CHECKING:
    DataSet = Reader
else:
    DataSet = Annotated[functools.reduce(operator.or_, readers().values()), Field(discriminator="source")]


class Config(StrictModel):
    """All settings of a run."""

    _weights_at_hand: frozenset[str] = PrivateAttr(default=frozenset())
    _programs: frozenset[str] | None = PrivateAttr(default=None)

    scale: str = Field(pattern=r"^[a-z0-9_]+$", description="name of the results folder, such as ci, small or paper")
    device: Literal["cpu", "cuda"] = Field(default="cpu", description="where reconstructions and networks run")
    numerics: Numerics = Field(
        default="portable",
        description="portable: the CPU gives the same bits for the same scene on every x86-64 machine with AVX2; "
        "native: each library chooses its code by the processor, which is faster where that has AVX-512",
    )
    seeds: Annotated[tuple[Seed, ...], Different] = Field(
        min_length=1, description="each episode runs once with each seed"
    )
    methods: Annotated[tuple[str, ...], Different] = Field(
        min_length=1, description="identifiers of the selection methods, in table order"
    )
    selectors: dict[str, dict[str, Any]] = Field(
        default_factory=dict, description="settings of the methods, by identifier"
    )
    method_protocols: dict[str, dict[str, Any]] = Field(
        default_factory=dict,
        description="settings of the loop for one method alone, by identifier; they go before what the method brings",
    )
    datasets: dict[DataSetName, DataSet] = Field(
        default_factory=dict,
        description="the data sets by name; those that distortions names are for scorers, the others get tables",
    )
    scenes_dir: str | None = Field(
        default=None,
        description="folder of captures to evaluate as the data set captures, instead of the evaluated ones; they are "
        "prepared as datasets.captures says where there is one",
    )
    protocol: ProtocolSettings = Field(default_factory=ProtocolSettings, description="the loop")
    representation: AnyRepresentationSettings = Field(
        default_factory=lambda: kinds.create_settings({}), description="the reconstruction"
    )
    distortions: DistortionConfig | None = Field(
        default=None, description="the data that scorers are trained on; null if the run trains none"
    )
    scorers: dict[ScorerName, ScorerSettings] = Field(
        default_factory=dict, description="cross-reference scorers that the run can train; it trains those it needs"
    )

    scorer_evaluation: ScorerEvaluationSettings | None = Field(
        default_factory=ScorerEvaluationSettings,
        description="the table of how well scorers predict SSIM on the held-out data sets; null to leave it out",
    )

    @field_validator("scale")
    @classmethod
    def _not_a_folder_of_the_project(cls, scale: str) -> str:
        if scale in ("published", "reference"):
            raise ValueError(f"{scale} is the name of a folder of results that belongs to the project")
        return scale

    @model_validator(mode="after")
    def _scorers_are_what_they_are_called(self) -> Self:
        for name, scorer in self.scorers.items():
            if scorer.network.backbone != BACKBONE_OF[name]:
                raise ValueError(f"scorers.{name}.network.backbone must be {BACKBONE_OF[name]}")
        return self

    pictures: PictureSettings | None = Field(
        default_factory=PictureSettings,
        description="pictures that each episode keeps beside its record, for the figures; null for none",
    )
    runtime: RuntimeSettings | None = Field(
        default_factory=RuntimeSettings, description="the table of selection times; null to leave it out"
    )
    common_states: CommonStatesSettings | None = Field(
        default_factory=CommonStatesSettings,
        description="the states at which all methods score the same candidates, for the table of rank correlations; "
        "null to leave it out",
    )
    coverage: CoverageSettings | None = Field(
        default_factory=CoverageSettings,
        description="what the views of each episode cover of the scene in structure from motion; null to leave it out",
    )
    slam: SlamConfig | None = Field(
        default=None, description="buildings that a robot explores, and what chooses its paths; null to leave it out"
    )
    sensitivity: SensitivitySettings | None = Field(
        default=None,
        description="variants of the settings under which some methods run again, for the table of how far their order "
        "depends on the settings; null for no such table",
    )
    agnostic: AgnosticSettings | None = Field(
        default=None,
        description="representations on which some methods run, for the table of whether their order is the same on "
        "all of them; null for no such table",
    )
    report: ReportSettings = Field(default_factory=ReportSettings, description="how results are tabulated")

    @model_validator(mode="after")
    def _scorers_have_data_of_their_own(self) -> Self:
        if self.distortions is None and self.scorers:
            raise ValueError("scorers need the section distortions, the data to train them on")
        return self

    @field_validator("datasets")
    @classmethod
    def _tables_have_names_of_their_own(cls, datasets: dict[str, Reader]) -> dict[str, Reader]:
        for name in datasets:
            for ending in ENDINGS:
                if name.endswith(ending):
                    told = f"ends in {ending}, as a file beside the table of {name.removesuffix(ending)} would"
                    raise ValueError(f"the name {name} {told}")
        return datasets

    @model_validator(mode="after")
    def _data_sets_are_known(self) -> Self:
        for name in self.distortions.datasets if self.distortions is not None else ():
            if name not in self.datasets:
                raise ValueError(f"distortions names the data set {name}, which is none of {', '.join(self.datasets)}")
            if self.datasets[name].methods is not None:
                raise ValueError(f"datasets.{name}.methods is of a data set for scorers, on which no method runs")
        # A file that is laid over another names the data sets for scorers anew, and keeps what that says of others.
        for name in self.distortions.representations if self.distortions is not None else ():
            if name not in self.datasets:
                told = ", ".join(self.datasets)
                raise ValueError(f"distortions.representations names the data set {name}, which is none of {told}")
        for name, dataset in self.datasets.items():
            if name in STAND_INS and (dataset.source, getattr(dataset, "pattern", None)) != ("embedded", name):
                twin = PRINTED_NAMES[STAND_INS[name]]
                raise ValueError(f"datasets.{name}: this name is kept for the embedded twin of {twin}; rename it")
            if dataset.published is not None and dataset.published not in PRINTED_NAMES:
                raise ValueError(f"datasets.{name}.published must be one of {', '.join(PRINTED_NAMES)}")
        return self

    def planned_with(self, weights_at_hand: Iterable[str], programs: Iterable[str] | None) -> Self:
        """Return this configuration of a run that had the weights of some methods, and others that were programs.

        It is looked at later, or elsewhere, where weights may be absent and methods not installed.
        """
        told = self.model_copy()
        told._weights_at_hand = frozenset(weights_at_hand)
        told._programs = None if programs is None else frozenset(programs)
        return told

    def had_weights(self, method: str) -> bool:
        """Whether a method had its weights when the run was planned; False if nothing is known of a plan."""
        return method in self._weights_at_hand

    def was_installed(self, method: str) -> bool:
        """Whether a method was no program of its own when the run was planned; False if nothing is known of a plan."""
        return self._programs is not None and method not in self._programs

    @property
    def evaluated(self) -> tuple[str, ...]:
        """The names of the data sets on which at least one method runs, in order."""
        return tuple(name for name in self._not_for_scorers if self.methods_on(name))

    @property
    def without_methods(self) -> tuple[str, ...]:
        """The names of the data sets that would be evaluated if the run had one of the methods that they list."""
        return tuple(name for name in self._not_for_scorers if not self.methods_on(name))

    def methods_on(self, dataset: str) -> tuple[str, ...]:
        """Return the methods that run on a data set, in the order of its rows: its own as far as the run has them."""
        own = self.datasets[dataset].methods
        return self.methods if own is None else tuple(method for method in own if method in self.methods)

    def with_table(self, table: FurtherTable) -> tuple[str, ...]:
        """Return the names of the evaluated data sets that get a table beside that of view synthesis, in order."""
        made = {"ranking": self.common_states, "coverage": self.coverage, "sensitivity": self.sensitivity}[table]
        wanted = {name: self.datasets[name].tables for name in self.evaluated if made is not None}
        return tuple(name for name, tables in wanted.items() if tables is None or table in tables)

    @property
    def _not_for_scorers(self) -> tuple[str, ...]:
        others = () if self.distortions is None else self.distortions.datasets
        return tuple(name for name in self.datasets if name not in others)
