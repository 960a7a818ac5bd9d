"""The contract of a reader: the settings of a data set, which know its scenes and prepare one.

A reader is a module of ``avs.datasets`` with a ``READER``, a subclass of ``Reader``; nothing lists it elsewhere. Its
module imports no torch and no other heavy library at import time, so that the workflow can list scenes quickly.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field

from avs.scene.pixel_forms import Color
from avs.system.models import Different, StrictModel
from avs.system.reasons import Reason

FurtherTable = Literal["ranking", "coverage", "sensitivity"]
"""The tables beside that of view synthesis for which a data set costs jobs of its own."""


class Reader(StrictModel):
    """Settings that all data sets share. A subclass has the field ``source``, a ``Literal`` of the reader's name."""

    source: str
    published: str | None = Field(
        default=None,
        description="the paper's data set whose values stand beside this one's in tables, such as mipnerf360; null for "
        "the one of the same name, if there is one",
    )
    methods: Annotated[tuple[str, ...], Different] | None = Field(
        default=None,
        description="methods in the order of the rows of this data set; those that the run leaves out are left out "
        "here, too; null for those of the run, an empty list for a data set of the table agnostic alone",
    )
    tables: Annotated[tuple[FurtherTable, ...], Different] | None = Field(
        default=None,
        description="tables of this data set beside that of view synthesis, as far as the run makes them; null for all",
    )

    @abstractmethod
    def scenes(self) -> Mapping[str, Self]:
        """Return the settings of each scene alone, by the scene's name, in order; no scene is read.

        A scene's settings hold all that it is made from and nothing of the others, so that it stays as it is when one
        is added beside it. Names consist of lower case letters, digits and ``_``.

        Raises:
            UserError: there is no scene, or none can be listed.
        """

    def left_out(self) -> Mapping[str, Reason]:
        """Return why something that looks like a scene is none, by its name; tables tell of it."""
        return {}

    def on_background(self, color: Color) -> Self:
        """Return settings with ``color``, sRGB in 0..1, behind what is transparent, unless they name one."""
        return self

    @abstractmethod
    def files(self) -> list[Path]:
        """Return the user's files that the scene is made from; ``self`` is of one scene."""

    def photographs(self) -> list[Path]:
        """Return those of the files that are photographs; ``self`` is of one scene. None where no user took them."""
        return []

    @abstractmethod
    def identities(self) -> tuple[tuple[object, ...], ...]:
        """Return what tells the scene from others, whatever its size and quality; ``self`` is of one scene.

        Two scenes that share one of these show the same, whichever readers they are of. One that begins with ``video``
        says that both are parts of one video: of the same place, if not of the same pictures.
        """

    @abstractmethod
    def prepare(self, dataset: str, folder: Path) -> None:
        """Write the scene, named after ``folder``, to ``folder``; ``self`` is of one scene.

        Args:
            dataset: name of the data set in the configuration.
            folder: the scene, as ``avs.scene.scene`` writes it.

        Raises:
            UserError: a file of the user's is missing or damaged.
        """

    def render_seed(self) -> int:
        """Return the seed of the reconstructions whose renderings train scorers; ``self`` is of one scene."""
        return 0
