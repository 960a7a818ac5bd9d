"""The kernels of TensoRF against their torch twins in float64."""

import numpy as np
import pytest
import torch

from avs.representations.ray_fields.unbounded_space import contracted, distance_at, spacing_of
from avs.representations.tensorf import vector_matrix_twin
from avs.representations.tensorf.vector_matrix_field import cells_after, refined
from avs.representations.tensorf.vector_matrix_lookup import March, marched, products
from tests import tolerances

CELLS, COMPONENTS, RAYS, SAMPLES = 7, 5, 40, 24


def tensors(seed=0, size=0.6):
    rng = np.random.default_rng(seed)
    shapes = ((3, CELLS, CELLS, COMPONENTS), (3, CELLS, COMPONENTS))
    return [torch.from_numpy(rng.normal(0, size, shape).astype(np.float32)) for shape in shapes]


def rays(seed=1):
    rng = np.random.default_rng(seed)
    origins = rng.uniform(-1, 1, (RAYS, 3))
    directions = rng.normal(size=(RAYS, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return [torch.from_numpy(each.astype(np.float32)) for each in (origins, directions, rng.random(RAYS))]


def march_of(filled=None, least=0.0, shift=-1.0):
    filled = torch.ones((1, 1, 1), dtype=torch.uint8) if filled is None else filled
    return March(filled, 0.02, 2.0, shift, 2.0, least, SAMPLES)


def same(found, expected, tolerance):
    scale = float(expected.abs().max())
    assert float((found.double() - expected).abs().max()) <= tolerance * scale


def twin(planes, lines, ray, march):
    return vector_matrix_twin.march(planes, lines, march.filled, *ray, march.numbers, march.samples)


@pytest.mark.parametrize("case", ["everywhere", "in some cells", "until opaque"])
def test_samples_weights_and_gradients_equal_those_of_the_twin(case):
    generator = torch.Generator().manual_seed(3)
    filled = (torch.rand((6, 6, 6), generator=generator) < 0.5).to(torch.uint8)
    march = {
        "everywhere": march_of(),
        "in some cells": march_of(filled),
        "until opaque": march_of(least=0.05, shift=1.0),
    }[case]
    single = [each.requires_grad_() for each in tensors()]
    double = [each.detach().double().requires_grad_() for each in single]
    places, owners, distances, weights = marched(*single, *rays(), march)
    expected = twin(*double, [each.double() for each in rays()], march)
    assert len(places) == len(expected[0]) > RAYS
    assert case == "everywhere" or len(places) < RAYS * SAMPLES
    assert torch.equal(owners, expected[1])
    same(places, expected[0], tolerances.FIELD_PLACES)
    near = expected[2] < 20  # beyond, float32 has few digits of the inverse distance
    same(distances[near], expected[2][near], tolerances.FIELD_PLACES)
    same(weights.detach(), expected[3].detach(), tolerances.FIELD_VALUES)
    by = torch.from_numpy(np.random.default_rng(5).normal(size=len(weights)))
    (weights * by.float()).sum().backward()
    (expected[3] * by).sum().backward()
    for one, other in zip(single, double, strict=True):
        same(one.grad, other.grad, tolerances.FIELD_GRADIENTS)


def test_products_and_gradients_equal_those_of_the_twin():
    rng = np.random.default_rng(2)
    places = torch.from_numpy(rng.uniform(-2, 2, (200, 3)).astype(np.float32))
    places[0], places[1] = 2.0, -2.0
    single = [each.requires_grad_() for each in tensors()]
    double = [each.detach().double().requires_grad_() for each in single]
    found, expected = products(*single, places), vector_matrix_twin.products(*double, places.double())
    same(found.detach(), expected.detach(), tolerances.FIELD_VALUES)
    by = torch.from_numpy(rng.normal(size=found.shape))
    (found * by.float()).sum().backward()
    (expected * by).sum().backward()
    for one, other in zip(single, double, strict=True):
        same(one.grad, other.grad, tolerances.FIELD_GRADIENTS)


def test_the_product_in_a_cell_is_that_of_its_numbers():
    planes, lines = tensors()
    step = 4 / (CELLS - 1)
    place = torch.tensor([[-2 + 2 * step, -2 + 3 * step, -2 + 5 * step]])
    expected = [planes[0, 2, 3] * lines[0, 5], planes[1, 3, 5] * lines[1, 2], planes[2, 5, 2] * lines[2, 3]]
    torch.testing.assert_close(products(planes, lines, place)[0], torch.cat(expected), rtol=1e-4, atol=1e-5)


def test_no_weight_is_lost_or_made():
    planes, lines = tensors()
    _, owners, _, weights = marched(planes, lines, *rays(), march_of(shift=3.0))
    opacity = torch.zeros(RAYS).index_add(0, owners, weights)
    assert float(weights.min()) >= 0
    assert float(opacity.max()) <= 1 + 1e-5
    assert float(opacity.min()) > 0.99  # rays go on to where intervals have no end


def test_space_is_contracted_into_a_cube_and_distances_into_one():
    points = torch.tensor([[0.5, -0.2, 0.9], [2.0, 0.0, 0.0], [0.0, -4.0, 2.0], [1e9, 1.0, 1.0]], dtype=torch.float64)
    expected = torch.tensor([[0.5, -0.2, 0.9], [1.5, 0, 0], [0, -1.75, 0.875], [2, 2e-9, 2e-9]], dtype=torch.float64)
    torch.testing.assert_close(contracted(points), expected, rtol=1e-6, atol=1e-9)
    distances = torch.tensor([0.1, 1.0, 2.0, 8.0, 1000.0], dtype=torch.float64)
    spacing = spacing_of(distances, 2.0)
    torch.testing.assert_close(spacing[:3], torch.tensor([0.025, 0.25, 0.5], dtype=torch.float64))
    torch.testing.assert_close(distance_at(spacing, 2.0), distances)


def test_refined_planes_and_lines_are_the_same_functions():
    planes, lines = tensors()
    finer = (refined(planes, 2 * CELLS - 1), refined(lines, 2 * CELLS - 1))
    torch.testing.assert_close(finer[0][:, ::2, ::2], planes)
    torch.testing.assert_close(finer[1][:, 1::2], (lines[:, 1:] + lines[:, :-1]) / 2)
    assert [cells_after(number, 16, 64, 2) for number in range(3)] == [16, 32, 64]
