"""The pictures that an episode keeps beside its record: small JPEG files in one archive, which any program opens.

``pictures.zip`` holds ``final_000.jpg`` and so on, the final renderings of ``KeptPictures.test``; and for each view
that was chosen, ``choice_<step>_<place>_rendering.jpg``, ``..._predicted.jpg`` and ``..._true.jpg``, where the place is
that in ``Step.chosen``. Maps of SSIM are grey, from black for 0 or less to white for 1.
Equal episodes give equal bytes.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from avs.nvs.picture_settings import PICTURES, PictureSettings
from avs.nvs.record import Episode, KeptPictures
from avs.representations.base import FloatImages, Renderer
from avs.scene.cameras import Cameras
from avs.scene.even_places import evenly_spread
from avs.scene.views import Views
from avs.selection.contract import Method, PredictsMaps, Selector, State
from avs.selection.untouched import untouched
from avs.system.errors import UserError
from avs.system.files import atomic_path
from metrics.image import ssim_map

_WRITTEN = (1980, 1, 1, 0, 0, 0)  # the first moment that an archive can tell: a later one would differ from run to run
_LEVELS = 255.0
_REMEDY = "delete the episode and run again"

Files = Mapping[str, bytes]


def final_rows(count: int, settings: PictureSettings) -> list[int]:
    """Return the places of the test images whose renderings are kept, ascending, of ``count`` in the order of names."""
    return evenly_spread(count, settings.test_images)


def final_files(renderer: Renderer, cameras: Cameras, settings: PictureSettings) -> dict[str, bytes]:
    """Return the renderings of the test images that are kept.

    Args:
        renderer: the final reconstruction.
        cameras: of all test images, in the order of names.
        settings: which are kept, and how.
    """
    rows = enumerate(final_rows(len(cameras), settings))
    return {f"final_{place:03d}.jpg": _encoded(_rendered(renderer, cameras[[row]]), settings) for place, row in rows}


def predicted_maps(
    method: Method, selector: Selector, state: State, rows: Iterable[int]
) -> list[npt.NDArray[np.float32]]:
    """Return the maps that a method predicts of the views that it just chose; none where it predicts no maps.

    Args:
        method: its metadata.
        selector: what ``method`` built.
        state: what the method saw.
        rows: of ``state.candidates`` that were chosen, in order of preference.

    Raises:
        UserError: the method changed what it was shown.
        ValueError: the method's map is none.
    """
    if not isinstance(selector, PredictsMaps):
        return []
    with untouched(method.label, state):
        return [_predicted(selector, state, row) for row in rows]


def chosen_files(
    renderer: Renderer,
    photographs: Views,
    maps: Sequence[npt.NDArray[np.float32]],
    step: int,
    settings: PictureSettings,
) -> dict[str, bytes]:
    """Return the pictures of the views that were just chosen.

    Args:
        renderer: the reconstruction that the method saw.
        photographs: of the chosen views, in order of preference; no method sees them.
        maps: that the method predicts of them, in that order; or none.
        step: number of the selection, from 0.
        settings: how they are kept.
    """
    files = {}
    for place, photograph in enumerate(photographs.images):
        rendering = _rendered(renderer, photographs.cameras[[place]])
        name = f"choice_{step:02d}_{place}"
        files[f"{name}_rendering.jpg"] = _encoded(rendering, settings)
        files[f"{name}_true.jpg"] = _encoded(ssim_map(rendering, photograph), settings)
    for place, predicted in enumerate(maps):
        files[f"choice_{step:02d}_{place}_predicted.jpg"] = _encoded(predicted, settings)
    return files


def archive(files: Files) -> bytes:
    """Return ``files`` by name as an archive; JPEG does not become smaller, so that nothing is compressed."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED) as opened:
        for name in sorted(files):
            opened.writestr(zipfile.ZipInfo(name, _WRITTEN), files[name])
    return stream.getvalue()


def kept_pictures(content: bytes, test: list[str]) -> KeptPictures:
    """Return what a record says of an archive with this content and the renderings of these test images."""
    return KeptPictures(sha256=hashlib.sha256(content).hexdigest(), test=test)


def write_pictures(folder: Path, content: bytes) -> None:
    """Write the archive of an episode to its folder."""
    with atomic_path(folder / PICTURES) as temporary:
        temporary.write_bytes(content)


def read_pictures(record: Path, episode: Episode) -> dict[str, npt.NDArray[np.uint8]]:
    """Return the pictures of an episode by name without suffix, such as ``choice_03_0_rendering``.

    Args:
        record: the ``episode.json``, beside which they lie.
        episode: what it holds.

    Returns:
        Renderings ``[height, width, 3]`` and maps ``[height, width]``; nothing where the episode keeps none.

    Raises:
        UserError: the archive is missing, or is not the one that the record tells of.
    """
    if episode.pictures is None:
        return {}
    path = record.with_name(PICTURES)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise UserError(path, (error.strerror or "cannot be read").lower(), _REMEDY) from error
    if hashlib.sha256(content).hexdigest() != episode.pictures.sha256:
        raise UserError(path, "is not the file that the record beside it tells of", _REMEDY)
    with zipfile.ZipFile(io.BytesIO(content)) as opened:
        return {name.removesuffix(".jpg"): _decoded(opened.read(name)) for name in opened.namelist()}


def shrunk(pixels: npt.NDArray[np.uint8], long_side: int) -> npt.NDArray[np.uint8]:
    """Return an image ``[height, width]`` or ``[height, width, 3]`` with its long side at most ``long_side`` pixels."""
    height, width = pixels.shape[:2]
    scale = long_side / max(height, width)
    if scale >= 1:
        return pixels
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    return np.asarray(Image.fromarray(pixels).resize(size, Image.Resampling.BOX))


def _rendered(renderer: Renderer, camera: Cameras) -> FloatImages:
    """Return the rendering ``[height, width, 3]`` of a batch of one camera."""
    return np.asarray(renderer.render(camera).rgb[0])


def _predicted(selector: PredictsMaps, state: State, row: int) -> npt.NDArray[np.float32]:
    """Return the map that a method predicts of a candidate; a plug-in's author needs to know at once if it is none."""
    values = np.asarray(selector.predicted_map(state, row), dtype=np.float32)
    if values.ndim != 2 or not np.isfinite(values).all():
        fault = "predicted a map that is no array [height, width] of finite numbers"
        raise ValueError(f"{type(selector).__name__} {fault}")
    return values


def _encoded(values: npt.NDArray[np.floating[Any]], settings: PictureSettings) -> bytes:
    """Return a picture of values in 0..1 as JPEG; what lies outside is clipped."""
    pixels = np.rint(np.clip(values, 0.0, 1.0) * _LEVELS).astype(np.uint8)
    stream = io.BytesIO()
    Image.fromarray(shrunk(pixels, settings.long_side)).save(stream, "JPEG", quality=settings.quality, subsampling=0)
    return stream.getvalue()


def _decoded(content: bytes) -> npt.NDArray[np.uint8]:
    with Image.open(io.BytesIO(content)) as opened:
        return np.asarray(opened)
