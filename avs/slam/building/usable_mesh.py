"""Whether the mesh of a building can be read, as far as a quick look tells: before a run, and without its triangles."""

from __future__ import annotations

from pathlib import Path

from avs.slam.building.building_files import check_gltf, check_kind
from avs.slam.building.named_colours import check_named
from avs.slam.building.side_files import side_files
from avs.system.errors import UserError
from avs.system.files import CAN_BE_NAMED, can_be_named, explained


def check_building(path: Path) -> None:
    """Look whether a mesh is there, of a kind that is read, and can be opened with every file that it names.

    Of a glTF file it is looked at what it says of itself. Materials and textures of colours that are named must be
    there, and end as pictures do; normal maps and the like are not read, and may be absent. What is wrong with
    triangles, or in the midst of a picture, is seen as they are read.

    Raises:
        UserError: names the first fault.
    """
    with explained():
        check_kind(path)
        for each in (path, *side_files(path)):
            with each.open("rb"):
                pass
            if not can_be_named(each):
                raise UserError(each, "has a name that the workflow cannot take", CAN_BE_NAMED)
        if not path.stat().st_size:
            raise UserError(path, "is empty", "download or export it again")
        if path.suffix.lower() in (".glb", ".gltf"):
            check_gltf(path)
        check_named(path)
