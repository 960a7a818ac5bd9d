"""The sensitivity table of a data set: does the order of the methods depend on the settings of the reconstruction?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.report.collect import Cell as Place
from avs.report.collect import Episodes
from avs.report.document import Cell, Column, Document, Group, Listing, Row
from avs.report.formats.numbers import plain
from avs.report.formats.writing import write_document
from avs.report.machines import machine_notes
from avs.report.methods import Presented, presented_in_columns
from avs.report.published import called
from avs.report.report_settings import BASE
from avs.report.tables.arrangement import arranged
from avs.report.tables.episode_columns import (
    PER_EPISODE,
    Standings,
    check_scenes,
    incomplete,
    missing_means,
    places_of,
    read_columns,
    single_values,
    told_by_columns,
)
from avs.report.tables.reconstruction_facts import column_differences, column_facts
from avs.report.tables.setting_sensitivity_numbers import Agreement, Standing, agreement, standings
from avs.report.tables.table_notes import count, unranked_notes
from avs.system.reasons import Reason
from metrics.definitions import Metric

FIELDS = ("setting", "method", "group", "psnr", "rank", "scenes", "seeds", "note")
"""Columns of the csv file."""

AGREEMENT_FIELDS = ("setting", "kendall_with_base", "methods", "kendall_between_seeds", "noise", "note")
"""Columns of the csv file of how the orders agree."""

ORDER = "Order of the methods"
"""Group of the rows that compare the columns."""

_DECIMALS = 4  # of the csv files


def write_sensitivity_table(
    base: Sequence[Path],
    varied: Mapping[str, Sequence[Path]],
    methods: Sequence[str],
    dataset: str,
    out: Path,
    absent: Mapping[str, Reason],
) -> None:
    """Write ``out`` with ``.csv``, ``.md`` and ``.tex``, ``_agreement.csv`` and ``_per_episode.csv``.

    Args:
        base: ``episode.json`` files of the run's own settings.
        varied: those of each variant of the settings, by its name.
        methods: identifiers of the methods, in the order of rows.
        dataset: name of the data set.
        out: path of the table without suffix.
        absent: why a method could not run, by identifier.

    Raises:
        UserError: a record is missing, damaged, of another data set, or cannot be compared with the others.
    """
    own = read_columns({BASE: base}, methods, dataset)[BASE]
    others = read_columns(varied, methods, dataset)
    write_document(setting_sensitivity(own, others, methods, absent), out)


def setting_sensitivity(
    base: Episodes, varied: Mapping[str, Episodes], methods: Sequence[str], absent: Mapping[str, Reason]
) -> Document:
    """Return the table of means and ranks under the run's own settings and under each variant.

    Args:
        base: episodes of the run's own settings.
        varied: those of each variant, by its name.
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where a number is
            missing.
        absent: why a method could not run, by identifier.

    Raises:
        UserError: the variants were run on other versions of the scenes.
    """
    settings = {BASE: base, **varied}
    check_scenes(settings)
    grid = places_of(settings)
    rows = [presented_in_columns(method, [base]) for method in methods]
    records = [path for episodes in settings.values() for path in episodes.records]
    found = {name: standings(episodes, rows, grid, absent) for name, episodes in settings.items()}
    agreements = {name: agreement(found[BASE], each) for name, each in found.items()}
    columns = tuple(column for name in settings for column in _columns(name))
    cells = {method: [cell for each in found.values() for cell in _cells(each[method])] for method in methods}
    return Document(
        label=f"sensitivity-{base.dataset}",
        caption=(*incomplete(found), *_caption(base.dataset, grid, settings)),
        columns=columns,
        groups=(*arranged(columns, rows, cells), _order(agreements)),
        notes=(
            *_notes(rows, found, agreements),
            *column_differences(settings),
            *told_by_columns(settings, rows),
            *machine_notes(records),
        ),
        listing=_listing(rows, found, grid),
        appendices={"_agreement": _agreement_listing(agreements), PER_EPISODE: single_values(settings, methods)},
    )


def _columns(name: str) -> tuple[Column, Column]:
    return (
        Column(Metric("psnr", f"{name}: PSNR", True, 2, "dB", "mean over scenes, then over seeds")),
        Column(Metric("rank", f"{name}: rank", None, 0, "", "by the unrounded mean")),
    )


def _cells(standing: Standing) -> list[Cell]:
    cause = None if standing.missing is None else standing.missing.cause
    mean = Cell(standing.mean, cause=cause, ranked=standing.rank is not None)
    return [mean, Cell(None if standing.rank is None else float(standing.rank))]


def _order(agreements: Mapping[str, Agreement]) -> Group:
    """Return the rows that compare the order of each column with that of the first, and with chance."""
    tau, seeds, noise = [], [], []
    for name, each in agreements.items():
        tau += [Cell(None if name == BASE else each.with_base.value), Cell()]
        seeds += [Cell(each.between_seeds.value), Cell()]
        noise += [Cell(each.noise), Cell()]
    rows = (
        Row("Kendall's tau with base", tuple(tau)),
        Row("tau between single seeds", tuple(seeds)),
        Row("noise of one seed (dB)", tuple(noise)),
    )
    return Group(ORDER, rows)


def _caption(dataset: str, grid: Sequence[Place], settings: Mapping[str, Episodes]) -> list[str]:
    scenes, seeds = dict.fromkeys(scene for scene, _ in grid), dict.fromkeys(seed for _, seed in grid)
    return [
        f"Test PSNR and rank of each method on the data set {called(dataset)} under the settings of the run "
        f"({BASE}) and under variants of them ({', '.join(name for name in settings if name != BASE)}): "
        f"{count(len(scenes), 'scene')} "
        f"({', '.join(scenes)}), {count(len(seeds), 'seed')} ({', '.join(map(str, seeds))}).",
        *column_facts(settings),
        "Kendall's tau is 1 where a variant puts the methods in the order of the run, 0 where they are unrelated.",
        "Two rows tell what is noise: tau between single seeds, of the same settings, and the standard deviation over "
        "seeds of a mean over scenes, pooled over methods; that of a printed mean is smaller by the root of the number "
        "of seeds.",
    ]


def _notes(rows: Sequence[Presented], found: Standings, agreements: Mapping[str, Agreement]) -> list[str]:
    lines = missing_means(rows, found)
    for name, each in agreements.items():
        lines += [f"{name}, {fault}" for fault in _undefined(name, each)]
        if name != BASE and each.methods < agreements[BASE].methods and each.with_base.value is not None:
            lines.append(f"{name}: tau compares {each.methods} of {agreements[BASE].methods} methods")
    return [*dict.fromkeys(lines), *unranked_notes(rows)]


def _undefined(name: str, each: Agreement) -> list[str]:
    faults = [] if name == BASE else [("tau with base", each.with_base)]
    faults.append(("tau between single seeds", each.between_seeds))
    return [
        f"no {what}: {found.reason}".replace("candidates", "methods") for what, found in faults if found.value is None
    ]


def _listing(rows: Sequence[Presented], found: Standings, grid: Sequence[Place]) -> Listing:
    counts = (len({scene for scene, _ in grid}), len({seed for _, seed in grid}))
    records: list[tuple[str | int, ...]] = []
    for name, each in found.items():
        for row in rows:
            standing = each[row.identifier]
            rank = "" if standing.rank is None else standing.rank
            note = "" if standing.missing is None else str(standing.missing)
            covered = (0, 0) if standing.mean is None else counts
            records.append((name, row.identifier, row.group, plain(standing.mean, _DECIMALS), rank, *covered, note))
    return Listing(FIELDS, tuple(records))


def _agreement_listing(agreements: Mapping[str, Agreement]) -> Listing:
    records: list[tuple[str | int, ...]] = []
    for name, each in agreements.items():
        tau = None if name == BASE else each.with_base.value
        numbers = (plain(each.between_seeds.value, _DECIMALS), plain(each.noise, _DECIMALS))
        note = "; ".join(_undefined(name, each))
        records.append((name, plain(tau, _DECIMALS), each.methods, *numbers, note))
    return Listing(AGREEMENT_FIELDS, tuple(records))
