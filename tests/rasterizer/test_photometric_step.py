"""The step in one operation against rasteriser, loss and their graph: the same kernels, so the same bits."""

import numpy as np
import pytest
import torch

from avs.rasterizer.losses import photometric_loss, prepare_target
from avs.rasterizer.photometric_step import photometric_step
from avs.rasterizer.rasterization import rasterization
from tests.rasterizer.test_rasterization import cameras, gaussians, leaves

WIDTH, HEIGHT = 45, 37


def by_graph(target, ssim_weight, **arguments):
    image, _, meta = rasterization(**arguments, packed=False)
    meta["means2d"].retain_grad()
    return photometric_loss(image[0], target, ssim_weight), meta


def small_step():
    viewmats, intrinsics = (x.float() for x in cameras(1, 1, WIDTH, HEIGHT))
    target = prepare_target(np.zeros((HEIGHT, WIDTH, 3), np.uint8), torch.device("cpu"))
    tensors = leaves(gaussians(20, 3, sh_degree=0), torch.float32)
    black = torch.zeros(1, 3)
    loss, _ = photometric_step(*tensors, viewmats, intrinsics, WIDTH, HEIGHT, 0, False, black, target, 0.2)
    return tensors, loss


@pytest.mark.parametrize("absgrad", [False, True])
@pytest.mark.parametrize("degree", [0, 2])
def test_value_and_gradients_are_those_of_the_graph(absgrad, degree):
    viewmats, intrinsics = (x.float() for x in cameras(1, 1, WIDTH, HEIGHT))
    photograph = np.random.default_rng(0).integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    target = prepare_target(photograph, torch.device("cpu"))
    found = []
    for compute in (photometric_step, by_graph):
        means, quats, scales, opacities, colors = tensors = leaves(gaussians(300, 3, sh_degree=3), torch.float32)
        loss, meta = compute(
            target=target, ssim_weight=0.2, means=means, quats=quats, scales=scales, opacities=opacities,
            colors=colors, viewmats=viewmats, Ks=intrinsics, width=WIDTH, height=HEIGHT, sh_degree=degree,
            absgrad=absgrad, backgrounds=torch.tensor([[0.2, 0.5, 0.9]]),
        )  # fmt: skip
        loss.backward()
        positions = meta["means2d"].absgrad if absgrad else meta["means2d"].grad
        seen = [meta["means2d"].detach(), meta["radii"], positions]
        found.append([loss.detach(), *(x.grad for x in tensors), *seen])
        assert all(float(x.grad.abs().max()) > 0 for x in tensors)
    for ours, graph in zip(*found, strict=True):
        assert torch.equal(ours, graph)


def test_a_factor_of_the_loss_is_one_of_the_gradients():
    found = []
    for factor in (1.0, 4.0):
        tensors, loss = small_step()
        (factor * loss).backward()
        found.append([x.grad / factor for x in tensors])
    for one, four in zip(*found, strict=True):
        assert torch.equal(one, four)


def test_a_step_is_differentiated_once():
    _, loss = small_step()
    loss.backward(retain_graph=True)
    with pytest.raises(RuntimeError, match="once"):
        loss.backward()
