"""The photographs of a scene, decoded once."""

from __future__ import annotations

from avs.scene.cameras import IndexArray
from avs.scene.images import Pixels
from avs.scene.scene import Scene
from avs.scene.views import Views


class Photographs:
    """Reads views of one scene and keeps their pixels: an oracle looks at those of every candidate at each step."""

    def __init__(self, scene: Scene) -> None:
        """Read nothing yet."""
        self._scene = scene
        self._read: dict[int, Pixels] = {}

    def views(self, indices: IndexArray) -> Views:
        """Return the views at ``indices`` of the scene, in that order.

        Raises:
            UserError: an image is missing or damaged.
        """
        rows = indices.tolist()
        new = [row for row in rows if row not in self._read]
        self._read.update(zip(new, self._scene.views(new).images, strict=True))
        return Views(self._scene.cameras[indices], tuple(self._read[row] for row in rows))
