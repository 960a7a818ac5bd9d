"""The fused loss against its conv2d twin in float64."""

import numpy as np
import pytest
import torch

from avs.rasterizer.losses import photometric_loss, prepare_target, structural_similarity
from tests import tolerances


def reference_loss(image, target, weight):
    target = target.to(torch.float64)
    return (1 - weight) * (image - target).abs().mean() + weight * (1 - structural_similarity(image, target))


@pytest.mark.parametrize("size", [(33, 47), (5, 7), (1, 1), (64, 16)])
@pytest.mark.parametrize("weight", [0.0, 0.2, 1.0])
def test_value_and_gradient_equal_those_of_conv2d(size, weight):
    rng = np.random.default_rng(size[0])
    photograph = rng.integers(0, 256, (*size, 3), dtype=np.uint8)
    target = prepare_target(photograph, torch.device("cpu"))
    noise = torch.from_numpy(rng.normal(0, 0.1, (*size, 3)))
    image = (target.image + noise).to(torch.float32).requires_grad_()
    exact = image.detach().to(torch.float64).requires_grad_()

    loss = photometric_loss(image, target, weight)
    (3 * loss).backward()
    expected = reference_loss(exact, target.image, weight)
    (3 * expected).backward()

    assert loss.item() == pytest.approx(expected.item(), abs=tolerances.LOSS_VALUE)
    scale = float(exact.grad.abs().max())
    assert float((image.grad - exact.grad).abs().max()) <= tolerances.LOSS_GRADIENT * scale


def test_flat_regions_are_accurate():
    """Variances are differences of nearly equal numbers there, the worst case for float32."""
    photograph = np.full((40, 40, 3), 250, dtype=np.uint8)
    target = prepare_target(photograph, torch.device("cpu"))
    image = torch.full((40, 40, 3), 0.97, requires_grad=True)
    exact = image.detach().to(torch.float64).requires_grad_()
    loss = photometric_loss(image, target, 1.0)
    expected = reference_loss(exact, target.image, 1.0)
    assert loss.item() == pytest.approx(expected.item(), abs=tolerances.LOSS_VALUE_FLAT)


def test_identical_images_have_no_loss():
    photograph = np.random.default_rng(0).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    target = prepare_target(photograph, torch.device("cpu"))
    assert float(photometric_loss(target.image.clone(), target, 0.2)) == pytest.approx(0, abs=tolerances.LOSS_VALUE)
