"""What runs on CUDA against the same on the CPU: the rasteriser, the losses, rendered variances."""

import pytest
import torch
from test_rasterization import CAMERAS, HEIGHT, WIDTH, cameras, gaussians, leaves
from tolerances import CUDA_GRADIENT, CUDA_IMAGE, CUDA_LOSS_GRADIENT, CUDA_LOSS_VALUE, CUDA_REDUCTION

from avs.rasterizer.likelihood import negative_log_likelihood
from avs.rasterizer.losses import photometric_loss, prepare_target
from avs.rasterizer.rasterization import rasterization
from avs.rasterizer.variance_rasterization import rasterization_with_variance, variance_reduction

pytestmark = pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU that torch can use")


@pytest.fixture(autouse=True)
def _seed():
    torch.manual_seed(0)


def on_both(scene, backgrounds=None):
    """Return float32 leaves on the CPU and on the GPU (Gaussians, view matrices, backgrounds if any) and intrinsics."""
    viewmats, intrinsics = cameras(CAMERAS, 1)
    tensors = [*scene, viewmats] + ([] if backgrounds is None else [backgrounds])
    here = leaves(tensors, torch.float32)
    there = [leaf.detach().cuda().requires_grad_() for leaf in here]
    return (here, intrinsics.float()), (there, intrinsics.float().cuda())


def same_gradients(here, there, tolerance):
    for place, (x, y) in enumerate(zip(here, there, strict=True)):
        if x.grad is not None:
            assert y.grad is not None, place
            assert (x.grad - y.grad.cpu()).norm() <= tolerance * x.grad.norm(), place


@pytest.mark.parametrize(
    ("degree", "options"),
    [
        (None, {}),
        (None, {"render_mode": "RGB+ED"}),
        (None, {"render_mode": "ED"}),
        (None, {"rasterize_mode": "antialiased"}),
        *((degree, {"sh_degree": degree}) for degree in range(5)),
    ],
)
@pytest.mark.parametrize("opaque", [False, True])
def test_images_and_gradients(degree, options, opaque):
    scene = gaussians(300, 3, sh_degree=degree, opaque=opaque)
    backgrounds = None if options.get("render_mode") == "ED" else torch.rand(CAMERAS, 3).double()
    sides = on_both(scene, backgrounds)
    results = [
        rasterization(
            *tensors[:6], intrinsics, WIDTH, HEIGHT, backgrounds=None if backgrounds is None else tensors[6],
            packed=False, **options,
        )
        for tensors, intrinsics in sides
    ]  # fmt: skip
    (image, alpha, meta), (image_there, alpha_there, meta_there) = results
    assert (image - image_there.cpu()).abs().max() < CUDA_IMAGE * max(1.0, float(image.detach().abs().max()))
    assert (alpha - alpha_there.cpu()).abs().max() < CUDA_IMAGE
    seen, seen_there = (facts["radii"].cpu()[..., 0] > 0 for facts in (meta, meta_there))
    assert (seen != seen_there).sum() <= len(seen.flatten()) // 100
    weights = torch.randn(image.shape), torch.randn(alpha.shape)
    for image, alpha, _ in results:
        sum(
            (values * weight.to(values.device)).sum() for values, weight in zip((image, alpha), weights, strict=True)
        ).backward()
    same_gradients(sides[0][0], sides[1][0], CUDA_GRADIENT)


@pytest.mark.parametrize("absgrad", [False, True])
def test_gradients_that_densification_reads(absgrad):
    sides = on_both(gaussians(300, 4, opaque=True))
    found = []
    for tensors, intrinsics in sides:
        image, _, meta = rasterization(*tensors, intrinsics, WIDTH, HEIGHT, packed=False, absgrad=absgrad)
        meta["means2d"].retain_grad()
        image.square().sum().backward()
        found.append((meta["means2d"].absgrad if absgrad else meta["means2d"].grad).cpu())
    assert (found[0] - found[1]).norm() <= CUDA_GRADIENT * found[0].norm()


@pytest.mark.parametrize("attenuated", [False, True])
def test_rendered_variance(attenuated):
    variances = torch.rand(200).double() + 0.1
    sides = on_both([*gaussians(200, 5, sh_degree=1), variances], torch.rand(CAMERAS, 3).double())
    results = []
    for tensors, intrinsics in sides:
        *five, betas, viewmats, backgrounds = tensors
        results.append(
            rasterization_with_variance(
                *five, betas, viewmats, intrinsics, WIDTH, HEIGHT, sh_degree=1, absgrad=False,
                backgrounds=backgrounds, attenuated=attenuated,
            )[:2]
        )  # fmt: skip
    for x, y in zip(*results, strict=True):
        assert (x - y.cpu()).abs().max() < CUDA_IMAGE * max(1.0, float(x.detach().abs().max()))
    weights = [torch.randn(x.shape) for x in results[0]]
    for pair in results:
        sum((x * weight.to(x.device)).sum() for x, weight in zip(pair, weights, strict=True)).backward()
    same_gradients(sides[0][0], sides[1][0], CUDA_GRADIENT)


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("saturated", [False, True])
@pytest.mark.parametrize("attenuated", [False, True])
def test_variance_that_a_view_removes(attenuated, weighted, saturated):
    variances = torch.rand(200) + 0.1
    scene = [x.float() for x in gaussians(200, 6, opaque=saturated, size=3.0)[:4]]
    viewmats, intrinsics = (x[0].float() for x in cameras(1, 1))
    values = []
    for device in ("cpu", "cuda"):
        tensors = [x.to(device) for x in (*scene, variances, viewmats, intrinsics)]
        values.append(variance_reduction(*tensors, WIDTH, HEIGHT, attenuated, 1e-4, weighted, saturated))
    assert values[1] == pytest.approx(values[0], rel=CUDA_REDUCTION)


def photographs():
    """Return a photograph of smooth and flat regions, where a rounding weighs most, and a rendering of it."""
    rows, columns = torch.meshgrid(torch.arange(48), torch.arange(64), indexing="ij")
    image = torch.stack([(128 + 60 * torch.sin(columns / 9)), rows * 2.0 + 60, torch.full((48, 64), 200.0)], dim=-1)
    rendering = (image / 255 + 0.02 * torch.randn(48, 64, 3)).float()
    return image.to(torch.uint8).numpy(), rendering


@pytest.mark.parametrize("weight", [0.2, 1.0])
def test_photometric_loss(weight):
    photograph, rendering = photographs()
    values, gradients = [], []
    for device in ("cpu", "cuda"):
        leaf = rendering.to(device).requires_grad_()
        loss = photometric_loss(leaf, prepare_target(photograph, torch.device(device)), weight)
        loss.backward()
        values.append(float(loss.detach()))
        gradients.append(leaf.grad.cpu())
        rendering = rendering.detach()
    assert values[1] == pytest.approx(values[0], abs=CUDA_LOSS_VALUE)
    assert (gradients[0] - gradients[1]).norm() <= CUDA_LOSS_GRADIENT * gradients[0].norm()


def test_likelihood():
    photograph, rendering = photographs()
    variance = torch.rand(48, 64) * 0.2
    values, gradients = [], []
    for device in ("cpu", "cuda"):
        image, spread = (x.detach().to(device).requires_grad_() for x in (rendering, variance))
        target = prepare_target(photograph, torch.device(device)).image
        loss = negative_log_likelihood(image, spread, target, 0.01)
        loss.backward()
        values.append(float(loss.detach()))
        gradients.append((image.grad.cpu(), spread.grad.cpu()))
    assert values[1] == pytest.approx(values[0], rel=CUDA_LOSS_VALUE)
    for x, y in zip(*gradients, strict=True):
        assert (x - y).norm() <= CUDA_LOSS_GRADIENT * x.norm()
