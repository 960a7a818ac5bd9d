"""Mip-NeRF360 (Barron et al., CVPR 2022): nine captures in COLMAP layout, from their full images.

``images_2``, ``images_4`` and ``images_8`` hold the authors' smaller copies, which are never read: results on those and
on pictures resized from the full ones differ by .3 to .7 dB.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field, PositiveInt

from avs.datasets.capture_folders import COLMAP, Layout
from avs.datasets.captures import posed_capture
from avs.datasets.folder_reader import PictureFolderReader
from avs.datasets.posed_scene import PosedPictures
from avs.datasets.published_archives import Archive
from avs.scene.colmap.conversion import sorted_images
from avs.scene.images import read_header
from avs.system.errors import UserError

SCENES = ("bicycle", "bonsai", "counter", "flowers", "garden", "kitchen", "room", "stump", "treehill")


class MipNerf360(PictureFolderReader):
    """The captures of Mip-NeRF360 in a folder of the user's."""

    archives = tuple(
        Archive(f"https://storage.googleapis.com/gresearch/refraw360/{name}.zip")
        for name in ("360_v2", "360_extra_scenes")
    )

    source: Literal["mipnerf360"] = Field(default="mipnerf360", description="Mip-NeRF360")
    folder: str = Field(description="folder of the scenes' folders")
    only: tuple[str, ...] | None = Field(
        default=SCENES, description="names of the scenes to take; those that are not there are told of"
    )
    long_side: PositiveInt | None = Field(default=1600, description="width in pixels; the paper's and 3DGS's is 1600")

    @classmethod
    def layout(cls) -> Layout:
        """Return COLMAP's."""
        return COLMAP

    def posed(self) -> PosedPictures:
        """Return the registered pictures.

        Raises:
            UserError: they are smaller copies, or as of ``avs.datasets.captures.posed_capture``.
        """
        posed = posed_capture(self.place)
        for image in sorted_images(posed.model):
            camera, size = posed.model.cameras[image.camera_id], read_header(posed.root / image.name).size
            if size != (camera.width, camera.height):
                real, told = ("x".join(map(str, each)) for each in (size, (camera.width, camera.height)))
                raise UserError(
                    posed.root / image.name,
                    f"is {real} pixels, but its camera {told}: a smaller copy",
                    "put the full images of the archive into images/, not those of images_2 or images_4",
                )
        return posed


READER = MipNerf360
