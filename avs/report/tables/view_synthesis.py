"""The view synthesis table of a data set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from avs.report.collect import Episodes, read_dataset
from avs.report.document import Document, Listing
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.formats.writing import write_document
from avs.report.published import called, published_note
from avs.report.tables.episode_entries import Numbers, has_spread
from avs.report.tables.episode_notes import episode_notes, equal_views
from avs.report.tables.episode_table import episode_table
from avs.report.tables.reconstruction_facts import loop_facts, reconstruction
from avs.report.tables.table_notes import (
    count,
    no_scenes,
    scenes_and_seeds,
    spread_note,
    unranked_notes,
)
from avs.report.tables.view_synthesis_numbers import COLUMNS, scene_value
from avs.system.reasons import Reason

SCENE_FIELDS = ("method", "metric", "scene", "seed", "images", "value")
"""Columns of the csv file of scenes."""

_RANGES = {"zero_one": "images in 0..1", "minus_one": "images in -1..1"}


def write_nvs_table(
    episodes: Sequence[Path],
    methods: Sequence[str],
    dataset: str,
    published: Path | None,
    out: Path,
    absent: Mapping[str, Reason],
    reference: str | None,
    left_out: Mapping[str, Reason] | None = None,
    pictures: Mapping[str, Any] | None = None,
) -> None:
    """Write ``out`` with ``.csv``, ``.md`` and ``.tex``, ``_per_scene.csv`` and ``_differences.csv``.

    Equal records give equal bytes, whatever the order of ``episodes``. How each number is computed is described in
    ``docs/tables.md``.

    Args:
        episodes: ``episode.json`` files of the data set.
        methods: see ``view_synthesis``.
        dataset: name of the data set.
        published: see ``view_synthesis``.
        out: path of the table without suffix.
        absent: see ``view_synthesis``.
        reference: see ``view_synthesis``.
        left_out: see ``view_synthesis``.
        pictures: see ``view_synthesis``.

    Raises:
        UserError: no episodes; a record is missing, damaged, of another data set or not comparable with the others;
            or the published values cannot be read.
    """
    collected = read_dataset(episodes, methods, dataset)
    write_document(view_synthesis(collected, methods, published, absent, reference, left_out, pictures), out)


def view_synthesis(
    episodes: Episodes,
    methods: Sequence[str],
    published: Path | None,
    absent: Mapping[str, Reason],
    reference: str | None,
    left_out: Mapping[str, Reason] | None = None,
    pictures: Mapping[str, Any] | None = None,
) -> Document:
    """Return the table of the test images at the end of the optimisation.

    Args:
        episodes: the episodes of one data set.
        methods: see ``episode_table``.
        published: see ``episode_table``.
        absent: see ``episode_table``.
        reference: see ``episode_table``.
        left_out: why something that looks like a scene of the data set is none, by its name.
        pictures: see ``episode_table``.

    Raises:
        UserError: the published values cannot be read.
    """
    table = episode_table(episodes, methods, published, absent, reference, pictures or {})
    tested = f"all pairs of methods are tested in the table significance_{episodes.dataset}"
    notes = [
        *table.missing(),
        *no_scenes(left_out or {}),
        *table.comparison_notes(),
        *([] if table.differences is None else [tested]),
        *spread_note(episodes, methods),
        *_lpips_note(episodes),
        *([] if table.paper is None else [published_note(table.paper.dataset, table.why_not)]),
        *table.fewer_compared(),
        *equal_views(episodes),
        *episode_notes(episodes),
        *unranked_notes(table.rows),
    ]
    caption = _caption(episodes, table.numbers, len(left_out or {}))
    return table.document("nvs", caption, notes, {"_per_scene": _scenes(episodes, methods)})


def _caption(episodes: Episodes, numbers: Numbers, left_out: int) -> list[str]:
    """Return what was measured, on what, and how."""
    facts = [*scenes_and_seeds(episodes), *loop_facts(episodes)]
    sentences = [
        f"Active view selection on the data set {called(episodes.dataset)}: {', '.join(facts)}.",
        *([f"Left out: {count(left_out, 'folder')} of it that cannot be a scene."] if left_out else []),
        reconstruction(episodes),
        "Test images at the end of the optimisation; mean over seeds of the mean over scenes.",
    ]
    if has_spread(numbers):
        sentences.append("After the plus-minus sign: standard deviation over seeds of the mean over scenes.")
    sentences.append("Marks rank the printed means, whatever their intervals.")
    return sentences


def _scenes(episodes: Episodes, methods: Sequence[str]) -> Listing:
    """Return one record for each method, metric, scene and seed: the mean over the test images at the end."""
    records, exact = [], []
    for method in methods:
        for metric in COLUMNS:
            for (scene, seed), episode in episodes.cells.get(method, {}).items():
                value = scene_value(episodes, method, scene, seed, metric.identifier)
                place = (method, metric.identifier, scene, seed, len(episode.curve[-1].images))
                records.append((*place, plain(value, metric.decimals + EXTRA_DECIMALS)))
                exact.append(value)
    return Listing(SCENE_FIELDS, tuple(records), tuple(exact))


def _lpips_note(episodes: Episodes) -> list[str]:
    settings = episodes.all[0].protocol.get("lpips")
    measured_anywhere = any("lpips" not in episode.absent for episode in episodes.all)
    if not isinstance(settings, dict) or not measured_anywhere:
        return []
    return [f"LPIPS: {settings.get('net')}, fed {_RANGES.get(str(settings.get('range')), 'unknown range')}"]
