"""The paper's values, transcribed in ``results/published``, and which of them stand beside which data set."""

from __future__ import annotations

import csv
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avs.nvs.protocol import ProtocolSettings
from avs.system.checksums import check_listed
from avs.system.errors import UserError
from avs.system.models import flat

STAND_INS = {
    "orbit": "mipnerf360",
    "walkthrough": "realestate10k",
    "handheld": "mapfree",
    "egocentric": "aria_dtc",
}
"""The data set of the paper for which an embedded capture pattern stands in: other pictures, the same kind of path."""

PRINTED_NAMES = {
    "mipnerf360": "Mip-NeRF360",
    "realestate10k": "RealEstate10K",
    "mapfree": "Map-Free",
    "aria_dtc": "ARIA-DTC",
}
"""Data sets of the paper by identifier."""

SCENES = {
    "mipnerf360": frozenset(
        ("bicycle", "bonsai", "counter", "flowers", "garden", "kitchen", "room", "stump", "treehill")
    )
}
"""The scenes that the paper's means are over, where it names them."""

COVERAGE_NAME = "coverage_realestate10k.csv"
"""The file of the paper's coverage, which it prints of one data set alone."""

SLAM_NAME = "slam_gibson.csv"
"""The file of the paper's active SLAM."""

MEAN = "mean"
"""What its files call the mean over the scenes of a data set."""

# What the paper says of its loop, and the iterations that FisherRF adds views at, which it follows, are the defaults of
# ``ProtocolSettings``, with LPIPS as 3DGS computes it.
_BUDGET = ProtocolSettings().budget

# Its reconstruction is that of 3DGS: the defaults of ``GaussianSettings``, written down here because tables must not be
# made anew when its code changes. A test compares.
_KIND = "gaussians"
_REPRESENTATION: dict[str, Any] = {
    "kind": "gaussians",
    "iterations": 30000,
    "extent": "robust",
    "sh_degree": 3,
    "sh_increase_every": 1000,
    "ssim_weight": 0.2,
    "background": [0.0, 0.0, 0.0],
    "adam_epsilon": 1e-15,
    "points.choice": "random",
    "points.random_count": 100000,
    "points.random_bounds": 3.0,
    "points.selected_min_views": 1,
    "points.max_count": None,
    "points.opacity": 0.1,
    "learning_rates.means": 0.00016,
    "learning_rates.means_final": 1.6e-06,
    "learning_rates.f_dc": 0.0025,
    "learning_rates.f_rest": 0.000125,
    "learning_rates.opacities": 0.05,
    "learning_rates.scales": 0.005,
    "learning_rates.quats": 0.001,
    "densification.start": 500,
    "densification.every": 100,
    "densification.until": 15000,
    "densification.gradient_threshold": 0.0002,
    "densification.absolute_gradient": False,
    "densification.split_scale": 0.01,
    "densification.prune_opacity": 0.005,
    "densification.prune_scale": 0.1,
    "densification.opacity_reset_every": 3000,
    "densification.opacity_reset_value": 0.01,
    "densification.max_gaussians": None,
}

# 1066 x 1600 pixels; LLFF's test images; a reader that refuses the authors' smaller copies.
_PICTURES = {"source": "mipnerf360", "test_every": 8, "long_side": 1600, "short_side": None, "resample": "pil"}

PICTURES = frozenset(_PICTURES)
"""The settings of a data set on which it depends whether the paper's values can be subtracted."""

RUNTIME_NAMES = {"memory": "runtime_garden.csv", "detail": "runtime_garden_detail.csv"}
"""The files of the paper's two tables of selection times."""

MEMORY_METHODS = ("fisherrf", "ours-dinov2", "ours-repvit")
"""The methods whose memory the paper has."""

PER_SCENE_NAMES = {"mipnerf360": "nvs_mipnerf360_per_scene.csv"}
"""The files of values of single scenes, by data set of the paper."""

_NAMED = 6
"""How many settings that are not the paper's are named at most."""

_COLUMNS = ["table", "dataset", "scene", "method", "metric", "value"]


def published_name(dataset: str) -> str | None:
    """Return the name of the file in ``results/published`` to print beside ``dataset``, or None if there is none."""
    source = STAND_INS.get(dataset, dataset)
    return f"nvs_{source}.csv" if source in PRINTED_NAMES else None


def called(dataset: str) -> str:
    """Return how a caption calls a data set: a stand-in is called the twin of what it stands for."""
    if dataset not in STAND_INS:
        return dataset
    return f"{dataset}, an embedded twin of {PRINTED_NAMES[STAND_INS[dataset]]}"


def headed(dataset: str) -> str:
    """Return the same in the few words of a heading."""
    return f"{dataset} (twin of {PRINTED_NAMES[STAND_INS[dataset]]})" if dataset in STAND_INS else dataset


@dataclass(frozen=True)
class Published:
    """The paper's values of one scene, or their means over scenes.

    Attributes:
        dataset: the data set of the paper, by identifier.
        values: with the digits that the paper prints, by identifier of the method and of the metric.
    """

    dataset: str
    values: dict[tuple[str, str], str]


def read_published(path: Path, scene: str = MEAN) -> Published:
    """Read the paper's values of a scene.

    Args:
        path: a file of ``results/published``.
        scene: name of the scene; ``mean`` for the means over scenes.

    Raises:
        UserError: the file is missing, is not a table of published values, or is not the one whose hash lies beside it.
    """
    try:
        check_listed(path, "restore it: git checkout results/published")
        with open(path, newline="", encoding="utf-8") as stream:
            reader = csv.DictReader(stream)
            rows = list(reader)
    except OSError as error:
        raise UserError(path, error.strerror or "cannot be read", "name a file of results/published") from error
    if reader.fieldnames != _COLUMNS or not rows:
        raise UserError(path, f"its columns are not {', '.join(_COLUMNS)}", "name a file of results/published")
    values = {(row["method"], row["metric"]): row["value"] for row in rows if row["scene"] == scene}
    for (method, metric), value in values.items():
        try:
            float(value)
        except (TypeError, ValueError):
            raise UserError(path, f"{method}, {metric}: {value!r} is not a number", "correct the file") from None
    return Published(rows[0]["dataset"], values)


def why_no_difference(
    source: str,
    dataset: str,
    scenes: Collection[str],
    protocol: Mapping[str, Any],
    representation: Mapping[str, Any],
    budgets: Collection[int],
    pictures: Mapping[str, Any],
) -> str | None:
    """Return why the paper's means stand beside a table for orientation alone, or None if they can be subtracted.

    Args:
        source: the data set of the paper, by identifier.
        dataset: name of the data set that was run.
        scenes: names of its scenes.
        protocol: its settings of the loop.
        representation: its settings of the reconstruction.
        budgets: numbers of views at the end.
        pictures: its reader, and its settings of images and of the split; one that is not there is not known.
    """
    if STAND_INS.get(dataset) == source:
        return f"{dataset} is a twin, with nothing in common but the kind of camera path"
    if dataset != source:
        return f"{dataset} is another data set"
    if source not in SCENES:
        return "the paper does not name the scenes of its mean"
    if set(scenes) != SCENES[source]:
        return f"its mean is over {', '.join(sorted(SCENES[source]))}"
    kind = representation.get("kind", _KIND)
    if kind != _KIND:
        return f"the paper's representation is {_KIND}, this one {kind}"
    differing = _differing(flat(ProtocolSettings().model_dump(mode="json")), flat(protocol))
    differing += [*_differing(_PICTURES, pictures), *_differing(_REPRESENTATION, flat(representation))]
    if differing:
        more = len(differing) - _NAMED
        return ", ".join([*differing[:_NAMED], *([f"and {more} more settings"] if more > 0 else [])])
    if set(budgets) != {_BUDGET}:
        return "the pool of a scene is too small for its budget"
    return None


def _differing(wanted: Mapping[str, Any], settings: Mapping[str, Any]) -> list[str]:
    """Return words for each setting that is not the paper's."""
    unknown = object()
    lines = []
    for key, value in wanted.items():
        found = settings.get(key, unknown)
        if found is unknown:
            lines.append(f"{key} is not known")
        elif isinstance(value, list):
            lines += [] if list(found) == value else [f"{key} at other iterations"]
        elif found != value:
            lines.append(f"{key} {'null' if found is None else found} in place of {'null' if value is None else value}")
    return lines


def published_note(source: str, why_not: str | None) -> str:
    """Return the note that tells whose values stand in the columns of published values.

    Args:
        source: the data set of the paper, by identifier.
        why_not: what ``why_no_difference`` returns.
    """
    told = f"published: the paper's means on {PRINTED_NAMES.get(source, source)}, one run without a spread"
    if why_not is None:
        return f"{told}; the difference is of the unrounded mean"
    return f"{told}, for orientation alone: {why_not}, so that no difference is printed"
