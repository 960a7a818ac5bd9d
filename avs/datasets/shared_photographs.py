"""Photographs that two scenes have in common, as a copy of a capture without one of them has."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from avs.system.files import explained, file_hash

Scene = TypeVar("Scene")


def shared_photographs(
    scenes: Sequence[Scene],
    photographs: Callable[[Scene], Sequence[Path]],
    may_not_share: Callable[[Scene, Scene], object],
) -> list[tuple[Scene, Scene, list[str]]]:
    """Find the scenes that have a photograph in common and may not.

    Only files of a size that both have are read: photographs of other scenes seldom have as many bytes, and to read all
    of them takes minutes.

    Args:
        scenes: in order.
        photographs: returns the files of a scene.
        may_not_share: whether it matters that the second scene, which comes later, shares a photograph with the first.

    Returns:
        The two scenes and the names of the shared photographs in the second, ascending, for each such pair in order.

    Raises:
        UserError: a file cannot be read.
    """
    by_size: dict[int, list[tuple[int, Path]]] = defaultdict(list)
    with explained():
        for place, scene in enumerate(scenes):
            for path in photographs(scene):
                by_size[path.stat().st_size].append((place, path))
        by_size.pop(0, None)
        shared: dict[tuple[int, int], list[str]] = defaultdict(list)
        for files in by_size.values():
            owners = sorted({place for place, _ in files})
            pairs = [pair for pair in itertools.combinations(owners, 2) if may_not_share(*(scenes[i] for i in pair))]
            concerned = {place for pair in pairs for place in pair}
            hashes: dict[int, dict[str, str]] = defaultdict(dict)
            for place, path in files:
                if place in concerned:
                    hashes[place][file_hash(path)] = path.name
            for first, second in pairs:
                shared[first, second] += [name for key, name in hashes[second].items() if key in hashes[first]]
    return [(scenes[i], scenes[j], sorted(names)) for (i, j), names in sorted(shared.items()) if names]
