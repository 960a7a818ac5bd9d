"""Further representations of a run: those that the table `agnostic` compares, and those of data for scorers."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from pydantic import ValidationError

from avs.config.configuration_faults import readable
from avs.config.run_config import Config
from avs.nvs.protocol import ProtocolSettings
from avs.representations.base import RepresentationSettings
from avs.representations.kinds import AnyRepresentationSettings, kinds
from avs.scene.images import BLACK
from avs.selection import registry
from avs.system.errors import UserError
from avs.system.models import StrictModel, laid_over


class _Changed(StrictModel):
    """The section that differs."""

    representation: AnyRepresentationSettings


def on_representation(config: Config, name: str) -> Config:
    """Return the configuration of a run on a representation of ``config.agnostic``.

    Raises:
        LookupError: there is no such representation.
        UserError: a key is unknown, a value does not fit, or it has another background than the scenes have.
    """
    told = config.agnostic
    values = {} if told is None else told.representations[name]
    changed = _laid_over(config, values, "agnostic", "representations", name)
    own = {} if told is None else told.protocol
    try:
        protocol = ProtocolSettings.model_validate(laid_over(config.protocol.model_dump(), own))
    except ValidationError as error:
        raise readable(error, Config, "agnostic", "protocol") from None
    return config.model_copy(update={"representation": changed, "protocol": protocol})


def representation_of(config: Config, dataset: str) -> RepresentationSettings:
    """Return what the scenes of a data set for scorers are reconstructed with.

    Raises:
        UserError: see ``on_representation``.
    """
    told = {} if config.distortions is None else config.distortions.representations
    if dataset not in told:
        return config.representation
    return _laid_over(config, told[dataset], "distortions", "representations", dataset)


def _laid_over(config: Config, values: Mapping[str, Any], *parents: str) -> RepresentationSettings:
    """Return settings laid over the run's where the kind is the same, else over the defaults of theirs."""
    own = config.representation.model_dump()
    background = {"background": own["background"]} if "background" in own else {}
    same = values.get("kind", own["kind"]) == own["kind"]
    try:
        changed = _Changed.model_validate({"representation": laid_over(own if same else background, values)})
    except ValidationError as error:
        raise readable(error, Config, *parents) from None
    if getattr(changed.representation, "background", BLACK) != getattr(config.representation, "background", BLACK):
        subject = f"configuration: {'.'.join(parents)}.background"
        raise UserError(subject, "cannot differ from the run's, for which the scenes are prepared", "remove it")
    return changed.representation


def agnostic_datasets(config: Config) -> tuple[str, ...]:
    """Return the data sets that get the table `agnostic`, in order; none where the run makes no such table."""
    told = config.agnostic
    if told is None or not agnostic_methods(config):
        return ()
    return config.evaluated if told.datasets is None else told.datasets


def agnostic_methods(config: Config) -> tuple[str, ...]:
    """Return the methods in the rows of that table, in order."""
    return () if config.agnostic is None else tuple(each for each in config.agnostic.methods if each in config.methods)


def agnostic_seeds(config: Config) -> tuple[int, ...]:
    """Return the seeds of its episodes."""
    return config.seeds if config.agnostic is None or config.agnostic.seeds is None else config.agnostic.seeds


def check_representations(config: Config, programs: Collection[str]) -> None:
    """Refuse a method, data set or representation of the table `agnostic`, or of data for scorers, that does not fit.

    Raises:
        UserError: one of them is unknown, chooses nothing by itself, is for scorers, or has settings that do not fit.
    """
    for name in () if config.distortions is None else config.distortions.representations:
        representation_of(config, name)
    told = config.agnostic
    if told is None:
        return
    for method in told.methods:
        if method in programs or registry.find(method).method.follows is not None:
            fault = f"{method} chooses no views in its episodes"
            raise UserError("configuration: agnostic.methods", fault, "leave it out")
    for_scorers = () if config.distortions is None else config.distortions.datasets
    for dataset in told.datasets or () if config.evaluated else ():
        if dataset not in config.datasets or dataset in for_scorers:
            known = ", ".join(name for name in config.datasets if name not in for_scorers)
            fault = f"{dataset} is no data set on which methods run"
            raise UserError("configuration: agnostic.datasets", fault, f"name some of {known}")
    for name in told.representations:
        kind = on_representation(config, name).representation.kind
        if name in kinds() and name != kind:
            subject = f"configuration: agnostic.representations.{name}"
            raise UserError(subject, f"is of the kind {kind}", f"give it `kind: {name}`, or another name")
