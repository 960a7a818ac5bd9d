"""The reference of a scene: the cloud of all its views, and points of the true surface where that is known.

It is made once for each scene, and the clouds of all its episodes are held against it.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avs.coverage.clouds_of_views import PlacedCloud, Stopwatch, as_free, cloud_of, why_empty
from avs.coverage.coverage_record import Reference
from avs.coverage.coverage_settings import ReferenceJob
from avs.coverage.true_surface import visible_surface
from avs.scene.cameras import FloatArray, IndexArray
from avs.scene.scene import Scene, read_scene
from avs.sfm.cloud import Cloud, empty_cloud
from avs.sfm.cloud_file import read_cloud, write_cloud
from avs.system.devices import take_device
from avs.system.errors import UserError
from avs.system.files import file_hash
from avs.system.records import CHANGED, read_record, write_record
from metrics.coverage import extent, representatives

RECORD, META, CLOUD, SURFACE = "reference.json", "reference.meta.json", "reference.ply", "surface.ply"
"""What the job writes to its folder."""

_REMEDY = "delete it and run again"
_GREY = 160  # of surface points, which have no colour
_FINER = 0.2
"""One point of the surface is kept in each voxel of this share of the edge: by default the least threshold."""


@dataclass(frozen=True)
class ReferenceFiles:
    """A reference as it was read.

    Attributes:
        record: what is told of it.
        cloud: of all views.
        surface_cloud: points of the true surface; none where it is not known.
    """

    record: Reference
    cloud: Cloud
    surface_cloud: Cloud

    @property
    def surface(self) -> FloatArray | None:
        """Points ``[m, 3]`` of the true surface; None where it is not known."""
        return self.surface_cloud.positions if len(self.surface_cloud) else None


def write_reference(scene_folder: Path, settings: ReferenceJob, out: Path) -> None:
    """Make the reference of a scene and write its record, its facts of the run and two clouds to the folder ``out``.

    A scene whose views give no cloud has a reference without points: its record says why, and no coverage is measured
    against it.

    Args:
        scene_folder: a scene, as ``avs.scene.scene`` writes it.
        settings: the back end, and which views.
        out: folder of the results.

    Raises:
        UserError: the scene is damaged or has too few views, or the back end cannot run here.
    """
    take_device(settings.device)
    watch, scene = Stopwatch(settings.device), read_scene(scene_folder)
    rows = np.arange(len(scene.names)) if settings.reference_views == "all" else scene.pool
    start = time.perf_counter()
    made = cloud_of(scene, rows, settings.sfm, scene_folder, settings.device)
    seconds = time.perf_counter() - start
    size = _extent(made.reconstruction.cloud, settings)
    surface = _surface(scene, rows, settings.voxel * (size or 0.0))
    write_cloud(out / CLOUD, made.reconstruction.cloud)
    write_cloud(out / SURFACE, surface)
    write_record(out / META, watch.facts(seconds))
    write_record(out / RECORD, _record(scene, rows, settings, made, size, len(surface), out))


def read_reference(folder: Path, scene: Scene) -> ReferenceFiles:
    """Read what ``write_reference`` wrote.

    Args:
        folder: its folder.
        scene: whose reference it is.

    Raises:
        UserError: a file is missing, is not as it was written, or is of another version of the scene.
    """
    record = read_record(folder / RECORD, Reference)
    if record.scene_hash != scene.content_hash:
        raise UserError(folder / RECORD, "is of another version of the scene", _REMEDY)
    clouds = {}
    for name in (CLOUD, SURFACE):
        clouds[name], _ = read_cloud(folder / name, _REMEDY)
        if file_hash(folder / name) != record.files.get(name):
            raise UserError(folder / name, CHANGED, _REMEDY)
    return ReferenceFiles(record, clouds[CLOUD], clouds[SURFACE])


def _extent(cloud: Cloud, settings: ReferenceJob) -> float | None:
    """Return the extent of a cloud, or None where it has none."""
    size = extent(cloud.positions, settings.extent) if len(cloud) else 0.0
    return size if size > 0 else None


def _surface(scene: Scene, rows: IndexArray, voxel: float) -> Cloud:
    """Return the true surface that the views see, without colours; an empty cloud where it is not known.

    The confidence of a point is the number of pixels that a voxel's edge takes there. Where it is 1 or more, images are
    as fine as voxels, so that equal areas hold equally many; only these points are to be covered (``two_clouds``).
    Points of both kinds are kept, one for each voxel of ``_FINER`` of the edge: whether a cloud lies on the surface
    does not depend on how far away that is.
    """
    found = visible_surface(scene, rows)
    if found is None or not voxel > 0:
        return empty_cloud()
    pixels = found.resolution * voxel
    groups = [np.flatnonzero(pixels >= 1), np.flatnonzero(pixels < 1)]
    kept = np.concatenate([group[representatives(found.points[group], _FINER * voxel)] for group in groups])
    colors = np.full((len(kept), 3), _GREY, dtype=np.uint8)
    return Cloud(found.points[kept], colors, pixels[kept].astype(np.float32))


def _record(
    scene: Scene,
    rows: IndexArray,
    settings: ReferenceJob,
    made: PlacedCloud,
    size: float | None,
    surface: int,
    out: Path,
) -> Reference:
    found = made.reconstruction
    lost = [] if size is not None else [f"{scene.name}: the cloud of all views has no extent: {why_empty(found)}"]
    return Reference(
        scene=scene.name,
        dataset=scene.dataset,
        scene_hash=scene.content_hash,
        settings=settings.model_dump(mode="json"),
        views=[scene.names[row] for row in rows],
        registered=list(found.registered),
        left_out=dict(found.left_out),
        points=len(found.cloud),
        extent=size,
        surface_points=surface,
        placement=made.placement,
        cameras=None if found.cameras is None else as_free(found.cameras, found.registered),
        notes=[*found.notes, *lost],
        files={name: file_hash(out / name) for name in (CLOUD, SURFACE)},
    )
