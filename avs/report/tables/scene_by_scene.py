"""View synthesis scene by scene: scenes in rows, methods in columns, a block for each metric, as the paper has it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.report.collect import Episodes, read_dataset
from avs.report.document import Cell, Column, Document, Group, Listing, Row
from avs.report.formats.numbers import EXTRA_DECIMALS, plain
from avs.report.formats.writing import write_document
from avs.report.methods import Presented, presented
from avs.report.published import MEAN, PRINTED_NAMES, SCENES, Published, called, read_published
from avs.report.tables.arrangement import in_groups, ranks
from avs.report.tables.episode_entries import Numbers
from avs.report.tables.episode_gaps import incomplete
from avs.report.tables.episode_notes import episode_notes
from avs.report.tables.reconstruction_facts import loop_facts, reconstruction
from avs.report.tables.table_notes import missing_notes, no_scenes, scenes_and_seeds, unranked_notes
from avs.report.tables.view_synthesis_numbers import COLUMNS, scene_value, summarise_episodes
from avs.system.reasons import Reason
from metrics.definitions import Metric

FIELDS = ("metric", "scene", "method", "value", "seeds", "published")
"""Columns of the csv file."""

OVER_SCENES = "mean over scenes"
"""What the csv file calls the means, in the column of scenes; no scene is called so, since names have no blanks."""

_Papers = Mapping[str | None, Published]  # none is their mean


def write_scene_table(
    episodes: Sequence[Path],
    methods: Sequence[str],
    dataset: str,
    published: Sequence[Path],
    out: Path,
    absent: Mapping[str, Reason],
    left_out: Mapping[str, Reason] | None = None,
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``; equal records give equal bytes.

    Raises:
        UserError: no episodes; a record is missing, damaged, of another data set or not comparable with the others; or
            the published values cannot be read.
    """
    collected = read_dataset(episodes, methods, dataset)
    write_document(scene_by_scene(collected, methods, published, absent, left_out), out)


def scene_by_scene(
    episodes: Episodes,
    methods: Sequence[str],
    published: Sequence[Path],
    absent: Mapping[str, Reason],
    left_out: Mapping[str, Reason] | None = None,
) -> Document:
    """Return the table: each value is the mean over test images, then over the seeds that a method has completely.

    Args:
        episodes: the episodes of one data set.
        methods: identifiers of the methods, in the order of columns.
        published: files of ``results/published`` with values of the scenes and their means; the first that has a value
            counts.
        absent: why a method could not run, by identifier.
        left_out: why something that looks like a scene of the data set is none, by its name.

    Raises:
        UserError: the published values cannot be read.
    """
    numbers = summarise_episodes(episodes, methods, None, absent)
    columns = [row for _, members in in_groups([presented(each, episodes) for each in methods]) for row in members]
    papers = _papers(published, episodes.scenes)
    reasons = {method: {name: entry.missing for name, entry in row.items()} for method, row in numbers.items()}
    return Document(
        label=f"scenes-{episodes.dataset}",
        caption=(*incomplete(episodes), *_caption(episodes)),
        columns=tuple(Column(Metric(each.identifier, each.label, None, 2, "", "")) for each in columns),
        groups=tuple(Group("", tuple(_rows(episodes, columns, numbers, papers, metric)), metric) for metric in COLUMNS),
        notes=tuple(
            dict.fromkeys(
                [
                    *missing_notes(episodes, COLUMNS, columns, reasons),
                    *no_scenes(left_out or {}),
                    *_paper_notes(papers),
                    *episode_notes(episodes),
                    *unranked_notes(columns),
                ]
            )
        ),
        listing=_listing(episodes, columns, numbers, papers),
        rows_are="Scene",
    )


def _papers(published: Sequence[Path], scenes: Sequence[str]) -> _Papers:
    """Return the paper's values by scene, and its means; what it has nothing of is left out.

    Its means are left out, too, beside some of its scenes alone, or others: they would stand under means of these. A
    scene may be called as the file calls its means: such a one is none of the paper's.
    """
    found: dict[str | None, Published] = {}
    for scene in (*(name for name in scenes if name != MEAN), None):
        if scene is None and found and set(scenes) != SCENES.get(_source(found), frozenset()):
            continue
        for path in published:
            paper = read_published(path, MEAN if scene is None else scene)
            known = found[scene].values if scene in found else {}
            if paper.values:
                found[scene] = Published(paper.dataset, paper.values | known)
    return found


def _source(papers: _Papers) -> str:
    return next(iter(papers.values())).dataset


def _rows(
    episodes: Episodes, columns: Sequence[Presented], numbers: Numbers, papers: _Papers, metric: Metric
) -> list[Row]:
    """Return the rows of one metric: each scene, then the mean, each followed by the paper's where it has one."""
    rows = []
    for scene in (*episodes.scenes, None):
        values = {each.identifier: _value(episodes, each.identifier, scene, numbers, metric) for each in columns}
        marks = ranks({each.identifier: values[each.identifier] for each in columns if each.ranked}, metric)
        cells = tuple(Cell(value, rank=marks.get(method)) for method, value in values.items())
        rows.append(Row(OVER_SCENES.capitalize() if scene is None else scene, cells))
        paper = papers.get(scene)
        if paper is not None:
            printed = [paper.values.get((each.identifier, metric.identifier)) for each in columns]
            name = PRINTED_NAMES.get(paper.dataset, paper.dataset)
            rows.append(Row(f"published, {name}", tuple(Cell(text=text) for text in printed)))
    return rows


def _value(episodes: Episodes, method: str, scene: str | None, numbers: Numbers, metric: Metric) -> float | None:
    """Return the mean over seeds of a scene, or over scenes and seeds for no one; None where there is none."""
    entry = numbers[method][metric.identifier]
    if scene is None or entry.missing is not None:
        return entry.mean
    seeds = episodes.complete_seeds(method)
    values = [scene_value(episodes, method, scene, seed, metric.identifier) for seed in seeds]
    known = [value for value in values if value is not None]
    return sum(known) / len(known)


def _caption(episodes: Episodes) -> list[str]:
    facts = [*scenes_and_seeds(episodes), *loop_facts(episodes)]
    return [
        f"Active view selection scene by scene on the data set {called(episodes.dataset)}: {', '.join(facts)}.",
        reconstruction(episodes),
        "Test images at the end of the optimisation; mean over seeds.",
        "Marks rank the printed values of a row, whatever their spread over seeds.",
    ]


def _paper_notes(papers: _Papers) -> list[str]:
    if not papers:
        return []
    scenes = [scene for scene in papers if scene is not None]
    told = f"on {', '.join(scenes)}" if scenes else "as means over its own scenes"
    if scenes and None in papers:
        told += " and their mean"
    lines = [f"published: the paper's values {told}, one run without a spread, for orientation alone"]
    if None not in papers:
        own = ", ".join(sorted(SCENES.get(_source(papers), ())))
        over = f": it is over {own}" if own else ", whose scenes it does not name"
        lines.append(f"the paper's mean is left out{over}")
    return lines


def _listing(episodes: Episodes, columns: Sequence[Presented], numbers: Numbers, papers: _Papers) -> Listing:
    """Return one record for each metric, scene and method."""
    records: list[tuple[str | int, ...]] = []
    for metric in COLUMNS:
        digits = metric.decimals + EXTRA_DECIMALS
        for scene in (*episodes.scenes, None):
            paper = papers[scene].values if scene in papers else {}
            for each in columns:
                value = _value(episodes, each.identifier, scene, numbers, metric)
                seeds = 0 if value is None else len(episodes.complete_seeds(each.identifier))
                beside = paper.get((each.identifier, metric.identifier), "")
                place = (metric.identifier, scene or OVER_SCENES, each.identifier)
                records.append((*place, plain(value, digits), seeds, beside))
    return Listing(FIELDS, tuple(records))
