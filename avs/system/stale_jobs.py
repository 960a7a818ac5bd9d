"""Which jobs of a run would be made again though what they wrote is there: for their own sources, or for a job before.

Which they are is seen at every look anew, since files change while a run goes on.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from avs.system.code_inputs import digest_now
from avs.system.ledger import damage_of, has_ended, origin_of

_OTHER_SOURCES = "it was made with other code or of other files than the last run had"
_OTHER_SETTINGS = "it was made with other settings than the last run had"
_OTHER_FILES = "it was made from other files than are there now"
_GONE = "it was made from files that are gone, or are being made again"
_NO_PART = "it was no part of the last run, so that nothing tells whether it is current"


def stale_jobs(
    stamps: Mapping[str, str], waits_for: Mapping[str, Sequence[str]], settings: Mapping[str, str]
) -> dict[str, str]:
    """Return why what a job wrote does not count, by the log of each job of which that is so.

    It does not if the job was made from other sources than it would be now, or if that holds for a job that it waits
    for, directly or not, or if such a job has not ended: its files are gone, or are being made again.

    Args:
        stamps: what the last run tells each of its jobs of their sources, by log; empty if nothing is known.
        waits_for: logs of the jobs that make what a job reads, by its log.
        settings: digest of what each file of settings of that run holds, or will hold, by its path.
    """
    own = {log: why for log, stamp in stamps.items() if (why := _why_stale(log, stamp, settings)) is not None}
    gone = {log: _GONE for log in stamps if not has_ended(Path(log))}
    found, followers = dict(own), followers_of(waits_for)
    for log, why in (own | gone).items():
        waiting = [log]
        while waiting:
            new = [each for each in followers.get(waiting.pop(), ()) if each not in found]
            found |= dict.fromkeys(new, why)
            waiting += new
    return found


def followers_of(waits_for: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return the logs of the jobs that wait for a job and for no other between them, by its log."""
    found: dict[str, list[str]] = {}
    for log, earlier in waits_for.items():
        for each in earlier:
            found.setdefault(each, []).append(log)
    return found


def linked(logs: Iterable[str], links: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Return the logs to which links lead from some, directly or not: the nearest first, and each once."""
    found: dict[str, None] = {}
    waiting = list(logs)
    while waiting:
        reached = dict.fromkeys(each for log in waiting for each in links.get(log, ()) if each not in found)
        found |= reached
        waiting = list(reached)
    return tuple(found)


def why_left_out(log: Path, stamps: Mapping[str, str], stale: Mapping[str, str]) -> str | None:
    """Return why what a job wrote does not count, or None if it does or nothing of the kind is known.

    What it wrote is hashed, which is too slow for what looks again every few seconds.

    Args:
        log: of the job.
        stamps: see ``stale_jobs``.
        stale: what that function returned.
    """
    if not stamps:
        return None
    if str(log) not in stamps:
        return _NO_PART
    damage = damage_of(log)
    changed = None if damage is None or not damage.changed else damage.changed[0].name
    return stale.get(str(log)) or (changed and f"{changed} holds something else than its job wrote")


def _why_stale(log: str, stamp: str, settings: Mapping[str, str]) -> str | None:
    """Return why the sources of a job are others than those of its last run, or None."""
    origin = origin_of(Path(log))
    if origin is None or origin.stamp != stamp:
        return _OTHER_SOURCES
    if any(settings.get(path, told) != told for path, told in origin.read.items()):
        return _OTHER_SETTINGS
    return _OTHER_FILES if origin.is_outdated(_digest_of) else None


def _digest_of(path: str) -> str | None:
    """Return the SHA-256 of a file as it is now, or None where there is none; one that has not changed is read once."""
    try:
        status = Path(path).stat()
    except OSError:
        return None
    return _digest_in_state(path, (status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns))


@functools.cache
def _digest_in_state(path: str, state: tuple[int, ...]) -> str | None:
    return digest_now(path)
