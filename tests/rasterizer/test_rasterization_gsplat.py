"""The projection and the harmonics against gsplat's own reference functions, where those run without CUDA."""

import inspect

import pytest
import torch
from test_rasterization import HEIGHT, WIDTH, cameras, gaussians
from tolerances import RASTER_GRADIENT, RASTER_IMAGE

from avs.rasterizer.projection import project_gaussians
from avs.rasterizer.rasterization import rasterization
from avs.rasterizer.spherical_harmonics import view_dependent_colors

gsplat = pytest.importorskip("gsplat")
twins = pytest.importorskip("gsplat.cuda._torch_impl")


def test_projection():
    means, quats, scales, opacities, _ = gaussians(300, 11)
    viewmats, intrinsics = cameras(2, 1)
    slow = [x.clone().requires_grad_() for x in (means, quats, scales, viewmats)]
    fast = [x.float().clone().requires_grad_() for x in (means, quats, scales, viewmats)]
    covariances, _ = twins._quat_scale_to_covar_preci(slow[1], slow[2], compute_preci=False)
    _, *expected = twins._fully_fused_projection(
        slow[0], covariances, slow[3], intrinsics, WIDTH, HEIGHT, calc_compensations=True
    )
    *result, radii = project_gaussians(
        *fast[:3], opacities.float(), fast[3], intrinsics.float(), WIDTH, HEIGHT, 0.01, 1e10, 0.0, 0.3, True
    )
    seen = radii[..., 0] > 0
    assert seen.sum() > 100
    loss, other = 0.0, 0.0
    for x, y in zip(expected, result, strict=True):
        weights = torch.randn(x[seen].shape)
        assert (x[seen] - y[seen]).abs().max() < RASTER_IMAGE * x[seen].detach().abs().max()
        loss = loss + (x[seen] * weights).sum()
        other = other + (y[seen] * weights).sum()
    loss.backward()
    other.backward()
    for x, y in zip(slow, fast, strict=True):
        assert (x.grad - y.grad).norm() < RASTER_GRADIENT * x.grad.norm()


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4])
def test_harmonics(degree):
    means = gaussians(200, 12)[0]
    coefficients = torch.randn(200, 25, 3, dtype=torch.float64)
    centres = torch.randn(2, 3, dtype=torch.float64)
    radii = torch.ones(2, 200, 2, dtype=torch.int32)
    expected = torch.stack([twins._spherical_harmonics(degree, means - c, coefficients) for c in centres])
    result = view_dependent_colors(coefficients.float(), means.float(), centres.float(), radii, degree)
    assert (result - (expected + 0.5).clamp(min=0)).abs().max() < RASTER_IMAGE


def test_same_arguments_and_defaults():
    ours, theirs = inspect.signature(rasterization).parameters, inspect.signature(gsplat.rasterization).parameters
    assert list(ours) == list(theirs)
    defaults = {name: parameter.default for name, parameter in theirs.items()}
    # an enumeration of gsplat's, which is not imported here; None stands for it
    assert defaults.pop("rolling_shutter").name == "GLOBAL"
    assert all(ours[name].default == default for name, default in defaults.items())


def test_gsplats_strategy_runs_on_our_output():
    scene = [x.float().requires_grad_() for x in gaussians(100, 13)]
    parameters = dict(zip(("means", "quats", "scales", "opacities", "colors"), scene, strict=True))
    viewmats, intrinsics = (x.float() for x in cameras(2, 1))
    for absgrad in (False, True):
        strategy = gsplat.DefaultStrategy(absgrad=absgrad)
        state = strategy.initialize_state()
        images, _, meta = rasterization(*scene, viewmats, intrinsics, WIDTH, HEIGHT, packed=False, absgrad=absgrad)
        strategy.step_pre_backward(parameters, {}, state, 0, meta)
        images.sum().backward()
        strategy._update_state(parameters, state, meta)
        assert state["grad2d"].sum() > 0
        assert state["count"].max() == 2
