"""Clouds of some of a scene's views, all in one frame; and what is told of how they were made."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from avs.coverage.coverage_record import CoverageMeta, FreeCamera, Placement
from avs.scene.cameras import Cameras, IndexArray
from avs.scene.scene import Scene
from avs.sfm.alignment import Alignment, placed
from avs.sfm.back_end_registry import reconstruct
from avs.sfm.reconstruction import BackEndSettings, Reconstruction
from avs.system import provenance
from avs.system.machine_load import LoadMeter


@dataclass(frozen=True)
class PlacedCloud:
    """A reconstruction in scene coordinates.

    Attributes:
        reconstruction: its cloud and what registered.
        placement: how it was brought there; None for known poses, and where no cameras agreed.
    """

    reconstruction: Reconstruction
    placement: Placement | None


class Stopwatch:
    """Measures one job from its making on."""

    def __init__(self, device: str) -> None:
        """Begin."""
        self._device, self._started, self._load = device, provenance.now(), LoadMeter()
        self._start = time.perf_counter()

    def facts(self, reconstruction_seconds: float) -> CoverageMeta:
        """Return what differs from run to run, at the end of the job."""
        return CoverageMeta(
            reconstruction_seconds=reconstruction_seconds,
            total_seconds=time.perf_counter() - self._start,
            peak_memory_bytes=provenance.peak_memory(self._device),
            other_cores=self._load.others(),
            device=self._device,
            machine=provenance.machine(self._device),
            packages=provenance.packages(),
            revision=provenance.revision(),
            started=self._started,
            finished=provenance.now(),
        )


def cloud_of(
    scene: Scene,
    rows: IndexArray,
    settings: BackEndSettings,
    subject: object,
    device: str,
    found: Mapping[str, FreeCamera] | None = None,
) -> PlacedCloud:
    """Return the cloud of the views at ``rows``, in the scene's coordinates.

    The views go to the back end in the order of the scene, so that the same views give the same cloud whatever the
    order of their capture.

    Args:
        scene: whose views they are.
        rows: indices of the views.
        settings: of the back end.
        subject: what errors name, such as the episode that chose the views.
        device: where networks run.
        found: cameras of the reference by name, where it found its own: a cloud with free poses is aligned to these, so
            that no error of the reference's own alignment lies between the two.

    Raises:
        UserError: see ``avs.sfm.back_end_registry.reconstruct``.
    """
    views = scene.views(np.sort(rows))
    reconstruction = reconstruct(views, settings, subject, device)
    targets = replace(views, cameras=_with_found(views.cameras, views.names, found or {}))
    moved, alignment = placed(reconstruction, targets, settings.seed)
    return PlacedCloud(moved, None if alignment is None else _placement(alignment))


def why_empty(reconstruction: Reconstruction) -> str:
    """Return why a reconstruction has no points, in one line."""
    reasons = dict.fromkeys(reconstruction.left_out.values())
    told = "; ".join(reasons) if len(reasons) <= 3 else "; ".join([*list(reasons)[:3], "..."])
    return told or "its views agree on no point"


def as_free(cameras: Cameras, names: tuple[str, ...]) -> dict[str, FreeCamera]:
    """Return cameras as a record keeps them, by name."""
    return {
        name: FreeCamera(world_to_camera=transform.tolist(), intrinsics=matrix.tolist())
        for name, transform, matrix in zip(names, cameras.world_to_camera, cameras.intrinsics, strict=True)
    }


def _with_found(cameras: Cameras, names: tuple[str, ...], found: Mapping[str, FreeCamera]) -> Cameras:
    """Return ``cameras``, those in ``found`` in place of the scene's own."""
    transforms = cameras.world_to_camera.copy()
    for row, name in enumerate(names):
        if name in found:
            transforms[row] = found[name].world_to_camera
    return replace(cameras, world_to_camera=transforms)


def _placement(alignment: Alignment) -> Placement:
    return Placement(
        scale=alignment.scale,
        residual=alignment.residual,
        agreeing=int(alignment.agree.sum()),
        shared=len(alignment.agree),
    )
