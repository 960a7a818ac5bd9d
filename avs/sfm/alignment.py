"""The similarity transform from a reconstruction with free poses to the world of the cameras given.

A reconstruction that finds its own poses has a frame and a scale of its own. Its cameras are the scene's cameras, so
that their centres, in both frames, tell the transform: the least-squares solution of Umeyama (1991), within RANSAC, as
some cameras may have been placed wrongly. Centres on one line leave a rotation about it open, which the cameras'
own rotations then decide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray, IndexArray
from avs.scene.views import Views
from avs.sfm.cloud import empty_cloud
from avs.sfm.reconstruction import Reconstruction

TOLERANCE = 0.05
"""A camera agrees if its centre comes to lie this near to where it belongs, in shares of the centres' spread."""

COLLINEAR = 0.05
"""Centres lie on one line if their second principal deviation is less than this share of the first."""

TRIALS = 300
"""Random samples of RANSAC: with half of the cameras wrong, one in eight samples of three is right."""


@dataclass(frozen=True)
class Alignment:
    """The map ``x -> scale rotation x + translation`` and how well it fits.

    Attributes:
        scale: greater than 0.
        rotation: ``[3, 3]`` float64, of determinant 1.
        translation: ``[3]`` float64.
        residual: root mean square of the distances between the centres that agree, in units of the target.
        agree: ``[n]`` bool, which of the shared cameras agree with the map.
        used_rotations: whether the cameras' rotations decided, because the centres lie on one line.
    """

    scale: float
    rotation: FloatArray
    translation: FloatArray
    residual: float
    agree: npt.NDArray[np.bool_]
    used_rotations: bool

    def points(self, positions: FloatArray) -> FloatArray:
        """Return positions ``[..., 3]`` of the source in the target's frame."""
        moved: FloatArray = self.scale * positions @ self.rotation.T + self.translation
        return moved

    def cameras(self, cameras: Cameras) -> Cameras:
        """Return cameras of the source in the target's frame; they see what they saw."""
        transforms = cameras.world_to_camera.copy()
        rotations = cameras.world_to_camera[:, :3, :3] @ self.rotation.T
        transforms[:, :3, :3] = rotations
        transforms[:, :3, 3] = self.scale * cameras.world_to_camera[:, :3, 3] - rotations @ self.translation
        return Cameras(transforms, cameras.intrinsics, cameras.sizes)


def align(source: Cameras, target: Cameras, seed: int = 0) -> Alignment | None:
    """Return the map from the frame of ``source`` to that of ``target``, or None if the cameras do not fit together.

    Args:
        source: n cameras, as estimated.
        target: the same n cameras, as they are known.
        seed: of RANSAC's samples.

    Returns:
        The map on which at least half of the cameras, and two, agree within ``TOLERANCE`` of the spread of the target's
        centres; None if there is none.
    """
    count = len(source)
    if count < 2:
        return None
    from_, to = source.centers, target.centers
    spread = math.sqrt(float(((to - to.mean(axis=0)) ** 2).sum(axis=1).mean()))
    use_rotations = _on_one_line(to) or _on_one_line(from_)
    turns = target.world_to_camera[:, :3, :3].transpose(0, 2, 1) @ source.world_to_camera[:, :3, :3]
    best, fewest = None, max(2, math.ceil(count / 2))
    for rows in _samples(count, 2 if use_rotations else 3, seed):
        found = _fitted(from_[rows], to[rows], turns[rows] if use_rotations else None)
        if found is None:
            continue
        distances = _distances(found, from_, to)
        key = (-int((distances <= TOLERANCE * spread).sum()), float(np.median(distances)))
        if best is None or key < best[0]:
            best = key, distances <= TOLERANCE * spread
    if best is None or best[1].sum() < fewest:
        return None
    return _refined(from_, to, turns if use_rotations else None, best[1], TOLERANCE * spread)


def placed(reconstruction: Reconstruction, views: Views, seed: int = 0) -> tuple[Reconstruction, Alignment | None]:
    """Return a reconstruction with free poses in the world of the cameras given, and the map that brought it there.

    Args:
        reconstruction: of a back end. With known poses it comes back as it is, with None for the map.
        views: what it was made of.
        seed: of RANSAC's samples.

    Returns:
        The reconstruction and the map. Where no map fits, an empty cloud, with the reason for every view, and None.
    """
    if reconstruction.cameras is None:
        return reconstruction, None
    rows = [views.names.index(name) for name in reconstruction.registered]
    alignment = align(reconstruction.cameras, views.cameras[np.array(rows, dtype=np.int64)], seed)
    if alignment is None:
        fault = f"the {len(rows)} registered cameras do not agree with the scene's on any similarity transform"
        lost = dict.fromkeys(reconstruction.registered, fault)
        return Reconstruction(empty_cloud(), (), {**reconstruction.left_out, **lost}), None
    cloud = reconstruction.cloud.moved_to(alignment.points(reconstruction.cloud.positions))
    cameras = alignment.cameras(reconstruction.cameras)
    return replace(reconstruction, cloud=cloud, cameras=cameras), alignment


def _samples(count: int, size: int, seed: int) -> list[IndexArray]:
    """Return rows of samples, and all rows at once as the first of them."""
    generator = np.random.default_rng(seed)
    every = np.arange(count, dtype=np.int64)
    drawn = [] if count <= size else [generator.choice(count, size, replace=False) for _ in range(TRIALS)]
    return [every, *drawn]


def _fitted(source: FloatArray, target: FloatArray, turns: FloatArray | None) -> Alignment | None:
    """Return the least-squares map of centres ``[n, 3]``, its rotation the mean of ``turns`` ``[n, 3, 3]`` if given."""
    middle, goal = source.mean(axis=0), target.mean(axis=0)
    centered, wanted = source - middle, target - goal
    variance = float((centered**2).sum())
    if not variance > 0:
        return None
    correlation = wanted.T @ centered if turns is None else turns.sum(axis=0)
    left, _, right = np.linalg.svd(correlation)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    rotation = (left * signs) @ right
    scale = float((wanted * (centered @ rotation.T)).sum()) / variance
    if not scale > 0:
        return None
    every = np.ones(len(source), dtype=bool)
    return Alignment(scale, rotation, goal - scale * rotation @ middle, 0.0, every, turns is not None)


def _refined(
    source: FloatArray, target: FloatArray, turns: FloatArray | None, agree: npt.NDArray[np.bool_], tolerance: float
) -> Alignment | None:
    """Return the map fitted to those that agree, until these are the ones that agree with it, five times at most."""
    found = None
    for _ in range(5):
        fit = _fitted(source[agree], target[agree], None if turns is None else turns[agree])
        if fit is None:
            break
        distances = _distances(fit, source, target)
        now = distances <= tolerance
        residual = math.sqrt(float((distances[agree] ** 2).mean()))
        found = replace(fit, residual=residual, agree=agree)
        if (now == agree).all() or now.sum() < agree.sum():
            break
        agree = now
    return found


def _distances(alignment: Alignment, source: FloatArray, target: FloatArray) -> FloatArray:
    distances: FloatArray = np.linalg.norm(alignment.points(source) - target, axis=1)
    return distances


def _on_one_line(centers: FloatArray) -> bool:
    deviations = np.linalg.svd(centers - centers.mean(axis=0), compute_uv=False)
    return len(centers) < 3 or bool(deviations[1] < COLLINEAR * deviations[0])
