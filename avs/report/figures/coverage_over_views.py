"""Draws the surface coverage ratio over the number of captured views."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from avs.coverage.coverage_record import Coverage
from avs.nvs.record import Episode
from avs.report.collect import Cell, read_episodes
from avs.report.collect_coverage import (
    Coverages,
    coverage_machine_notes,
    paths_by_dataset,
    read_coverages,
    with_coverage,
)
from avs.report.figures.captions import sentences, told_of_machines, write_caption
from avs.report.figures.curves import Panel, Values, panels
from avs.report.figures.figure_files import draw_notice
from avs.report.figures.over_views import Wording, draw_over_views

_WORDING = Wording("median SCR (%)", "difference to the\nmean of methods (%)", "all views")

_CAPTION = (
    "Surface coverage ratio over the number of views, median over scenes of the mean over seeds, and below it the "
    "difference to the mean of the methods in the same scene with the same seed. Thick lines are the reference method "
    "and the two with the highest last value, bands their intervals; a dot is the cloud of all views."
)
_NOTHING = "No coverage is measured: no scene has a reference cloud, or no record is there."


def write_coverage_over_views(
    episodes: Sequence[Path], records: Sequence[Path], methods: Sequence[str], out: Path, reference: str | None = None
) -> None:
    """Write ``out`` as ``.pdf`` and ``.png``, and its caption as ``.md``: two panels for each data set and budget.

    The upper panel has the SCR of the first views of each episode against their number: the median over scenes of the
    mean over seeds. Scenes without a reference cloud are left out. The lower panel has the mean difference to the mean
    of the methods in the same scene with the same seed; its band is the interval of ``avs.report.intervals``. Equal
    records give equal bytes.

    Args:
        episodes: ``episode.json`` files, of any data sets.
        records: their ``coverage.json`` files.
        methods: identifiers of the methods, in the order of the legend.
        out: path of the figure without suffix.
        reference: the method that the tables compare with, or None.

    Raises:
        UserError: no episodes; or a record is missing, damaged, or not comparable with the others of its data set.
    """
    drawn = coverage_panels(episodes, records, methods)
    if drawn:
        draw_over_views(drawn, reference, _WORDING, out)
        told = told_of_machines(episodes) + sentences(coverage_machine_notes(records))
        write_caption(out, _CAPTION + told)
    else:
        draw_notice(_NOTHING, out)


def coverage_panels(episodes: Sequence[Path], records: Sequence[Path], methods: Sequence[str]) -> list[Panel]:
    """Return the panels of all data sets."""
    drawn, by_dataset = [], paths_by_dataset(records)
    for collected in read_episodes(episodes, methods):
        coverages = read_coverages(by_dataset.get(collected.dataset, []), collected)
        found = Coverages({method: _measured(cells) for method, cells in coverages.cells.items()})
        measured = with_coverage(collected, found, {})
        if measured.cells:
            drawn += panels(measured, _scr_of(coverages), np.median)
    return drawn


def _measured(cells: Mapping[Cell, Coverage]) -> dict[Cell, Coverage]:
    """Return the records with a curve."""
    return {cell: record for cell, record in cells.items() if record.curve}


def _scr_of(coverages: Coverages) -> Values:
    """Return the function that gives the SCR of an episode, in percent, by number of views."""

    def values(episode: Episode) -> Mapping[int, float]:
        record = coverages.record(episode.method, (episode.scene, episode.seed))
        return {} if record is None else {point.views: 100.0 * point.scr for point in record.curve}

    return values
