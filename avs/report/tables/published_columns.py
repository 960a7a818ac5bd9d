"""The columns of a table beside which the paper's values stand, with or without a difference to them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avs.report.collect import Episodes, common_protocol
from avs.report.document import Column
from avs.report.published import PRINTED_NAMES, Published, why_no_difference
from metrics.definitions import Metric


def published_column(metric: Metric, paper: Published | None, why_not: str | None, over: str | None = None) -> Column:
    """Return a column with the paper's values beside it, where it has the metric.

    Args:
        metric: of the column.
        paper: the paper's values, or None.
        why_not: why no difference to them is printed, or None if it is.
        over: heading above the column and its neighbours, or None.
    """
    if paper is None or all(identifier != metric.identifier for _, identifier in paper.values):
        return Column(metric, over=over)
    printed = PRINTED_NAMES.get(paper.dataset, paper.dataset)
    heading = "published" if why_not is None else f"published, {printed}"
    return Column(metric, heading, difference=why_not is None, over=over)


def why_no_mean_difference(paper: Published, episodes: Episodes, pictures: Mapping[str, Any]) -> str | None:
    """Return why the paper's means cannot be subtracted from those of these episodes, or None.

    Args:
        paper: the paper's values.
        episodes: of one data set.
        pictures: its settings of the size of images and of the split, as far as they are known.
    """
    budgets = {episode.budget for episode in episodes.all}
    protocol, representation = common_protocol(episodes), episodes.all[0].representation
    known = (paper.dataset, episodes.dataset, episodes.scenes, protocol, representation)
    return why_no_difference(*known, budgets, pictures)
