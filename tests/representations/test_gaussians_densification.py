import numpy as np
import pytest
import torch
from gsplat.strategy import DefaultStrategy

from avs.representations.gaussians.densification import STATISTICS, DensityControl
from avs.representations.gaussians.gaussian_settings import Densification, GaussianSettings, LearningRates
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.optimization import active_degree, create_optimizers, means_rate
from avs.representations.gaussians.parameters import create_parameters

COUNT = 20


class Bench:
    """Gaussians whose image plane gradients the test chooses: Gaussian i has (i + 1) times ``gradient``."""

    def __init__(self, gradient=1.0, **densification):
        settings = Densification(**{"start": 0, "every": 1, "prune_scale": 1e9, **densification})
        positions = np.random.default_rng(0).normal(size=(COUNT, 3))
        cloud = PointCloud(positions, np.full((COUNT, 3), 0.5))
        self.parameters = create_parameters(cloud, 0.1, 0, torch.device("cpu"))
        self.optimizers = create_optimizers(self.parameters, GaussianSettings(), 1.0)
        self.control = DensityControl(settings, 1.0)
        self.generator = np.random.default_rng(0)
        self.gradient = gradient

    def step(self, number):
        count = len(self.parameters["means"])
        means2d = torch.zeros(1, count, 2, requires_grad=True)
        weights = torch.arange(1, count + 1, dtype=torch.float32) * self.gradient
        # A width of 2 makes image plane gradients and those in normalised device coordinates equal.
        meta = {"width": 2, "height": 2, "n_cameras": 1, "gaussian_ids": None, "means2d": means2d}
        meta["radii"] = torch.ones(1, count, 2, dtype=torch.int32)
        self.control.before_backward(self.parameters, self.optimizers, number, meta)
        loss = (means2d[0, :, 0] * weights).sum() + sum((p**2).sum() for p in self.parameters.values())
        loss.backward()
        for optimizer in self.optimizers.values():
            optimizer.step()
            optimizer.zero_grad()
        self.control.after_backward(number, meta)
        self.control.before_step(self.parameters, self.optimizers, number + 1, self.generator)

    @property
    def count(self):
        return len(self.parameters["means"])


@pytest.mark.parametrize("absolute", [False, True])
def test_statistics_are_those_of_gsplat(absolute):
    """To the last bit, over several steps, with Gaussians that are seen not at all or in one direction alone."""
    control = DensityControl(Densification(absolute_gradient=absolute), 1.0)
    strategy = DefaultStrategy(absgrad=absolute)
    state = strategy.initialize_state(scene_scale=1.0)
    generator = torch.Generator().manual_seed(0)
    for step in range(1, 4):
        positions = torch.zeros(1, COUNT, 2, requires_grad=True)
        positions.grad = torch.randn(1, COUNT, 2, generator=generator)
        positions.absgrad = torch.rand(1, COUNT, 2, generator=generator)
        radii = torch.randint(0, 3, (1, COUNT, 2), generator=generator, dtype=torch.int32)
        meta = {"width": 177, "height": 131, "n_cameras": 1, "gaussian_ids": None, "means2d": positions, "radii": radii}
        control.after_backward(step, meta)
        strategy._update_state({"means": torch.zeros(COUNT, 3)}, state, meta)
    for name, values in control.statistics().items():
        assert torch.equal(values, state[name])
    assert control.statistics().keys() == set(STATISTICS)


def test_gaussians_of_large_gradients_grow():
    bench = Bench(gradient_threshold=15.5)
    bench.step(1)
    assert bench.count == COUNT + 5
    shapes = {
        name: optimizer.state[bench.parameters[name]]["exp_avg"].shape for name, optimizer in bench.optimizers.items()
    }
    assert shapes == {name: values.shape for name, values in bench.parameters.items()}
    bench.step(2)


@pytest.mark.parametrize("split_scale", [1e-9, 1e9])
def test_the_budget_holds_and_goes_to_the_largest_gradients(split_scale):
    bench = Bench(gradient_threshold=0.5, max_gaussians=COUNT + 3, split_scale=split_scale)
    before = bench.parameters["means"].detach().clone()
    bench.step(1)
    assert bench.count == COUNT + 3
    kept = {tuple(row) for row in bench.parameters["means"].detach().numpy().round(2)}
    unchanged = [i for i, row in enumerate(before.numpy().round(2)) if tuple(row) in kept]
    if split_scale < 1:
        assert set(unchanged).isdisjoint({17, 18, 19}), "the three of the largest gradients are split"
    bench.step(2)
    assert bench.count == COUNT + 3


def test_equal_gradients_never_exceed_the_budget():
    bench = Bench(gradient_threshold=0.5, max_gaussians=COUNT + 3)
    bench.control._state["grad2d"] = torch.full((COUNT,), 1e9)
    bench.control._state["count"] = torch.ones(COUNT)
    bench.step(1)
    assert bench.count <= COUNT + 3


def test_transparent_gaussians_are_removed():
    bench = Bench(gradient_threshold=1e9, prune_opacity=0.05)
    with torch.no_grad():
        bench.parameters["opacities"][:4] = -10
    bench.step(1)
    assert bench.count == COUNT - 4


def test_large_gaussians_are_removed_only_after_the_first_reset_is_due():
    bench = Bench(gradient_threshold=1e9, prune_scale=100.0, opacity_reset_every=2, prune_opacity=1e-6)
    with torch.no_grad():
        bench.parameters["scales"][:3] = 10
    for step, count in ((1, COUNT), (2, COUNT), (3, COUNT - 3)):
        bench.step(step)
        assert bench.count == count


def test_opacities_are_reset_where_it_is_due():
    bench = Bench(gradient_threshold=1e9, opacity_reset_every=3, opacity_reset_value=0.02, prune_opacity=0.001)
    for step, largest in ((1, 0.1), (2, 0.1), (3, 0.02)):
        bench.step(step)
        assert bench.parameters["opacities"].detach().sigmoid().max().item() == pytest.approx(largest, rel=0.2)
    assert not bench.optimizers["opacities"].state[bench.parameters["opacities"]]["exp_avg"].any()


def test_nothing_changes_outside_the_steps_of_densification():
    bench = Bench(gradient_threshold=0.5, start=2, every=2, until=6)
    counts = []
    for step in range(1, 9):
        bench.step(step)
        counts.append(bench.count)
    assert counts[:3] == [COUNT] * 3
    assert counts[3] > COUNT
    assert counts[4:] == [counts[3]] * 4


def test_splits_depend_on_the_generator_alone():
    benches = [Bench(gradient_threshold=0.5, split_scale=1e-9) for _ in range(2)]
    for seed, bench in enumerate(benches):
        torch.manual_seed(seed)
        state = torch.random.get_rng_state()
        bench.step(1)
        assert torch.equal(torch.random.get_rng_state(), state)
    assert torch.equal(benches[0].parameters["means"], benches[1].parameters["means"])


def test_schedules():
    settings = GaussianSettings()
    assert [active_degree(settings, step) for step in (1, 999, 1000, 2999, 3000, 30_000)] == [0, 0, 1, 2, 3, 3]
    rates = LearningRates()
    expected = [1.6e-4, 1.6e-5, 1.6e-6, 1.6e-6]
    assert [means_rate(rates, progress) for progress in (0, 0.5, 1, 2)] == pytest.approx(expected)
