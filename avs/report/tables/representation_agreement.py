"""The table `agnostic` of a data set: do methods come in the same order whatever the scene is reconstructed with?"""

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
from avs.report.tables.representation_agreement_numbers import (
    FEWEST_SCENES,
    METRICS,
    OrderAgreement,
    metric_means,
    order_agreements,
)
from avs.report.tables.setting_sensitivity_numbers import Agreement, Standing, agreement, standings
from avs.report.tables.table_notes import count, unranked_notes
from avs.system.errors import UserError
from avs.system.reasons import Reason
from metrics.definitions import Metric

FIELDS = ("representation", "kind", "method", "group", *METRICS, "rank", "scenes", "seeds", "note")
"""Columns of the csv file."""

AGREEMENT_FIELDS = ("first", "second", "kendall", "low", "high", "chance", "methods", "note")
"""Columns of the csv file of how the orders agree."""

_DECIMALS = 4  # of the csv files
_SHOWN = {"psnr": ("PSNR", True, 2, "dB"), "ssim": ("SSIM", True, 3, ""), "lpips": ("LPIPS", False, 3, "")}

_Means = Mapping[str, Mapping[str, Mapping[str, float | None]]]


def write_agnostic_table(
    records: Mapping[str, Sequence[Path]],
    methods: Sequence[str],
    dataset: str,
    out: Path,
    absent: Mapping[str, Mapping[str, Reason]],
) -> None:
    """Write ``out`` with ``.csv``, ``.md`` and ``.tex``, ``_agreement.csv`` and ``_per_episode.csv``.

    Args:
        records: ``episode.json`` files on each representation, by its name.
        methods: identifiers of the methods, in the order of rows.
        dataset: name of the data set.
        out: path of the table without suffix.
        absent: why a method could not run, by representation and method.

    Raises:
        UserError: a record is missing, damaged, of another data set, or cannot be compared with the others.
    """
    found = read_columns(records, methods, dataset)
    write_document(representation_agreement(found, methods, dataset, absent), out)


def representation_agreement(
    episodes: Mapping[str, Episodes],
    methods: Sequence[str],
    dataset: str,
    absent: Mapping[str, Mapping[str, Reason]],
) -> Document:
    """Return the table of means on each representation, and of how far the orders of the methods agree.

    Args:
        episodes: on each representation, by its name.
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where a number is
            missing.
        dataset: name of the data set.
        absent: why a method could not run, by representation and method.

    Raises:
        UserError: they were run on other versions of the scenes, with other loops, or one name has two representations.
    """
    _check_comparable(episodes)
    grid = places_of(episodes)
    shown = {method: presented_in_columns(method, episodes.values()) for method in methods}
    found = {name: standings(each, list(shown.values()), grid, absent.get(name, {})) for name, each in episodes.items()}
    means = {
        name: {method: _known(each, method, grid, found[name]) for method in methods} for name, each in episodes.items()
    }
    within = {name: agreement(each, each) for name, each in found.items()}
    orders = order_agreements(episodes, found, grid)
    columns = tuple(column for name in episodes for column in _columns(name))
    cells = {
        method: [cell for name in episodes for cell in _cells(found[name][method], means[name][method])]
        for method in methods
    }
    records = [path for each in episodes.values() for path in each.records]
    return Document(
        label=f"agnostic-{dataset}",
        caption=(*incomplete(found), *_caption(dataset, grid, episodes)),
        columns=columns,
        groups=(*arranged(columns, list(shown.values()), cells), _order(found, within, orders)),
        notes=(
            *_notes(shown, found, orders, within),
            *_not_measured(episodes),
            *column_differences(episodes),
            *told_by_columns(episodes, list(shown.values())),
            *machine_notes(records),
        ),
        listing=_listing(episodes, shown, found, means, grid),
        appendices={"_agreement": _agreement_listing(orders), PER_EPISODE: single_values(episodes, methods)},
    )


def _check_comparable(episodes: Mapping[str, Episodes]) -> None:
    """Refuse episodes of other versions of a scene, of other loops, or of several representations under one name."""
    check_scenes(episodes)
    loop: dict[str, tuple[object, ...]] = {}
    for name, each in episodes.items():
        for episode in each.all:
            told = tuple(episode.protocol.get(key) for key in ("iterations", "budget", "initial_views"))
            if loop.setdefault("loop", told) != told:
                fault = "was run with another budget, start or number of iterations than others"
                raise UserError(f"{name}, {episode.method}", fault, "run all of them again")
            kind = (sorted(map(str, episode.representation.items())),)
            if loop.setdefault(name, kind) != kind:
                raise UserError(f"{name}, {episode.method}", "has another representation than others", "run all again")


def _known(
    episodes: Episodes, method: str, grid: Sequence[Place], standing: Mapping[str, Standing]
) -> dict[str, float | None]:
    """Return the means of a method that has all of its episodes."""
    return dict.fromkeys(METRICS) if standing[method].missing else metric_means(episodes, method, grid)


def _columns(name: str) -> list[Column]:
    told = "mean over scenes and seeds"
    metrics = [
        Metric(metric, f"{name}: {label}", up, places, unit, told)
        for metric, (label, up, places, unit) in _SHOWN.items()
    ]
    return [Column(each) for each in (*metrics, Metric("rank", f"{name}: rank", None, 0, "", "by the unrounded PSNR"))]


def _cells(standing: Standing, means: Mapping[str, float | None]) -> list[Cell]:
    cause = None if standing.missing is None else standing.missing.cause
    ranked = standing.rank is not None
    values = [Cell(means[metric], cause=cause if metric == "psnr" else None, ranked=ranked) for metric in METRICS]
    return [*values, Cell(None if standing.rank is None else float(standing.rank))]


def _order(found: Standings, within: Mapping[str, Agreement], orders: Sequence[OrderAgreement]) -> Group:
    """Return the rows that compare the order on each representation with that on the others, and with chance."""
    taus = {(each.first, each.second): each.tau.value for each in orders}
    blank = [Cell(), Cell(), Cell()]
    rows = []
    for other in found:
        cells = []
        for name in found:
            value = None if name == other else taus.get((name, other), taus.get((other, name)))
            cells += [Cell(value), *blank]
        rows.append(Row(f"Kendall's tau with {other}", tuple(cells)))
    seeds = [cell for name in found for cell in (Cell(within[name].between_seeds.value), *blank)]
    rows.append(Row("tau between single seeds", tuple(seeds)))
    return Group("Order of the methods by PSNR", tuple(rows))


def _caption(dataset: str, grid: Sequence[Place], episodes: Mapping[str, Episodes]) -> list[str]:
    scenes, seeds = dict.fromkeys(scene for scene, _ in grid), dict.fromkeys(seed for _, seed in grid)
    return [
        f"The same methods on several representations of the data set {called(dataset)} ({', '.join(episodes)}): "
        f"{count(len(scenes), 'scene')} ({', '.join(scenes)}), {count(len(seeds), 'seed')} "
        f"({', '.join(map(str, seeds))}), the same views to choose from and the same number of them.",
        *column_facts(episodes),
        "Kendall's tau is 1 where two representations put the methods in one order by their mean PSNR, 0 where the "
        "orders are unrelated; tau between single seeds, of one representation, tells what noise leaves of an order.",
    ]


def _notes(
    shown: Mapping[str, Presented],
    found: Standings,
    orders: Sequence[OrderAgreement],
    within: Mapping[str, Agreement],
) -> list[str]:
    lines = missing_means(list(shown.values()), found)
    lines += [_told(each) for each in orders]
    seeds = {each.between_seeds.reason for each in within.values() if each.between_seeds.value is None}
    lines += [f"no tau between single seeds: {why}".replace("candidates", "methods") for why in sorted(map(str, seeds))]
    return [*dict.fromkeys(lines), *unranked_notes(list(shown.values()))]


def _not_measured(episodes: Mapping[str, Episodes]) -> list[str]:
    """Return why records lack a metric that the table has."""
    told = [
        f"{_SHOWN[metric][0]}: {why}"
        for each in episodes.values()
        for episode in each.all
        for metric, why in episode.absent.items()
        if metric in _SHOWN
    ]
    return list(dict.fromkeys(told))


def _told(each: OrderAgreement) -> str:
    """Return the line about two representations: tau with its uncertainty, or why there is none."""
    pair = f"{each.first} and {each.second}"
    if each.tau.value is None:
        return f"{pair}: no tau: {each.tau.reason}".replace("candidates", "methods")
    interval = f"no interval of fewer than {FEWEST_SCENES} scenes"
    if each.interval is not None:
        interval = f"95 % of resampled scenes and seeds lie in {each.interval[0]:.2f} to {each.interval[1]:.2f}"
    told = f"tau {each.tau.value:.2f} of {count(each.methods, 'method')}; {interval}"
    return f"{pair}: {told}; unrelated orders agree so or better with probability {each.chance:.3f}"


def _listing(
    episodes: Mapping[str, Episodes],
    shown: Mapping[str, Presented],
    found: Standings,
    means: _Means,
    grid: Sequence[Place],
) -> Listing:
    counts = (len({scene for scene, _ in grid}), len({seed for _, seed in grid}))
    records: list[tuple[str | int, ...]] = []
    for name, each in episodes.items():
        kind = next((str(episode.representation.get("kind", "")) for episode in each.all), "")
        for method, row in shown.items():
            standing, values = found[name][method], means[name][method]
            rank = "" if standing.rank is None else standing.rank
            note = "" if standing.missing is None else str(standing.missing)
            covered = (0, 0) if standing.mean is None else counts
            numbers = (plain(values[metric], _DECIMALS) for metric in METRICS)
            records.append((name, kind, method, row.group, *numbers, rank, *covered, note))
    return Listing(FIELDS, tuple(records))


def _agreement_listing(orders: Sequence[OrderAgreement]) -> Listing:
    records: list[tuple[str | int, ...]] = []
    for each in orders:
        low, high = each.interval or (None, None)
        numbers = (plain(value, _DECIMALS) for value in (each.tau.value, low, high, each.chance))
        note = (each.tau.reason or "").replace("candidates", "methods")
        records.append((each.first, each.second, *numbers, each.methods, note))
    return Listing(AGREEMENT_FIELDS, tuple(records))
