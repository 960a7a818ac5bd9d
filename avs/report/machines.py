"""Whether the episodes of one table were computed by one kind of machine and the same packages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from avs.coverage.coverage_record import CoverageMeta
from avs.nvs.record import EpisodeMeta
from avs.system.computed_by import ComputedBy
from avs.system.records import read_record

_MACHINE = ("processor", "gpu", "system", "python", "numerics")
"""What rounding depends on; the number of cores does not change a bit."""

_NATIVE = (
    "{number} of {all} computed with native numerics: the same run on another kind of processor gives other digits, "
    "see docs/numerics.md"
)

Told = tuple[str, Mapping[str, str], Mapping[str, str]]
"""The device of a record, its machine, and the versions of packages."""


def machine_notes(
    records: Sequence[Path],
    kind: type[EpisodeMeta | CoverageMeta | ComputedBy] = EpisodeMeta,
    what: str = "episodes",
    timed: bool = False,
) -> list[str]:
    """Return a line for each fact of machine or packages that differs between records, with how many have which value.

    The processor counts where its kind can change a bit: not with portable numerics.

    Args:
        records: such as ``episode.json`` files; the facts are in ``episode.meta.json`` beside each. Without one nothing
            is known of an episode.
        kind: what those files hold.
        what: what the records are of, in plural.
        timed: whether seconds stand beside each other, for which the processor and its cores count in any case.

    Raises:
        UserError: such a file is damaged.
    """
    beside = [path.with_suffix(".meta.json") for path in records]
    metas = [read_record(path, kind) for path in beside if path.is_file()]
    return differing([(meta.device, meta.machine, meta.packages) for meta in metas], what, timed)


def differing(told: Sequence[Told], what: str, timed: bool = False) -> list[str]:
    """Return a line for each fact that differs; see ``machine_notes``.

    Args:
        told: device, machine and packages of each record.
        what: the records, in plural.
        timed: as there.
    """
    known = [_facts(*each, timed) for each in told]
    names = dict.fromkeys(name for facts in known for name in facts)
    lines = (_line(name, [facts.get(name, "none") for facts in known], what) for name in names)
    native = sum(facts["device"] == "cpu" and facts.get("numerics") == "native" for facts in known)
    return [*([_NATIVE.format(number=native, all=len(known))] if native else []), *(line for line in lines if line)]


def _facts(device: str, machine: Mapping[str, str], packages: Mapping[str, str], timed: bool) -> dict[str, str]:
    own = {name: machine[name] for name in (*_MACHINE, *(["cores"] if timed else [])) if name in machine}
    if not timed and device == "cpu" and own.get("numerics") == "portable":
        own.pop("processor", None)
    return {"device": device} | own | dict(packages)


def _line(name: str, values: Iterable[str], what: str) -> str | None:
    counted = Counter(values).most_common()
    if len(counted) < 2:
        return None
    told = ", ".join(f"{value} in {number}" for value, number in sorted(counted, key=lambda each: (-each[1], each[0])))
    return f"{name} differs between {what}, and numbers may differ with it: {told}"
