"""Records of explorations read for a table or figure, checked to be comparable."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy.typing as npt

from avs.report.labels import told_apart
from avs.slam.loop.exploration_record import MAPS_HEADER, ExplorationMeta, ExplorationRecord
from avs.system.errors import UserError
from avs.system.records import read_record
from avs.system.tensor_files import read_tensors

Place = tuple[str, str, int]
"""Building, method and seed."""

ORACLES = frozenset({"oracle"})
"""Kinds of choosers that know the building: upper references without a rank."""


@dataclass(frozen=True)
class Explorations:
    """What a run has explored.

    Attributes:
        cells: records by building, method and seed.
        metas: what differs from run to run, by the same.
        missing: why a record that an unfinished run asks for is not there, by the same.
    """

    cells: Mapping[Place, ExplorationRecord]
    metas: Mapping[Place, ExplorationMeta]
    missing: Mapping[Place, str] = field(default_factory=dict)

    def of(self, building: str, method: str) -> list[ExplorationRecord]:
        """Return the records of a method in a building, by seed."""
        return [record for place, record in sorted(self.cells.items()) if place[:2] == (building, method)]

    def chose(self, building: str, method: str) -> bool:
        """Return whether a method has chosen a path in a building; until then the robot does what it does for all."""
        return any(record.decisions for record in self.of(building, method))

    def label(self, method: str) -> str:
        """Return the printed name of a method, its identifier where it has no record.

        Where several have the same, such as one method with two settings, its identifier is beside it.
        """
        return printed_name(method, self.cells.values())

    def ranked(self, method: str) -> bool:
        """Return whether a method competes."""
        kinds = {record.settings["scorer"]["kind"] for place, record in self.cells.items() if place[1] == method}
        return not kinds & ORACLES


def printed_name(method: str, records: Iterable[ExplorationRecord]) -> str:
    """Return the label of a method among ``records``, with its identifier where several have the same."""
    return told_apart({record.method: record.label for record in records}).get(method, method)


def read_maps(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Read ``maps.safetensors`` of an exploration.

    Raises:
        UserError: it is missing or damaged.
    """
    return read_tensors(path, MAPS_HEADER, "run the job that makes it again")[0]


def read_explorations(paths: Sequence[Path]) -> Explorations:
    """Read ``exploration.json`` files, and ``exploration.meta.json`` beside each.

    Raises:
        UserError: none is given; or one is missing, damaged, repeats another or cannot be compared with the others.
    """
    if not paths:
        raise UserError("explorations", "no record", "pass at least one exploration.json")
    records = {path: read_record(path, ExplorationRecord) for path in paths}
    check_comparable(records)
    found: dict[Place, Path] = {}
    for path in paths:
        place = (records[path].building, records[path].method, records[path].seed)
        if place in found:
            raise UserError(path, f"repeats {found[place]}", "pass one record for each building, method and seed")
        found[place] = path
    metas = {
        place: read_record(path.with_name("exploration.meta.json"), ExplorationMeta) for place, path in found.items()
    }
    return Explorations({place: records[path] for place, path in found.items()}, metas)


def check_comparable(records: Mapping[Path, ExplorationRecord]) -> None:
    """Refuse records that do not belong in one table or figure, in whatever order they come.

    Args:
        records: by the file that each was read from.

    Raises:
        UserError: one is of another mesh of its building, another robot than others, another start than others of its
            building and seed, or other settings of what chooses the paths than others of its method.
    """
    first: dict[Hashable, tuple[Path, object]] = {}
    for path, record in records.items():
        robot = {key: value for key, value in record.settings.items() if key not in ("scorer", "start")}
        for among, told, fault in (
            ("robot", robot, "was made with other settings of the robot"),
            (("mesh", record.building), record.building_hash, "was made with another mesh"),
            (("start", record.building, record.seed), record.start, "started at another place"),
            (("scorer", record.method), record.settings["scorer"], "chose its paths with other settings"),
        ):
            other, expected = first.setdefault(among, (path, told))
            if told != expected:
                raise UserError(path, f"{fault} than {other}", "run the jobs that make them again")
