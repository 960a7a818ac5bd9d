"""The table of scorers: how well networks, metrics and plain numbers predict the SSIM of held-out renderings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from avs.iqa.held_out.held_out_record import HeldOutScores, Kind, Scored
from avs.iqa.held_out.held_out_settings import STATISTICS
from avs.report.collect_held_out import read_held_out
from avs.report.document import Cell, Column, Document, Group, Listing, Row
from avs.report.formats.numbers import plain
from avs.report.formats.writing import write_document
from avs.report.machines import machine_notes
from avs.report.methods import presented
from avs.report.tables.arrangement import ranks
from avs.report.tables.changed_settings import changed_settings
from avs.report.tables.scorer_agreement_numbers import (
    IMAGES,
    METRICS,
    PIXELS,
    WITHIN,
    WITHIN_KENDALL,
    Agreement,
    agreements,
    moments_without_order,
    scene_numbers,
)
from avs.report.tables.table_notes import count
from avs.selection import registry
from avs.system.computed_by import ComputedBy
from avs.system.reasons import Reason
from metrics.statistics import ENOUGH_FOR_SPREAD

FIELDS = ("predictor", "label", "kind", "scenes_of", "metric", "mean", "standard_error", "scenes", "note")
"""Columns of the csv file."""

SCENE_FIELDS = ("predictor", "dataset", "scene", "metric", "value")
"""Columns of the csv file of scenes."""

ALL = "all data sets"
"""What the csv file calls their scenes together; no data set is called so, since names have no blanks."""

_GROUPS: dict[Kind, str] = {
    "network": "Networks",
    "metric": "No-reference metrics",
    "regression": "Regressions on render statistics",
    "plain": "Plain numbers",
    "references": "Networks with other references",
}
_UNMARKED: tuple[Kind, ...] = ("references",)
_DECIMALS = 4  # of the csv files

_SAME_PICTURES = (
    "{datasets}: the scenes trained nothing, but their surfaces show some of the ten photographs that those of "
    "training scenes show, in other places, so that real scenes are farther from the training than these"
)

_Numbers = Mapping[str, Mapping[str, Mapping[str, Agreement]]]  # by scenes, predictor and metric
_Partial = Mapping[tuple[str, str], str]  # by scenes and predictor: of how few moments its number within them is


def write_scorer_table(
    paths: Sequence[Path],
    scenes: Mapping[str, Sequence[str]],
    methods: Sequence[str],
    out: Path,
    absent: Mapping[str, Reason],
    same_pictures: Sequence[str] = (),
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md``, ``.tex`` and ``.json``, and ``_per_scene.csv``.

    Equal records give equal bytes, whatever their order. How each number is computed is described in
    ``docs/tables.md``.

    Args:
        paths: the records of all held-out scenes.
        scenes: names of these scenes, by data set.
        methods: identifiers of the methods that have rows, in order.
        out: path of the table without suffix.
        absent: why one of them has no number, by identifier.
        same_pictures: see ``scorer_agreement``.

    Raises:
        UserError: a record is missing, damaged or of another scene, or they are not comparable.
    """
    write_document(scorer_agreement(read_held_out(paths, scenes), methods, absent, paths, same_pictures), out)


def scorer_agreement(
    records: Sequence[HeldOutScores],
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    paths: Sequence[Path] = (),
    same_pictures: Sequence[str] = (),
) -> Document:
    """Return the table.

    Args:
        records: of all held-out scenes, one at least, in order.
        methods: identifiers of the methods that have rows, in order.
        absent: why one of them has no number, by identifier.
        paths: the files of the records, beside which stands with what they were computed.
        same_pictures: data sets whose surfaces show the pictures that training scenes show.
    """
    datasets = list(dict.fromkeys(record.dataset for record in records))
    numbers: _Numbers = {ALL: agreements(records)} | {
        name: agreements([record for record in records if record.dataset == name]) for name in datasets
    }
    columns, partial = _columns(datasets), _partial(records)
    return Document(
        label="scorer",
        caption=tuple(_caption(records, datasets)),
        columns=columns,
        groups=_groups(records[0].scored, columns, numbers, partial, methods, absent),
        notes=(
            *dict.fromkeys(_notes(records, partial, methods, absent)),
            *([_SAME_PICTURES.format(datasets=", ".join(same_pictures))] if same_pictures else []),
            *machine_notes(paths, ComputedBy, "records of held-out scenes"),
        ),
        listing=_listing(records[0].scored, numbers, partial, absent),
        appendices={"_per_scene": _scenes(records)},
        rows_are="Predictor",
    )


def _partial(records: Sequence[HeldOutScores]) -> _Partial:
    """Return what is to be said of predictors that have an order of the candidates at some of the moments alone."""
    found: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for record in records:
        for each in record.scored:
            for scenes in (ALL, record.dataset):
                found.setdefault((scenes, each.identifier), []).append(moments_without_order(record, each))
    counts = {place: tuple(map(sum, zip(*each, strict=True))) for place, each in found.items()}
    return {
        place: f"within moments of {total - left} of {total}; at the others it gives all candidates one score"
        for place, (left, total) in counts.items()
        if 0 < left < total
    }


def _columns(datasets: Sequence[str]) -> tuple[Column, ...]:
    own = [
        Column(replace(WITHIN, identifier=f"within_{name}", name=name.removesuffix("_held_out")), over="by data set")
        for name in (datasets if len(datasets) > 1 else ())
    ]
    return (*(Column(metric) for metric in (*PIXELS, *IMAGES, WITHIN)), *own)


def _cells(predictor: str, columns: Sequence[Column], numbers: _Numbers) -> list[Cell]:
    datasets = [name for name in numbers if name != ALL]
    own = numbers[ALL][predictor]
    cells = [
        Cell(own[metric.identifier].mean, own[metric.identifier].error if metric == WITHIN else None)
        for metric in (*PIXELS, *IMAGES, WITHIN)
    ]
    beside = [Cell(numbers[name][predictor][WITHIN.identifier].mean) for name in datasets]
    return [*cells, *beside][: len(columns)]


def _groups(
    scored: Sequence[Scored],
    columns: Sequence[Column],
    numbers: _Numbers,
    partial: _Partial,
    methods: Sequence[str],
    absent: Mapping[str, Reason],
) -> tuple[Group, ...]:
    """Return the rows by kind, the best three values of each column marked.

    Other references compete with none, nor does a mean over other moments than those of the others.
    """
    cells = {each.identifier: _cells(each.identifier, columns, numbers) for each in scored}
    marked = [each for each in scored if each.kind not in _UNMARKED]
    names = [name for name in numbers if name != ALL]
    within = dict(enumerate((ALL, *names), start=len((*PIXELS, *IMAGES))))  # the data sets of each such column
    for index, column in enumerate(columns):
        whole = [each.identifier for each in marked if (within.get(index), each.identifier) not in partial]
        for name in {each.identifier for each in marked}.difference(whole):
            cells[name][index] = replace(cells[name][index], ranked=False)
        values = {name: cells[name][index].value for name in whole}
        for predictor, rank in ranks(values, column.metric).items():
            cells[predictor][index] = replace(cells[predictor][index], rank=rank)
    found: dict[Kind, list[Row]] = {kind: [] for kind in _GROUPS}
    for each in _with_absent(scored, methods, absent):
        if isinstance(each, Scored):
            own, competes = tuple(cells[each.identifier]), each.kind not in _UNMARKED
            found[each.kind].append(Row(each.label, own, identifier=each.identifier, ranked=competes))
        else:
            kind, label, reason = each
            found[kind].append(Row(label, (Cell(cause=reason.cause), *[Cell()] * (len(columns) - 1))))
    return tuple(Group(_GROUPS[kind], tuple(rows)) for kind, rows in found.items() if rows)


def _with_absent(
    scored: Sequence[Scored], methods: Sequence[str], absent: Mapping[str, Reason]
) -> Iterator[Scored | tuple[Kind, str, Reason]]:
    """Yield the predictors, those of methods in the order of the run with the absent ones in their places."""
    there = {each.identifier: each for each in scored}
    for name in methods:
        if name in there:
            yield there.pop(name)
        elif name in absent:
            method = registry.find(name).method
            kind: Kind = "metric" if method.assesses_images else "regression" if method.scorer is None else "network"
            yield kind, presented(name).label, absent[name]
    yield from there.values()


def _caption(records: Sequence[HeldOutScores], datasets: Sequence[str]) -> Iterator[str]:
    told = ", ".join(
        f"{name} ({', '.join(each.scene for each in records if each.dataset == name)})" for name in datasets
    )
    renderings = sum(len(record.ssim) for record in records)
    candidates = sum(map(sum, (record.candidate for record in records)))
    yield (
        f"How well scores agree with the true SSIM of {renderings} renderings of {count(len(records), 'scene')} that "
        f"trained nothing: {told}."
    )
    yield "Its maps are clipped to 0..1 pixel by pixel, as those that networks and regressions are trained with."
    yield (
        "Each number is computed on a scene and averaged over scenes. Over all renderings of a scene, an early "
        "reconstruction is easily told from a late one; a choice depends on the column within a moment: Spearman's rho "
        f"among the candidates of one moment of a reconstruction ({candidates} in all), mean over moments."
    )
    if len(records) >= ENOUGH_FOR_SPREAD:
        yield "After the plus-minus sign: its standard error over scenes."


def _own_settings(record: HeldOutScores) -> Iterator[str]:
    """Yield which settings of methods are not their defaults, as the tables of episodes tell."""
    told = record.settings
    own: dict[str, dict[str, Any]] = {
        each.method: each.model_dump(mode="json", include={"references", "resize", "precision"})
        for each in told.networks
    }
    own |= {each.method: each.selector for each in told.metrics}
    own |= {} if told.statistics is None else {STATISTICS: told.statistics.model_dump(mode="json")}
    for each in record.scored:
        changed = changed_settings(each.identifier, own.get(each.identifier, {}))
        if changed:
            yield f"{each.label}, not as by default: {changed}"


def _notes(
    records: Sequence[HeldOutScores], partial: _Partial, methods: Sequence[str], absent: Mapping[str, Reason]
) -> Iterator[str]:
    for name in methods:
        if name in absent:
            yield f"{presented(name).label}: {absent[name]}"
    for record in records:
        for each in record.scored:
            if each.failure is not None:
                yield f"{each.label}, {record.scene}: {each.failure}"
            yield from each.notes
    yield from _own_settings(records[0])
    for each in records[0].scored:
        if (ALL, each.identifier) in partial:
            yield f"{each.label}: {partial[ALL, each.identifier]}; no rank"
    if any(each.kind == "references" for each in records[0].scored):
        pairs = ", ".join(f"{record.other_scene} for {record.scene}" for record in records)
        yield f"photographs of another scene are those of {pairs}"


def _listing(scored: Sequence[Scored], numbers: _Numbers, partial: _Partial, absent: Mapping[str, Reason]) -> Listing:
    records: list[tuple[str | int, ...]] = []
    for each in scored:
        for scenes, found in numbers.items():
            for metric in METRICS:
                value = found[each.identifier][metric.identifier]
                texts = (plain(value.mean, _DECIMALS), plain(value.error, _DECIMALS))
                place = (each.identifier, each.label, each.kind, scenes, metric.identifier)
                fewer = partial.get((scenes, each.identifier), "") if metric in (WITHIN, WITHIN_KENDALL) else ""
                records.append((*place, *texts, value.scenes, each.failure or fewer))
    for name, reason in absent.items():
        records.append((name, presented(name).label, "", ALL, "", "", "", 0, str(reason)))
    return Listing(FIELDS, tuple(records))


def _scenes(records: Sequence[HeldOutScores]) -> Listing:
    found = [
        (each.identifier, record.dataset, record.scene, name, value)
        for record in records
        for each in record.scored
        for name, value in scene_numbers(record, each).items()
    ]
    told = tuple((*place, plain(value, _DECIMALS)) for *place, value in found)
    return Listing(SCENE_FIELDS, told, tuple(value for *_, value in found))
