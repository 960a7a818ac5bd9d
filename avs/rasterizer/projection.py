"""Projection of all Gaussians into all cameras, differentiable in the Gaussians and in the poses."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import torch
from torch import Tensor

from avs.rasterizer.ewa import project, project_backward
from avs.rasterizer.kernels import Context, Floats, Integers, Number, Numbers, kernel
from avs.rasterizer.simd import LANES, broadcast
from avs.rasterizer.simd_memory import load, store, sum_lanes

# A pixel takes no notice of a Gaussian whose opacity there is below this (3DGS, gsplat: ALPHA_THRESHOLD).
ALPHA_THRESHOLD = 1.0 / 255.0
# The Jacobian is held beyond this share of the half field of view outside the image (3DGS: 1.3 tan; gsplat: + 0.3 tan).
_MARGIN = 0.3
# A Gaussian whose image is wider than this, in pixels, is left out: float32 cannot hold its conic.
_LARGEST = 1e6


# Long because sixteen Gaussians are gathered into vectors and scattered again, number by number.
@kernel
def _project_kernel(
    means: Floats, quats: Floats, scales: Floats, opacities: Floats, pose: Numbers, lens: Numbers, size: Numbers,
    planes: Numbers, eps2d: Number, radius_clip: Number, antialiased: bool, means2d: Floats, depths: Floats,
    conics: Floats, compensations: Floats, radii: Integers,
) -> None:  # fmt: skip
    """Fill the outputs for one camera; those of Gaussians that are out of sight are 0."""
    count = len(means)
    rows = np.empty(20 * LANES, np.float32)
    for start in range(0, count, LANES):
        for lane in range(LANES):
            i = min(start + lane, count - 1)
            for k in range(3):
                rows[k * LANES + lane] = means[i, k]
                rows[(7 + k) * LANES + lane] = scales[i, k]
            for k in range(4):
                rows[(3 + k) * LANES + lane] = quats[i, k]
        image, depth, conic, variance, compensation = project(
            (load(rows, 0), load(rows, 16), load(rows, 32)),
            (load(rows, 48), load(rows, 64), load(rows, 80), load(rows, 96)),
            (load(rows, 112), load(rows, 128), load(rows, 144)),
            pose,
            lens,
            eps2d,
        )
        store(rows, 160, image[0])
        store(rows, 176, image[1])
        store(rows, 192, depth)
        store(rows, 208, conic[0])
        store(rows, 224, conic[1])
        store(rows, 240, conic[2])
        store(rows, 256, variance[0])
        store(rows, 272, variance[1])
        store(rows, 288, compensation)
        for lane in range(min(LANES, count - start)):
            i = start + lane
            z = rows[192 + lane]
            radius_x = np.float32(0.0)
            radius_y = np.float32(0.0)
            if z >= planes[0] and z <= planes[1]:
                opacity = opacities[i]
                if antialiased:
                    opacity *= rows[288 + lane]
                if opacity >= np.float32(ALPHA_THRESHOLD):
                    extent = np.sqrt(np.float32(2.0) * np.log(opacity * np.float32(255.0)))
                    radius_x = np.ceil(extent * np.sqrt(rows[256 + lane]))
                    radius_y = np.ceil(extent * np.sqrt(rows[272 + lane]))
                    x = rows[160 + lane]
                    y = rows[176 + lane]
                    seen = x + radius_x > 0 and x - radius_x < size[0] and y + radius_y > 0 and y - radius_y < size[1]
                    # false for numbers that are not finite, too
                    sane = radius_x < _LARGEST and radius_y < _LARGEST and rows[208 + lane] > 0 and rows[240 + lane] > 0
                    if not (seen and sane and (radius_x > radius_clip or radius_y > radius_clip)):
                        radius_x = np.float32(0.0)
            if radius_x > 0 and radius_y > 0:
                radii[i, 0] = np.int32(radius_x)
                radii[i, 1] = np.int32(radius_y)
                means2d[i, 0] = rows[160 + lane]
                means2d[i, 1] = rows[176 + lane]
                depths[i] = z
                for k in range(3):
                    conics[i, k] = rows[208 + k * LANES + lane]
                compensations[i] = rows[288 + lane]
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
def _project_backward_kernel(
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
    rows = np.zeros(31 * LANES, np.float32)
    sums = (
        broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0),
        broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0),
    )  # fmt: skip
    for start in range(0, size, LANES):
        for lane in range(LANES):
            i = chosen[min(start + lane, size - 1)]
            live = np.float32(1.0) if start + lane < size else np.float32(0.0)
            for k in range(3):
                rows[k * LANES + lane] = means[i, k]
                rows[(7 + k) * LANES + lane] = scales[i, k]
                rows[(10 + k) * LANES + lane] = conics[i, k]
                rows[(17 + k) * LANES + lane] = v_conics[i, k] * live
            for k in range(4):
                rows[(3 + k) * LANES + lane] = quats[i, k]
            rows[13 * LANES + lane] = v_means2d[i, 0] * live
            rows[14 * LANES + lane] = v_means2d[i, 1] * live
            rows[15 * LANES + lane] = v_depths[i] * live
            if antialiased:
                rows[16 * LANES + lane] = v_compensations[i] * live
                rows[20 * LANES + lane] = compensations[i]
        v_mean, v_quat, v_scale, v_pose_part = project_backward(
            (load(rows, 0), load(rows, 16), load(rows, 32)),
            (load(rows, 48), load(rows, 64), load(rows, 80), load(rows, 96)),
            (load(rows, 112), load(rows, 128), load(rows, 144)),
            pose,
            lens,
            eps2d,
            (load(rows, 160), load(rows, 176), load(rows, 192)),
            load(rows, 320),
            (load(rows, 208), load(rows, 224)),
            load(rows, 240),
            (load(rows, 272), load(rows, 288), load(rows, 304)),
            load(rows, 256),
        )
        store(rows, 336, v_mean[0])
        store(rows, 352, v_mean[1])
        store(rows, 368, v_mean[2])
        store(rows, 384, v_quat[0])
        store(rows, 400, v_quat[1])
        store(rows, 416, v_quat[2])
        store(rows, 432, v_quat[3])
        store(rows, 448, v_scale[0])
        store(rows, 464, v_scale[1])
        store(rows, 480, v_scale[2])
        s, p = sums, v_pose_part
        sums = (
            s[0] + p[0], s[1] + p[1], s[2] + p[2], s[3] + p[3], s[4] + p[4], s[5] + p[5],
            s[6] + p[6], s[7] + p[7], s[8] + p[8], s[9] + p[9], s[10] + p[10], s[11] + p[11],
        )  # fmt: skip
        for lane in range(min(LANES, size - start)):
            i = chosen[start + lane]
            for k in range(3):
                v_means[i, k] += rows[336 + k * LANES + lane]
                v_scales[i, k] += rows[448 + k * LANES + lane]
            for k in range(4):
                v_quats[i, k] += rows[384 + k * LANES + lane]
    for row in range(3):
        v_pose[row, 0] = np.float32(0.0)
    v_pose[0, 0], v_pose[0, 1], v_pose[0, 2] = sum_lanes(sums[0]), sum_lanes(sums[1]), sum_lanes(sums[2])
    v_pose[1, 0], v_pose[1, 1], v_pose[1, 2] = sum_lanes(sums[3]), sum_lanes(sums[4]), sum_lanes(sums[5])
    v_pose[2, 0], v_pose[2, 1], v_pose[2, 2] = sum_lanes(sums[6]), sum_lanes(sums[7]), sum_lanes(sums[8])
    v_pose[0, 3], v_pose[1, 3], v_pose[2, 3] = sum_lanes(sums[9]), sum_lanes(sums[10]), sum_lanes(sums[11])


def camera_numbers(viewmat: Tensor, intrinsics: Tensor, width: int, height: int) -> tuple[Any, Any]:
    """Return a camera as the kernels take it: pose (rotation row by row, translation) and lens, as float32 tuples."""
    view = viewmat.detach().numpy().astype(np.float32)
    pose = (*view[:3, :3].ravel(), *view[:3, 3])
    k = intrinsics.detach().numpy().astype(np.float32)
    fx, fy, cx, cy = k[0, 0], k[1, 1], k[0, 2], k[1, 2]
    margin_x, margin_y = _MARGIN * 0.5 * width / fx, _MARGIN * 0.5 * height / fy
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
            _project_backward_kernel(
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
        ``ALPHA_THRESHOLD``. All are 0 where a Gaussian is out of sight.
    """
    options = (width, height, near_plane, far_plane, radius_clip, eps2d, antialiased)
    result = _Project.apply(means, quats, scales, viewmats, opacities, intrinsics, options)  # type: ignore[no-untyped-call]
    return cast("tuple[Tensor, Tensor, Tensor, Tensor, Tensor]", result)
