"""Gaussians as a ``.ply`` file in the layout of the 3DGS code, which splat viewers open.

Properties, all float32: ``x y z nx ny nz f_dc_0..2 f_rest_* opacity scale_0..2 rot_0..3``. Values are those before
activation: harmonics coefficients, the opacity's logit, logarithms of scales, quaternions as (w, x, y, z). ``f_rest``
lists all coefficients of red, then those of green, then of blue. Normals are zero; nobody reads them.

Positions and scales are those of the capture. Where it lies so far from its origin that float32 would blur the
positions, as georeferenced captures do, they are relative to an offset, which stands in a comment of the header:
``offset X Y Z``, to be added to x, y and z. The comment follows the line ``element``, since the viewer of the 3DGS code
takes the third line for that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from plyfile import PlyData, PlyElement, PlyParseError
from torch import Tensor

from avs.scene.similarity import IDENTITY, Similarity
from avs.system.errors import UserError
from avs.system.files import atomic_path

_FIXED = {
    "means": ["x", "y", "z"],
    "normals": ["nx", "ny", "nz"],
    "f_dc": ["f_dc_0", "f_dc_1", "f_dc_2"],
    "opacities": ["opacity"],
    "scales": ["scale_0", "scale_1", "scale_2"],
    "quats": ["rot_0", "rot_1", "rot_2", "rot_3"],
}


FARTHEST_ORIGIN = 1000.0
"""Distance in scene units of the capture's origin from the scene's up to which positions need no offset: float32 then
keeps them to 3e-5 scene units, a hundredth of a pixel or less in ordinary photographs."""

_OFFSET = "offset"


def write_ply(path: Path, parameters: Mapping[str, Tensor], to_capture: Similarity = IDENTITY) -> None:
    """Write the tensors of ``parameters.Parameters`` to ``path`` atomically, in the coordinates of the capture."""
    values = {name: tensor.detach().cpu().numpy() for name, tensor in parameters.items()}
    translation = np.array(to_capture.translation)
    far = np.linalg.norm(translation) > FARTHEST_ORIGIN * to_capture.scale
    offset = translation if far else np.zeros(3)
    values["means"] = values["means"].astype(np.float64) * to_capture.scale + (translation - offset)
    values["scales"] = values["scales"].astype(np.float64) + math.log(to_capture.scale)
    harmonics = values["sh"]
    rest = harmonics[:, 1:].transpose(0, 2, 1).reshape(len(harmonics), -1)
    columns = {
        "means": values["means"],
        "normals": np.zeros_like(values["means"]),
        "f_dc": harmonics[:, 0],
        "f_rest": rest,
        "opacities": values["opacities"][:, None],
        "scales": values["scales"],
        "quats": values["quats"],
    }
    names = [name for key in columns for name in _FIXED.get(key, _rest_names(rest.shape[1]))]
    table = np.concatenate(list(columns.values()), axis=1).astype("<f4")
    vertices = np.ascontiguousarray(table).view([(name, "<f4") for name in names])[:, 0]
    comments = [" ".join((_OFFSET, *map(repr, offset.tolist())))] if far else []
    with atomic_path(path) as temporary:
        PlyData([PlyElement.describe(vertices, "vertex", comments=comments)], byte_order="<").write(temporary)


def read_ply(path: Path, to_capture: Similarity = IDENTITY) -> dict[str, Tensor]:
    """Return the tensors that ``write_ply``, or another 3DGS program, wrote, in the coordinates of the scene.

    Normals and unknown properties are ignored.

    Args:
        path: the file.
        to_capture: from the scene's coordinates to those of the capture, which the file has.

    Returns:
        ``means`` ``[n, 3]``, ``scales`` ``[n, 3]``, ``quats`` ``[n, 4]``, ``opacities`` ``[n]``, ``sh`` ``[n, k, 3]``.

    Raises:
        UserError: the file is missing, damaged, lacks a property, or holds NaN or an infinity.
    """
    remedy = "give a .ply file of 3D Gaussian splatting"
    try:
        data = PlyData.read(path)
        vertices = data["vertex"].data
    except (OSError, PlyParseError, KeyError, ValueError, MemoryError) as error:
        raise UserError(path, f"cannot be read as a .ply file of vertices ({error})", remedy) from error
    found = set(vertices.dtype.names or ())
    rest_names = _rest_names(sum(name.startswith("f_rest_") for name in found))
    needed = [name for key, names in _FIXED.items() if key != "normals" for name in names]
    missing = sorted({*needed, *rest_names} - found)
    if missing:
        raise UserError(path, f"lacks the properties {', '.join(missing)}", remedy)
    if len(rest_names) not in (0, 9, 24, 45):
        raise UserError(
            path, f"has {len(rest_names)} f_rest properties, where 0, 9, 24 or 45 make full degrees", remedy
        )
    fixed = {key: _table(vertices, names) for key, names in _FIXED.items() if key != "normals"}
    rest = _table(vertices, rest_names).reshape(len(vertices), 3, -1).transpose(0, 2, 1)
    arrays = {
        "means": to_capture.points_back(fixed["means"].astype(np.float64) + _offset(data)).astype(np.float32),
        "scales": (fixed["scales"].astype(np.float64) - math.log(to_capture.scale)).astype(np.float32),
        "quats": fixed["quats"],
        "opacities": fixed["opacities"][:, 0],
        "sh": np.concatenate([fixed["f_dc"][:, None], rest], axis=1),
    }
    if not all(np.isfinite(values).all() for values in arrays.values()):
        raise UserError(path, "holds NaN or an infinity", remedy)
    return {name: torch.from_numpy(np.ascontiguousarray(values)) for name, values in arrays.items()}


def _offset(data: PlyData) -> npt.NDArray[np.float64]:
    """Return what is to be added to the positions, ``[3]``."""
    for words in map(str.split, data["vertex"].comments):
        if len(words) == 4 and words[0] == _OFFSET:
            return np.array(words[1:], dtype=np.float64)
    return np.zeros(3)


def _rest_names(count: int) -> list[str]:
    return [f"f_rest_{index}" for index in range(count)]


def _table(vertices: npt.NDArray[np.void], names: list[str]) -> npt.NDArray[np.float32]:
    columns = [np.asarray(vertices[name], dtype=np.float32) for name in names]
    return np.stack(columns, axis=1) if columns else np.zeros((len(vertices), 0), dtype=np.float32)
