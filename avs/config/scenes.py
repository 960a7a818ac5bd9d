"""The scenes of a run, listed without reading one."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from types import MappingProxyType

from avs.config.run_config import Config
from avs.datasets.reader import Reader
from avs.system.errors import UserError

_MEASURES = "for measuring scorers"


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
        UserError: no data set is evaluated; the scenes of one cannot be listed; or a scene that two data
            sets hold is evaluated in one and trains scorers in the other, or the like, or measures scorers in both,
            where it would count twice.
    """
    if not config.evaluated and config.without_methods:
        fault = "the run has none of its methods"
        raise UserError(f"configuration: datasets.{config.without_methods[0]}", fault, "add one of them to methods")
    if not config.evaluated:
        fault = "no data set is evaluated"
        raise UserError("configuration: datasets", fault, "add one, or --config scenes_dir=DIR with your own captures")
    listed = {name: scenes_in(dataset) for name, dataset in config.datasets.items()}
    uses = _uses(config)
    seen: dict[tuple[object, ...], tuple[str, str]] = {}
    for dataset, scenes in listed.items():
        for scene, settings in scenes.items():
            for first in [seen.setdefault(identity, (dataset, scene)) for identity in settings.identities()]:
                one, other = uses[first[0]], uses[dataset]
                fault = f"is the scene {first[1]} of {first[0]}: "
                if one != other:
                    fault += f"one is {one}, the other {other}"
                elif other == _MEASURES and first[0] != dataset:
                    fault += f"both are {other}, where it would count twice and be its own other scene"
                else:
                    continue
                raise UserError(f"configuration: {scene} of {dataset}", fault, "leave it out of one of them")
    return listed


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
    uses = dict.fromkeys(config.datasets, "evaluated")
    if config.distortions is not None:
        uses |= dict.fromkeys(config.distortions.training, "for training scorers")
        uses |= dict.fromkeys(config.distortions.held_out, _MEASURES)
    return uses
