"""Tables as csv: one row per number, for other programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

from avs.report.formats.wording import against, has_spread
from avs.report.tables.summary import Entry, Row, Table, scene_value
from metrics.definitions import Metric

COLUMNS = ("method", "group", "metric", "mean", "spread", "scenes", "seeds", "published", "difference", "note")
SCENE_COLUMNS = ("method", "metric", "scene", "seed", "images", "value")

# Beyond the printed digits, so that differences and ranks can be recomputed.
_EXTRA_DECIMALS = 2


def table_csv(table: Table) -> str:
    """Return the table, one row per method and metric in the order of the table; an empty field is a missing value."""
    rows = []
    for row in table.rows:
        for metric in table.metrics:
            entry = row.entries[metric.identifier]
            rows.append(
                (
                    row.method,
                    row.group,
                    metric.identifier,
                    _number(entry.mean, metric),
                    _number(entry.spread, metric),
                    entry.scenes,
                    entry.seeds,
                    entry.published or "",
                    _number(entry.difference, metric),
                    "; ".join(_notes(table, row, entry, metric)),
                )
            )
    return csv_text(COLUMNS, rows)


def scenes_csv(table: Table) -> str:
    """Return one row per method, metric, scene and seed: the mean over the test images at the end of the episode."""
    rows = []
    for row in table.rows:
        for metric in table.metrics:
            for (scene, seed), episode in table.episodes.cells.get(row.method, {}).items():
                value = scene_value(table.episodes, row.method, scene, seed, metric.identifier)
                images = len(episode.curve[-1].images)
                rows.append((row.method, metric.identifier, scene, seed, images, _number(value, metric)))
    return csv_text(SCENE_COLUMNS, rows)


def _notes(table: Table, row: Row, entry: Entry, metric: Metric) -> list[str]:
    if entry.missing is not None:
        return [str(entry.missing)]
    notes = []
    if entry.seeds == 1 and has_spread(table):
        notes.append("one seed, no spread")
    difference = against(entry, metric)
    if difference is not None and table.reference is not None:
        notes.append(f"vs {table.reference.method} {difference}")
    # A deviation of one scene, such as a capped budget, concerns the mean of every metric.
    notes += sorted({note for episode in table.episodes.cells[row.method].values() for note in episode.notes})
    return notes


def _number(value: float | None, metric: Metric) -> str:
    return "" if value is None else f"{value:.{metric.decimals + _EXTRA_DECIMALS}f}"


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a header and rows as csv with line feeds."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return stream.getvalue()
