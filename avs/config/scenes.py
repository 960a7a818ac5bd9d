"""The scenes of a run, listed without reading one."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from avs.config.run_config import Config
from avs.datasets.reader import Reader
from avs.datasets.shared_photographs import shared_photographs
from avs.system.errors import UserError
from avs.system.lists_of_names import some_of

_EVALUATED, _MEASURES = "evaluated", "for measuring scorers"


@functools.cache
def scenes_in(dataset: Reader) -> Mapping[str, Reader]:
    """Return the scenes of a data set by name, each with its settings, in order.

    A process looks once, so that all of a run is about the same scenes; among hundreds of captures a look takes a
    second.

    Raises:
        UserError: they cannot be listed.
    """
    return MappingProxyType(dataset.scenes())


def scenes_of(config: Config) -> dict[str, Mapping[str, Reader]]:
    """Return the scenes of every data set, by its name and theirs, each with its settings, in order.

    Raises:
        UserError: no data set is evaluated; the scenes of one cannot be listed; or a scene that two data sets hold, or
            a photograph of two scenes, is evaluated in one and trains scorers in the other, or the like, or measures
            scorers in both, where it would count twice.
    """
    if not config.evaluated and config.without_methods:
        fault = "the run has none of its methods"
        raise UserError(f"configuration: datasets.{config.without_methods[0]}", fault, "add one of them to methods")
    if not config.evaluated:
        fault = "no data set is evaluated"
        raise UserError("configuration: datasets", fault, "add one, or --config scenes_dir=DIR with your own captures")
    listed = {name: scenes_in(dataset) for name, dataset in config.datasets.items()}
    placed = [_Placed(name, scene, each) for name, scenes in listed.items() for scene, each in scenes.items()]
    uses = _uses(config)
    clash = _clashing(uses)
    seen: dict[tuple[object, ...], _Placed] = {}
    for place in placed:
        for identity in place.settings.identities():
            first = seen.setdefault(identity, place)
            if why := clash(first, place):
                told = "is a part of the same video as" if identity[0] == "video" else "is"
                raise _shared(place, f"{told} the scene {first.scene} of {first.dataset}", why)
    if not any(uses[place.dataset] != _EVALUATED and place.settings.photographs() for place in placed):
        return listed  # those of evaluated scenes alone cannot clash, and to look at all of them takes a while
    for first, place, photographs in shared_photographs(placed, lambda place: place.settings.photographs(), clash):
        told = f"shares {some_of(photographs)} with the scene {first.scene} of {first.dataset}"
        raise _shared(place, told, clash(first, place) or "")
    return listed


@dataclass(frozen=True)
class _Placed:
    """A scene of a data set."""

    dataset: str
    scene: str
    settings: Reader


def _clashing(uses: Mapping[str, str]) -> Callable[[_Placed, _Placed], str | None]:
    """Return what says why two scenes may not show the same, or None, given what each data set is for."""

    def why(first: _Placed, second: _Placed) -> str | None:
        one, other = uses[first.dataset], uses[second.dataset]
        if one != other:
            return f"one is {one}, the other {other}"
        if other == _MEASURES and first.dataset != second.dataset:
            return f"both are {other}, where it would count twice and be its own other scene"
        return None

    return why


def _shared(place: _Placed, fault: str, why: str) -> UserError:
    return UserError(
        f"configuration: {place.scene} of {place.dataset}", f"{fault}: {why}", "leave it out of one of them"
    )


def timed_scene(config: Config) -> tuple[str, str]:
    """Return the data set and the scene on which selections are timed.

    Raises:
        UserError: the scene that is named is not evaluated.
    """
    return scene_named(config, None if config.runtime is None else config.runtime.scene, "runtime.scene")


def scene_named(config: Config, wanted: str | None, key: str) -> tuple[str, str]:
    """Return the data set and the name of an evaluated scene.

    Args:
        config: of the run.
        wanted: the scene, by its name or as dataset/scene; None for the first of the first data set.
        key: where the configuration names it.

    Raises:
        UserError: there is no such scene.
    """
    pairs = [(dataset, scene) for dataset in config.evaluated for scene in scenes_in(config.datasets[dataset])]
    for pair in pairs:
        if wanted in (None, pair[1], "/".join(pair)):
            return pair
    raise UserError(f"configuration: {key}", f"{wanted} is no scene of this run", "name one of them")


def _uses(config: Config) -> dict[str, str]:
    """Return what each data set is for."""
    uses = dict.fromkeys(config.datasets, _EVALUATED)
    if config.distortions is not None:
        uses |= dict.fromkeys(config.distortions.training, "for training scorers")
        uses |= dict.fromkeys(config.distortions.held_out, _MEASURES)
    return uses
