"""How the map grows where it is empty or wrong, and is optimised on keyframes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from scipy.spatial import KDTree
from torch import Tensor
from torch.nn import Parameter

from avs.rasterizer.adam import Adam
from avs.rasterizer.losses import Target, photometric_loss, prepare_target
from avs.scene.cameras import Cameras
from avs.slam.building.simulator import Frame
from avs.slam.mapping.gaussian_map import (
    NAMES,
    MapTensors,
    Seen,
    camera_tensors,
    extended,
    gaussians_of,
    map_rendering,
    map_seen,
    points_of,
)
from avs.slam.mapping.mapper_settings import GrowthSettings, MapperSettings, PruningSettings

_CPU = torch.device("cpu")


@dataclass(frozen=True)
class Lesson:
    """A picture as the optimisation takes it.

    Attributes:
        camera: a batch of one.
        target: its colours.
        depth: ``[height, width]`` metres.
        valid: ``[height, width]`` where there is a depth.
    """

    camera: Cameras
    target: Target
    depth: Tensor
    valid: Tensor


def lesson(frame: Frame, camera: Cameras) -> Lesson:
    """Return a picture as the optimisation takes it."""
    depth = torch.from_numpy(frame.depth)
    return Lesson(camera, prepare_target(frame.rgb, _CPU), depth, depth > 0)


def grown(
    tensors: MapTensors, frame: Frame, camera: Cameras, settings: GrowthSettings, rng: np.random.Generator
) -> MapTensors:
    """Return the map with Gaussians at the pixels of a picture that it does not explain.

    A pixel with a depth gets one where less than ``silhouette`` of the map is in front of it, or where the map lies
    behind it by more than ``error_factor`` times the median error, or has no centre within ``spacing`` of it.
    """
    if len(tensors["means"]):
        wanted = unexplained(map_seen(tensors, camera), frame, settings)
    else:
        wanted = frame.depth > settings.nearest
    if settings.spacing is not None and len(tensors["means"]):
        wanted |= _sparse(tensors, frame, camera, settings)
    lattice = np.zeros_like(wanted)
    lattice[settings.stride // 2 :: settings.stride, settings.stride // 2 :: settings.stride] = True
    wanted = _limited(wanted & lattice, len(tensors["means"]), settings.max_gaussians, rng)
    return extended(tensors, gaussians_of(frame, camera, wanted, settings.opacity, settings.stride))


def _sparse(tensors: MapTensors, frame: Frame, camera: Cameras, settings: GrowthSettings) -> npt.NDArray[np.bool_]:
    """Return the pixels ``[height, width]`` with a depth whose point has no Gaussian's centre within ``spacing``."""
    valid = frame.depth > settings.nearest
    means = tensors["means"].detach().numpy()
    points, found = points_of(frame, camera, valid), np.zeros_like(valid)
    if len(points):
        around = (means >= points.min(axis=0) - settings.spacing) & (means <= points.max(axis=0) + settings.spacing)
        tree = KDTree(means[around.all(axis=1)])
        found[valid] = ~np.isfinite(tree.query(points, distance_upper_bound=settings.spacing)[0])
    return found


def unexplained(seen: Seen, frame: Frame, settings: GrowthSettings) -> npt.NDArray[np.bool_]:
    """Return the pixels ``[height, width]`` of a picture that a rendering does not explain; see ``grown``."""
    valid = frame.depth > settings.nearest
    depth = seen.depth.numpy()
    error = np.where(valid, np.abs(depth - frame.depth), 0)
    # SplaTAM's median is over all pixels, those without a depth counting as 0.
    behind = (depth > frame.depth) & (error > settings.error_factor * np.median(error))
    return np.asarray(((seen.alpha.numpy() < settings.silhouette) | behind) & valid)


def optimised(
    tensors: MapTensors,
    lessons: Sequence[Lesson],
    settings: MapperSettings,
    radius: float,
    rng: np.random.Generator,
) -> tuple[MapTensors, float]:
    """Return the map after one optimisation on ``lessons``, each iteration on one of them by chance; and its mean loss.

    ``radius`` is that of the scene, in metres, which the pruning is relative to.
    """
    optimizers = _optimizers(tensors, settings)
    total = 0.0
    for iteration, index in enumerate(rng.integers(len(lessons), size=settings.iterations)):
        loss = mapping_loss(tensors, lessons[index], settings)
        loss.backward()  # type: ignore[no-untyped-call]
        total += float(loss.detach())
        if iteration in settings.pruning.iterations:
            tensors, optimizers = _pruned(tensors, optimizers, settings.pruning, radius)
        for optimizer in optimizers.values():
            optimizer.step()
            optimizer.zero_grad()
    return tensors, total / settings.iterations


def mapping_loss(tensors: MapTensors, shown: Lesson, settings: MapperSettings) -> Tensor:
    """Return the loss of the map on a picture: the mean error of depth where there is one, and the photometric loss."""
    width, height = (int(side) for side in shown.camera.sizes[0])
    seen = map_rendering(tensors, *camera_tensors(shown.camera), width, height)
    loss = settings.color_weight * photometric_loss(seen.rgb, shown.target, settings.ssim_weight)
    if bool(shown.valid.any()):
        loss = loss + settings.depth_weight * (seen.depth - shown.depth)[shown.valid].abs().mean()
    return loss


def _optimizers(tensors: MapTensors, settings: MapperSettings) -> dict[str, Adam]:
    return {name: Adam(tensors[name], getattr(settings.rates, name), settings.adam_epsilon) for name in NAMES}


def _pruned(
    tensors: MapTensors, optimizers: dict[str, Adam], settings: PruningSettings, radius: float
) -> tuple[MapTensors, dict[str, Adam]]:
    """Return the map without what is too faint or too large, with gradients and moments of the others."""
    with torch.no_grad():
        faint = tensors["opacities"].sigmoid() < settings.opacity
        large = tensors["scales"][:, 0] > math.log(settings.scale * radius)
        kept = torch.nonzero(~(faint | large))[:, 0]
    if len(kept) == len(tensors["means"]):
        return tensors, optimizers
    fewer: MapTensors = {}
    for name in NAMES:
        old = tensors[name]
        fewer[name] = Parameter(old.detach()[kept])
        fewer[name].grad = None if old.grad is None else old.grad[kept]
        optimizer, state = optimizers[name], optimizers[name].state.pop(old, {})
        optimizer.param_groups[0]["params"] = [fewer[name]]
        moments = {key: value[kept] if isinstance(value, Tensor) else value for key, value in state.items()}
        optimizer.state[fewer[name]].update(moments)
    return fewer, optimizers


def _limited(
    wanted: npt.NDArray[np.bool_], present: int, limit: int | None, rng: np.random.Generator
) -> npt.NDArray[np.bool_]:
    """Return ``wanted``, or so many of it by chance that ``limit`` is kept."""
    places = np.flatnonzero(wanted)
    if limit is None or present + len(places) <= limit:
        return wanted
    kept = np.zeros(wanted.size, bool)
    kept[rng.permutation(places)[: max(limit - present, 0)]] = True
    return kept.reshape(wanted.shape)
