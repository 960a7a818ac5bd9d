"""The methods and scenes of the sensitivity table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avs.config.configuration import Config
from avs.config.sensitivity_settings import SensitivitySettings
from avs.system.errors import UserError


def studied_methods(config: Config) -> tuple[str, ...]:
    """Return the methods that run under variants of the settings, in order; none without such variants."""
    told = config.sensitivity
    return () if told is None else tuple(method for method in told.methods if method in config.methods)


def studied_scenes(settings: SensitivitySettings | None, scenes: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return by data set the scenes on which methods run under variants of the settings.

    Args:
        settings: the section of the configuration, or None if it has none.
        scenes: the evaluated scenes of each data set.

    Raises:
        UserError: a scene is named that is not evaluated.
    """
    if settings is None:
        return {}
    known = {scene for names in scenes.values() for scene in names}
    unknown = [scene for scene in settings.scenes or () if scene not in known]
    if unknown:
        fault = f"{unknown[0]} is not evaluated"
        raise UserError("configuration: sensitivity.scenes", fault, f"name some of {', '.join(sorted(known))}")
    wanted = known if settings.scenes is None else set(settings.scenes)
    found = {dataset: [scene for scene in names if scene in wanted] for dataset, names in scenes.items()}
    return {dataset: names for dataset, names in found.items() if names}
