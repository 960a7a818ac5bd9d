"""What feed-forward networks give: a point and a confidence for each pixel, and cameras, in a frame of their own."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image
from pydantic import Field

from avs.scene.cameras import Cameras, FloatArray
from avs.scene.views import Views
from avs.sfm.alignment import placed
from avs.sfm.cloud import Cloud
from avs.sfm.reconstruction import BackEndSettings, Reconstruction
from avs.system.reasons import Reason

WEIGHTS = "model.safetensors"
"""The file that a folder of weights must hold, beside ``config.json``; no other format is read."""


class NetworkSettings(BackEndSettings):
    """Base of the settings of a network."""

    weights: Path | None = Field(None, description=f"folder with {WEIGHTS} and config.json; nothing is downloaded")
    side: int = Field(512, ge=32, description="long side in pixels of the pictures that the network gets")
    least_confidence: float = Field(1.5, description="of a point, in the network's own unit")
    every: int = Field(2, ge=1, description="pixels in a row and in a column of which one gives a point")

    def lacks(self) -> Reason | None:
        """Return why there are no weights, or None."""
        if self.weights is None:
            return Reason(cause="no weights are given", remedy="fetch them, then set sfm.weights to their folder")
        if not (self.weights / WEIGHTS).is_file():
            return Reason(cause=f"{self.weights / WEIGHTS} does not exist", remedy="check sfm.weights")
        return None


@dataclass(frozen=True)
class PointMaps:
    """What a network says of n views.

    Attributes:
        positions: n arrays ``[h, w, 3]``, in one frame.
        colors: n arrays ``[h, w, 3]`` uint8.
        confidence: n arrays ``[h, w]``; what is not to be used has NaN or 0.
        camera_to_world: ``[n, 4, 4]`` float64, poses in that frame.
    """

    positions: Sequence[npt.NDArray[Any]]
    colors: Sequence[npt.NDArray[np.uint8]]
    confidence: Sequence[npt.NDArray[Any]]
    camera_to_world: FloatArray


def reconstruction_of(maps: PointMaps, views: Views, settings: NetworkSettings) -> Reconstruction:
    """Return the cloud of point maps, in the world of the views' cameras if their poses are known.

    Networks that take known poses give points in a frame of the first camera, in metres, or in the world, depending on
    the network and its version. The cameras that they give tell which, whatever it is.
    """
    step = settings.every
    positions = np.concatenate([one[::step, ::step].reshape(-1, 3) for one in maps.positions]).astype(np.float64)
    colors = np.concatenate([one[::step, ::step].reshape(-1, 3) for one in maps.colors])
    confidence = np.concatenate([one[::step, ::step].reshape(-1) for one in maps.confidence]).astype(np.float32)
    used = np.isfinite(positions).all(axis=1) & np.isfinite(confidence)
    used[used] = confidence[used] >= max(settings.least_confidence, 0)
    cloud = Cloud(positions[used], colors[used], confidence[used])
    cameras = Cameras(inverses(maps.camera_to_world), views.cameras.intrinsics, views.cameras.sizes)
    found = Reconstruction(cloud, views.names, cameras=cameras)
    if settings.poses == "free":
        return found
    moved, alignment = placed(found, views, settings.seed)
    if alignment is None:
        return Reconstruction(moved.cloud, (), moved.left_out)
    note = f"cameras returned by the network: {alignment.residual:.2g} scene units from those given"
    return Reconstruction(moved.cloud, moved.registered, moved.left_out, notes=(note,))


class PictureFiles:
    """The pictures of views as PNG files in a temporary folder, for networks that read files; a context manager."""

    def __init__(self, views: Views) -> None:
        self._views = views

    def __enter__(self) -> list[str]:
        """Write the files and return their paths."""
        self._folder = tempfile.TemporaryDirectory(prefix="avs-sfm-")
        paths = [str(Path(self._folder.name) / f"{row:05d}.png") for row in range(len(self._views))]
        for path, image in zip(paths, self._views.images, strict=True):
            Image.fromarray(image).save(path)
        return paths

    def __exit__(self, *_: object) -> None:
        """Remove them."""
        self._folder.cleanup()


def as_array(values: Any) -> npt.NDArray[Any]:  # noqa: ANN401 - a tensor of any device, or an array
    """Return the numbers of a tensor."""
    return np.asarray(values.detach().cpu().numpy() if hasattr(values, "detach") else values)


def as_bytes(colors: Any) -> npt.NDArray[np.uint8]:  # noqa: ANN401
    """Return colours in 0..1 as bytes."""
    rounded: npt.NDArray[np.uint8] = np.rint(np.clip(as_array(colors), 0, 1) * 255).astype(np.uint8)
    return rounded


def inverses(transforms: npt.NDArray[Any]) -> FloatArray:
    """Return the inverses ``[n, 4, 4]`` of rigid transforms ``[n, 4, 4]`` or ``[n, 3, 4]``."""
    whole = np.tile(np.eye(4), (len(transforms), 1, 1))
    whole[:, :3] = transforms[:, :3]
    return np.asarray(np.linalg.inv(whole), dtype=np.float64)
