"""Meshes from files: ``.glb`` and ``.gltf`` (also those of Gibson, HM3D and Matterport3D), ``.obj``, ``.ply``."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.scene.srgb import from_srgb, to_srgb
from avs.slam.building.building_mesh import GREY, Building, FloatArray, joined
from avs.slam.building.named_colours import check_pictures
from avs.slam.building.side_files import gltf_description
from avs.system.compatibility import import_open3d
from avs.system.errors import UserError
from avs.system.files import explained

SUFFIXES = (".glb", ".gltf", ".obj", ".ply")
"""The kinds of files that are read."""

_HEADER = 65536  # bytes; more than any header of a PLY file
_UNREADABLE = {
    "KHR_texture_basisu": (
        "has Basis textures, which are not read",
        "take the archive with plain JPEG or PNG textures (HM3D: hm3d-<split>-glb, files without .basis in their name)",
    ),
    "KHR_draco_mesh_compression": ("is compressed by Draco, which is not read", "export it without compression"),
    "EXT_meshopt_compression": ("is compressed by meshopt, which is not read", "export it without compression"),
}


def read_building(path: Path) -> Building:
    """Return the mesh of a file in the file's own axes and unit.

    Raises:
        UserError: the file is missing, is of another kind, is damaged, has no triangle, or has textures or a
            compression that are not read; or a texture that it names is missing or damaged.
    """
    check_kind(path)
    if path.suffix.lower() in (".glb", ".gltf"):
        check_gltf(path)
    with explained():
        textured = check_pictures(path)
    building = _read_colored(path) if path.suffix.lower() == ".ply" else _read_model(path, textured)
    if not np.isfinite(building.vertices).all():
        raise UserError(path, "has vertices that are not finite numbers", "repair the mesh")
    return building


def check_kind(path: Path) -> None:
    """Look whether a mesh is there and of a kind that is read.

    Raises:
        UserError: it is not.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise UserError(path, "is no mesh that is read", f"give a file with one of {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise UserError(path, "is no file", "check the path")


def check_gltf(path: Path) -> None:
    """Look at what a glTF file says of itself, without its triangles.

    Raises:
        UserError: it cannot be understood, is cut, or has contents that Open3D would leave out in silence.
    """
    try:
        if path.suffix.lower() == ".glb":
            _check_whole(path)
        described: dict[str, Any] = json.loads(gltf_description(path))
        used = [*described.get("extensionsUsed", []), *described.get("extensionsRequired", [])]
        if any(str(image.get("mimeType", "")) == "image/ktx2" for image in described.get("images", [])):
            used.append("KHR_texture_basisu")
    except (ValueError, struct.error, AttributeError, TypeError) as error:
        raise UserError(path, f"is no readable glTF file ({error})", "download or export it again") from error
    for extension, (fault, remedy) in _UNREADABLE.items():
        if extension in used:
            raise UserError(path, fault, remedy)


def _check_whole(path: Path) -> None:
    """Look whether a binary glTF file is one, and all there.

    Raises:
        ValueError: it is of another kind, or ends before all that it announces.
    """
    with path.open("rb") as stream:
        head = stream.read(12)
    if head[:4] != b"glTF":
        raise ValueError("its first bytes are not glTF")
    (announced,) = struct.unpack("<I", head[8:])
    if path.stat().st_size < announced:
        raise ValueError(f"it has {path.stat().st_size} of {announced} bytes")


def _read_model(path: Path, textured: int) -> Building:
    """Return a mesh of several materials, of which so many have a texture by what the file says."""
    open3d = import_open3d()
    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        model = open3d.io.read_triangle_model(str(path))
    tinted = path.suffix.lower() != ".obj"  # whose readers do not agree on colours beside textures: some are black
    parts = [_part(piece.mesh, model.materials[piece.material_idx], tinted) for piece in model.meshes]
    parts = [part for part in parts if len(part.triangles)]
    if not parts:
        raise UserError(path, "has no triangle", "check that it is a mesh, and whole")
    used = {piece.material_idx for piece in model.meshes}
    found = sum(_is_there(model.materials[number].albedo_img) for number in used)
    if textured and not found:
        fault = "names textures that Open3D does not find or cannot read"
        raise UserError(path, fault, "give them names of letters and digits, as PNG or JPEG, or export one .glb file")
    lost = f"{textured - found} of {textured} textures are not read; their surfaces have the material's colour"
    return joined(parts).noted(*([lost] if found < textured else []))


def _read_colored(path: Path) -> Building:
    """Return a mesh with colours at its vertices, or without any."""
    open3d = import_open3d()
    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        mesh = open3d.io.read_triangle_mesh(str(path))
    if not len(mesh.triangles):
        raise UserError(path, "has no triangle", "check that it is a mesh (a cloud of points is none), and whole")
    with path.open("rb") as stream:
        textured = b"comment TextureFile" in stream.read(_HEADER).partition(b"end_header")[0]
    unread = "the texture that it names is not read, as of any PLY file; .glb and .obj have some"
    return _part(mesh, None, tinted=False).noted(*([unread] if textured else []))


def _part(mesh: Any, material: Any, tinted: bool) -> Building:  # noqa: ANN401 - Open3D has no types
    """Return one mesh of Open3D with its material, if that has a picture or a colour.

    A picture is multiplied with the colour of its material where it is ``tinted``, as glTF has it.
    """
    vertices = np.asarray(mesh.vertices, np.float32)
    triangles = np.asarray(mesh.triangles, np.int32)
    notes: tuple[str, ...] = ()
    texture = None if material is None or not mesh.has_triangle_uvs() else _picture(material.albedo_img)
    corners = np.zeros((len(triangles), 3, 2), np.float32)
    if texture is not None:
        texture = _multiplied(texture, np.asarray(material.base_color, np.float32)[:3]) if tinted else texture
        corners = np.asarray(mesh.triangle_uvs, np.float32).reshape(-1, 3, 2)
    if mesh.has_vertex_colors():
        colors = np.asarray(mesh.vertex_colors, np.float32)
    elif texture is not None:
        colors = np.ones_like(vertices)
    else:
        colors, notes = _plain(material, len(vertices))
    index = np.full(len(triangles), -1 if texture is None else 0, np.int32)
    return Building(vertices, triangles, colors, corners, index, () if texture is None else (texture,), notes)


def _is_there(image: Any) -> bool:  # noqa: ANN401
    return image is not None and not image.is_empty()


def _picture(image: Any) -> npt.NDArray[np.uint8] | None:  # noqa: ANN401
    """Return a texture ``[height, width, 3]``; None where there is none."""
    if not _is_there(image):
        return None
    pixels = np.asarray(image)
    if pixels.dtype == np.uint16:
        pixels = (pixels >> 8).astype(np.uint8)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    if pixels.shape[2] < 3:
        pixels = np.repeat(pixels[:, :, :1], 3, axis=2)
    return np.ascontiguousarray(pixels[:, :, :3])


def _multiplied(texture: npt.NDArray[np.uint8], color: FloatArray) -> npt.NDArray[np.uint8]:
    """Return a texture times a linear colour ``[3]`` in 0..1."""
    if (color >= 1).all():
        return texture
    table = to_srgb(from_srgb(np.arange(256, dtype=np.float32) / 255)[:, None] * color)
    shades = np.clip(np.rint(table * 255), 0, 255).astype(np.uint8)
    return np.stack([shades[texture[..., channel], channel] for channel in range(3)], axis=-1)


def _plain(material: Any, count: int) -> tuple[FloatArray, tuple[str, ...]]:  # noqa: ANN401
    """Return one colour for all vertices: the material's own, or grey, and what to say of it."""
    base = None if material is None else np.asarray(material.base_color, np.float32)[:3]
    if base is None or (base >= 1).all():
        return np.full((count, 3), GREY, np.float32), ("surfaces without texture and colours are grey",)
    return np.tile(to_srgb(base), (count, 1)), ("surfaces without texture have their material's colour",)
