"""The configuration of a run on another representation, as the table `agnostic` compares them."""

from __future__ import annotations

from collections.abc import Collection

from pydantic import ValidationError

from avs.config.configuration_faults import readable
from avs.config.run_config import Config
from avs.config.sensitivity_settings import laid_over
from avs.nvs.protocol import ProtocolSettings
from avs.representations.kinds import AnyRepresentationSettings
from avs.scene.images import BLACK
from avs.selection import registry
from avs.system.errors import UserError
from avs.system.models import StrictModel


class _Changed(StrictModel):
    """The sections that differ."""

    protocol: ProtocolSettings
    representation: AnyRepresentationSettings


def on_representation(config: Config, name: str) -> Config:
    """Return the configuration of a run on a representation of ``config.agnostic``.

    Raises:
        LookupError: there is no such representation.
        UserError: a key is unknown, a value does not fit, or it has another background than the scenes have.
    """
    told = config.agnostic
    values = {} if told is None else told.representations[name]
    own = config.representation.model_dump()
    same = values.get("kind", own["kind"]) == own["kind"]
    background = {"background": own["background"]} if "background" in own else {}
    protocol = laid_over(config.protocol.model_dump(), {} if told is None else told.protocol)
    try:
        changed = _Changed.model_validate(
            {"protocol": protocol, "representation": laid_over(own if same else background, values)}
        )
    except ValidationError as error:
        place = error.errors()[0]["loc"][0]
        parents = ("agnostic",) if place == "protocol" else ("agnostic", "representations", name)
        raise readable(error, Config, *parents) from None
    if getattr(changed.representation, "background", BLACK) != getattr(config.representation, "background", BLACK):
        subject = f"configuration: agnostic.representations.{name}.background"
        raise UserError(subject, "cannot differ from the run's, for which the scenes are prepared", "remove it")
    return config.model_copy(update=dict(changed))


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


def kinds_compared(config: Config) -> tuple[str, ...]:
    """Return the kinds of its representations."""
    names = () if config.agnostic is None else tuple(config.agnostic.representations)
    return tuple(on_representation(config, name).representation.kind for name in names)


def check_agnostic(config: Config, programs: Collection[str]) -> None:
    """Refuse a method, data set or representation of the table `agnostic` that does not fit.

    Raises:
        UserError: one of them is unknown, chooses nothing by itself, is for scorers, or has settings that do not fit.
    """
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
        on_representation(config, name)
