"""Whether the episodes of one table were computed by one kind of machine and the same packages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from avs.nvs.record import EpisodeMeta
from avs.system.records import read_record

_MACHINE = ("processor", "gpu", "system", "python", "numerics")
"""What rounding depends on; the number of cores does not change a bit."""

_NATIVE = (
    "{number} of {all} computed with native numerics: the same run on another kind of processor gives other digits, "
    "see docs/numerics.md"
)


def machine_notes(records: Sequence[Path]) -> list[str]:
    """Return a line for each fact of machine or packages that differs between episodes, with how many have which value.

    The processor counts where its kind can change a bit: not with portable numerics.

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
    native = sum(facts["device"] == "cpu" and facts.get("numerics") == "native" for facts in known)
    return [*([_NATIVE.format(number=native, all=len(known))] if native else []), *(line for line in lines if line)]


def _facts(meta: EpisodeMeta) -> dict[str, str]:
    machine = {name: meta.machine[name] for name in _MACHINE if name in meta.machine}
    if meta.device == "cpu" and machine.get("numerics") == "portable":
        del machine["processor"]
    return {"device": meta.device} | machine | meta.packages


def _line(name: str, values: Iterable[str]) -> str | None:
    counted = Counter(values).most_common()
    if len(counted) < 2:
        return None
    told = ", ".join(f"{value} in {number}" for value, number in sorted(counted, key=lambda each: (-each[1], each[0])))
    return f"{name} differs between episodes, and numbers may differ with it: {told}"
