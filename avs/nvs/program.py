"""Episodes on views that a file lists: a replay, or the choice of a program that is no part of this suite."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np
from pydantic import Field

from avs.selection.contract import Selection, State
from avs.system.errors import UserError
from avs.system.lists_of_names import some_of
from avs.system.models import StrictModel
from avs.system.records import read_record


class ViewList(StrictModel):
    """``views.json``: what a program writes that chooses all views by itself."""

    label: str = Field(min_length=1, description="printed name of the method")
    group: str = Field(default="2D-based", min_length=1, description="row group in the tables")
    views: list[str] = Field(
        min_length=1,
        description="image names in order of preference; those captured already are passed over, those that the budget "
        "does not reach are left out",
    )


class ListedViews:
    """A selector that takes the listed views one after another, without scores."""

    def __init__(self, views: Sequence[str], source: Path) -> None:
        """Take the image names to select, in order; ``source`` names the list in errors."""
        self._waiting = list(views)
        self._source = source

    def select(self, state: State, k: int) -> Selection:
        """Return the next ``k`` listed views.

        Raises:
            UserError: the list is too short, or names something else than a candidate.
        """
        names, self._waiting = self._waiting[:k], self._waiting[k:]
        if len(names) < k:
            raise UserError(
                self._source, f"lists too few views at step {state.step}", "list at least as many as the budget needs"
            )
        left = list(state.names)
        rows = []
        for name in names:
            if name not in left:
                raise UserError(
                    self._source, f"{name} is not a candidate at step {state.step}", "correct the list of views"
                )
            rows.append(state.names.index(name))
            left.remove(name)
        return Selection(np.array(rows, dtype=np.int64), None)


def read_views(path: Path, initial: Sequence[str], pool: Collection[str]) -> tuple[ViewList, ListedViews]:
    """Read ``views.json`` and return it with a selector that follows it, past the ``initial`` views' names.

    Raises:
        UserError: the file is missing, does not follow the schema, or names what is not in the ``pool``, such as a test
            image, also where the budget does not reach.
    """
    listed = read_record(path, ViewList, edited=True)
    others = [name for name in listed.views if name not in pool]
    if others:
        raise UserError(
            path, f"{some_of(others)}: no view of the pool", "list images that are there and no test images"
        )
    return listed, ListedViews([name for name in dict.fromkeys(listed.views) if name not in initial], path)
