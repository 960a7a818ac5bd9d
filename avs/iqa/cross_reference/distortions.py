"""Distortion data of one scene on disk: renderings of its reconstruction, with their true SSIM maps.

One safetensors file holds all that training needs of a scene: ``photograph/<i>`` ``[height, width, 3]`` uint8, image
number i of the scene; ``rendering/<j>`` likewise; ``ssim/<j>`` ``[height, width]`` uint16, (SSIM + 1) * 32767 as in
CrossScore's data; ``geometry`` ``[renderings, 5]`` float64, what is known of each view beside its pixels; ``centers``
``[photographs, 3]`` float64, where the cameras stand; and a header of JSON: the moments of the reconstruction, and for
each rendering its image and its moment.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from pydantic import Field, ValidationError

from avs.iqa.cross_reference.reference_order import reference_order
from avs.iqa.cross_reference.scorer_settings import ReferenceChoice
from avs.iqa.render_statistics.view_geometry import VIEW_GEOMETRY
from avs.system.errors import UserError
from avs.system.models import StrictModel
from avs.system.tensor_files import read_tensors, write_tensors

_FORMAT = "avs-renders-2"
_REMEDY = "delete it and make the renderings again"
_MAP_SCALE = 32767.0

Image = npt.NDArray[np.uint8]
CodedMap = npt.NDArray[np.uint16]
FloatArray = npt.NDArray[np.float64]


class Moment(StrictModel):
    """One state of a reconstruction."""

    run: int = Field(description="number of the reconstruction, from 0")
    iteration: int = Field(description="optimisation steps done")
    captured: tuple[int, ...] = Field(description="numbers of the photographs it has seen, in order of capture")


class _Header(StrictModel):
    format: str
    scene: str
    scene_hash: str
    photographs: int
    moments: tuple[Moment, ...]
    images: tuple[int, ...]
    moment_of: tuple[int, ...]
    geometry: tuple[str, ...]


@dataclass(frozen=True)
class Distortions:
    """The distortion data of one scene.

    Attributes:
        scene: the scene's name.
        scene_hash: its content hash.
        photographs: ``[height, width, 3]`` uint8 each, every image of the scene.
        moments: the states of the reconstructions.
        renderings: ``[height, width, 3]`` uint8 each.
        maps: ``[height, width]`` uint16 each, the coded SSIM map of each rendering; see ``decoded``.
        images: for each rendering the number of its photograph.
        moment_of: for each rendering the number of its moment.
        geometry: ``[renderings, 5]`` finite, see ``avs.iqa.render_statistics.view_geometry``.
        centers: ``[photographs, 3]`` finite, camera centres in scene units.
    """

    scene: str
    scene_hash: str
    photographs: tuple[Image, ...]
    moments: tuple[Moment, ...]
    renderings: tuple[Image, ...]
    maps: tuple[CodedMap, ...]
    images: tuple[int, ...]
    moment_of: tuple[int, ...]
    geometry: FloatArray
    centers: FloatArray

    def __len__(self) -> int:
        """Return the number of renderings."""
        return len(self.renderings)

    @property
    def candidates(self) -> npt.NDArray[np.bool_]:
        """``[renderings]``: whether the view had not been captured at the moment, so that it could have been chosen."""
        pairs = zip(self.images, self.moment_of, strict=True)
        return np.array([image not in self.moments[moment].captured for image, moment in pairs])

    @property
    def similarity(self) -> FloatArray:
        """``[renderings]``: the true SSIM of each, mean over its pixels of the decoded map, clipped to 0..1."""
        return np.array([decoded(code).mean(dtype=np.float64) for code in self.maps])


def captured_references(data: Distortions, row: int, choice: ReferenceChoice, rng: np.random.Generator) -> list[int]:
    """Return the photographs captured at the moment of a rendering, without its own, in the order they are taken.

    Args:
        data: of the scene.
        row: number of the rendering.
        choice: see ``reference_order``, as ``rng``.
        rng: decides an order by chance.
    """
    own = data.images[row]
    captured = data.moments[data.moment_of[row]].captured
    pool = np.array([image for image in captured if image != own], dtype=np.int64)
    ordered: list[int] = pool[reference_order(data.centers[pool], data.centers[own], choice, rng)].tolist()
    return ordered


def batches(data: Distortions, size: int) -> Iterator[list[int]]:
    """Yield all renderings, at most ``size`` of one shape at a time."""
    shapes = np.array([image.shape[:2] for image in data.renderings])
    for shape in np.unique(shapes, axis=0):
        alike = np.flatnonzero((shapes == shape).all(axis=1))
        for rows in np.split(alike, range(size, len(alike), size)):
            yield rows.tolist()


def coded(similarity: npt.NDArray[np.float64]) -> CodedMap:
    """Return an SSIM map in -1..1 as 16-bit integers."""
    return np.round((similarity + 1.0) * _MAP_SCALE).astype(np.uint16)


def decoded(code: CodedMap) -> npt.NDArray[np.float32]:
    """Return the SSIM map of a code, clipped to 0..1 as CrossScore's loader does."""
    similarity: npt.NDArray[np.float32] = code.astype(np.float32) / np.float32(_MAP_SCALE) - np.float32(1.0)
    return similarity.clip(0.0, 1.0)


def write_distortions(path: Path, data: Distortions) -> None:
    """Write ``data`` to ``path``, whole or not at all; equal data give equal bytes."""
    header = _Header(
        format=_FORMAT,
        scene=data.scene,
        scene_hash=data.scene_hash,
        photographs=len(data.photographs),
        moments=data.moments,
        images=data.images,
        moment_of=data.moment_of,
        geometry=VIEW_GEOMETRY,
    )
    arrays: dict[str, npt.NDArray[Any]] = {f"photograph/{i}": image for i, image in enumerate(data.photographs)}
    arrays |= {f"rendering/{j}": image for j, image in enumerate(data.renderings)}
    arrays |= {f"ssim/{j}": code for j, code in enumerate(data.maps)}
    arrays |= {"geometry": data.geometry, "centers": data.centers}
    write_tensors(path, arrays, "header", header.model_dump(mode="json"))


def read_distortions(path: Path) -> Distortions:
    """Read what ``write_distortions`` wrote.

    Raises:
        UserError: the file is missing, truncated, not safetensors, or its parts contradict each other.
    """
    arrays, values = read_tensors(path, "header", _REMEDY)
    try:
        header = _Header.model_validate(values)
        data = Distortions(
            scene=header.scene,
            scene_hash=header.scene_hash,
            photographs=tuple(cast(Image, arrays[f"photograph/{i}"]) for i in range(header.photographs)),
            moments=header.moments,
            renderings=tuple(cast(Image, arrays[f"rendering/{j}"]) for j in range(len(header.images))),
            maps=tuple(cast(CodedMap, arrays[f"ssim/{j}"]) for j in range(len(header.images))),
            images=header.images,
            moment_of=header.moment_of,
            geometry=cast(FloatArray, arrays["geometry"]),
            centers=cast(FloatArray, arrays["centers"]),
        )
    except ValidationError as error:
        fault = "not distortion data of this program (its header is missing or damaged)"
        raise UserError(path, fault, _REMEDY) from error
    except KeyError as error:
        raise UserError(path, f"not distortion data of this program ({error.args[0]} is missing)", _REMEDY) from error
    if header.format != _FORMAT:
        raise UserError(path, f"format {header.format!r}, expected {_FORMAT!r}", _REMEDY)
    if header.geometry != VIEW_GEOMETRY:
        raise UserError(path, "tells other things of its views than this program reads", _REMEDY)
    _check(path, data)
    return data


def _check(path: Path, data: Distortions) -> None:
    """Refuse data whose numbers or sizes do not fit together."""
    sizes_agree = all(
        rendering.shape == data.photographs[image].shape and code.shape == rendering.shape[:2]
        for rendering, code, image in zip(data.renderings, data.maps, data.images, strict=True)
        if 0 <= image < len(data.photographs)
    )
    numbers = (*data.images, *(image for moment in data.moments for image in moment.captured))
    if (
        not data.renderings
        or not sizes_agree
        or not all(0 <= number < len(data.photographs) for number in numbers)
        or len(data.moment_of) != len(data.images)
        or not all(0 <= number < len(data.moments) for number in data.moment_of)
        or data.geometry.shape != (len(data), len(VIEW_GEOMETRY))
        or data.centers.shape != (len(data.photographs), 3)
        or not np.isfinite(data.geometry).all()
        or not np.isfinite(data.centers).all()
    ):
        raise UserError(path, "its renderings, photographs and moments do not fit together", _REMEDY)
