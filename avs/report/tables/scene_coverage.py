"""The coverage table of a data set: how much of the scene the views of each method cover in structure from motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.report.collect import Episodes, read_dataset
from avs.report.collect_coverage import Coverages, coverage_machine_notes, read_coverages
from avs.report.document import Cell, Document, Group, Listing, Row
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.formats.writing import write_document
from avs.report.machines import machine_notes
from avs.report.published import called, published_note
from avs.report.tables.coverage_agreement import TWINS, CoverageAgreement, agreement_listing, agreements
from avs.report.tables.episode_entries import has_spread
from avs.report.tables.episode_notes import equal_views, grouped_notes, own_schedules, own_settings, repeated_notes
from avs.report.tables.episode_table import episode_table
from avs.report.tables.scene_coverage_numbers import coverage_value, quantities_of
from avs.report.tables.table_notes import (
    scenes_and_seeds,
    span,
    spread_note,
    unranked_notes,
)
from avs.system.reasons import Reason
from metrics.definitions import Metric

EPISODE_FIELDS = ("method", "metric", "scene", "seed", "views", "value")
"""Columns of the csv file of episodes."""

TRUST = "Agreement"
"""Group of the rows that tell how far coverage that is measured against a cloud can be trusted."""


def write_coverage_table(
    episodes: Sequence[Path],
    records: Sequence[Path],
    methods: Sequence[str],
    dataset: str,
    published: Path | None,
    out: Path,
    absent: Mapping[str, Reason],
    lacking: Reason | None,
    reference: str | None,
) -> None:
    """Write ``out`` with ``.csv``, ``.md`` and ``.tex``, ``_per_scene.csv``, ``_differences.csv``, ``_agreement.csv``.

    Equal records give equal bytes, whatever their order. How each number is computed is described in
    ``docs/coverage.md``.

    Args:
        episodes: ``episode.json`` files of the data set.
        records: their ``coverage.json`` files.
        methods: see ``scene_coverage``.
        dataset: name of the data set.
        published: see ``scene_coverage``.
        out: path of the table without suffix.
        absent: see ``scene_coverage``.
        lacking: why there is no coverage at all, such as a back end that is not installed; or None.
        reference: see ``scene_coverage``.

    Raises:
        UserError: no episodes; a record is missing, damaged, or not comparable with the others; or the published values
            cannot be read.
    """
    collected = read_dataset(episodes, methods, dataset)
    coverages = read_coverages(records, collected, lacking)
    write_document(scene_coverage(collected, coverages, methods, published, absent, reference), out)


def scene_coverage(
    episodes: Episodes,
    coverages: Coverages,
    methods: Sequence[str],
    published: Path | None,
    absent: Mapping[str, Reason],
    reference: str | None,
) -> Document:
    """Return the table of coverage by all views of an episode.

    Args:
        episodes: the episodes of one data set.
        coverages: of those episodes.
        methods: see ``episode_table``.
        published: see ``episode_table``.
        absent: see ``episode_table``.
        reference: see ``episode_table``.

    Raises:
        UserError: the published values cannot be read.
    """
    table = episode_table(episodes, methods, published, absent, reference, {}, quantities_of(coverages))
    paper = table.paper
    trust = agreements(episodes, coverages, [row.identifier for row in table.rows if row.ranked])
    notes = [
        *table.missing(),
        *table.comparison_notes(),
        *spread_note(episodes, methods),
        *([] if paper is None else [f"{published_note(paper.dataset, table.why_not)}; its clouds are MASt3R's"]),
        *table.fewer_compared(),
        *_placements(coverages),
        *equal_views(episodes, of_views_alone=True),
        *own_schedules(episodes),
        *own_settings(episodes),
        *machine_notes(episodes.records),
        *coverage_machine_notes(coverages.records),
        *repeated_notes(episodes),
        *grouped_notes(((each.scene, note) for each in coverages.all for note in each.notes), episodes.scenes),
        *unranked_notes(table.rows),
    ]
    listings = {
        "_per_scene": _per_scene(episodes, coverages, methods, table.metrics),
        "_agreement": agreement_listing(trust),
    }
    caption = _caption(episodes, coverages, trust, spread=has_spread(table.numbers))
    return table.document("coverage", caption, notes, listings, below=_trust(table.metrics, trust))


def _caption(
    episodes: Episodes, coverages: Coverages, trust: Sequence[CoverageAgreement], *, spread: bool
) -> list[str]:
    facts = [*scenes_and_seeds(episodes), f"{span(episode.budget for episode in episodes.all)} views"]
    sentences = [
        f"Scene coverage by structure from motion on the data set {called(episodes.dataset)}: {', '.join(facts)}.",
        *_measured(coverages),
    ]
    if trust and any(each.other in TWINS.values() for each in trust):
        sentences.append(
            "The columns named true hold the same clouds against the true surface that the reference's views see. "
            "The rows under Agreement tell how a column goes with that truth, and with test PSNR: 1 is the same order, "
            "0 no relation."
        )
    sentences.append("Mean over seeds of the mean over scenes.")
    if spread:
        sentences.append("After the plus-minus sign: standard deviation over seeds of the mean over scenes.")
    return [*sentences, "Marks rank the printed means, whatever their intervals."]


def _measured(coverages: Coverages) -> list[str]:
    """Return what was measured, as the records tell."""
    if not coverages.all:
        return [f"Not measured: {coverages.lacking or 'there is no record'}."]
    told, reference = coverages.all[0].settings, coverages.all[0].reference
    views = "all views of a scene" if reference["reference_views"] == "all" else "all views but the test images"
    poses = "known poses" if told["sfm"]["poses"] == "known" else "poses of its own, aligned by shared cameras"
    thresholds = ", ".join(f"{share:g}" for share in told["thresholds"])
    return [
        f"Clouds by the back end {told['sfm']['back_end']} with {poses}; the reference is its cloud of {views}.",
        f"SCR: share of the reference nearer than {told['threshold']:g} of its extent; F-score: mean over "
        f"{thresholds}; F (toolbox): at {told['threshold']:g}.",
    ]


def _placements(coverages: Coverages) -> list[str]:
    """Return what a reader should know of the alignment of clouds with poses of their own."""
    found = [(each.placement, each.extent) for each in coverages.all if each.placement is not None]
    shares = [100.0 * placement.residual / size for placement, size in found if placement is not None and size]
    if not shares:
        return []
    return [
        f"clouds were aligned by Sim(3) on shared cameras; the residual of their centres is {min(shares):.3f} to "
        f"{max(shares):.3f} % of the extent"
    ]


def _trust(metrics: Sequence[Metric], trust: Sequence[CoverageAgreement]) -> tuple[Group, ...]:
    """Return the rows that tell how far each column goes with another."""
    rows = []
    for others, name in ((tuple(TWINS.values()), "the truth"), (("psnr",), "test PSNR")):
        found = {each.metric: each for each in trust if each.other in others}
        if found:
            columns = [found.get(metric.identifier) for metric in metrics]
            within = tuple(Cell(None if each is None else each.within_scenes.value) for each in columns)
            methods = tuple(Cell(None if each is None else each.methods.value) for each in columns)
            rows.append(Row(f"rho with {name}, within scenes", within))
            rows.append(Row(f"tau with {name}, of methods", methods))
    return (Group(TRUST, tuple(rows)),) if rows else ()


def _per_scene(episodes: Episodes, coverages: Coverages, methods: Sequence[str], metrics: Sequence[Metric]) -> Listing:
    """Return one record for each method, metric, scene and seed."""
    records, exact = [], []
    for method in methods:
        for metric in metrics:
            for cell, episode in episodes.cells.get(method, {}).items():
                value = coverage_value(coverages, method, cell, metric.identifier)
                told = plain(value, metric.decimals + EXTRA_DECIMALS)
                records.append((method, metric.identifier, *cell, episode.budget, told))
                exact.append(value)
    return Listing(EPISODE_FIELDS, tuple(records), tuple(exact))
