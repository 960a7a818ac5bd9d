"""Projection of all Gaussians into all cameras, differentiable in the Gaussians and in the poses."""

from __future__ import annotations

import functools
from typing import Any, cast

import numpy as np
import torch
from torch import Tensor

from avs.rasterizer.constants import ALPHA_MIN, FIELD_OF_VIEW_MARGIN, LARGEST_RADIUS
from avs.rasterizer.ewa import project, project_backward
from avs.rasterizer.gaussian_rows import COMPENSATION, CONIC, ROWS, gather_gaussian, load_gaussian
from avs.rasterizer.kernels import Context, Floats, Integers, Number, Numbers, kernel
from avs.rasterizer.simd import broadcast
from avs.rasterizer.simd_memory import load, load_rows, store, store_rows, sum_lanes
from avs.rasterizer.simd_types import LANES

# Where the rows of scratch memory begin after those of ``gaussian_rows``: centre in the image and depth (3), blurred
# variances (2); in the backward pass the gradients of centre and depth (3), conic (3) and compensation, then those of
# centre (3), quaternion (4) and scale (3).
_IMAGE, _DEPTH, _VARIANCE, _SCRATCH = (ROWS + LANES * row for row in (0, 2, 3, 5))
_V_IMAGE, _V_DEPTH, _V_CONIC, _V_COMPENSATION, _V_MEAN, _V_QUAT, _V_SCALE, _BACKWARD_SCRATCH = (
    ROWS + LANES * row for row in (0, 2, 3, 6, 7, 10, 14, 17)
)


# Long because sixteen Gaussians are gathered into vectors and scattered again, number by number.
@kernel
def _project_kernel(
    means: Floats, quats: Floats, scales: Floats, opacities: Floats, pose: Numbers, lens: Numbers, size: Numbers,
    planes: Numbers, eps2d: Number, radius_clip: Number, antialiased: bool, means2d: Floats, depths: Floats,
    conics: Floats, compensations: Floats, radii: Integers,
) -> None:  # fmt: skip
    """Fill the outputs for one camera; those of Gaussians that are out of sight are 0."""
    count = len(means)
    rows = np.empty(_SCRATCH, np.float32)
    for start in range(0, count, LANES):
        for lane in range(LANES):
            gather_gaussian(rows, lane, means, quats, scales, min(start + lane, count - 1))
        mean, quat, scale = load_gaussian(rows)
        image, depth, conic, variance, compensation = project(mean, quat, scale, pose, lens, eps2d)
        store_rows(rows, _IMAGE, image)
        store(rows, _DEPTH, depth)
        store_rows(rows, CONIC, conic)
        store_rows(rows, _VARIANCE, variance)
        store(rows, COMPENSATION, compensation)
        for lane in range(min(LANES, count - start)):
            i = start + lane
            z = rows[_DEPTH + lane]
            radius_x = np.float32(0.0)
            radius_y = np.float32(0.0)
            if z >= planes[0] and z <= planes[1]:
                opacity = opacities[i]
                if antialiased:
                    opacity *= rows[COMPENSATION + lane]
                if opacity >= np.float32(ALPHA_MIN):
                    extent = np.sqrt(np.float32(2.0) * np.log(opacity * np.float32(1.0 / ALPHA_MIN)))
                    radius_x = np.ceil(extent * np.sqrt(rows[_VARIANCE + lane]))
                    radius_y = np.ceil(extent * np.sqrt(rows[_VARIANCE + LANES + lane]))
                    x = rows[_IMAGE + lane]
                    y = rows[_IMAGE + LANES + lane]
                    seen = x + radius_x > 0 and x - radius_x < size[0] and y + radius_y > 0 and y - radius_y < size[1]
                    # false for numbers that are not finite, too
                    definite = rows[CONIC + lane] > 0 and rows[CONIC + 2 * LANES + lane] > 0
                    sane = radius_x < LARGEST_RADIUS and radius_y < LARGEST_RADIUS and definite
                    if not (seen and sane and (radius_x > radius_clip or radius_y > radius_clip)):
                        radius_x = np.float32(0.0)
            if radius_x > 0 and radius_y > 0:
                radii[i, 0] = np.int32(radius_x)
                radii[i, 1] = np.int32(radius_y)
                means2d[i, 0] = rows[_IMAGE + lane]
                means2d[i, 1] = rows[_IMAGE + LANES + lane]
                depths[i] = z
                for k in range(3):
                    conics[i, k] = rows[CONIC + k * LANES + lane]
                compensations[i] = rows[COMPENSATION + lane]
            else:
                radii[i, 0] = 0
                radii[i, 1] = 0
                means2d[i, 0] = np.float32(0.0)
                means2d[i, 1] = np.float32(0.0)
                depths[i] = np.float32(0.0)
                for k in range(3):
                    conics[i, k] = np.float32(0.0)
                compensations[i] = np.float32(0.0)


# Long for the same reason.
@kernel
def project_backward_kernel(
    means: Floats, quats: Floats, scales: Floats, pose: Numbers, lens: Numbers, eps2d: Number, radii: Integers,
    conics: Floats, compensations: Floats, v_means2d: Floats, v_depths: Floats, v_conics: Floats,
    v_compensations: Floats, antialiased: bool, v_means: Floats, v_quats: Floats, v_scales: Floats, v_pose: Floats,
) -> None:  # fmt: skip
    """Add one camera's gradients to ``v_means``, ``v_quats`` and ``v_scales``; set that of the pose, ``v_pose``."""
    count = len(means)
    chosen = np.empty(count, np.int32)
    size = 0
    for i in range(count):
        if radii[i, 0] > 0:
            moved = v_means2d[i, 0] != 0 or v_means2d[i, 1] != 0 or v_depths[i] != 0
            shaped = v_conics[i, 0] != 0 or v_conics[i, 1] != 0 or v_conics[i, 2] != 0
            if moved or shaped or (antialiased and v_compensations[i] != 0):
                chosen[size] = i
                size += 1
    rows = np.zeros(_BACKWARD_SCRATCH, np.float32)
    sums = (
        broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0),
        broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0),
    )  # fmt: skip
    for start in range(0, size, LANES):
        for lane in range(LANES):
            i = chosen[min(start + lane, size - 1)]
            live = np.float32(1.0) if start + lane < size else np.float32(0.0)
            gather_gaussian(rows, lane, means, quats, scales, i)
            for k in range(3):
                rows[CONIC + k * LANES + lane] = conics[i, k]
                rows[_V_CONIC + k * LANES + lane] = v_conics[i, k] * live
            rows[_V_IMAGE + lane] = v_means2d[i, 0] * live
            rows[_V_IMAGE + LANES + lane] = v_means2d[i, 1] * live
            rows[_V_DEPTH + lane] = v_depths[i] * live
            if antialiased:
                rows[COMPENSATION + lane] = compensations[i]
                rows[_V_COMPENSATION + lane] = v_compensations[i] * live
        mean, quat, scale = load_gaussian(rows)
        v_mean, v_quat, v_scale, v_pose_part = project_backward(
            mean, quat, scale, pose, lens, eps2d, load_rows(rows, CONIC, 3), load(rows, COMPENSATION),
            load_rows(rows, _V_IMAGE, 2), load(rows, _V_DEPTH), load_rows(rows, _V_CONIC, 3),
            load(rows, _V_COMPENSATION),
        )  # fmt: skip
        store_rows(rows, _V_MEAN, v_mean)
        store_rows(rows, _V_QUAT, v_quat)
        store_rows(rows, _V_SCALE, v_scale)
        s, p = sums, v_pose_part
        sums = (
            s[0] + p[0], s[1] + p[1], s[2] + p[2], s[3] + p[3], s[4] + p[4], s[5] + p[5],
            s[6] + p[6], s[7] + p[7], s[8] + p[8], s[9] + p[9], s[10] + p[10], s[11] + p[11],
        )  # fmt: skip
        for lane in range(min(LANES, size - start)):
            i = chosen[start + lane]
            for k in range(3):
                v_means[i, k] += rows[_V_MEAN + k * LANES + lane]
                v_scales[i, k] += rows[_V_SCALE + k * LANES + lane]
            for k in range(4):
                v_quats[i, k] += rows[_V_QUAT + k * LANES + lane]
    for row in range(3):
        v_pose[row, 0] = np.float32(0.0)
    v_pose[0, 0], v_pose[0, 1], v_pose[0, 2] = sum_lanes(sums[0]), sum_lanes(sums[1]), sum_lanes(sums[2])
    v_pose[1, 0], v_pose[1, 1], v_pose[1, 2] = sum_lanes(sums[3]), sum_lanes(sums[4]), sum_lanes(sums[5])
    v_pose[2, 0], v_pose[2, 1], v_pose[2, 2] = sum_lanes(sums[6]), sum_lanes(sums[7]), sum_lanes(sums[8])
    v_pose[0, 3], v_pose[1, 3], v_pose[2, 3] = sum_lanes(sums[9]), sum_lanes(sums[10]), sum_lanes(sums[11])


def camera_numbers(viewmat: Tensor, intrinsics: Tensor, width: int, height: int) -> tuple[Any, Any]:
    """Return a camera as the kernels take it: pose (rotation row by row, translation) and lens, as float32 tuples."""
    view, k = (x.detach().numpy().astype(np.float32).tobytes() for x in (viewmat, intrinsics))
    return _camera_numbers(view, k, width, height)


# An optimisation sees the same cameras again and again.
@functools.lru_cache(maxsize=4096)
def _camera_numbers(viewmat: bytes, intrinsics: bytes, width: int, height: int) -> tuple[Any, Any]:
    view, k = (np.frombuffer(x, np.float32).reshape(side, side) for x, side in ((viewmat, 4), (intrinsics, 3)))
    pose = (*view[:3, :3].ravel(), *view[:3, 3])
    fx, fy, cx, cy = k[0, 0], k[1, 1], k[0, 2], k[1, 2]
    margin_x, margin_y = (FIELD_OF_VIEW_MARGIN * 0.5 * side / focal for side, focal in ((width, fx), (height, fy)))
    bounds = (-cx / fx - margin_x, (width - cx) / fx + margin_x, -cy / fy - margin_y, (height - cy) / fy + margin_y)
    return pose, tuple(np.float32(x) for x in (fx, fy, cx, cy, *bounds))


class _Project(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Context,
        means: Tensor,
        quats: Tensor,
        scales: Tensor,
        viewmats: Tensor,
        opacities: Tensor,
        intrinsics: Tensor,
        options: tuple[int, int, float, float, float, float, bool],
    ) -> tuple[Tensor, ...]:
        width, height, near, far, clip, eps2d, antialiased = options
        cameras, count = len(viewmats), len(means)
        means2d = torch.empty(cameras, count, 2)
        depths, compensations = torch.empty(cameras, count), torch.empty(cameras, count)
        conics = torch.empty(cameras, count, 3)
        radii = torch.empty(cameras, count, 2, dtype=torch.int32)
        gaussians = [x.detach().numpy() for x in (means, quats, scales, opacities)]
        outputs = [x.numpy() for x in (means2d, depths, conics, compensations, radii)]
        planes, size = (np.float32(near), np.float32(far)), (np.float32(width), np.float32(height))
        for c in range(cameras):
            pose, lens = camera_numbers(viewmats[c], intrinsics[c], width, height)
            _project_kernel(
                *gaussians, pose, lens, size, planes, np.float32(eps2d), np.float32(clip), antialiased,
                *(x[c] for x in outputs),
            )  # fmt: skip
        ctx.save_for_backward(means, quats, scales, viewmats, intrinsics, radii, conics, compensations)
        ctx.options = options
        ctx.mark_non_differentiable(radii)
        return means2d, depths, conics, compensations, radii

    @staticmethod
    def backward(ctx: Context, *gradients: Tensor) -> tuple[Tensor | None, ...]:
        means, quats, scales, viewmats, intrinsics, radii, conics, compensations = ctx.saved_tensors
        width, height, _, _, _, eps2d, antialiased = ctx.options
        v_means, v_quats, v_scales = torch.zeros_like(means), torch.zeros_like(quats), torch.zeros_like(scales)
        v_viewmats = torch.zeros_like(viewmats)
        gaussians = [x.detach().numpy() for x in (means, quats, scales)]
        saved = [x.detach().numpy() for x in (radii, conics, compensations)]
        incoming = [x.contiguous().numpy() for x in gradients[:4]]
        outgoing = [x.numpy() for x in (v_means, v_quats, v_scales)]
        for c in range(len(viewmats)):
            pose, lens = camera_numbers(viewmats[c], intrinsics[c], width, height)
            project_backward_kernel(
                *gaussians, pose, lens, np.float32(eps2d), *(x[c] for x in saved), *(x[c] for x in incoming),
                antialiased, *outgoing, v_viewmats[c].numpy(),
            )  # fmt: skip
        return v_means, v_quats, v_scales, v_viewmats, None, None, None


def project_gaussians(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    viewmats: Tensor,
    intrinsics: Tensor,
    width: int,
    height: int,
    near_plane: float,
    far_plane: float,
    radius_clip: float,
    eps2d: float,
    antialiased: bool,
) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
    """Project N Gaussians into C cameras.

    Args:
        means: centres ``[N, 3]`` in the world.
        quats: rotations ``[N, 4]``, w first, of any length but zero.
        scales: standard deviations ``[N, 3]``.
        opacities: ``[N]``; only to bound the extent in the image, so no gradient flows to them from here.
        viewmats: world-to-camera matrices ``[C, 4, 4]``.
        intrinsics: ``[C, 3, 3]``, without skew; not differentiable.
        width: image width in pixels.
        height: image height in pixels.
        near_plane: least depth.
        far_plane: greatest depth.
        radius_clip: a Gaussian that extends no farther than this, in pixels, is left out.
        eps2d: variance in square pixels that is added to the image covariance.
        antialiased: whether opacities will be multiplied by the compensations.

    Returns:
        Centres in pixels ``[C, N, 2]``, depths ``[C, N]``, conics ``[C, N, 3]``, compensations ``[C, N]`` and radii
        ``[C, N, 2]`` int32: half the sides in pixels of the box outside of which the opacity is below
        ``ALPHA_MIN``. All are 0 where a Gaussian is out of sight.
    """
    options = (width, height, near_plane, far_plane, radius_clip, eps2d, antialiased)
    result = _Project.apply(means, quats, scales, viewmats, opacities, intrinsics, options)  # type: ignore[no-untyped-call]
    return cast("tuple[Tensor, Tensor, Tensor, Tensor, Tensor]", result)
