"""Records of held-out scenes read for a table, checked to be comparable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.iqa.held_out.held_out_record import HeldOutScores
from avs.report.labels import told_apart
from avs.system.errors import UserError
from avs.system.records import read_record

_REMEDY = "run all of them with one configuration"


def read_held_out(paths: Sequence[Path], scenes: Mapping[str, Sequence[str]]) -> list[HeldOutScores]:
    """Read the records at ``paths``, one for each of ``scenes``, and return them in their order.

    Args:
        paths: the records.
        scenes: names of the scenes by data set.

    Raises:
        UserError: a record is missing, damaged, of another scene, or was made with other settings or weights than the
            others.
    """
    found: dict[tuple[str, str], tuple[Path, HeldOutScores]] = {}
    for path in paths:
        record = read_record(path, HeldOutScores)
        found[record.dataset, record.scene] = (path, record)
    wanted = [(dataset, scene) for dataset, names in scenes.items() for scene in names]
    if not wanted or set(found) != set(wanted) or len(found) != len(paths):
        told = ", ".join("/".join(each) for each in wanted) or "none"
        raise UserError("held-out scenes", "the records are of others than the table is", f"pass those of {told}")
    first = found[wanted[0]][1]
    for path, record in found.values():
        if record.settings != first.settings or _predictors(record) != _predictors(first):
            raise UserError(path, "was scored with other settings or weights than others", _REMEDY)
    labels = told_apart({each.identifier: each.label for each in first.scored})
    return [_labelled(found[each][1], labels) for each in wanted]


def _labelled(record: HeldOutScores, labels: Mapping[str, str]) -> HeldOutScores:
    scored = [each.model_copy(update={"label": labels[each.identifier]}) for each in record.scored]
    return record.model_copy(update={"scored": scored})


def _predictors(record: HeldOutScores) -> list[tuple[str, str | None]]:
    return [(each.identifier, each.weights_hash) for each in record.scored]
