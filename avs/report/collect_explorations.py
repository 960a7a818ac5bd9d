"""Records of explorations read for a table or figure, checked to be comparable."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy.typing as npt

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
    labels = {record.method: record.label for record in records}
    label = labels.get(method, method)
    return f"{label} ({method})" if list(labels.values()).count(label) > 1 else label


def read_maps(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Read ``maps.safetensors`` of an exploration.

    Raises:
        UserError: it is missing or damaged.
    """
    return read_tensors(path, MAPS_HEADER, "run the job that makes it again")[0]


def read_explorations(paths: Sequence[Path]) -> Explorations:
    """Read ``exploration.json`` files, and ``exploration.meta.json`` beside each.

    Raises:
        UserError: none is given; or one is missing, damaged, or was made with another mesh or other settings of the
            robot than others of its building.
    """
    if not paths:
        raise UserError("explorations", "no record", "pass at least one exploration.json")
    cells: dict[Place, ExplorationRecord] = {}
    metas: dict[Place, ExplorationMeta] = {}
    first: dict[str, tuple[Path, object]] = {}
    for path in paths:
        record = read_record(path, ExplorationRecord)
        same = {key: value for key, value in record.settings.items() if key not in ("scorer", "start")}
        told = (record.building_hash, same)
        other, expected = first.setdefault(record.building, (path, told))
        if told != expected:
            fault = f"was made with another mesh or other settings of the robot than {other}"
            raise UserError(path, fault, "run the jobs that make them again")
        place = (record.building, record.method, record.seed)
        cells[place] = record
        metas[place] = read_record(path.with_name("exploration.meta.json"), ExplorationMeta)
    return Explorations(cells, metas)
