"""The paper's values, transcribed in ``results/published``, and which of them stand beside which data set."""

from __future__ import annotations

import csv
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


def read_published(path: Path, scene: str = "mean") -> dict[tuple[str, str], str]:
    """Return the paper's values of a scene by (method, metric), with the digits that the paper prints.

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
    if reader.fieldnames != _COLUMNS:
        raise UserError(path, f"its columns are not {', '.join(_COLUMNS)}", "name a file of results/published")
    values = {(row["method"], row["metric"]): row["value"] for row in rows if row["scene"] == scene}
    for (method, metric), value in values.items():
        try:
            float(value)
        except (TypeError, ValueError):
            raise UserError(path, f"{method}, {metric}: {value!r} is not a number", "correct the file") from None
    return values
