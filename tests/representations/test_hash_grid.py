"""Nerfacto's lookups against their torch twin in float64, and its sampling and losses against their definitions."""

import numpy as np
import pytest
import torch

from avs.representations.nerfacto.hash_grid import cells_of, looked_up, looked_up_by_torch
from avs.representations.nerfacto.nerfacto_field import annealed
from avs.representations.nerfacto.nerfacto_settings import HashGrid
from avs.representations.nerfacto.proposal_sampling import (
    distortion_loss,
    drawn_edges,
    even_edges,
    interlevel_loss,
    weights_of,
)
from tests import tolerances

GRID = HashGrid(levels=4, coarsest=3, finest=40, log2_entries=9)  # the first two need no hash


def tables(seed=0):
    rng = np.random.default_rng(seed)
    return torch.from_numpy(rng.normal(size=(4, 512, 2)).astype(np.float32))


def ordered(rows, count, seed):
    values = np.sort(np.random.default_rng(seed).random((rows, count)), axis=1)
    values[:, 0], values[:, -1] = 0, 1
    return torch.from_numpy(values)


def shares(rows, count, seed):
    return torch.from_numpy(np.random.default_rng(seed).dirichlet(np.ones(count), rows)) * 0.9


def test_values_and_gradients_equal_those_of_the_twin():
    rng = np.random.default_rng(1)
    places = torch.from_numpy(rng.uniform(-2, 2, (300, 3)).astype(np.float32))
    places[0], places[1] = 2.0, -2.0
    single = tables().requires_grad_()
    double = single.detach().double().requires_grad_()
    found = looked_up(single, cells_of(GRID), places)
    expected = looked_up_by_torch(double, cells_of(GRID), places.double())
    by = torch.from_numpy(rng.normal(size=found.shape))
    (found * by.float()).sum().backward()
    (expected * by).sum().backward()
    for one, other in ((found.detach(), expected.detach()), (single.grad, double.grad)):
        assert float((one.double() - other).abs().max()) <= tolerances.FIELD_GRADIENTS * float(other.abs().max())


def test_a_corner_has_the_numbers_of_its_entry():
    place = torch.tensor([[-2 + 4 / 3, -2 + 8 / 3, 2.0]])
    entry = (1 * 4 + 2) * 4 + 3
    torch.testing.assert_close(looked_up(tables(), cells_of(GRID), place)[0, :2], tables()[0, entry])


def test_cells_grow_by_equal_factors():
    assert cells_of(HashGrid(levels=3, coarsest=16, finest=64)) == (16, 32, 64)
    assert cells_of(HashGrid(levels=1, coarsest=16, finest=64)) == (16,)


def test_even_edges_lie_between_their_ends_and_are_moved_together():
    edges = even_edges(2, 4, 0.2, 1.0, torch.tensor([0.5, 0.75]))
    torch.testing.assert_close(edges[0], torch.tensor([0.2, 0.4, 0.6, 0.8, 1.0]))
    torch.testing.assert_close(edges[1], torch.tensor([0.2, 0.45, 0.65, 0.85, 1.0]))


def test_new_edges_are_dense_where_the_weight_is():
    edges = torch.linspace(0, 1, 11)[None]
    weights = torch.zeros((1, 10))
    weights[0, 3] = 1.0
    found = drawn_edges(edges, weights, 20, torch.tensor([0.5]))[0]
    assert bool((found.diff() >= 0).all())
    inside = ((found >= 0.3) & (found <= 0.4)).float().mean()
    assert float(inside) > 0.8


def test_weights_are_those_of_volume_rendering():
    density, lengths = torch.tensor([[1.0, 2.0, 0.5]]), torch.tensor([[0.1, 0.3, 1.0]])
    alpha = 1 - np.exp(-np.array([0.1, 0.6, 0.5]))
    expected = alpha * np.cumprod([1, 1 - alpha[0], 1 - alpha[1]])
    np.testing.assert_allclose(weights_of(density, lengths)[0], expected, rtol=1e-6)


def test_distortion_is_the_double_sum():
    edges, weights = ordered(3, 8, 0), shares(3, 7, 1)
    middles = (edges[:, 1:] + edges[:, :-1]) / 2
    apart = (middles[:, :, None] - middles[:, None]).abs()
    double = (weights[:, :, None] * weights[:, None] * apart).sum(dim=(1, 2))
    expected = (double + (weights**2 * edges.diff(dim=1)).sum(dim=1) / 3).mean()
    torch.testing.assert_close(distortion_loss(edges, weights), expected)


def test_a_proposal_is_bound_by_all_of_its_intervals_that_touch():
    edges, weights = ordered(5, 7, 2), shares(5, 6, 3)
    outer_edges, outer_weights = ordered(5, 5, 4), shares(5, 4, 5)
    total = 0.0
    for row in range(5):
        for i in range(6):
            low, high = edges[row, i], edges[row, i + 1]
            touching = (outer_edges[row, 1:] > low) & (outer_edges[row, :-1] < high)
            excess = max(0.0, float(weights[row, i] - outer_weights[row][touching].sum()))
            total += excess**2 / (float(weights[row, i]) + 1e-7)
    found = interlevel_loss(edges, weights, outer_edges, outer_weights)
    assert float(found) == pytest.approx(total / 30, rel=1e-6)
    assert float(interlevel_loss(edges, weights, edges, weights)) == pytest.approx(0, abs=1e-12)


def test_annealing_goes_from_no_weight_to_all_of_it():
    assert annealed(0.0) == 0
    assert annealed(1.0) == 1
    assert 0.5 < annealed(0.2) < 1
