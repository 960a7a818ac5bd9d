"""What the jobs that write tables and figures read of the configuration, as typed models."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from avs.report.figure_settings import FigureSettings
from avs.report.page.page_settings import PageSettings
from avs.system.models import StrictModel
from avs.system.reasons import Reason


class FigureJob(StrictModel):
    """What a figure reads."""

    methods: tuple[str, ...] = Field(description="identifiers of the methods, in order")
    scenes: dict[str, tuple[str, ...]] = Field(
        description="names of the scenes whose records it holds, by data set; with other ones it is made anew"
    )
    seeds: tuple[int, ...] = Field(description="seeds of those records")


class DrawnJob(FigureJob):
    """What a figure reads whose contents the configuration sets."""

    figures: FigureSettings = Field(description="what the figures show")
    reference: str | None = Field(description="identifier of the method that the tables compare with")


class RowsJob(FigureJob):
    """What a table reads."""

    absent: dict[str, Reason] = Field(description="why a method has no number, by identifier")


class SensitivityJob(RowsJob):
    """What the sensitivity table reads."""

    variants: tuple[str, ...] = Field(description="names of the variants of the settings, in the order of columns")


class AgnosticJob(FigureJob):
    """What the table of several representations reads."""

    representations: tuple[str, ...] = Field(description="names of the representations, in the order of columns")
    absent: dict[str, dict[str, Reason]] = Field(
        description="why a method has no number on a representation, by representation"
    )


class DataSetJob(RowsJob):
    """What every table of the scenes of a data set reads."""

    left_out: dict[str, Reason] = Field(description="why something that looks like a scene is none, by its name")


class TableJob(DataSetJob):
    """What the table of a data set reads."""

    published: str | None = Field(description="file of the published values to print beside its own")
    reference: str | None = Field(description="identifier of the method that the others are compared with")
    pictures: dict[str, Any] = Field(description="settings of the size of images and of the split, empty if not known")


class NamedTableJob(TableJob):
    """What is read of one of several data sets."""

    dataset: str = Field(description="its name")


class SideBySideJob(StrictModel):
    """What the table of several data sets reads."""

    data_sets: tuple[NamedTableJob, ...] = Field(description="the data sets in the order of columns")


class SceneTableJob(DataSetJob):
    """What the table of single scenes reads."""

    published: tuple[str, ...] = Field(description="files of the published values to print beside its own")


class SummaryJob(RowsJob):
    """What a table of the paper's layout of selection times reads."""

    published: str = Field(description="file of the published values to print beside its own")


class CoverageTableJob(RowsJob):
    """What the coverage table of a data set reads."""

    published: str | None = Field(description="file of the published values to print beside its own")
    reference: str | None = Field(description="identifier of the method that the others are compared with")
    lacking: Reason | None = Field(description="why there is no coverage at all, or null")


class PageSceneJob(RowsJob):
    """What the scripts of a scene's part of the page read."""

    page: PageSettings = Field(description="what the page holds")
    share: float = Field(ge=0, le=1, description="of the page's limit of bytes that one scene has")


class PageExplorationJob(StrictModel):
    """What the script of an exploration reads."""

    page: PageSettings = Field(description="what the page holds")


class PageJob(RowsJob):
    """What the page reads."""

    scale: str = Field(description="name of the run")
    data_sets: tuple[str, ...] = Field(description="names of the data sets, in order")
    config: dict[str, Any] = Field(description="the whole configuration")
    explorations: dict[str, tuple[tuple[str, int], ...]] = Field(
        description="methods and seeds of the explorations, by building"
    )


class ScorerTableJob(StrictModel):
    """What the table of scorers on held-out scenes reads."""

    scenes: dict[str, tuple[str, ...]] = Field(description="names of the held-out scenes, by data set")
    same_pictures: tuple[str, ...] = Field(
        default=(), description="data sets of them whose surfaces show the pictures that training scenes show"
    )
    methods: tuple[str, ...] = Field(description="methods that have rows there, in order")
    absent: dict[str, Reason] = Field(description="why one of them has no number, by identifier")
