"""The table of scorers of an unfinished run: whole, or left out with the reason."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from avs.report.collect_held_out import read_held_out
from avs.report.document import Document
from avs.report.tables.scorer_agreement import scorer_agreement
from avs.system.errors import UserError
from avs.system.job_logs import why_missing
from avs.system.reasons import Reason


@dataclass(frozen=True)
class WantedHeldOut:
    """The scores of the renderings of one held-out scene.

    Attributes:
        path: of their record.
        logs: of its job, then of the jobs that it waits for.
        stale: why the record does not count though it is there, or None.
    """

    path: Path
    logs: tuple[Path, ...]
    stale: str | None = None


@dataclass(frozen=True)
class WantedScorers:
    """The table of scorers.

    Attributes:
        records: what it is made from.
        scenes: names of the held-out scenes, by data set.
        methods: identifiers of the methods that have rows, in order.
        absent: why one of them has no number, by identifier.
        same_pictures: see ``avs.report.tables.scorer_agreement.scorer_agreement``.
    """

    records: tuple[WantedHeldOut, ...]
    scenes: Mapping[str, tuple[str, ...]]
    methods: tuple[str, ...]
    absent: Mapping[str, Reason]
    same_pictures: tuple[str, ...] = ()


def incomplete_scorers(wanted: WantedScorers) -> Document:
    """Return the table, whose numbers are means over all held-out scenes.

    Raises:
        UserError: a scene is not scored yet, or its record does not count.
    """
    reasons = [each.stale if each.path.exists() else why_missing(each.logs) for each in wanted.records]
    missing = [why for why in reasons if why is not None]
    if missing:
        fault = f"{len(missing)} of {len(reasons)} held-out scenes have no scores"
        raise UserError("table of scorers", fault, "; ".join(dict.fromkeys(missing)))
    paths = [each.path for each in wanted.records]
    return scorer_agreement(
        read_held_out(paths, wanted.scenes), wanted.methods, wanted.absent, paths, wanted.same_pictures
    )
