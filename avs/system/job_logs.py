"""What the log of a job says of its end."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from avs.system.ledger import has_ended, ledger_of

_MARK = "error: "
_TRACEBACK = "Traceback (most recent call last):"
# What pydantic puts below a fault.
_ADVICE = "For further information visit "

_LONGEST = 200
"""Characters of a program's last line that are repeated."""


def fault_of(log: Path) -> str | None:
    """Return why a job failed, as its log says last, or None if it says nothing of the kind or is not there.

    That is the line after ``error: ``, with which ``avs.system.job_process.job`` ends a log, or the last line of a
    traceback.
    """
    try:
        lines = [line.strip() for line in log.read_text(encoding="utf-8", errors="replace").splitlines()]
    except OSError:
        return None
    last = next((line for line in reversed(lines) if line and not line.startswith(_ADVICE)), "")
    if last.startswith(_MARK):
        return last.removeprefix(_MARK)
    return last if _TRACEBACK in lines else None


def why_missing(logs: Iterable[Path]) -> str:
    """Return why the result of a job is not there.

    Args:
        logs: of the job itself, then of the jobs that it waits for; one that has not begun has none.
    """
    own, *others = logs
    for log in (own, *others):
        fault = fault_of(log)
        if fault is not None:
            return fault
    if own.exists():
        ended_once = ledger_of(own).exists()
        gone = "what its job wrote is gone: moved or deleted, or its job began again and did not end"
        return gone if ended_once else "its job began and did not end"
    cut = next((log for log in others if log.exists() and not has_ended(log)), None)
    if cut is None:
        return "its job has not run"
    last = _last_line(cut)
    if last is None:
        return f"a job that it waits for printed nothing to {cut}: if it did not start, Snakemake has told why above"
    return f"a job that it waits for did not end; {cut} ends with: {last}"


def _last_line(log: Path) -> str | None:
    """Return what a job printed last, a program's words of its failure, or None if it printed nothing."""
    lines = [line.strip() for line in log.read_text(encoding="utf-8", errors="replace").splitlines()]
    return next((line[:_LONGEST] for line in reversed(lines) if line), None)
