"""What the readers of a user's folders share: one scene for each folder in it, told apart by its photographs."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import ClassVar, Self

from pydantic import Field

from avs.datasets.capture_folders import FoundCaptures, Layout, find_captures
from avs.datasets.capture_pictures import plan_pictures
from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.posed_scene import PosedPictures, write_posed
from avs.datasets.published_archives import Archive
from avs.datasets.reader import Reader
from avs.scene.colmap.conversion import sorted_images
from avs.scene.pixel_forms import Color
from avs.system.errors import UserError
from avs.system.reasons import Reason


class FolderReader(Reader, CaptureSettings):
    """Scenes in a folder of the user's, each in a folder of its own. A subclass says how such a folder looks."""

    archives: ClassVar[tuple[Archive, ...]] = ()
    """What is published of it and may be fetched without being asked for terms, by ``avs data get``."""

    folder: str | None = Field(description="folder of the scenes' folders, or that of one scene")
    only: tuple[str, ...] | None = Field(
        default=None,
        description="names of the scenes to take, as the tables name them; null for all that are there",
    )

    @classmethod
    @abstractmethod
    def layout(cls) -> Layout:
        """Return how a scene's folder is told from others."""

    def scenes(self) -> dict[str, Self]:
        """Return the settings of each scene, by its folder's name in lower case, in order; see ``find_captures``."""
        found = self._found().folders
        wanted = found if self.only is None else {name: found[name] for name in self.only if name in found}
        if not wanted:
            told = ", ".join(self.only or ())
            fault = f"holds none of the scenes that `only` names ({told}), but {', '.join(found)}"
            raise UserError(self.folder, fault, "name some of these, or get the others")
        return {name: self.model_copy(update={"folder": str(path), "only": None}) for name, path in wanted.items()}

    def left_out(self) -> dict[str, Reason]:
        """Return why a folder is no scene, by its name, and which scenes that should be there are not."""
        if self.folder is None:
            return {}
        found = self._found()
        if self.only is None:
            return found.left_out
        absent = Reason(cause="is not there", remedy=f"put it into {self.folder}; docs/data.md says where it is from")
        return {name: found.left_out.get(name, absent) for name in self.only if name not in found.folders}

    @abstractmethod
    def examine(self) -> str:
        """Return what is there of a scene, one line, after a look at its files that tells of faults early.

        Raises:
            UserError: a file is missing or damaged, as far as that is seen without reading pixels.
        """

    def on_background(self, color: Color) -> Self:
        """Return settings with ``color`` behind transparent pixels, unless they name one."""
        return self if self.background is not None else self.model_copy(update={"background": color})

    def files(self) -> list[Path]:
        """Return every file that the scene may be read from."""
        return self.layout().files(self.place)

    def photographs(self) -> list[Path]:
        """Return the photographs among them."""
        return self.layout().photographs(self.place)

    def identities(self) -> tuple[tuple[object, ...], ...]:
        """Return the place of the scene and what tells its photographs from those of others: a copy is the same."""
        place, key = ("place", str(self.place.resolve())), self.layout().key(self.place)
        return (place,) if key is None else (place, ("photographs", *key))

    @property
    def place(self) -> Path:
        """The folder as a path."""
        return Path(self.folder or ".")

    def _found(self) -> FoundCaptures:
        return find_captures(self.place, self.layout())


class PictureFolderReader(FolderReader):
    """Scenes whose pictures are files in their folders."""

    @abstractmethod
    def posed(self) -> PosedPictures:
        """Return the pictures with cameras and poses; ``self`` is of one scene, and no pixel is read.

        Raises:
            UserError: a file of the user's is missing or damaged.
        """

    def prepare(self, dataset: str, folder: Path) -> None:
        """Write the scene that the pictures make; see ``avs.datasets.posed_scene.write_posed``."""
        write_posed(self.posed(), folder, self, dataset)

    def examine(self) -> str:
        """Return how many pictures have a pose, and their size, after a look at the header of each."""
        posed = self.posed()
        model = posed.model
        pictures = plan_pictures(posed.root, posed.camera_file, model.cameras, sorted_images(model), self)
        sizes = sorted({picture.size for picture in pictures})
        told = " and others" if len(sizes) > 1 else ""
        width, height = sizes[-1]
        return f"{len(pictures)} pictures with poses, {width} x {height} pixels in the scene{told}"
