"""Which data set of a run stands where in the paper's tables."""

from __future__ import annotations

from avs.config.run_config import Config
from avs.report.published import MEMORY_METHODS, PER_SCENE_NAMES, STAND_INS, published_name
from avs.selection import registry

SIDE_BY_SIDE = ("realestate10k", "mapfree")
"""The data sets that the paper has in one table, in the order of its columns."""

FOLDER = "results/published"


def source_of(config: Config, dataset: str) -> str:
    """Return the data set of the paper whose values stand beside one of the run, or its own name."""
    return config.datasets[dataset].published or STAND_INS.get(dataset, dataset)


def published_means(config: Config, dataset: str) -> str | None:
    """Return the file of the paper's means that stand beside a data set, or None."""
    name = published_name(source_of(config, dataset))
    return None if name is None else f"{FOLDER}/{name}"


def published_scenes(config: Config, dataset: str) -> tuple[str, ...]:
    """Return the files of the paper's values of single scenes and of their means, as far as there are any."""
    scenes, means = PER_SCENE_NAMES.get(source_of(config, dataset)), published_means(config, dataset)
    return (*([] if scenes is None else [f"{FOLDER}/{scenes}"]), *([] if means is None else [means]))


def side_by_side(config: Config) -> tuple[str, ...]:
    """Return the data sets of the run for the paper's table of two data sets; none if one of them has none.

    A data set of the paper's own name comes before others that stand for it.
    """
    found = []
    for source in SIDE_BY_SIDE:
        names = [name for name in config.evaluated if source_of(config, name) == source]
        found += sorted(names, key=lambda name: name != source)[:1]
    return tuple(found) if len(found) == len(SIDE_BY_SIDE) else ()


def with_memory(config: Config, dataset: str) -> tuple[str, ...]:
    """Return the methods on a data set for the paper's table of memory, in order: its own, and its other networks."""
    proposed = {name for name, found in registry.methods().items() if found.method.proposed}
    return tuple(method for method in config.methods_on(dataset) if method in proposed.union(MEMORY_METHODS))
