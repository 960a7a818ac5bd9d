"""Which methods of a run score the renderings of held-out scenes, and what the jobs that let them do so are told."""

from __future__ import annotations

from avs.config.method_weights import absent_methods, is_program
from avs.config.report_jobs import ScorerTableJob
from avs.config.run_config import Config
from avs.config.scenes import scenes_in
from avs.iqa.cross_reference.scorer_settings import BACKBONE_OF
from avs.iqa.held_out.held_out_settings import (
    STATISTICS,
    HeldOutJob,
    ScoredMetric,
    ScoredNetwork,
    ScorerEvaluationSettings,
)
from avs.iqa.render_statistics.regression_settings import RegressionSettings
from avs.report.labels import told_apart
from avs.selection import registry

_EMBEDDED = "embedded"  # the source of scenes whose textures do not depend on their seed


def held_out_scenes(config: Config) -> dict[str, tuple[str, ...]]:
    """Return the held-out scenes on which scorers are measured, by data set; none where there is nothing to measure.

    A run that neither trains nor uses a scorer of its own makes no distortion data for the sake of a table.
    """
    if config.distortions is None or config.scorer_evaluation is None:
        return {}
    absent = absent_methods(config)
    learned = [name for name in _rows(config) if not registry.find(name).method.assesses_images and name not in absent]
    return {name: tuple(scenes_in(config.datasets[name])) for name in config.distortions.held_out if learned}


def other_scene(config: Config, dataset: str, scene: str) -> tuple[str, str]:
    """Return data set and name of the scene whose photographs stand in for those of a wrong scene.

    It is the next held-out one, or the first that trains where there is but one.
    """
    assert config.distortions is not None
    held_out = [(name, each) for name, scenes in held_out_scenes(config).items() for each in scenes]
    if len(held_out) > 1:
        return held_out[(held_out.index((dataset, scene)) + 1) % len(held_out)]
    first = config.distortions.training[0]
    return first, next(iter(scenes_in(config.datasets[first])))


def held_out_methods(config: Config) -> tuple[str, ...]:
    """Return the methods that score held-out renderings, in the order of the table."""
    absent = absent_methods(config)
    return tuple(name for name in _rows(config) if name not in absent)


def held_out_job(config: Config) -> HeldOutJob:
    """Return what the job of a held-out scene reads."""
    methods = held_out_methods(config)
    found = {name: registry.find(name).method for name in methods}
    return HeldOutJob(
        device=config.device,
        evaluation=config.scorer_evaluation or ScorerEvaluationSettings(),
        networks=_told_apart(tuple(_network(config, name) for name in methods if found[name].scorer is not None)),
        metrics=tuple(
            ScoredMetric(method=name, selector=config.selectors.get(name, {}))
            for name in methods
            if found[name].assesses_images
        ),
        statistics=regression_settings(config) if STATISTICS in methods else None,
    )


def scorer_table_job(config: Config) -> ScorerTableJob:
    """Return what the table reads."""
    rows, absent = _rows(config), absent_methods(config)
    scenes = held_out_scenes(config)
    training = () if config.distortions is None else config.distortions.training
    embedded = tuple(name for name in scenes if config.datasets[name].source == _EMBEDDED)
    return ScorerTableJob(
        scenes=scenes,
        same_pictures=embedded if any(config.datasets[name].source == _EMBEDDED for name in training) else (),
        methods=rows,
        absent={name: absent[name] for name in rows if name in absent},
    )


def regression_settings(config: Config) -> RegressionSettings:
    """Return what the regressions on render statistics read."""
    return RegressionSettings.taken_from(registry.create_settings(STATISTICS, config.selectors.get(STATISTICS, {})))


def _rows(config: Config) -> tuple[str, ...]:
    """Return the methods that have rows, in order: metrics, the regressions, and one for each use of a network.

    Methods that differ in what they do with a network's scores share a row, which is that of the first of them in the
    registry, whatever their order in the run; those that show it other references or sizes have rows of their own.
    """
    found: dict[object, list[str]] = {}
    for name in config.methods:
        if is_program(name):
            continue
        method = registry.find(name).method
        if method.scorer is not None:
            found.setdefault(_network(config, name).model_dump_json(exclude={"method", "label"}), []).append(name)
        elif method.assesses_images or name == STATISTICS:
            found.setdefault(name, []).append(name)
    known = list(registry.methods())
    return tuple(min(names, key=known.index) for names in found.values())


def _network(config: Config, name: str) -> ScoredNetwork:
    scorer = registry.find(name).method.scorer
    assert scorer is not None  # those that call have looked
    settings = registry.create_settings(name, config.selectors.get(name, {}))
    told = settings.model_dump(include={"references", "resize", "precision"})
    label = next(each.method.label for each in registry.methods().values() if each.method.scorer == scorer)
    return ScoredNetwork.model_validate({"method": name, "label": label, "backbone": BACKBONE_OF[scorer], **told})


def _told_apart(networks: tuple[ScoredNetwork, ...]) -> tuple[ScoredNetwork, ...]:
    """Return ``networks`` with the method's identifier in a label that looks like another's."""
    labels = told_apart({each.method: each.label for each in networks})
    return tuple(each.model_copy(update={"label": labels[each.method]}) for each in networks)
