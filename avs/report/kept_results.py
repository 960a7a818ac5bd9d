"""The results of a measured run that are kept with the project, and how far another run is from them.

Compared are the single values from which the tables are computed: those of episodes, states and explorations. What
takes time differs between any two runs and is not compared.
"""

from __future__ import annotations

import csv
import shutil
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import Field

from avs.nvs.record import EpisodeMeta
from avs.report.machines import machine_notes
from avs.system.errors import UserError
from avs.system.files import atomic_folder
from avs.system.models import StrictModel
from avs.system.records import read_record, write_record

ABOUT = "reference.json"
"""What a kept run was; ``ReferenceRun``."""

_SINGLE = ("_per_scene.csv", "_per_state.csv", "_per_run.csv", "_per_episode.csv")
_VALUE = "value"
_OF_TIME = "seconds"

TOLERANCES = {"psnr": 0.5, "ssim": 0.02}
"""Largest root mean square of the differences of a table's single values where bits need not be the same.

Between two kinds of processor, before there were portable numerics, the rows of one table were 0.14 dB apart; a single
episode differs by twice to three times as much as the mean over scenes and seeds.
"""


class ReferenceRun(StrictModel):
    """Which run the kept tables and figures are of."""

    command: str = Field(description="what was called in a fresh clone")
    revisions: tuple[str, ...] = Field(description="git revisions of the episodes, + where files were changed")
    machine: dict[str, str] = Field(description="processor, cores, operating system, numerics of the first episode")
    packages: dict[str, str] = Field(description="versions of what takes part in a computation")
    notes: tuple[str, ...] = Field(description="what differed between the episodes")
    first: str = Field(description="begin of the first episode, UTC")
    last: str = Field(description="end of the last episode, UTC")


@dataclass(frozen=True)
class Deviation:
    """How far the values of one metric in one file are from those of the reference."""

    file: str
    metric: str
    compared: int
    differing: int
    root_mean_square: float
    largest: float
    lacking: int = 0

    def line(self) -> str:
        """Return it in words."""
        told = f"{self.file}, {self.metric}: {self.differing} of {self.compared} values differ"
        if self.differing:
            told += f", by {self.root_mean_square:.3g} (root mean square), {self.largest:.3g} at most"
        return f"{told}; {self.lacking} are not there" if self.lacking else told


def keep(results: Path, episodes: Sequence[Path], folder: Path, command: str, figures: Sequence[str]) -> None:
    """Copy the tables of a finished run, as csv and md, and some of its figures, with what the run was.

    Args:
        results: folder of the run.
        episodes: the records of its episodes.
        folder: where the copy goes.
        command: that made the run.
        figures: names of figures.

    Raises:
        UserError: the folder holds no tables or no episodes, or a figure is not there.
    """
    tables = sorted(path for path in (results / "tables").glob("*") if path.suffix in (".csv", ".md"))
    if not tables:
        raise UserError(results / "tables", "holds no tables", "make them first")
    drawn = [results / "figures" / name for name in figures]
    missing = next((path for path in drawn if not path.is_file()), None)
    if missing is not None:
        raise UserError(missing, "is not there", "name a figure of this run")
    about = _about(results, episodes, command)
    with atomic_folder(folder) as whole:
        for name, files in (("tables", tables), ("figures", drawn)):
            (whole / name).mkdir()
            for path in files:
                shutil.copyfile(path, whole / name / path.name)
        write_record(whole / ABOUT, about)


def _about(results: Path, episodes: Sequence[Path], command: str) -> ReferenceRun:
    if not episodes:
        raise UserError(results, "holds no episodes", "run them first")
    metas = [read_record(path.with_name("episode.meta.json"), EpisodeMeta) for path in episodes]
    return ReferenceRun(
        command=command,
        revisions=tuple(sorted({meta.revision or "unknown" for meta in metas})),
        machine=metas[0].machine,
        packages=metas[0].packages,
        notes=tuple(machine_notes(episodes)),
        first=min(meta.started for meta in metas),
        last=max(meta.finished for meta in metas),
    )


def same_bits(results: Path, episodes: Sequence[Path], folder: Path) -> bool:
    """Return whether a run should end in the bits of the reference: portable numerics and equal packages in both.

    Args:
        results: folder of the run.
        episodes: the records of its episodes.
        folder: of the reference.

    Raises:
        UserError: there is no reference, one of them is damaged, or the run has no episodes.
    """
    if not (folder / ABOUT).is_file():
        raise UserError(folder, "holds no results that were kept", "name the folder of some with --folder")
    kept, found = read_record(folder / ABOUT, ReferenceRun), _about(results, episodes, "")
    portable = all(run.machine.get("numerics") == "portable" and not run.notes for run in (kept, found))
    return portable and kept.packages == found.packages


def deviations(results: Path, folder: Path) -> Iterator[Deviation]:
    """Yield how far a run is from the reference, by file and metric, for all values that the reference has.

    Raises:
        UserError: a file is not such a table.
    """
    for path in sorted((folder / "tables").glob("*.csv")):
        other = results / "tables" / path.name
        if not path.name.endswith(_SINGLE):
            continue
        kept, found = _values(path), _values(other) if other.is_file() else {}
        pairs, lacking = defaultdict(list), Counter(key[0] for key in kept.keys() - found.keys())
        for key in kept.keys() & found.keys():
            pairs[key[0]].append((kept[key], found[key]))
        for metric in sorted({key[0] for key in kept}):
            expected, measured = np.array(pairs[metric], dtype=np.float64).reshape(-1, 2).T
            # a value that is no number on one side alone is infinitely far from what should be there
            same = (measured == expected) | (np.isnan(measured) & np.isnan(expected))
            apart = np.where(same, 0.0, np.nan_to_num(np.abs(measured - expected), nan=np.inf))
            square = float(np.sqrt(np.mean(apart**2))) if len(apart) else 0.0
            largest = float(apart.max(initial=0))
            counts = len(apart), int((~same).sum())
            yield Deviation(path.name, metric, *counts, square, largest, lacking[metric])


def not_compared(folder: Path) -> list[str]:
    """Return the tables of a reference of which no single values are kept, so that nothing is compared of them."""
    names = sorted(path.stem for path in (folder / "tables").glob("*.md"))
    compared = [path.name for path in (folder / "tables").glob("*.csv") if path.name.endswith(_SINGLE)]
    return [name for name in names if not any(each.removeprefix(name) in _SINGLE for each in compared)]


def is_too_far(deviation: Deviation, bits: bool) -> bool:
    """Return whether a deviation is a fault: any where the bits should be the same, else one beyond ``TOLERANCES``.

    So is a value that is not there: a run that lacks some confirms nothing.
    """
    if deviation.lacking:
        return True
    if bits:
        return deviation.differing > 0
    return deviation.root_mean_square > TOLERANCES.get(deviation.metric, np.inf)


def _values(path: Path) -> dict[tuple[str, ...], float]:
    """Return the values of a table that are there, by metric and all else that names them."""
    with path.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    try:
        named = [(dict(row), row.pop(_VALUE)) for row in rows]
        return {_key(row): float(value) for row, value in named if value and _OF_TIME not in _metric(row)}
    except (KeyError, ValueError) as error:
        raise UserError(path, f"is no table of single values ({error})", "make it again") from error


def _metric(row: dict[str, str]) -> str:
    return row.get("metric") or f"{row['target']} ({row['statistic']})"


def _key(row: dict[str, str]) -> tuple[str, ...]:
    names = (name for name in row if name not in (_VALUE, "metric"))
    return _metric(row), *(row[name] for name in sorted(names))
