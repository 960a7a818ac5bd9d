"""The ranking table of a data set: do a method's scores put the candidates in the order of the truth?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from avs.report.collect_states import StateRecords, read_states
from avs.report.document import Cell, Column, Document, Group, Listing, Row
from avs.report.formats.numbers import plain
from avs.report.formats.writing import write_document
from avs.report.machines import machine_notes
from avs.report.methods import Presented, presented
from avs.report.published import called
from avs.report.tables.arrangement import arranged
from avs.report.tables.changed_settings import changed_settings
from avs.report.tables.episode_notes import grouped_notes
from avs.report.tables.gain_reliability import Reliability, reliability, reliability_listing
from avs.report.tables.reconstruction_facts import with_primitives
from avs.report.tables.score_ranking_numbers import COLUMNS, Ranking, measured_by, summarise_ranking
from avs.report.tables.table_notes import count, spanned, unranked_notes, whole_row
from avs.system.computed_by import ComputedBy
from avs.system.reasons import Reason
from metrics.statistics import ENOUGH_FOR_SPREAD

FIELDS = (
    "method",
    "group",
    "target",
    "statistic",
    "mean",
    "spread",
    "low",
    "high",
    "states",
    "scenes",
    "seeds",
    "note",
)
"""Columns of the csv file."""

STATE_FIELDS = ("method", "target", "statistic", "scene", "seed", "views", "candidates", "value")
"""Columns of the csv file of states."""

MEASUREMENT = "Measurement"
"""Group of the rows that tell how far the gain can be trusted."""

_DECIMALS = 4  # of the csv files

_Numbers = Mapping[str, Mapping[str, Ranking]]


def write_ranking_table(
    records: Sequence[Path], methods: Sequence[str], dataset: str, out: Path, absent: Mapping[str, Reason]
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``, ``_per_state.csv`` and ``_gain.csv``.

    Equal records give equal bytes, whatever their order. How each number is computed is described in
    ``docs/tables.md``.

    Args:
        records: the common states of the data set, one file for each scene and seed.
        methods: see ``score_ranking``.
        dataset: name of the data set.
        out: path of the table without suffix.
        absent: see ``score_ranking``.

    Raises:
        UserError: no records; or one is missing, damaged, of another data set or not comparable with the others.
    """
    write_document(score_ranking(read_states(records, dataset), methods, absent), out)


def score_ranking(records: StateRecords, methods: Sequence[str], absent: Mapping[str, Reason]) -> Document:
    """Return the table of rank correlations between scores and truth.

    Args:
        records: the common states of one data set.
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where it has no
            number.
        absent: why a method has no scores, by identifier.
    """
    numbers = summarise_ranking(records, methods, absent)
    rows = [presented(method) for method in methods]
    columns = tuple(Column(column.metric) for column in COLUMNS)
    cells = {method: _cells(row.values()) for method, row in numbers.items()}
    measured = reliability(records)
    return Document(
        label=f"ranking-{records.dataset}",
        caption=(*_incomplete(records), *_caption(records, measured)),
        columns=columns,
        groups=(*arranged(columns, rows, cells), *_measurement(measured)),
        notes=(*_notes(records, rows, numbers), *unranked_notes(rows)),
        listing=_listing(rows, numbers),
        appendices={"_per_state": _states(rows, numbers), "_gain": reliability_listing(records)},
    )


def _cells(row: Iterable[Ranking]) -> list[Cell]:
    rankings = list(row)
    whole = whole_row(each.missing for each in rankings)
    return [
        Cell(
            each.mean,
            each.spread,
            cause=whole.cause if whole is not None and index == 0 else None,
            ranked=not each.left_out,
        )
        for index, each in enumerate(rankings)
    ]


def _measurement(measured: Reliability | None) -> tuple[Group, ...]:
    """Return the rows that say how far the columns of the gain can be trusted, if it is measured."""
    if measured is None:
        return ()
    retest, bound = [], []
    for column in COLUMNS:
        of_gain = column.target == "gain"
        ranking = measured.retest[column.statistic]
        retest.append(Cell(ranking.mean, ranking.spread) if of_gain else Cell())
        bound.append(Cell(measured.bound if of_gain and column.statistic == "spearman" else None))
    rows = (Row("gain, measured again", tuple(retest)), Row("bound for any score", tuple(bound)))
    return (Group(MEASUREMENT, rows),)


def _caption(records: StateRecords, measured: Reliability | None) -> list[str]:
    states = [state for _, state in records.states]
    views, steps = sorted({state.views for state in states}), sorted({state.iteration for state in states})
    first = next(iter(records.cells.values()))
    kind, order = first.representation.get("kind", "gaussians"), first.settings["order"]
    number = len(states)
    sentences = [
        f"Rank correlation of each method's scores with the truth on the data set {called(records.dataset)}, at "
        f"{count(number, 'common state')}: {count(len(records.scenes), 'scene')} ({', '.join(records.scenes)}), "
        f"{count(len(records.seeds), 'seed')} ({', '.join(map(str, records.seeds))}), "
        f"{', '.join(map(str, views))} captured views after {', '.join(map(str, steps))} iterations, "
        f"{spanned((len(state.candidates) for state in states), 'candidate')} a state; representation: "
        f"{with_primitives([kind], (state.primitives for state in states))}.",
        f"At each state all methods score the same candidates of the same reconstruction, whose views are captured in "
        f"{'random order' if order == 'random' else 'the order of farthest-view sampling'}.",
        "One means that the method would take the candidates in the very order of the truth: lowest SSIM or PSNR "
        "against the hidden photograph first, or highest gain in test PSNR first; zero means no relation.",
    ]
    if number >= ENOUGH_FOR_SPREAD:
        sentences.append(
            f"After the plus-minus sign: standard deviation over the {number} states; states of one scene are alike, "
            "so that it does not tell how the mean would differ on other scenes."
        )
    return sentences + ([] if measured is None else _reliability(measured, number))


def _reliability(measured: Reliability, states: int) -> list[str]:
    retest = measured.retest["spearman"]
    if measured.bound is None or measured.of_mean is None or retest.mean is None:
        return [f"The gain was measured twice, without a correlation of the two: {retest.missing}."]
    return [
        "The gain is the mean of two measurements with independent random streams, whose Spearman correlation is "
        f"{retest.mean:.2f} (mean of {count(states, 'state')}); for the mean of both that makes a reliability of "
        f"{measured.of_mean:.2f} (Spearman-Brown), and no score can be expected to correlate with it by more than the "
        f"root, {measured.bound:.2f}."
    ]


def _incomplete(records: StateRecords) -> list[str]:
    if not records.missing:
        return []
    total = len(records.cells) + len(records.missing)
    verb = "is" if len(records.missing) == 1 else "are"
    return [f"Incomplete: {len(records.missing)} of {total} records of common states {verb} missing."]


def _notes(records: StateRecords, rows: Sequence[Presented], numbers: _Numbers) -> list[str]:
    first = next(iter(records.cells.values()))
    lines = [f"{scene} with seed {seed}: {why}" for (scene, seed), why in records.missing.items()]
    notes = ((scene, note) for (scene, _), record in records.cells.items() for note in record.notes)
    lines += grouped_notes(notes, records.scenes)
    lines += machine_notes(records.paths, ComputedBy, "records of common states")
    if any(state.gains is not None for _, state in records.states):
        sampled = first.settings["gain_candidates"]
        lines.append(
            f"gain: of {'all' if sampled is None else f'{sampled} random'} candidates; a copy fitted with the "
            f"candidate against a copy fitted without it, until each view was used "
            f"{_times(first.settings['gain_passes'])}; twice, with independent orders of the views"
        )
    lines += _of_gain(rows, numbers)
    for row in rows:
        scored = list(records.of_method(row.identifier).values())
        lines += [note for each in scored for note in each.notes]
        changed = dict.fromkeys(changed_settings(row.identifier, each.selector) for each in scored)
        lines += [f"{row.label}, not as by default: {told}" for told in changed if told]
        if any(each.own_fit for each in scored):
            lines.append(
                f"{row.label}: scores a twin of the reconstruction, fitted its way on the same views; the truth is "
                "that of the common one"
            )
        lines += _missing(row, numbers[row.identifier])
    return list(dict.fromkeys(lines))


def _of_gain(rows: Sequence[Presented], numbers: _Numbers) -> Iterator[str]:
    """Say that an oracle of the gain stands for that of the states, which its episodes do not choose by."""
    first = COLUMNS[0].metric.identifier
    for row in rows:
        if measured_by(row.identifier) == "gain" and numbers[row.identifier][first].missing is None:
            yield (
                f"{row.label}: the gain that these states measure, in test PSNR; its episodes choose by one of their "
                f"own, whose passes and metric are those of its settings (selectors.{row.identifier})"
            )


def _missing(row: Presented, ranking: Mapping[str, Ranking]) -> list[str]:
    """Say why cells of a row are empty or leave states out, each reason once with its columns."""
    columns: dict[str, list[str]] = {}
    for column in COLUMNS:
        each = ranking[column.metric.identifier]
        for line in [str(each.missing)] if each.missing is not None else _left_out(each):
            columns.setdefault(line, []).append(column.metric.name)
    places = {line: "" if len(names) == len(COLUMNS) else f" ({'; '.join(names)})" for line, names in columns.items()}
    missing = {str(each.missing) for each in ranking.values()}
    ends = {line: "" if line in missing else "; no rank" for line in places}
    return [f"{row.label}{place}: {line}{ends[line]}" for line, place in places.items()]


def _left_out(ranking: Ranking) -> list[str]:
    return [f"{count(number, 'state')} left out, {reason}" for reason, number in ranking.left_out.items()]


def _times(number: int) -> str:
    return "once" if number == 1 else f"{number} times"


def _listing(rows: Sequence[Presented], numbers: _Numbers) -> Listing:
    """Return one record for each method and correlation in the order of the table."""
    records: list[tuple[str | int, ...]] = []
    for row in rows:
        for column in COLUMNS:
            each = numbers[row.identifier][column.metric.identifier]
            cells = {state.cell for state in each.defined}
            counts = (len(each.defined), len({scene for scene, _ in cells}), len({seed for _, seed in cells}))
            note = "; ".join(_left_out(each)) if each.missing is None else str(each.missing)
            ends = (None, None) if each.interval is None else (each.interval.low, each.interval.high)
            values = (plain(value, _DECIMALS) for value in (each.mean, each.spread, *ends))
            records.append((row.identifier, row.group, column.target, column.statistic, *values, *counts, note))
    return Listing(FIELDS, tuple(records))


def _states(rows: Sequence[Presented], numbers: _Numbers) -> Listing:
    """Return one record for each method, correlation and state; an undefined correlation is empty."""
    records: list[tuple[str | int, ...]] = [
        (
            row.identifier,
            column.target,
            column.statistic,
            *state.cell,
            state.views,
            state.candidates,
            plain(state.correlation.value, _DECIMALS),
        )
        for row in rows
        for column in COLUMNS
        for state in numbers[row.identifier][column.metric.identifier].states
    ]
    return Listing(STATE_FIELDS, tuple(records))
