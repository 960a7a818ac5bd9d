"""The photographs of a scene, decoded once."""

from __future__ import annotations

from avs.scene.cameras import IndexArray
from avs.scene.images import Pixels
from avs.scene.scene import Scene
from avs.scene.views import Views


class Photographs:
    """Reads views of one scene and keeps their pixels by name: an oracle looks at those of all candidates each time."""

    def __init__(self, scene: Scene) -> None:
        """Read nothing yet."""
        self._scene = scene
        self._read: dict[str, Pixels] = {}

    def views(self, indices: IndexArray) -> Views:
        """Return the views at ``indices`` of the scene, in that order; their pixels cannot be written to.

        Raises:
            UserError: an image is missing or damaged.
        """
        names = tuple(self._scene.names[row] for row in indices)
        new = [row for row, name in zip(indices.tolist(), names, strict=True) if name not in self._read]
        read = self._scene.views(new)
        for image in read.images:  # methods are shown them, and the reconstruction learns from them
            image.setflags(write=False)
        self._read.update(zip(read.names, read.images, strict=True))
        return Views(self._scene.cameras[indices], tuple(self._read[name] for name in names), names)
