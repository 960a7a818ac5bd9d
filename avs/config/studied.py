"""The methods and scenes of the sensitivity table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avs.config.run_config import Config
from avs.system.errors import UserError


def studied_methods(config: Config, dataset: str) -> tuple[str, ...]:
    """Return the methods that run on a data set under variants of the settings, in order; none without variants."""
    told = config.sensitivity
    return () if told is None else tuple(method for method in told.methods if method in config.methods_on(dataset))


def studied_scenes(config: Config, scenes: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return by data set the scenes on which methods run under variants of the settings.

    Args:
        config: of the run.
        scenes: the evaluated scenes of each data set.

    Raises:
        UserError: a scene is named that is not evaluated.
    """
    settings = config.sensitivity
    if settings is None:
        return {}
    known = {scene for names in scenes.values() for scene in names}
    unknown = [scene for scene in settings.scenes or () if scene not in known]
    if unknown:
        fault = f"{unknown[0]} is not evaluated"
        raise UserError("configuration: sensitivity.scenes", fault, f"name some of {', '.join(sorted(known))}")
    wanted = known if settings.scenes is None else set(settings.scenes)
    able = [dataset for dataset in config.with_table("sensitivity") if studied_methods(config, dataset)]
    found = {dataset: [scene for scene in scenes[dataset] if scene in wanted] for dataset in able}
    return {dataset: names for dataset, names in found.items() if names}
