"""Which records a table, a figure or the page holds, and why some methods have none."""

from __future__ import annotations

from typing import Any

from avs.config.method_weights import absent_methods, choosing_elsewhere
from avs.config.run_config import Config
from avs.config.scenes import scenes_in


def records_of(config: Config, *datasets: str) -> dict[str, Any]:
    """Return which records a table or figure holds: those of these data sets, or of all that are evaluated."""
    names = datasets or config.evaluated
    shown = {method for name in names for method in config.methods_on(name)}
    methods = config.methods_on(*names) if len(names) == 1 else [each for each in config.methods if each in shown]
    scenes = {name: tuple(scenes_in(config.datasets[name])) for name in names}
    return {"methods": methods, "scenes": scenes, "seeds": config.seeds}


def rows_of(config: Config, dataset: str, *, that_choose: bool = False) -> dict[str, Any]:
    """Return the records of a data set, and why some of its methods have no number.

    Args:
        config: of the run.
        dataset: name of the data set.
        that_choose: whether methods that choose nothing have none, either.
    """
    records = records_of(config, dataset)
    absent = (choosing_elsewhere(config) if that_choose else {}) | absent_methods(config)
    return records | {"absent": {method: why for method, why in absent.items() if method in records["methods"]}}
