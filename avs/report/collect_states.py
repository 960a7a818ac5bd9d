"""Records of common states read for a table, checked to be comparable."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from avs.nvs.common_states_record import CommonState, CommonStates, ScoredMethod
from avs.report.collect import Cell
from avs.system.errors import UserError
from avs.system.records import read_record


@dataclass(frozen=True)
class StateRecords:
    """The records of one data set, at most one for each scene and seed.

    Attributes:
        dataset: name of the data set.
        cells: by scene and seed, ascending.
        missing: why a record that the run asks for is not there, by scene and seed; empty where the run is complete or
            nothing is known of it.
        paths: the files.
    """

    dataset: str
    cells: dict[Cell, CommonStates]
    missing: Mapping[Cell, str] = field(default_factory=dict)
    paths: Sequence[Path] = ()

    @property
    def scenes(self) -> list[str]:
        """The scenes, ascending."""
        return sorted({scene for scene, _ in self.cells})

    @property
    def seeds(self) -> list[int]:
        """The seeds, ascending."""
        return sorted({seed for _, seed in self.cells})

    @property
    def states(self) -> Iterator[tuple[Cell, CommonState]]:
        """Every state with its scene and seed."""
        return ((cell, state) for cell, record in self.cells.items() for state in record.states)

    def of_method(self, method: str) -> dict[Cell, ScoredMethod]:
        """Return what the records have of a method, by scene and seed."""
        found = {cell: _scored(record, method) for cell, record in self.cells.items()}
        return {cell: scored for cell, scored in found.items() if scored is not None}


def read_states(paths: Sequence[Path], dataset: str) -> StateRecords:
    """Read the records at ``paths``, which are all of one data set.

    Raises:
        UserError: no path is given; a record is missing or does not follow the schema, repeats another, is of another
            data set, or cannot be compared with the others.
    """
    if not paths:
        raise UserError("common states", "none given", "pass at least one record")
    places: dict[Cell, Path] = {}
    cells: dict[Cell, CommonStates] = {}
    for path in paths:
        record = read_record(path, CommonStates)
        cell = (record.scene, record.seed)
        if record.dataset != dataset:
            raise UserError(path, f"is of the data set {record.dataset}", f"pass records of {dataset} only")
        if cell in places:
            raise UserError(path, f"repeats {places[cell]}", "pass one record for each scene and seed")
        places[cell], cells[cell] = path, record
    first = next(iter(cells.values()))
    hashes: dict[str, str] = {}
    for cell, record in cells.items():
        _check_comparable(places[cell], record, first, hashes.setdefault(record.scene, record.scene_hash))
    return StateRecords(dataset, dict(sorted(cells.items())), paths=tuple(paths))


def _scored(record: CommonStates, method: str) -> ScoredMethod | None:
    return next((scored for scored in record.methods if scored.method == method), None)


def _weights(record: CommonStates) -> dict[str, str | None]:
    return {scored.method: scored.weights_hash for scored in record.methods}


def _check_comparable(path: Path, record: CommonStates, first: CommonStates, scene_hash: str) -> None:
    settings = {scored.method: scored.selector for scored in record.methods}
    for name, own, other in (
        ("protocol", record.protocol, first.protocol),
        ("representation", record.representation, first.representation),
        ("common_states", record.settings, first.settings),
        ("the weights of methods", _weights(record), _weights(first)),
        ("the methods or their settings", settings, {scored.method: scored.selector for scored in first.methods}),
        ("the versions of the scene", record.scene_hash, scene_hash),
    ):
        if own != other:
            fault = f"not comparable with other records of {record.dataset}, {name} differ"
            raise UserError(path, fault, "run all of them with one configuration")
