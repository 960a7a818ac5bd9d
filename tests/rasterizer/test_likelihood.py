"""The fused likelihood against its formula in float64."""

import pytest
import torch
from tolerances import LIKELIHOOD

from avs.rasterizer.likelihood import negative_log_likelihood

FLOOR = 0.1


def test_value_and_gradients():
    generator = torch.Generator().manual_seed(0)
    image, photograph = (torch.rand(7, 9, 3, generator=generator) for _ in range(2))
    variance = torch.rand(7, 9, generator=generator) * 0.4
    variance[0, 0] = 0.1  # on the floor: 0.1 is a little more in float32 than in float64
    below = variance < FLOOR
    assert 0 < below.double().mean() < 1
    fast = [x.clone().requires_grad_() for x in (image, variance)]
    slow = [x.double().requires_grad_() for x in (image, variance)]
    value = negative_log_likelihood(*fast, photograph, FLOOR)
    held = torch.where(slow[1] < FLOOR, FLOOR, slow[1])[..., None]
    expected = ((slow[0] - photograph) ** 2 / (2 * held) + held.log() / 2).mean()
    (3 * value).backward()
    (3 * expected).backward()
    assert value.item() == pytest.approx(expected.item(), rel=LIKELIHOOD)
    for one, other in zip(fast, slow, strict=True):
        assert (one.grad - other.grad).abs().max() <= LIKELIHOOD * other.grad.abs().max()
    assert not fast[1].grad[below].any()


def test_images_that_are_slices_of_others():
    """The rasteriser hands out the first three of four interleaved channels."""
    both = torch.rand(5, 6, 4, generator=torch.Generator().manual_seed(1), requires_grad=True)
    photograph = torch.zeros(5, 6, 3)
    negative_log_likelihood(both[..., :3], both[..., 3], photograph, FLOOR).backward()
    copies = [x.detach().clone().requires_grad_() for x in (both[..., :3], both[..., 3])]
    negative_log_likelihood(*copies, photograph, FLOOR).backward()
    assert torch.equal(both.grad, torch.cat([copies[0].grad, copies[1].grad[..., None]], dim=-1))
