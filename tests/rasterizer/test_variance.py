"""Rendered variance, its gradients and its expected reduction, against the slow twin in float64."""

from typing import NamedTuple

import gsplat
import numpy as np
import pytest
import torch
from test_rasterization import CAMERAS, HEIGHT, WIDTH, cameras, gaussians, leaves
from tolerances import RASTER_GRADIENT, RASTER_IMAGE, VARIANCE_REDUCTION

from avs.rasterizer import variance_gsplat
from avs.rasterizer.compositing import composite
from avs.rasterizer.rasterization import rasterization
from avs.rasterizer.variance_rasterization import PLAIN, rasterization_with_variance, variance_reduction
from tests.rasterizer import reference_renderer as reference

NAMES = ("means", "quats", "scales", "opacities", "colors", "variances")
DEGREE = 1


class Rule(NamedTuple):
    """The last three arguments of ``variance_reduction``."""

    constant: float
    weighted: bool
    saturated: bool


RULES = [Rule(1e-4, weighted, saturated) for weighted in (True, False) for saturated in (False, True)]


def scene(count=120, opaque=False, size=1.5):
    """Gaussians with harmonics and variances, float64."""
    generator = torch.Generator().manual_seed(7)
    variances = torch.exp(torch.randn(count, generator=generator, dtype=torch.float64))
    return [*gaussians(count, 3, sh_degree=DEGREE, opaque=opaque, size=size), variances]


def twin_weights(tensors, viewmat, intrinsics):
    """Return the weights ``[H W, N]`` of all Gaussians: rendered colours that are one for one Gaussian alone."""
    means, quats, scales, opacities = tensors[:4]
    unit = torch.eye(len(means), dtype=means.dtype)
    image, _ = reference.render(means, quats, scales, opacities, unit, viewmat, intrinsics, WIDTH, HEIGHT)
    return image.reshape(-1, len(means))


def attenuated_weights(weights, tensors, viewmat):
    """Return alpha_i T_{i+1} from alpha_i T_i, by the transmittances that the weights leave."""
    order = torch.argsort((tensors[0] @ viewmat[:3, :3].T + viewmat[:3, 3])[:, 2].float(), stable=True)
    after = 1 - weights[:, order].cumsum(1)
    before = torch.cat([torch.ones_like(after[:, :1]), after[:, :-1]], 1)
    factor = torch.empty_like(weights)
    factor[:, order] = after / before
    return weights * factor


def twin(tensors, viewmat, intrinsics):
    """Return the image ``[H, W, 3]`` and the variance ``[H, W]``."""
    image, _ = reference.render(*tensors[:5], viewmat, intrinsics, WIDTH, HEIGHT, sh_degree=DEGREE)
    return image, (twin_weights(tensors, viewmat, intrinsics) ** 2 @ tensors[5]).reshape(HEIGHT, WIDTH)


def fast(tensors, viewmats, intrinsics, attenuated=False, render=rasterization_with_variance, absgrad=False):
    means, quats, scales, opacities, colors, variances = tensors
    backgrounds = torch.zeros(len(viewmats), 3)
    return render(
        means, quats, scales, opacities, colors, variances, viewmats.float(), intrinsics.float(), WIDTH, HEIGHT,
        DEGREE, absgrad, backgrounds, attenuated,
    )  # fmt: skip


def backward(image, variance):
    """Differentiate a sum of both outputs with random weights."""
    generator = torch.Generator().manual_seed(1)
    for_image, for_variance = (
        torch.randn(x.shape, generator=generator, dtype=torch.float64) for x in (image, variance)
    )
    ((image * for_image).sum() + (variance * for_variance).sum()).backward()


def check_gradients(slow, found):
    for name, expected, tensor in zip(NAMES, slow, found, strict=True):
        assert (expected.grad - tensor.grad).norm() <= RASTER_GRADIENT * expected.grad.norm(), name


@pytest.mark.parametrize("opaque", [False, True])
def test_image_variance_and_gradients(opaque):
    viewmats, intrinsics = cameras(CAMERAS, 1)
    tensors = scene(opaque=opaque, size=4.0 if opaque else 1.5)
    slow, quick = leaves(tensors, torch.float64), leaves(tensors, torch.float32)
    images, variances = (
        torch.stack(x) for x in zip(*(twin(slow, viewmats[c], intrinsics[c]) for c in range(CAMERAS)), strict=True)
    )
    image, variance, _ = fast(quick, viewmats, intrinsics)
    assert (images - image).abs().max() < RASTER_IMAGE
    assert (variances - variance).abs().max() < RASTER_IMAGE * variances.max()
    backward(images, variances)
    backward(image, variance)
    check_gradients(slow, quick)


def test_gradients_are_derivatives_of_the_variance():
    """Central differences of the float64 twin, so that its autograd is not taken on trust."""
    viewmats, intrinsics = cameras(1, 1)
    tensors = scene(40)
    quick = leaves(tensors, torch.float32)
    _, variance, _ = fast(quick, viewmats, intrinsics)
    weights = torch.randn(HEIGHT, WIDTH, generator=torch.Generator().manual_seed(2), dtype=torch.float64)
    (variance[0] * weights).sum().backward()
    for place in (0, 1, 2, 3, 5):
        at = int(quick[place].grad.abs().argmax())
        values = []
        for step in (1e-6, -1e-6):
            moved = [x.clone() for x in tensors]
            moved[place].view(-1)[at] += step
            values.append(float((twin(moved, viewmats[0], intrinsics[0])[1] * weights).sum()))
        assert float(quick[place].grad.flatten()[at]) == pytest.approx(
            (values[0] - values[1]) / 2e-6, rel=RASTER_GRADIENT
        ), NAMES[place]


def test_attenuated_variance_is_differentiated_by_the_variances_alone():
    viewmats, intrinsics = cameras(1, 1)
    tensors = scene()
    weights = twin_weights(tensors, viewmats[0], intrinsics[0])
    expected = attenuated_weights(weights, tensors, viewmats[0]) ** 2 @ tensors[5]
    quick, plain = leaves(tensors, torch.float32), leaves(tensors, torch.float32)
    image, variance, _ = fast(quick, viewmats, intrinsics, attenuated=True)
    assert (expected - variance.flatten()).abs().max() < RASTER_IMAGE * expected.max()
    backward(image, variance)
    image, variance, _ = fast(plain, viewmats, intrinsics)
    backward(image, 0 * variance)
    for name, one, other in zip(NAMES[:5], quick, plain, strict=False):
        assert torch.equal(one.grad, other.grad), name
    generator = torch.Generator().manual_seed(1)
    torch.randn(image.shape, generator=generator, dtype=torch.float64)
    for_variance = torch.randn(variance.shape, generator=generator, dtype=torch.float64)
    gradient = for_variance.flatten() @ weights**2
    assert (gradient - quick[5].grad).norm() <= RASTER_GRADIENT * gradient.norm()


def test_the_image_is_that_of_the_rasteriser_and_twice_the_same():
    viewmats, intrinsics = cameras(CAMERAS, 1)
    tensors = scene()
    results = []
    for _ in range(2):
        quick = leaves(tensors, torch.float32)
        image, variance, meta = fast(quick, viewmats, intrinsics, absgrad=True)
        backward(image, variance)
        results.append([image, variance, meta["means2d"].absgrad, *(x.grad for x in quick)])
    assert all(torch.equal(first, second) for first, second in zip(*results, strict=True))
    assert (results[0][2] > 0).any()
    plain = rasterization(*quick[:5], viewmats.float(), intrinsics.float(), WIDTH, HEIGHT, sh_degree=DEGREE)[0]
    assert torch.equal(plain, results[0][0])


def twin_reductions(tensors, viewmat, intrinsics, attenuated, monkeypatch):
    """Return the reduction by each of ``RULES``, before less after, and whether each pixel stopped ``[H W]``."""
    weights = twin_weights(tensors, viewmat, intrinsics)
    with monkeypatch.context() as patch:
        patch.setattr(reference, "TRANSMITTANCE_MIN", 0.0)
        endless = twin_weights(tensors, viewmat, intrinsics)
    blended = weights > 0
    stopped = (endless > 0).sum(1) > blended.sum(1)
    squares = (attenuated_weights(weights, tensors, viewmat) if attenuated else weights) ** 2
    beta = tensors[5]
    reductions = []
    for rule in RULES:
        prior = rule.constant + squares @ beta
        before = prior if rule.weighted else blended.double() @ beta
        of_each = (squares if rule.weighted else blended) / (1 / beta + squares / prior[:, None])
        after = torch.where(stopped, 0, of_each.sum(1)) if rule.saturated else of_each.sum(1)
        reductions.append(float((before - after).sum()))
    return reductions, stopped


def reduction_inputs(opaque):
    viewmats, intrinsics = cameras(1, 1)
    tensors = scene(200, opaque=opaque, size=4.0 if opaque else 1.5)
    tensors[3] = tensors[3].clamp(max=0.999)
    return tensors, viewmats[0], intrinsics[0]


def reduction(tensors, viewmat, intrinsics, attenuated, rule, compute=variance_reduction):
    means, quats, scales, opacities, _, variances = (x.float() for x in tensors)
    return compute(
        means, quats, scales, opacities, variances, viewmat.float(), intrinsics.float(), WIDTH, HEIGHT, attenuated,
        *rule,
    )  # fmt: skip


@pytest.mark.parametrize("attenuated", [False, True])
def test_reduction(attenuated, monkeypatch):
    inputs = reduction_inputs(opaque=True)
    reductions, stopped = twin_reductions(*inputs, attenuated, monkeypatch)
    assert 0.1 < stopped.double().mean() < 0.9, "the test needs pixels of both kinds"
    for rule, expected in zip(RULES, reductions, strict=True):
        found = reduction(*inputs, attenuated, rule)
        assert isinstance(found, float)
        assert found == pytest.approx(expected, rel=VARIANCE_REDUCTION), rule


def test_pixels_that_a_gaussian_does_not_touch():
    """Beside a pixel that it touches lies one whose exponent of -2176 the kernels' exponential takes to -infinity."""
    steep = np.float32(272 * np.log(2))
    for _ in range(4):
        steep = np.nextafter(steep, np.float32(0))
    for _ in range(8):
        leaf = torch.ones(1, requires_grad=True)
        variance, _ = composite(
            torch.full((1, 1, 2), 0.5), torch.tensor([[[float(steep), 0.0, 1.0]]]), leaf, torch.ones(1, 1, 1),
            torch.ones(1, 1), torch.full((1, 1, 2), 8, dtype=torch.int32), None, 8, 8, False, False, squares=PLAIN,
        )  # fmt: skip
        variance.sum().backward()
        assert torch.isfinite(variance).all()
        assert torch.isfinite(leaf.grad).all()
        steep = np.nextafter(steep, np.float32(1e9))


def test_reduction_where_there_is_no_variance():
    tensors, *camera = reduction_inputs(opaque=False)
    few = [*(x[:9] for x in tensors[:5]), torch.ones(9)]
    found = reduction(few, *camera, False, Rule(0.0, True, False))
    assert np.isfinite(found).all()
    assert found > 0


def test_reduction_of_an_empty_view_is_the_constant():
    tensors, _, intrinsics = reduction_inputs(opaque=False)
    away = torch.diag(torch.tensor([1.0, -1.0, -1.0, 1.0]))
    away[2, 3] = -20.0
    found = reduction([*tensors[:5], torch.ones(200)], away, intrinsics, False, Rule(1e-4, True, False))
    assert found == pytest.approx(1e-4 * WIDTH * HEIGHT)


# --- the way through gsplat, with stand-ins for its two functions that need a GPU ---


def stand_in_rasterization(means, quats, scales, opacities, colors, viewmats, Ks, width, height, **options):
    """Render on the CPU, and add to ``meta`` the lists of a single tile, which hold nothing but their length."""
    images, alphas, meta = rasterization(
        means, quats, scales, opacities, colors, viewmats, Ks, width, height, **options
    )
    meta |= {"tile_size": 16, "isect_offsets": None, "flatten_ids": torch.arange(len(means))}
    return images, alphas, meta


def stand_in_indices(start, end, transmittances, means2d, conics, opacities, width, height, *_):
    """Return the pairs that gsplat's kernel returns, from near to far: Gaussians, pixels, images."""
    found = []
    y, x = (v.flatten() + 0.5 for v in torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij"))
    for image in range(len(means2d)):
        order = torch.argsort(stand_in_indices.depths[image], stable=True)
        dx, dy = x[:, None] - means2d[image, order, 0], y[:, None] - means2d[image, order, 1]
        a, b, c = conics[image, order].unbind(-1)
        alphas = (opacities[image, order] * torch.exp(-0.5 * (a * dx**2 + c * dy**2) - b * dx * dy)).clamp(max=0.999)
        alphas = torch.where((alphas >= 1 / 255) & stand_in_indices.seen[image, order], alphas, 0).double()
        after = transmittances[image].reshape(-1, 1) * torch.cumprod(1 - alphas, 1)
        pixels, places = torch.nonzero((alphas > 0) & (after > 1e-4), as_tuple=True)
        found.append((order[places], pixels, torch.full_like(pixels, image)))
    return tuple(torch.cat(x) for x in zip(*found, strict=True))


@pytest.fixture
def without_gpu(monkeypatch):
    def rasterize(*arguments, **options):
        images, alphas, meta = stand_in_rasterization(*arguments, **options)
        stand_in_indices.depths, stand_in_indices.seen = meta["depths"], (meta["radii"] > 0).all(-1)
        return images, alphas, meta

    monkeypatch.setattr(gsplat, "rasterization", rasterize)
    monkeypatch.setattr(gsplat, "rasterize_to_indices_in_range", stand_in_indices)


@pytest.mark.parametrize("attenuated", [False, True])
def test_the_way_through_gsplat_gives_the_same(attenuated, without_gpu):
    viewmats, intrinsics = cameras(CAMERAS, 1)
    tensors = scene()
    here, there = leaves(tensors, torch.float32), leaves(tensors, torch.float32)
    image, variance, _ = fast(here, viewmats, intrinsics, attenuated)
    other_image, other_variance, _ = fast(
        there, viewmats, intrinsics, attenuated, render=variance_gsplat.rasterization_with_variance
    )
    assert (variance - other_variance).abs().max() < RASTER_IMAGE * variance.max()
    backward(image, variance)
    backward(other_image, other_variance)
    check_gradients(there, here)


@pytest.mark.parametrize("attenuated", [False, True])
def test_the_reduction_through_gsplat_gives_the_same(attenuated, without_gpu):
    inputs = reduction_inputs(opaque=True)
    for rule in RULES:
        expected = reduction(*inputs, attenuated, rule)
        found = reduction(*inputs, attenuated, rule, compute=variance_gsplat.variance_reduction)
        assert found == pytest.approx(expected, rel=VARIANCE_REDUCTION), rule
