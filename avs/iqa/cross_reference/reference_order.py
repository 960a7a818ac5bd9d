"""In which order photographs are taken to compare an image with: the first ones are its references."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.iqa.cross_reference.scorer_settings import ReferenceChoice
from avs.scene.cameras import FloatArray, IndexArray


def reference_order(
    centers: FloatArray, own: npt.ArrayLike, choice: ReferenceChoice, rng: np.random.Generator
) -> IndexArray:
    """Return the numbers of photographs in the order in which they are taken, ``[n]``.

    Args:
        centers: ``[n, 3]`` camera centres of the photographs.
        own: ``[3]`` centre of the image's own camera.
        choice: random: an order by chance. nearest: by distance to the image's own centre, ties in the order given.
        rng: decides the order by chance; nothing else is drawn from it.
    """
    if choice == "random":
        return rng.permutation(len(centers))
    return np.argsort(np.linalg.norm(centers - np.asarray(own), axis=1), kind="stable")
