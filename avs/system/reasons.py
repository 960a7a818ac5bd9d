"""Why something is missing from the results, and what helps."""

from __future__ import annotations

from avs.system.models import StrictModel


class Reason(StrictModel):
    """A cause, short enough for a cell of a table, and apart from it the remedy, such as a command; or None."""

    cause: str
    remedy: str | None = None

    def __str__(self) -> str:
        """Return both as one line."""
        return self.cause if self.remedy is None else f"{self.cause}: {self.remedy}"
