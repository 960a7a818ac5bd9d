"""Which weights a method gets in a run, and why a method cannot run at all: the one place where that is decided."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from avs.config.configuration import scorer_of
from avs.config.run_config import Config
from avs.config.slam_config import explorers, untrained
from avs.iqa.cross_reference.backbone_weights import absent_weights
from avs.iqa.cross_reference.published_weights import published_weights
from avs.iqa.cross_reference.scorer_settings import PUBLISHED
from avs.selection import registry
from avs.system import weights
from avs.system.named_files import named_files
from avs.system.reasons import Reason

_FITTED: dict[str, Literal["niqe_fit", "statistics_fit"]] = {"niqe": "niqe_fit", "statistics": "statistics_fit"}
"""The rules that fit what ``Method.fallback`` names."""

_NO_TRAINING_SCENES = Reason(
    cause="fitted to training scenes, of which the run has none", remedy="name some in the section distortions"
)


_NOT_INSTALLED = Reason(
    cause="its package is not installed here, so that nothing is known of its records", remedy="install it again"
)


@dataclass(frozen=True)
class Made:
    """Weights that this run makes.

    Attributes:
        rule: the rule that makes them.
        name: the scorer that is trained, or that whose parameters are fitted.
    """

    rule: Literal["scorer_train", "niqe_fit", "statistics_fit"]
    name: str


@dataclass(frozen=True)
class Absent:
    """Weights that a method needs and that are neither here nor made by the run.

    Attributes:
        reason: which, and the command that fetches them.
    """

    reason: Reason


def weights_of(config: Config, identifier: str) -> Path | Made | Absent | None:
    """Return what a method gets as its weights: a file that is here, one that the run makes, or none.

    Published weights come first, then those that the run makes. Files are located, not read: who loads one checks it.
    A method that needs several files looks for them itself and gets none; a program of its own does too.
    """
    if is_program(identifier) or followed(identifier) is not None:
        return None
    method = registry.find(identifier).method
    if method.scorer is not None:
        scorer = scorer_of(config, method.scorer)
        published = published_weights(method.scorer, scorer)
        if published is not None or (reason := absent_weights(scorer)) is None:
            return published or Made("scorer_train", method.scorer)
        whole = weights.missing([PUBLISHED[method.scorer]]) if scorer.published and method.scorer in PUBLISHED else None
        return Absent(whole or reason)  # a scorer that others have trained is better than a backbone
    reason = weights.missing(method.pretrained)
    if (method.pretrained and reason is None) or method.fallback is None:
        return _located(method.pretrained) if reason is None else Absent(reason)
    if config.distortions is None:
        return Absent(reason or _NO_TRAINING_SCENES)
    return Made(_FITTED[method.fallback], method.fallback)


def _located(pretrained: Sequence[str]) -> Path | None:
    """Return the file of published weights that are here, if it is one alone."""
    return weights.locate(pretrained[0]) if len(pretrained) == 1 else None


def files_read(config: Config, identifier: str, *, evaluated: bool) -> tuple[Path, ...]:
    """Return the files on this machine that a method reads beside what it gets, so that a change is seen.

    They are downloaded weights, and what its settings and those of the representation name by a path.

    Args:
        config: of the run.
        identifier: of the method.
        evaluated: whether test metrics are computed too, LPIPS by its published backbone.

    Raises:
        UserError: see ``named_files``.
    """
    downloaded = (f"lpips-{config.protocol.lpips.net}",) if evaluated else ()
    own = _files_of(identifier, config.selectors.get(identifier, {}), downloaded)
    return (*own, *named_files(config.representation.model_dump()))


def files_read_exploring(config: Config, name: str) -> tuple[Path, ...]:
    """Return the same of the method that chooses paths under a name of ``slam.methods``; none if no method does."""
    told = explorers(config.slam).get(name)
    return () if told is None else _files_of(told.method, told.settings)


def files_read_by_back_end(config: Config) -> tuple[Path, ...]:
    """Return the files on this machine that the back end of coverage reads, such as the weights of its network.

    Raises:
        UserError: see ``named_files``.
    """
    return () if config.coverage is None else tuple(named_files(config.coverage.sfm.model_dump()))


def check_named_files(config: Config) -> None:
    """Look at all files that settings name, so that none is found later that cannot be watched.

    Raises:
        UserError: see ``named_files``.
    """
    for identifier in config.methods:
        files_read(config, identifier, evaluated=False)
    for name in explorers(config.slam):
        files_read_exploring(config, name)
    files_read_by_back_end(config)


def _files_of(identifier: str, told: dict[str, Any], downloaded: Sequence[str] = ()) -> tuple[Path, ...]:
    """Return downloaded weights, and what a method's settings name, those that are its defaults too."""
    pretrained: Sequence[str] = ()
    if not is_program(identifier):
        pretrained = registry.find(identifier).method.pretrained
        told = registry.create_settings(identifier, told).model_dump()
    found = tuple(path for name in (*pretrained, *downloaded) if (path := weights.locate(name)) is not None)
    return (*found, *named_files(told))


def absent_methods(config: Config) -> dict[str, Reason]:
    """Return why each method of the run that cannot run here does not, by identifier.

    Such a method keeps its row in the tables, which says so; no episode of it is asked for.
    """
    return {method: reason for method in config.methods if (reason := _why_not(config, method)) is not None}


def scoring_methods(config: Config, dataset: str) -> tuple[str, ...]:
    """Return the methods on a data set that score candidates at common states.

    Those of an oracle that measures a truth are that truth itself, which needs no method.
    """
    absent = absent_methods(config) | choosing_elsewhere(config)
    able = (method for method in config.methods_on(dataset) if method not in absent)
    return tuple(method for method in able if registry.find(method).method.measures is None)


def _why_not(config: Config, identifier: str) -> Reason | None:
    """Return why one method cannot run, or None."""
    if is_program(identifier):
        return _NOT_INSTALLED if config.was_installed(identifier) else None
    other = followed(identifier)
    if other is not None:
        reason = _why_not(config, other)
        return None if reason is None else Reason(cause=f"{other}: {reason.cause}", remedy=reason.remedy)
    settings = registry.create_settings(identifier, config.selectors.get(identifier, {}))
    misfit = registry.why_not(identifier, settings, config.representation.kind)
    return misfit or lacking_weights(config, identifier)


def lacking_weights(config: Config, identifier: str) -> Reason | None:
    """Return why a method has no weights, or None; what a run had when it was planned counts as being here still."""
    answer = None if config.had_weights(identifier) else weights_of(config, identifier)
    return answer.reason if isinstance(answer, Absent) else None


def with_weights_at_hand(config: Config) -> tuple[str, ...]:
    """Return the methods of a run, those that choose paths too, that lack no weights here."""
    unable = untrained(config.slam, config.scorers)
    choosing_paths = (told.method for name, told in explorers(config.slam).items() if name not in unable)
    methods = dict.fromkeys((*config.methods, *choosing_paths))
    return tuple(method for method in methods if lacking_weights(config, method) is None)


def choosing_elsewhere(config: Config) -> dict[str, Reason]:
    """Return the methods that look at no reconstruction when they choose, and so can be neither timed nor compared."""
    found = {}
    for method in config.methods:
        other = followed(method)
        if is_program(method):
            found[method] = Reason(cause="a program of its own, which chooses by itself")
        elif other is not None:
            found[method] = Reason(cause=f"it captures the views of {other} and chooses none")
    return found


def followed(identifier: str) -> str | None:
    """Return the method whose views a method captures, or None if it chooses by itself."""
    return None if is_program(identifier) else registry.find(identifier).method.follows


def is_program(identifier: str) -> bool:
    """Return whether a method of a checked configuration is a program of its own, of which only its rule knows."""
    return identifier not in registry.methods()
