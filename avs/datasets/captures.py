"""Captures: any folder in COLMAP layout, ``images/`` and ``sparse/0``, becomes a scene; see ``posed_scene``."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Self

from pydantic import Field

from avs.datasets.capture_folders import COLMAP, Layout
from avs.datasets.capture_models import choose_model
from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.folder_reader import PictureFolderReader
from avs.datasets.posed_scene import PosedPictures, write_posed
from avs.scene.colmap import find_model
from avs.system.errors import UserError
from avs.system.file_walk import walk_files


class Captures(PictureFolderReader):
    """Captures in a folder of the user's."""

    source: Literal["captures"] = Field(default="captures", description="captures in COLMAP layout")
    folder: str | None = Field(
        default=None, description="folder of captures, or one capture; null where the option scenes_dir gives it"
    )

    @classmethod
    def layout(cls) -> Layout:
        """Return COLMAP's."""
        return COLMAP

    def scenes(self) -> dict[str, Self]:
        """Return the settings of each capture, by its name in lower case, in order; see ``find_captures``."""
        if self.folder is None:
            raise UserError("captures", "no folder is given", "add --config scenes_dir=DIR, or name a folder")
        return super().scenes()

    def posed(self) -> PosedPictures:
        """Return the registered pictures; see ``posed_capture``."""
        return posed_capture(self.place)


READER = Captures


def prepare(source: Path, folder: Path, settings: CaptureSettings, dataset: str = "captures") -> None:
    """Turn the capture in ``source`` into a scene of ``dataset`` in ``folder``, named after ``folder``.

    Only registered images are used. Every ``settings.test_every``-th of them by name, from the first on, is a test
    image.

    Raises:
        UserError: the model or an image is missing or damaged, or they contradict one another.
    """
    write_posed(posed_capture(Path(source)), Path(folder), settings, dataset)


def posed_capture(source: Path) -> PosedPictures:
    """Return the registered pictures of the capture in ``source`` with its cameras, poses and points.

    Raises:
        UserError: the model is missing or damaged.
    """
    chosen = choose_model(source)
    return PosedPictures(
        subject=f"capture {source.resolve().name}",
        licence="as the capture's owner says",
        root=source / "images",
        camera_file=find_model(chosen.folder)[0],
        model=chosen.model,
        notes=tuple(chosen.notes),
        listed=tuple(walk_files(source / "images")),
    )
