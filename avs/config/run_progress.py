"""How far a run has come: how many of each kind of its jobs are done, running, failed or to come, and the time left.

It is read from what is on disk: the plan of the run, each job's log and the list beside it, and the times that
Snakemake keeps of the jobs that it has run. No process has to be asked.
"""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from avs.config.run_plan import RunPlan
from avs.system.job_logs import fault_of
from avs.system.ledger import has_ended
from avs.system.stale_jobs import followers_of, linked, stale_jobs

State = Literal["done", "running", "failed", "stopped", "to come"]
STATES: tuple[State, ...] = ("done", "running", "failed", "stopped", "to come")
"""What a job can be: stopped is one that had begun when its run was killed."""

METADATA = Path(".snakemake/metadata")
"""Where Snakemake keeps when it ran each job, in the folder of the workflow."""

_LOGS = "logs"
_LONGEST = 160  # characters of what is told of a fault


@dataclass(frozen=True)
class JobStatus:
    """One job of the run.

    Attributes:
        kind: the folder of its log, such as ``episodes``, or the log's name.
        log: its log.
        state: what it is.
        fault: the line with which its log ends, of one that failed.
        is_held: whether it waits for one that failed, so that it does not run.
    """

    kind: str
    log: Path
    state: State
    fault: str | None = None
    is_held: bool = False


def job_statuses(plan: RunPlan, begun: float, is_alive: bool) -> list[JobStatus]:
    """Return each job that the plan has, in the order of its logs.

    Args:
        plan: of the run.
        begun: when the run began, in seconds of the system's clock; logs that are older are those of another run.
        is_alive: whether a run is at work; without one, a job that has begun and not ended was stopped.
    """
    stale = stale_jobs(plan.stamps, plan.waits_for, plan.settings)
    found = [_status(Path(log), stale, begun, is_alive) for log in sorted(plan.stamps)]
    failed = [str(each.log) for each in found if each.state == "failed"]
    held = set(linked(failed, followers_of(plan.waits_for)))
    return [replace(each, is_held=each.state == "to come" and str(each.log) in held) for each in found]


def _status(log: Path, stale: Collection[str], begun: float, is_alive: bool) -> JobStatus:
    kind = _kind(log)
    if has_ended(log):
        return JobStatus(kind, log, "to come" if str(log) in stale else "done")
    if not log.exists() or log.stat().st_mtime < begun:  # of an earlier run, such as of a table that was set aside
        return JobStatus(kind, log, "to come")
    fault = fault_of(log)
    if fault is not None:
        return JobStatus(kind, log, "failed", fault)
    return JobStatus(kind, log, "running" if is_alive else "stopped")


def _kind(log: Path) -> str:
    parts = log.parts[log.parts.index(_LOGS) + 1 :] if _LOGS in log.parts else (log.name,)
    return parts[0].removesuffix(".log")


def mean_seconds(results: Path, metadata: Path = METADATA) -> dict[str, float]:
    """Return how long the jobs of each kind took in the mean, of those that Snakemake has run; nothing if not known.

    Args:
        results: folder of the run; jobs of another one in the same folder have other sizes.
        metadata: where Snakemake keeps what it knows.
    """
    found: dict[str, dict[str, float]] = {}
    for path in metadata.rglob("*") if metadata.is_dir() else ():
        try:
            told = json.loads(path.read_text(encoding="utf-8"))
            log, seconds = told["log"][0], float(told["endtime"]) - float(told["starttime"])
        except (OSError, ValueError, LookupError, TypeError):
            continue  # of a job without a log, or being written
        if not Path(log).is_relative_to(results):
            continue
        found.setdefault(_kind(Path(log)), {})[log] = seconds
    return {kind: sum(each.values()) / len(each) for kind, each in found.items()}


def time_left(statuses: Iterable[JobStatus], seconds: Mapping[str, float]) -> tuple[float, int]:
    """Return the seconds that the jobs to come and half of those running take, and of how many that is not known.

    Jobs that wait for one that failed do not count.
    As many run at a time as do now, one at least.
    """
    waiting = [each for each in statuses if each.state in ("to come", "running", "stopped") and not each.is_held]
    known = [each for each in waiting if each.kind in seconds]
    work = sum(seconds[each.kind] * (0.5 if each.state == "running" else 1.0) for each in known)
    return work / max(1, sum(each.state == "running" for each in waiting)), len(waiting) - len(known)


def status_lines(statuses: Sequence[JobStatus], seconds: Mapping[str, float], is_alive: bool) -> list[str]:
    """Return the table of kinds and states, the jobs that run and have failed, and the time left."""
    counts: dict[str, Counter[State]] = {}
    for each in statuses:
        counts.setdefault(each.kind, Counter())[each.state] += 1
    shown = [state for state in STATES if state == "done" or any(each.state == state for each in statuses)]
    width = max([*map(len, counts), len("all")])
    lines = [" ".join([" " * width, *(f"{state:>8}" for state in shown), "    mean"])]
    for kind, found in [*counts.items(), ("all", Counter(each.state for each in statuses))]:
        took = f"{_duration(seconds[kind]):>8}" if kind in seconds else ""
        lines.append(" ".join([f"{kind:<{width}}", *(f"{found[state] or '':>8}" for state in shown), took]).rstrip())
    lines += [f"running: {each.log}" for each in statuses if each.state == "running"]
    failed = [each for each in statuses if each.state == "failed"]
    lines += [f"failed: {each.log}: {(each.fault or '')[:_LONGEST]}" for each in failed]
    held = sum(each.is_held for each in statuses)
    lines += [f"{held} of those to come wait for a job that failed, and are not counted below"] if held else []
    return [*lines, _summary(statuses, seconds, is_alive)]


def _summary(statuses: Sequence[JobStatus], seconds: Mapping[str, float], is_alive: bool) -> str:
    if all(each.state == "done" for each in statuses):
        return "All jobs are done."
    left, unknown = time_left(statuses, seconds)
    words = f"{'at least' if unknown else 'about'} {_duration(left)} left"
    if unknown and not left and is_alive:
        return f"{time.strftime('%H:%M:%S')}: how long the rest takes is not known yet; no job of its kinds has ended."
    at = time.strftime("%H:%M:%S")
    if not is_alive:
        return f"{at}: no run is alive in this folder; {words} once it goes on."
    return f"{at}: {words}" + (f" ({unknown} jobs of kinds that have not run yet are not counted)." if unknown else ".")


def _duration(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"
