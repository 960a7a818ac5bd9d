"""Whether the episodes of one table were computed by one kind of machine and the same packages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from avs.nvs.record import EpisodeMeta
from avs.system.records import read_record

_MACHINE = ("processor", "gpu", "system", "python")
"""What rounding depends on; the number of cores does not change a bit."""


Facts = Mapping[str, str]
"""Of one episode: device, processor, GPU, system and Python, and the versions of packages, by name."""


def machine_facts(record: Path) -> Facts | None:
    """Return the facts of the episode at ``record``, of which ``episode.meta.json`` beside it tells; None without one.

    Raises:
        UserError: that file is damaged.
    """
    beside = record.with_name("episode.meta.json")
    if not beside.is_file():
        return None
    meta = read_record(beside, EpisodeMeta)
    machine = {name: meta.machine[name] for name in _MACHINE if name in meta.machine}
    return {"device": meta.device} | machine | meta.packages


def machine_notes(known: Sequence[Facts]) -> list[str]:
    """Return a line for each fact that differs between episodes, with how many have which value."""
    names = dict.fromkeys(name for facts in known for name in facts)
    lines = (_line(name, [facts.get(name, "none") for facts in known]) for name in names)
    return [line for line in lines if line]


def _line(name: str, values: Iterable[str]) -> str | None:
    counted = Counter(values).most_common()
    if len(counted) < 2:
        return None
    told = ", ".join(f"{value} in {number}" for value, number in sorted(counted, key=lambda each: (-each[1], each[0])))
    return f"{name} differs between episodes, and numbers may differ with it: {told}"
