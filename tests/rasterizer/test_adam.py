import numpy as np
import pytest
import torch

from avs.rasterizer import adam
from avs.rasterizer.adam import Adam
from tests import tolerances


@pytest.mark.parametrize("shape", [(50, 3), (50,), (50, 4, 3)])
@pytest.mark.parametrize("epsilon", [1e-8, 1e-15])
def test_steps_equal_those_of_torch(shape, epsilon):
    generator = torch.Generator().manual_seed(0)
    ours = torch.nn.Parameter(torch.randn(shape, generator=generator))
    theirs = torch.nn.Parameter(ours.detach().clone())
    first, second = Adam(ours, 0.01, epsilon), torch.optim.Adam([theirs], lr=0.01, eps=epsilon)
    for step in range(20):
        gradient = torch.randn(shape, generator=generator)
        gradient[::3] = 0  # Gaussians out of sight
        ours.grad, theirs.grad = gradient, gradient.clone()
        first.set_rate(0.01 * 0.9**step)
        second.param_groups[0]["lr"] = 0.01 * 0.9**step
        first.step()
        second.step()
    torch.testing.assert_close(ours, theirs, rtol=0, atol=tolerances.ADAM_STEPS)


def test_the_rest_has_its_own_rate_and_inactive_columns_stay():
    parameter = torch.nn.Parameter(torch.zeros(5, 4, 3))
    optimizer = Adam(parameter, 0.1, 1e-15, rest=(3, 0.01))
    optimizer.set_active(6)
    parameter.grad = torch.ones(5, 4, 3)
    optimizer.step()
    expected = torch.tensor([-0.1, -0.01, 0, 0])[None, :, None].expand(5, 4, 3)
    torch.testing.assert_close(parameter.detach(), expected)


def test_the_torch_path_of_other_devices_equals_the_kernel(monkeypatch):
    results = []
    for update in (adam._update_cpu, adam._update):
        monkeypatch.setattr(adam, "_update_cpu", update)
        generator = torch.Generator().manual_seed(3)
        parameter = torch.nn.Parameter(torch.randn(20, 4, 3, generator=generator))
        optimizer = Adam(parameter, 0.05, 1e-15, rest=(3, 0.002))
        for _ in range(5):
            parameter.grad = torch.randn(20, 4, 3, generator=generator)
            optimizer.step()
        results.append(parameter.detach().numpy())
    np.testing.assert_allclose(*results, rtol=0, atol=tolerances.ADAM_STEPS)


def test_a_parameter_that_lost_its_rows_is_left_alone():
    optimizer = Adam(torch.nn.Parameter(torch.zeros(2, 3)), 0.01, 1e-15)
    parameter = torch.nn.Parameter(torch.zeros(0, 3))
    parameter.grad = torch.zeros(0, 3)
    optimizer.param_groups[0]["params"] = [parameter]
    optimizer.step()
    assert parameter not in optimizer.state
