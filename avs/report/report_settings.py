"""What the configuration tells the report."""

from __future__ import annotations

from pydantic import Field

from avs.system.models import StrictModel


class ReportSettings(StrictModel):
    """How results are tabulated."""

    reference: str | None = Field(
        default="farthest",
        description="method that the tables compare all others with, or null; the default counts where it runs",
    )
