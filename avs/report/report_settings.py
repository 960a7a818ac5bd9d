"""What the configuration tells the report."""

from __future__ import annotations

from pydantic import Field

from avs.report.figure_settings import FigureSettings
from avs.report.page.page_settings import PageSettings
from avs.system.models import StrictModel

BASE = "base"
"""What the sensitivity table calls the run's own settings."""

ENDINGS = ("_agreement", "_differences", "_gain", "_pairs", "_per_episode", "_per_scene", "_per_state", "_ranks")
"""What is appended to the name of a data set's table for the files beside it: no data set's own name ends so."""


class ReportSettings(StrictModel):
    """How results are tabulated."""

    reference: str | None = Field(
        default="farthest",
        description="method that the tables compare all others with, or null; the default counts where it runs",
    )
    figures: FigureSettings = Field(default_factory=FigureSettings, description="what the figures show")
    page: PageSettings = Field(default_factory=PageSettings, description="what the page holds")
