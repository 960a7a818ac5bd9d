"""One photograph under several names: a test photograph that is also a candidate would be learned by heart."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from PIL import Image

from avs.scene.cameras import Cameras, FloatArray
from avs.scene.colmap import Model
from avs.scene.images import Pixels

_NEAR = 1e-3
"""Distance of two cameras that may have taken one photograph, as a share of their median distance from the middle."""

_TURN = 2 * np.sqrt(2) * np.sin(np.radians(0.1) / 2)
"""Their turn of 0.1 degrees, as the Frobenius norm of the difference of two rotations."""

_SIDE, _SQUARE = 32, 4
"""Pixels to which a photograph's sides are reduced at most, each the mean of as many on a side at the least, so that
neither noise nor compression counts."""

_ALIKE = 2.0
"""Root mean square difference, of 255, between two such pictures that count as one: JPEG of quality 30 makes 1."""


@dataclass(frozen=True)
class Repeats:
    """Images that are others once more, by name, with the name of the earlier one.

    Attributes:
        equal: those of the same pixels.
        similar: those of nearly the same pose and picture, such as a photograph that was saved again as JPEG.
    """

    equal: Mapping[str, str] = field(default_factory=dict)
    similar: Mapping[str, str] = field(default_factory=dict)

    @property
    def names(self) -> frozenset[str]:
        """All of them."""
        return frozenset((*self.equal, *self.similar))


def find_repeats(
    names: Sequence[str], hashes: Sequence[str], cameras: Cameras, read: Callable[[int], Pixels]
) -> Repeats:
    """Find the images that are earlier ones by name once more.

    Args:
        names: of the n images.
        hashes: of their pixels.
        cameras: of the n images.
        read: returns an image's pixels; it is asked for those alone that have a pose nearly in common.
    """
    equal = repeated(dict(zip(names, hashes, strict=True)))
    order = [index for index in sorted(range(len(names)), key=names.__getitem__) if names[index] not in equal]
    similar: dict[str, str] = {}
    for first, second in _pairs_of_one_pose(cameras, order):
        if not {names[first], names[second]} & similar.keys() and _are_alike(read(first), read(second)):
            similar[names[second]] = names[first]
    return Repeats(equal, similar)


def repeated(hashes: Mapping[str, str]) -> dict[str, str]:
    """Return the images whose pixels are those of an earlier one, by name, with the name of that one.

    Args:
        hashes: of the pixels of each image, by name.
    """
    first: dict[str, str] = {}
    originals = {name: first.setdefault(hashes[name], name) for name in sorted(hashes)}
    return {name: original for name, original in originals.items() if name != original}


def without(model: Model, names: Collection[str]) -> Model:
    """Return the model without the images of these names."""
    kept = {number: image for number, image in model.images.items() if image.name not in names}
    return replace(model, images=kept)


def repeat_notes(repeats: Repeats) -> list[str]:
    """Return the notes on images that are others once more, if there are any."""
    causes = {
        "they are other images once more": repeats.equal,
        "they are nearly other images once more, in pose and picture": repeats.similar,
    }
    return [
        f"left out, since {cause}: {', '.join(f'{name} ({original})' for name, original in found.items())}"
        for cause, found in causes.items()
        if found
    ]


def _pairs_of_one_pose(cameras: Cameras, order: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of ``order``, the earlier one first, that stand at nearly the same pose."""
    centers, turns = cameras.centers[order], cameras.world_to_camera[order, :3, :3]
    near = _NEAR * float(np.median(_lengths(centers - np.median(centers, axis=0)))) if len(order) else 0.0
    for place, first in enumerate(order):
        later = slice(place + 1, None)
        found = _lengths(centers[later] - centers[place]) <= near
        found &= _lengths((turns[later] - turns[place]).reshape(-1, 9)) <= _TURN
        yield from ((first, order[place + 1 + each]) for each in np.flatnonzero(found).tolist())


def _lengths(vectors: FloatArray) -> FloatArray:
    lengths: FloatArray = np.linalg.norm(vectors, axis=1)
    return lengths


def _are_alike(first: Pixels, second: Pixels) -> bool:
    height, width = (min(sides) for sides in zip(first.shape[:2], second.shape[:2], strict=True))
    size = tuple(max(1, min(_SIDE, side // _SQUARE)) for side in (width, height))
    one, other = (
        np.asarray(Image.fromarray(each).resize(size, Image.Resampling.BOX), dtype=np.float64)
        for each in (first, second)
    )
    return bool(np.sqrt(((one - other) ** 2).mean()) < _ALIKE)
