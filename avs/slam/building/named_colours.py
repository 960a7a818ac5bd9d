"""What a mesh file names for the colours of its surfaces: whether all of it is there, and whether pictures are whole.

Open3D goes on without a texture that is missing, and fills up one that is cut: the robot would see another building.
"""

from __future__ import annotations

import base64
import binascii
import io
import json
import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from avs.slam.building.side_files import gltf_description, libraries_of, places_of_line, statements
from avs.system.errors import UserError

_COPY = "copy it again from where the mesh is from, with all files beside it"
_ENDS = (b"\xff\xd9", b"IEND")
"""What the last bytes of a JPEG and of a PNG file hold."""
_TAIL = 4096  # bytes

Picture = tuple[str, Path | bytes]
"""What an error calls it, and the file or its bytes."""


def check_named(path: Path) -> None:
    """Look whether what a mesh names for its colours is there, and ends as a picture does.

    Raises:
        UserError: names the first that does not.
    """
    for name, content in _pictures(path):
        if isinstance(content, Path) and not _ends_well(content):
            _check_picture(path, name, content)


def check_pictures(path: Path) -> int:
    """Look at all pixels of every texture of colours, also of those that lie within the mesh file.

    Returns:
        How many of the materials that are used have one.

    Raises:
        UserError: names the first that is missing or damaged.
    """
    found = list(_pictures(path))
    for content, name in {content: name for name, content in found}.items():
        _check_picture(path, name, content)
    return len(found)


def _pictures(path: Path) -> Iterator[Picture]:
    kinds = {".gltf": _of_gltf, ".glb": _of_gltf, ".obj": _of_obj}
    found = kinds.get(path.suffix.lower())
    return iter(()) if found is None else found(path)


def _ends_well(path: Path) -> bool:
    with path.open("rb") as stream:
        stream.seek(max(0, path.stat().st_size - _TAIL))
        tail = stream.read()
    return any(end in tail for end in _ENDS)


def _check_picture(path: Path, name: str, content: Path | bytes) -> None:
    from PIL import Image

    try:
        with Image.open(io.BytesIO(content) if isinstance(content, bytes) else content) as image:
            image.load()
    except Exception as error:  # Pillow's decoders raise whatever the bytes of a damaged file bring about
        if isinstance(error, OSError) and error.errno is not None:
            raise
        told = " ".join(str(error).split())
        where = f"its texture {name}" if isinstance(content, bytes) else f"its texture {content.name}"
        raise UserError(path, f"{where} is damaged or cut off, or no picture ({told})", _COPY) from error


def _lacking(path: Path, what: str) -> UserError:
    return UserError(path, f"{what} is not there, without which it has other colours", _COPY)


def _of_obj(path: Path) -> Iterator[Picture]:
    """Yield the texture of each material that faces use."""
    used = {name.strip() for name in statements(path, "usemtl")}
    if not used:
        return
    named = [line.strip() for line in statements(path, "mtllib")]
    libraries = libraries_of(path)
    if named and not libraries:
        raise _lacking(path, f"the file of materials that it names, {named[0]},")
    for library in libraries:
        material = None
        for line in library.read_text(errors="replace").splitlines():
            word, *rest = line.split(maxsplit=1)[:2] or [""]
            if word.lower() == "newmtl":
                material = "".join(rest).strip()
            elif word.lower() == "map_kd" and material in used:
                told = "".join(rest).strip()
                there = [each for each in places_of_line(told, [library.parent, path.parent]) if each.is_file()]
                if not there:
                    raise _lacking(path, f"the texture {told} of its material {material}")
                yield told, max(there, key=lambda each: len(each.name))


def _of_gltf(path: Path) -> Iterator[Picture]:
    """Yield the texture of colours of each material that primitives use; what cannot be understood others tell of."""
    try:
        described: dict[str, Any] = json.loads(gltf_description(path))
        images = [(number, described["images"][number]) for number in _colour_images(described)]
    except (ValueError, AttributeError, TypeError, KeyError, IndexError, struct.error):
        return
    for number, image in images:
        name, uri = str(image.get("name", f"number {number}")), image.get("uri")
        if isinstance(uri, str) and not uri.startswith("data:"):
            place = path.parent / unquote(uri)
            if not place.is_file():
                raise _lacking(path, f"the texture {uri}")
            yield name, place
        else:
            try:
                yield name, _content(path, described, image)
            except (ValueError, TypeError, KeyError, IndexError, struct.error, binascii.Error) as error:
                raise UserError(path, f"its texture {name} cannot be found in it", _COPY) from error


def _colour_images(described: Mapping[str, Any]) -> list[int]:
    """Return for each material that is used the number of the image that gives it its colours, if one does."""
    primitives = [each for mesh in described.get("meshes", []) for each in mesh.get("primitives", [])]
    numbers = sorted({each["material"] for each in primitives if "material" in each})
    found = []
    for material in (described["materials"][number] for number in numbers):
        glossy = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness", {})
        texture = material.get("pbrMetallicRoughness", {}).get("baseColorTexture", glossy.get("diffuseTexture"))
        if texture is not None and "source" in (entry := described["textures"][texture["index"]]):
            found.append(entry["source"])
    return found


def _content(path: Path, described: Mapping[str, Any], image: Mapping[str, Any]) -> bytes:
    """Return the bytes of an image that lies in the mesh file, or in a buffer beside it."""
    if "uri" in image:
        return base64.b64decode(image["uri"].partition(",")[2], validate=True)
    view = described["bufferViews"][image["bufferView"]]
    buffer = described["buffers"][view["buffer"]]
    start, length = view.get("byteOffset", 0), view["byteLength"]
    uri = buffer.get("uri")
    if isinstance(uri, str) and uri.startswith("data:"):
        return base64.b64decode(uri.partition(",")[2], validate=True)[start : start + length]
    if isinstance(uri, str):
        place, first = path.parent / unquote(uri), 0
    else:
        place, first = path, _binary_chunk(path)
    with place.open("rb") as stream:
        stream.seek(first + start)
        return stream.read(length)


def _binary_chunk(path: Path) -> int:
    """Return where the second chunk of a binary glTF file begins: behind its own head of eight bytes."""
    with path.open("rb") as stream:
        (length,) = struct.unpack("<I", stream.read(20)[12:16])
    return 20 + int(length) + 8
