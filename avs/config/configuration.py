"""The configuration of a run, read and checked: one schema, and a scale is only numbers.

``workflows/config/<scale>.yaml`` holds the values.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, cast

from pydantic import ValidationError

from avs.config.configuration_faults import check_numbers, readable, remedy_of_unknown
from avs.config.other_representations import check_representations
from avs.config.run_config import Config, DataSet, ScorerName
from avs.config.slam_config import check_slam
from avs.datasets.captures import Captures
from avs.iqa.cross_reference.scorer_settings import ScorerSettings
from avs.nvs.protocol import ProtocolSettings, check_own_settings, protocol_of_method
from avs.report.figure_settings import ROLES
from avs.representations.kinds import AnyRepresentationSettings
from avs.selection import registry
from avs.system.errors import UserError
from avs.system.models import StrictModel, laid_over


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
    _check_lists_of_methods(config, programs)
    _check_sensitivity(config, programs)
    check_slam(config.slam)
    check_representations(config, programs)
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
    others = () if config.agnostic is None else config.agnostic.datasets or ()
    kept = {name: each for name, each in config.datasets.items() if name not in (*config.evaluated, *others)}
    captures = own.model_copy(update={"folder": config.scenes_dir})
    changes: dict[str, Any] = {"datasets": kept | {"captures": captures}}
    if others:  # chosen small, which captures are not: on them, the table is made when it is asked for
        assert config.agnostic is not None
        changes["agnostic"] = config.agnostic.model_copy(update={"datasets": None, "with_tables": False})
    return config.model_copy(update=changes)


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


def _check_lists_of_methods(config: Config, programs: Collection[str]) -> None:
    """Raise a UserError if a data set or a figure names what is no method; one that the run leaves out is left out."""
    known = {*registry.methods(), *programs}
    for name, dataset in config.datasets.items():
        _check_known(dataset.methods or (), known, f"datasets.{name}.methods")
    _check_known(config.report.figures.methods, {*known, *ROLES}, "report.figures.methods")


def _check_known(methods: Collection[str], known: Collection[str], key: str) -> None:
    for method in methods:
        if method not in known:
            raise UserError(f"configuration: {key}", f"{method} is no method", remedy_of_unknown(method, known))


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
