"""Whether the episodes of one table were computed by one kind of machine and the same packages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from avs.nvs.record import EpisodeMeta
from avs.system.records import read_record

_MACHINE = ("processor", "gpu", "system", "python")
"""What rounding depends on; the number of cores does not change a bit."""


def machine_notes(records: Sequence[Path]) -> list[str]:
    """Return a line for each fact of machine or packages that differs between episodes, with how many have which value.

    Args:
        records: ``episode.json`` files; the facts are in ``episode.meta.json`` beside each. Without one nothing is
            known of an episode.

    Raises:
        UserError: such a file is damaged.
    """
    beside = [path.with_name("episode.meta.json") for path in records]
    known = [_facts(read_record(path, EpisodeMeta)) for path in beside if path.is_file()]
    names = dict.fromkeys(name for facts in known for name in facts)
    lines = (_line(name, [facts.get(name, "none") for facts in known]) for name in names)
    return [line for line in lines if line]


def _facts(meta: EpisodeMeta) -> dict[str, str]:
    machine = {name: meta.machine[name] for name in _MACHINE if name in meta.machine}
    return {"device": meta.device} | machine | meta.packages


def _line(name: str, values: Iterable[str]) -> str | None:
    counted = Counter(values).most_common()
    if len(counted) < 2:
        return None
    told = ", ".join(f"{value} in {number}" for value, number in sorted(counted, key=lambda each: (-each[1], each[0])))
    return f"{name} differs between episodes, and numbers may differ with it: {told}"
