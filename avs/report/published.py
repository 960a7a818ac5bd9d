"""The paper's values, transcribed in ``results/published``, and which of them stand beside which data set."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

from avs.system.errors import UserError

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

_COLUMNS = ["table", "dataset", "scene", "method", "metric", "value"]


def published_name(dataset: str) -> str | None:
    """Return the name of the file in ``results/published`` to print beside ``dataset``, or None if there is none."""
    source = STAND_INS.get(dataset, dataset)
    return f"nvs_{source}.csv" if source in PRINTED_NAMES else None


@dataclass(frozen=True)
class Published:
    """The paper's values of one scene, or their means over scenes.

    Attributes:
        dataset: the data set of the paper, by identifier.
        values: with the digits that the paper prints, by identifier of the method and of the metric.
    """

    dataset: str
    values: dict[tuple[str, str], str]


def read_published(path: Path, scene: str = "mean") -> Published:
    """Read the paper's values of a scene.

    Args:
        path: a file of ``results/published``.
        scene: name of the scene; ``mean`` for the means over scenes.

    Raises:
        UserError: the file is missing, or is not a table of published values.
    """
    try:
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


def published_note(source: str, dataset: str) -> str:
    """Return the note that tells which values of the paper stand beside those of a data set.

    Args:
        source: the data set of the paper, by identifier.
        dataset: name of the data set that was run.
    """
    printed = PRINTED_NAMES.get(source, source)
    if STAND_INS.get(dataset) == source:
        return (
            f"published: the paper's values on {printed}; {dataset} stands in for its kind of capture with other "
            "scenes and a shorter schedule, so that the difference is no measure of a reproduction"
        )
    return f"published: the paper's values on {printed}"
