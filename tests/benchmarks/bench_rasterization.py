"""Speed of the CPU rasteriser against pure-torch renderers: forward and backward, one thread, interleaved.

Run from the root of the repository: ``python -m tests.benchmarks.bench_rasterization [W1 W2 W3] [--repeats 10]``.

The workloads are cubes of random Gaussians 2.5 units before the camera, 60 degrees of horizontal field of view, black
background; the loss is the mean absolute difference from an image of noise. Three renderers:

* ``ours``: ``avs.rasterizer.rasterization``.
* ``gsplat``: gsplat's public torch functions, its projection and its ``accumulate``. Two things that these need have
  no CPU version and are replaced here: the CUDA kernel that lists the pairs of pixels and Gaussians, and nerfacc's two
  functions. So this is a renderer in the style of gsplat, not a property of gsplat.
* ``naive``: every pixel against every Gaussian, in blocks of pixels; W1 only, as W2 would take minutes.

Below them stand the other passes over the blended Gaussians, which have no counterpart: the diagonal Fisher
information, a step with rendered variances (forward and backward), the variance that a view removes, and the weights of
the Gaussians in front.

Times are of the process's CPU, so that a busy machine blurs them less; compare columns of one run only.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import types
from collections.abc import Callable

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
import torch  # noqa: E402

from avs.rasterizer import blended_view, compositing, projection  # noqa: E402
from avs.rasterizer.constants import ALPHA_MAX, ALPHA_MIN, TRANSMITTANCE_MIN  # noqa: E402
from avs.rasterizer.fisher_diagonal import fisher_diagonal  # noqa: E402
from avs.rasterizer.front_weights import weights_in_front  # noqa: E402
from avs.rasterizer.rasterization import rasterization  # noqa: E402
from avs.rasterizer.variance_rasterization import rasterization_with_variance, variance_reduction  # noqa: E402

# Gaussians, width, height, seed.
WORKLOADS = {"W1": (5000, 160, 120, 1), "W2": (20000, 320, 240, 2), "W3": (100000, 640, 480, 3)}
STAGES = {
    "project": (projection, "_project_kernel"),
    "sort": (blended_view, "depth_order"),
    "pack": (blended_view, "pack_records"),
    "tiles+blend": (blended_view, "blend"),
    "image": (compositing, "to_image"),
    "blend back": (compositing, "blend_backward"),
    "unpack": (compositing, "unpack_gradients"),
    "project back": (projection, "project_backward_kernel"),
}


def workload(name):
    """Return means, quats, scales, opacities, colors; view matrix; intrinsics; width; height; target."""
    count, width, height, seed = WORKLOADS[name]
    generator = np.random.default_rng(seed)
    means = generator.random((count, 3)) - 0.5 + [0, 0, 2.5]
    scales = np.exp(generator.uniform(np.log(0.005), np.log(0.03), (count, 3)))
    quats = generator.standard_normal((count, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True)
    opacities = generator.uniform(0.1, 0.9, count)
    colors = generator.random((count, 3))
    target = torch.from_numpy(generator.random((height, width, 3)).astype(np.float32))
    focal = 0.5 * width / np.tan(np.deg2rad(30))
    intrinsics = torch.tensor([[[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]]], dtype=torch.float32)
    tensors = [torch.from_numpy(x.astype(np.float32)) for x in (means, quats, scales, opacities, colors)]
    return tensors, torch.eye(4)[None], intrinsics, width, height, target


def segment_sums(values, segments):
    """Return the sum of all earlier elements of the same segment; ``segments`` is sorted."""
    total = torch.cumsum(values, 0) - values
    first = torch.searchsorted(segments, segments)
    return total - total[first]


def stand_in_for_nerfacc():
    """Return a module with the two functions of nerfacc that gsplat's ``accumulate`` calls."""
    module = types.ModuleType("nerfacc")

    def render_weight_from_alpha(alphas, ray_indices, n_rays):
        light = torch.exp(segment_sums(torch.log1p(-alphas.double()), ray_indices)).float()
        return alphas * light, light

    def accumulate_along_rays(weights, values, ray_indices, n_rays):
        values = weights[:, None] if values is None else weights[:, None] * values
        return torch.zeros(n_rays, values.shape[1]).index_add(0, ray_indices, values)

    module.render_weight_from_alpha = render_weight_from_alpha
    module.accumulate_along_rays = accumulate_along_rays
    return module


@torch.no_grad()
def blended_pairs(means2d, radii, depths, conics, opacities, width, height, chunk=2000):
    """Return the Gaussians and pixels of all blended pairs, by pixel and then depth, as gsplat's CUDA kernel would."""
    order = torch.argsort(depths, stable=True)
    order = order[(radii[order] > 0).all(-1)]
    remaining = torch.zeros(width * height, dtype=torch.float64)
    stopped = torch.zeros(width * height, dtype=torch.bool)
    found = []
    for ids in order.split(chunk):
        low = (means2d[ids] - radii[ids] - 0.5).ceil().long().clamp(min=0)
        high = (means2d[ids] + radii[ids] - 0.5).floor().long() + 1
        size = (torch.minimum(high, torch.tensor([width, height])) - low).clamp(min=0)
        area = size.prod(1)
        local = torch.repeat_interleave(torch.arange(len(ids)), area)
        within = torch.arange(len(local)) - (area.cumsum(0) - area)[local]
        x, y = low[local, 0] + within % size[local, 0], low[local, 1] + within // size[local, 0]
        gaussian, pixel = ids[local], y * width + x
        dx, dy = x + 0.5 - means2d[gaussian, 0], y + 0.5 - means2d[gaussian, 1]
        a, b, c = conics[gaussian].unbind(1)
        alpha = (opacities[gaussian] * torch.exp(-0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy)).clamp(max=ALPHA_MAX)
        keep = (alpha >= ALPHA_MIN) & ~stopped[pixel]
        gaussian, pixel, alpha = gaussian[keep], pixel[keep], alpha[keep].double()
        by_pixel = torch.argsort(pixel, stable=True)
        gaussian, pixel, loss = gaussian[by_pixel], pixel[by_pixel], torch.log1p(-alpha[by_pixel])
        after = remaining[pixel] + segment_sums(loss, pixel) + loss
        blended = after > np.log(TRANSMITTANCE_MIN)
        stopped[pixel[~blended]] = True
        remaining.index_add_(0, pixel[blended], loss[blended])
        found.append((gaussian[blended], pixel[blended]))
    gaussian, pixel = (torch.cat(x) for x in zip(*found, strict=True))
    by_pixel = torch.argsort(pixel, stable=True)
    return gaussian[by_pixel], pixel[by_pixel]


def render_gsplat(tensors, viewmats, intrinsics, width, height):
    """Render with gsplat's torch functions; return the image and the number of blended pairs."""
    from gsplat.cuda import _torch_impl as gsplat

    means, quats, scales, opacities, colors = tensors
    covariances, _ = gsplat._quat_scale_to_covar_preci(quats, scales, compute_preci=False)
    radii, means2d, depths, conics, _ = gsplat._fully_fused_projection(
        means, covariances, viewmats, intrinsics, width, height
    )
    pairs = blended_pairs(means2d[0], radii[0], depths[0], conics[0], opacities, width, height)
    images = torch.zeros_like(pairs[0])
    image, _ = gsplat.accumulate(
        means2d, conics, opacities[None], colors[None], *pairs, image_ids=images, image_width=width, image_height=height
    )
    return image[0], len(pairs[0])


def step_naive(tensors, viewmats, intrinsics, width, height, target, rows=4):
    """Every pixel against every Gaussian, ``rows`` rows of pixels at a time; gradients add up over the blocks."""
    from gsplat.cuda import _torch_impl as gsplat

    target = target.reshape(-1, 3)
    for start in range(0, width * height, rows * width):
        means, quats, scales, opacities, colors = tensors
        covariances, _ = gsplat._quat_scale_to_covar_preci(quats, scales, compute_preci=False)
        _, means2d, depths, conics, _ = gsplat._fully_fused_projection(
            means, covariances, viewmats, intrinsics, width, height
        )
        order = torch.argsort(depths[0], stable=True)
        pixel = torch.arange(start, min(start + rows * width, width * height))[:, None]
        dx, dy = pixel % width + 0.5 - means2d[0, order, 0], pixel // width + 0.5 - means2d[0, order, 1]
        a, b, c = conics[0, order].unbind(1)
        alpha = (opacities[order] * torch.exp(-0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy)).clamp(max=ALPHA_MAX)
        alpha = torch.where(alpha >= ALPHA_MIN, alpha, 0)
        alpha = torch.where(torch.cumprod(1 - alpha, 1).detach() > TRANSMITTANCE_MIN, alpha, 0)
        after = torch.cumprod(1 - alpha, 1)
        weights = alpha * torch.cat([torch.ones_like(after[:, :1]), after[:, :-1]], 1)
        loss = (weights @ colors[order] - target[pixel[:, 0]]).abs().sum() / target.numel()
        loss.backward()


def timed(function: Callable[[], object]) -> float:
    """Return the milliseconds of CPU that ``function`` takes."""
    start = time.process_time()
    function()
    return 1e3 * (time.process_time() - start)


def quartiles(values):
    """Return ``median [first-third quartile]``."""
    low, middle, high = np.percentile(values, [25, 50, 75])
    return f"{middle:.2f} [{low:.2f}-{high:.2f}]"


def stage_times(step, repeats):
    """Return the median milliseconds of each stage of our renderer."""
    times: dict[str, list[float]] = {stage: [] for stage in STAGES}
    originals = {stage: getattr(module, function) for stage, (module, function) in STAGES.items()}

    def wrapped(stage):
        def call(*arguments):
            start = time.process_time()
            result = originals[stage](*arguments)
            times[stage].append(1e3 * (time.process_time() - start))
            return result

        return call

    for stage, (module, function) in STAGES.items():
        setattr(module, function, wrapped(stage))
    total = [timed(step) for _ in range(repeats)]
    for stage, (module, function) in STAGES.items():
        setattr(module, function, originals[stage])
    medians = {stage: float(np.median(values)) for stage, values in times.items()}
    return medians | {"torch": float(np.median(total)) - sum(medians.values())}


def passes(name):
    """Return the passes over one workload's Gaussians beside rendering, with colours as harmonics of degree 0."""
    (means, quats, scales, opacities, colors), viewmats, intrinsics, width, height, target = workload(name)
    gaussians, harmonics = (means, quats, scales, opacities), colors[:, None] - 0.5
    variances, black = opacities.clone(), torch.zeros(1, 3)
    camera = (viewmats[0], intrinsics[0])

    def variance_step():
        leaves = [tensor.clone().requires_grad_() for tensor in (*gaussians, harmonics, variances)]
        image, variance, _ = rasterization_with_variance(
            *leaves, viewmats, intrinsics, width, height, 0, False, black, False
        )
        ((image[0] - target).abs().mean() + variance.mean()).backward()

    return {
        "Fisher": lambda: fisher_diagonal(*gaussians, harmonics, *camera, width, height, 0),
        "variance step": variance_step,
        "variance reduction": lambda: variance_reduction(
            *gaussians, variances, *camera, width, height, False, 1e-4, True, False
        ),
        "front weights": lambda: weights_in_front(*gaussians, *camera, target[:, :, 0].numpy(), 0.5),
    }


def measure_passes(name, repeats):
    """Print one workload's other passes."""
    works = passes(name)
    for work in works.values():
        work()  # compiles
    rounds = [{label: timed(work) for label, work in works.items()} for _ in range(repeats)]
    for label in works:
        print(f"{name}  {label:18} {quartiles([times[label] for times in rounds]):>28} ms", flush=True)


def measure(name, repeats):
    """Print one workload's rows."""
    tensors, viewmats, intrinsics, width, height, target = workload(name)
    for tensor in tensors:
        tensor.requires_grad_()
    counted = []

    def reset():
        for tensor in tensors:
            tensor.grad = None

    def step_ours():
        reset()
        image, _, _ = rasterization(*tensors, viewmats, intrinsics, width, height, packed=False)
        (image[0] - target).abs().mean().backward()

    def step_gsplat():
        reset()
        image, count = render_gsplat(tensors, viewmats, intrinsics, width, height)
        (image - target).abs().mean().backward()
        counted.append(count)

    step_ours()  # compiles
    mine = [x.grad.clone() for x in tensors]
    step_gsplat()
    errors = [float((x.grad - y).norm() / x.grad.norm()) for x, y in zip(tensors, mine, strict=True)]
    steps = {"ours": step_ours, "gsplat": step_gsplat}
    times: dict[str, list[float]] = {"ours": [], "gsplat": []}
    for _ in range(repeats):
        for _ in range(5):
            times["ours"].append(timed(step_ours))
        times["gsplat"].append(timed(steps["gsplat"]))
    if name == "W1":
        reset()
        times["naive"] = [timed(lambda: step_naive(tensors, viewmats, intrinsics, width, height, target))]
    best = np.median(times["ours"])
    for renderer, values in times.items():
        rate = counted[0] / np.median(values) / 1e3
        ratio = np.median(values) / best
        print(f"{name}  {renderer:7} {quartiles(values):>28} ms  {ratio:8.1f}x  {rate:8.2f} M pairs/s", flush=True)
    stages = stage_times(step_ours, 5 * repeats)
    print(f"{name}  ours by stage, ms: " + ", ".join(f"{stage} {value:.2f}" for stage, value in stages.items()))
    print(f"{name}  gradients, ours against gsplat's, relative: " + ", ".join(f"{error:.0e}" for error in errors))


def main() -> None:
    """Measure the workloads that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workloads", nargs="*", default=list(WORKLOADS), choices=[*WORKLOADS, []])
    parser.add_argument("--repeats", type=int, default=10)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    sys.modules["nerfacc"] = stand_in_for_nerfacc()
    print(f"forward + backward, one thread, CPU time; load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    for name in arguments.workloads:
        measure(name, arguments.repeats)
        measure_passes(name, 5 * arguments.repeats)


if __name__ == "__main__":
    main()
