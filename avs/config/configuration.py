"""The configuration of a run: one schema, and a scale is only numbers.

``workflows/config/<scale>.yaml`` holds the values; ``workflows/schemas/config.json`` is generated from these models.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Collection
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, cast

from pydantic import Field, ValidationError, field_validator, model_validator

from avs.config.configuration_faults import check_numbers, readable
from avs.config.distortion_config import DistortionConfig
from avs.config.sensitivity_settings import SensitivitySettings, laid_over
from avs.config.slam_config import SlamConfig, check_slam
from avs.coverage.coverage_settings import CoverageSettings
from avs.datasets.captures import Captures
from avs.datasets.reader import Reader
from avs.datasets.reader_registry import readers
from avs.iqa.cross_reference.scorer_settings import BACKBONE_OF, ScorerSettings
from avs.nvs.common_states_settings import CommonStatesSettings
from avs.nvs.protocol import ProtocolSettings, check_own_settings, protocol_of_method
from avs.nvs.timing_settings import RuntimeSettings
from avs.report.published import PRINTED_NAMES
from avs.report.report_settings import ReportSettings
from avs.representations import kinds
from avs.representations.kinds import AnyRepresentationSettings
from avs.selection import registry
from avs.system.errors import UserError
from avs.system.models import Different, Seed, StrictModel

ScorerName = Literal["repvit", "dinov2"]
DataSetName = Annotated[str, Field(pattern=r"^[a-z0-9_]+$")]

# The settings of a data set: those of any reader, told apart by ``source``.
if TYPE_CHECKING:
    DataSet = Reader
else:
    DataSet = Annotated[functools.reduce(operator.or_, readers().values()), Field(discriminator="source")]


class Config(StrictModel):
    """All settings of a run."""

    scale: str = Field(pattern=r"^[a-z0-9_]+$", description="name of the results folder, such as ci, small or paper")
    device: Literal["cpu", "cuda"] = Field(default="cpu", description="where reconstructions and networks run")
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
    report: ReportSettings = Field(default_factory=ReportSettings, description="how results are tabulated")

    @model_validator(mode="after")
    def _scorers_have_data_of_their_own(self) -> Self:
        if self.distortions is None and self.scorers:
            raise ValueError("scorers need the section distortions, the data to train them on")
        return self

    @model_validator(mode="after")
    def _data_sets_are_known(self) -> Self:
        for name in self.distortions.datasets if self.distortions is not None else ():
            if name not in self.datasets:
                raise ValueError(f"distortions names the data set {name}, which is none of {', '.join(self.datasets)}")
        for name, dataset in self.datasets.items():
            if dataset.published is not None and dataset.published not in PRINTED_NAMES:
                raise ValueError(f"datasets.{name}.published must be one of {', '.join(PRINTED_NAMES)}")
        return self

    @property
    def evaluated(self) -> tuple[str, ...]:
        """The names of the evaluated data sets, in order."""
        others = () if self.distortions is None else self.distortions.datasets
        return tuple(name for name in self.datasets if name not in others)


def load(values: dict[str, Any], programs: Collection[str] = ()) -> Config:
    """Check configuration values, as Snakemake reads them, and return them typed.

    Args:
        values: the configuration.
        programs: identifiers of methods that are rules of the workflow; their settings are theirs to check.

    Raises:
        UserError: a key is unknown (the line names the nearest one), a value does not fit, a method is unknown or lacks
            the scorer it needs, or a program's name is no identifier.
    """
    try:
        config = Config.model_validate(values)
    except ValidationError as error:
        raise readable(error, Config) from None
    check_numbers(values, config)
    _check_reference(config)
    for identifier in programs:
        registry.check_identifier(identifier, "workflows/baselines")
        if identifier in registry.methods():
            fault = f"is a method of {registry.find(identifier).module} and a program as well"
            raise UserError(f"method {identifier}", fault, f"rename workflows/baselines/{identifier}.smk")
    episodes = dict.fromkeys((*config.methods, *_followed(config, programs)))
    for identifier in dict.fromkeys((*episodes, *config.method_protocols)):
        protocol_of(config, identifier)
    for identifier in dict.fromkeys((*episodes, *config.selectors, *config.method_protocols)):
        if identifier in programs:
            continue
        scorer = registry.find(identifier).method.scorer
        if identifier in episodes and scorer is not None and scorer not in config.scorers:
            fault = f"needs the scorer {scorer}, which the configuration does not train"
            raise UserError(f"method {identifier}", fault, f"add scorers.{scorer}, or leave the method out")
        registry.create_settings(identifier, config.selectors.get(identifier, {}))
    _check_sensitivity(config, programs)
    check_slam(config.slam, config.scorers)
    return _with_captures(config)


def _with_captures(config: Config) -> Config:
    """Return ``config`` with the captures of ``scenes_dir`` in place of the evaluated data sets, where it is given.

    Without it, captures without a folder only say how they would be prepared, and give way to other data sets.
    """
    if config.scenes_dir is None:
        waiting = {name for name in config.evaluated if _waits_for_a_folder(config.datasets[name])}
        if waiting == set(config.evaluated):
            return config
        named = {name: dataset for name, dataset in config.datasets.items() if name not in waiting}
        return config.model_copy(update={"datasets": named})
    own = config.datasets.get("captures", Captures())
    if not isinstance(own, Captures) or (config.distortions and "captures" in config.distortions.datasets):
        fault = "is the name of what scenes_dir gives, and of another data set"
        raise UserError("configuration: datasets.captures", fault, "rename the data set")
    kept = {name: dataset for name, dataset in config.datasets.items() if name not in config.evaluated}
    captures = own.model_copy(update={"folder": config.scenes_dir})
    return config.model_copy(update={"datasets": kept | {"captures": captures}})


def _waits_for_a_folder(dataset: DataSet) -> bool:
    return isinstance(dataset, Captures) and dataset.folder is None


def protocol_of(config: Config, method: str) -> ProtocolSettings:
    """Return the settings of the loop for one method: the common ones, and its own where it has them.

    Raises:
        UserError: a key is unknown, or a value does not fit.
    """
    registered = registry.methods().get(method)  # programs are not registered
    batches = None if registered is None else registered.method.batches
    own = config.method_protocols.get(method, {})
    try:
        protocol = protocol_of_method(config.protocol, batches, own)
        check_own_settings(method, own, config.protocol)
        return protocol
    except ValidationError as error:
        raise readable(error, Config, "method_protocols", method) from None


def variant_of(config: Config, variant: str) -> Config:
    """Return the configuration of a run under a variant of ``config.sensitivity``: its settings, laid over the run's.

    Raises:
        LookupError: there is no such variant.
        UserError: a key is unknown, a value does not fit, or what the scenes are prepared for would change.
    """
    changes = ({} if config.sensitivity is None else config.sensitivity.variants)[variant]
    parents = ("sensitivity", "variants", variant)
    values = {
        "protocol": laid_over(config.protocol.model_dump(), changes.protocol),
        "representation": laid_over(config.representation.model_dump(), changes.representation),
    }
    try:
        changed = _Varied.model_validate(values)
    except ValidationError as error:
        raise readable(error, Config, *parents) from None
    for name in ("kind", "background"):
        if getattr(changed.representation, name, None) != getattr(config.representation, name, None):
            subject = f"configuration: {'.'.join(parents)}.representation.{name}"
            raise UserError(subject, "cannot differ from the run's, for which the scenes are prepared", "remove it")
    return config.model_copy(update=dict(changed))


class _Varied(StrictModel):
    """The sections that a variant changes."""

    protocol: ProtocolSettings
    representation: AnyRepresentationSettings


def _check_sensitivity(config: Config, programs: Collection[str]) -> None:
    """Raise a UserError if a variant of the settings, or a method that is to run under them, does not fit."""
    if config.sensitivity is None:
        return
    subject = "configuration: sensitivity.methods"
    for method in config.sensitivity.methods:
        if method in programs or registry.find(method).method.follows is not None:
            raise UserError(subject, f"{method} chooses no views in its episodes", "leave it out")
    for variant in config.sensitivity.variants:
        changed = variant_of(config, variant)
        for method in config.sensitivity.methods:
            protocol_of(changed, method)


def _followed(config: Config, programs: Collection[str]) -> list[str]:
    """Return the methods whose episodes those of the run's methods follow.

    Raises:
        UserError: one of them is no method, or follows another itself.
    """
    found = []
    for identifier in config.methods:
        method = registry.methods().get(identifier)
        if method is None or method.method.follows is None:
            continue
        other = method.method.follows
        known = registry.methods().get(other)
        if other not in programs and (known is None or known.method.follows is not None):
            fault = f"follows {other}, which is no method that chooses views"
            raise UserError(f"method {identifier} of {method.module}", fault, "name another method to follow")
        found.append(other)
    return found


def _check_reference(config: Config) -> None:
    """Raise a UserError if the tables are to compare with what is no method of the run; the default need not be one."""
    named = config.report.reference if "reference" in config.report.model_fields_set else None
    if named is not None and named not in config.methods:
        fault = f"{named} is not among the methods"
        raise UserError("configuration: report.reference", fault, "name one of them, or null for none")


def scorer_of(config: Config, name: str) -> ScorerSettings:
    """Return the settings of the scorer called ``name``, which the configuration trains."""
    return config.scorers[cast(ScorerName, name)]
