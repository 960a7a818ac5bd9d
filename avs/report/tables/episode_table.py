"""A table of one data set's episodes: methods in rows, metrics in columns, the paper's values beside the means."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avs.report.collect import Episodes
from avs.report.document import Cell, Comparison, Document, Group, Listing
from avs.report.methods import Presented, presented
from avs.report.published import Published, read_published
from avs.report.tables.arrangement import arranged
from avs.report.tables.episode_entries import Numbers, entry_cells, entry_listing
from avs.report.tables.episode_gaps import incomplete
from avs.report.tables.published_columns import published_column, why_no_mean_difference
from avs.report.tables.reference_differences import comparison, comparison_notes, fewer_compared, listed_differences
from avs.report.tables.table_notes import missing_notes
from avs.report.tables.view_synthesis_numbers import TEST_IMAGES, Quantities, summarise_episodes
from avs.system.reasons import Reason
from metrics.definitions import Metric


@dataclass(frozen=True)
class EpisodeTable:
    """The numbers of a table, and what is said of them whatever they are.

    Attributes:
        episodes: of one data set.
        metrics: the columns.
        reference: identifier of the method that the others are to be compared with, or None.
        compared_with: the reference, if it has episodes, or None.
        rows: the methods, in order.
        numbers: by identifier of the method and of the metric.
        paper: the published values, or None.
        why_not: why they are not subtracted, or None if they are, or if there are none.
        differences: to the reference, or None where there are none.
    """

    episodes: Episodes
    metrics: Sequence[Metric]
    reference: str | None
    compared_with: str | None
    rows: Sequence[Presented]
    numbers: Numbers
    paper: Published | None
    why_not: str | None
    differences: Comparison | None

    def missing(self) -> list[str]:
        """Say why cells are empty."""
        reasons = {method: {name: entry.missing for name, entry in row.items()} for method, row in self.numbers.items()}
        return missing_notes(self.episodes, self.metrics, self.rows, reasons)

    def comparison_notes(self) -> list[str]:
        """Say how the differences to the reference are to be read, or why there are none."""
        return comparison_notes(self.differences, self.reference, self.rows, self.episodes)

    def fewer_compared(self) -> list[str]:
        """Tell which methods are compared with the reference on fewer seeds than their mean is over."""
        return fewer_compared(self.rows, self.numbers, self.compared_with, self.episodes)

    def document(
        self,
        kind: str,
        caption: Iterable[str],
        notes: Iterable[str],
        appendices: Mapping[str, Listing],
        below: Sequence[Group] = (),
    ) -> Document:
        """Return the table in print.

        Args:
            kind: first part of its label, before the name of the data set.
            caption: sentences, after the one that says what is incomplete.
            notes: each is printed once.
            appendices: further csv files by suffix, beside that of differences to the reference.
            below: groups of rows after those of the methods.
        """
        methods = [row.identifier for row in self.rows]
        columns = tuple(published_column(metric, self.paper, self.why_not) for metric in self.metrics)
        cells = self._cells()
        return Document(
            label=f"{kind}-{self.episodes.dataset}",
            caption=(*incomplete(self.episodes), *caption),
            columns=columns,
            groups=(*arranged(columns, self.rows, cells), *below),
            notes=tuple(dict.fromkeys(notes)),
            listing=entry_listing(
                self.metrics,
                self.episodes,
                self.rows,
                self.numbers,
                cells,
                has_difference=self.paper is not None and self.why_not is None,
            ),
            comparison=self.differences,
            appendices={
                **appendices,
                "_differences": listed_differences(
                    self.episodes, methods, self.compared_with, self.numbers, self.metrics
                ),
            },
        )

    def _cells(self) -> Mapping[str, Sequence[Cell]]:
        published = {} if self.paper is None else self.paper.values
        return {method: entry_cells(self.metrics, method, row, published) for method, row in self.numbers.items()}


def episode_table(
    episodes: Episodes,
    methods: Sequence[str],
    published: Path | None,
    absent: Mapping[str, Reason],
    reference: str | None,
    pictures: Mapping[str, Any],
    quantities: Quantities = TEST_IMAGES,
) -> EpisodeTable:
    """Return the numbers of a table.

    Args:
        episodes: the episodes of one data set.
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where it has no
            number.
        published: a file of ``results/published`` (``avs.report.published.published_name``), or None.
        absent: why a method could not run, by identifier.
        reference: identifier of the method that the others are compared with, or None; one without episodes counts
            as None.
        pictures: settings of the size of images and of the split, as far as they are known.
        quantities: what the table has of each episode.

    Raises:
        UserError: the published values cannot be read.
    """
    compared_with = reference if reference in episodes.cells else None
    paper = None if published is None else read_published(published)
    rows = [presented(method, episodes) for method in methods]
    numbers = summarise_episodes(episodes, methods, compared_with, absent, quantities)
    return EpisodeTable(
        episodes=episodes,
        metrics=quantities.columns,
        reference=reference,
        compared_with=compared_with,
        rows=rows,
        numbers=numbers,
        paper=paper,
        why_not=None if paper is None else why_no_mean_difference(paper, episodes, pictures),
        differences=None if compared_with is None else comparison(compared_with, episodes, rows, numbers),
    )
