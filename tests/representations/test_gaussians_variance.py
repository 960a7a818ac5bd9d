"""Variances that Gaussians learn: the objective, densification, checkpoints, copies."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from plyfile import PlyData
from test_gaussians import CAMERAS, SETTINGS, psnr, same, splats, views  # noqa: F401
from test_gaussians_densification import COUNT, Bench
from tolerances import LOSS_VALUE

from avs.rasterizer.losses import prepare_target, structural_similarity
from avs.rasterizer.variance_rasterization import rasterization_with_variance, variance_reduction
from avs.representations.gaussians.gaussian_settings import GaussianSettings, InitialPoints
from avs.representations.gaussians.objective import LikelihoodObjective
from avs.representations.gaussians.optimization import create_optimizers
from avs.representations.gaussians.parameters import PrimitiveParameter, extend_parameters
from avs.representations.gaussians.ply import write_ply
from avs.representations.gaussians.rendering import rasterizer_arguments
from avs.representations.gaussians.variance import variance_reductions
from avs.representations.learned_variance import HasLearnedVariance, VarianceLearning, VarianceReduction
from avs.system.errors import UserError

RULE = VarianceReduction(1e-4, True, False)
LEARNING = VarianceLearning(learning_rate=None, constant=1e-4, floor=0.1, attenuated=False)


# The likelihood's floor hides the variance of Gaussians that hardly cover anything.
OPAQUE = SETTINGS.model_copy(update={"points": InitialPoints(opacity=0.9)})


def extended(seed=1, **changes):
    representation = splats(OPAQUE, seed)
    representation.learn_variance(replace(LEARNING, **changes))
    return representation


def test_each_gaussian_gets_the_parameter_at_its_start_and_learns_it(views):  # noqa: F811
    representation = splats()
    representation.learn_variance(LEARNING)
    values = representation.parameters["log_variances"]
    assert values.shape == (50,)
    assert not values.detach().any()
    before = psnr(representation, views)
    representation.fit(views, 200)
    assert psnr(representation, views) > before + 4
    values = representation.parameters["log_variances"].detach()
    assert len(values) == representation.primitives != 50
    assert values.max() < -0.1


def test_the_rate_is_the_one_given_or_that_of_opacities(views):  # noqa: F811
    rates = []
    for changes in ({}, {"learning_rate": 0.003}):
        representation = extended(**changes)
        representation.fit(views, 1)
        rates.append(float(representation.parameters["log_variances"].detach().abs().max()))
    # Adam's first step is the rate, where there is a gradient.
    np.testing.assert_allclose(rates, [GaussianSettings().learning_rates.opacities, 0.003], rtol=1e-3)


@pytest.mark.parametrize("attenuated", [False, True])
def test_the_loss_is_the_likelihood_and_dssim(views, attenuated):  # noqa: F811
    rule = replace(LEARNING, attenuated=attenuated)
    representation = extended(attenuated=attenuated)
    with torch.no_grad():
        representation.parameters["log_variances"].normal_(generator=torch.Generator().manual_seed(0))
        arguments = rasterizer_arguments(representation.parameters, CAMERAS[:1], 0, torch.zeros(1, 3))
        target = prepare_target(views.images[0], torch.device("cpu"))
        loss, _ = LikelihoodObjective(rule, 0.2)(representation.parameters, arguments, target)
        beta = representation.parameters["log_variances"].exp()
        image, variance, _ = rasterization_with_variance(**arguments, variances=beta, attenuated=attenuated)
    image, photograph = image[0].double(), target.image.double()
    held = (variance[0].double() + 1e-4).clamp(min=0.1)[..., None]
    assert (held > 0.1).any()
    assert (held == 0.1).any()
    data = ((image - photograph) ** 2 / (2 * held) + 0.5 * held.log()).mean()
    expected = 0.8 * data + 0.2 * (1 - structural_similarity(image, photograph))
    assert loss.item() == pytest.approx(expected.item(), abs=LOSS_VALUE)


class NumberedBench(Bench):
    """Gaussian i has the log-variance i."""

    def __init__(self, **densification):
        super().__init__(**densification)
        extra = {"log_variances": PrimitiveParameter(0.0)}
        extend_parameters(self.parameters, extra)
        with torch.no_grad():
            self.parameters["log_variances"] += torch.arange(COUNT)
        self.optimizers = create_optimizers(self.parameters, GaussianSettings(), 1.0, extra)

    @property
    def origins(self):
        """The number of the Gaussian that each one comes from."""
        return self.parameters["log_variances"].detach().numpy().round().astype(int).tolist()


@pytest.mark.parametrize("split_scale", [1e-9, 1e9])
def test_a_gaussian_that_grows_hands_the_parameter_on(split_scale):
    bench = NumberedBench(gradient_threshold=15.5, split_scale=split_scale)
    bench.step(1)
    assert sorted(bench.origins) == sorted([*range(COUNT), 15, 16, 17, 18, 19])
    moments = bench.optimizers["log_variances"].state[bench.parameters["log_variances"]]["exp_avg"]
    assert moments.shape == (COUNT + 5,)
    bench.step(2)


def test_a_gaussian_that_is_pruned_takes_the_parameter_with_it():
    bench = NumberedBench(gradient_threshold=1e9, prune_opacity=0.05)
    with torch.no_grad():
        bench.parameters["opacities"][[3, 8]] = -8.0
    bench.step(1)
    assert bench.origins == [i for i in range(COUNT) if i not in (3, 8)]


def test_same_seed_same_bits(views):  # noqa: F811
    first, second = extended(), extended()
    first.fit(views, 60)
    second.fit(views, 60)
    assert same(first, second)
    reductions = [x.variance_reduction(CAMERAS, RULE) for x in (first, second)]
    np.testing.assert_array_equal(*reductions)
    assert reductions[0].shape == (6,)
    assert (reductions[0] > 0).all()


def test_a_resumed_run_has_the_same_bits(views, tmp_path):  # noqa: F811
    straight, interrupted, resumed = extended(), extended(), extended(seed=5)
    straight.fit(views, 100)
    interrupted.fit(views, 50)
    interrupted.save(tmp_path / "half.safetensors")
    resumed.load(tmp_path / "half.safetensors")
    resumed.fit(views, 50)
    assert "log_variances" in resumed.parameters
    assert same(resumed, straight)


def test_a_checkpoint_of_other_parameters_is_refused(tmp_path):
    plain, more = splats(OPAQUE), extended()
    plain.save(tmp_path / "plain.safetensors")
    more.save(tmp_path / "more.safetensors")
    with pytest.raises(UserError, match=r"has the parameters .* instead of log_variances, "):
        more.load(tmp_path / "plain.safetensors")
    with pytest.raises(UserError, match=r"has the parameters log_variances, .* instead of "):
        plain.load(tmp_path / "more.safetensors")


def test_a_copy_goes_on_alike(views):  # noqa: F811
    original = extended()
    original.fit(views, 10)
    copy = original.copy()
    original.fit(views, 20)
    copy.fit(views, 20)
    assert same(original, copy)


def test_a_ply_file_has_the_attributes_of_3dgs_alone(tmp_path):
    write_ply(tmp_path / "plain.ply", splats().parameters)
    write_ply(tmp_path / "more.ply", extended().parameters)
    plain, more = (PlyData.read(tmp_path / name)["vertex"].data for name in ("plain.ply", "more.ply"))
    assert plain.dtype == more.dtype


def test_variances_are_learned_from_the_start_and_once(views):  # noqa: F811
    representation = extended()
    assert isinstance(representation, HasLearnedVariance)
    with pytest.raises(ValueError, match="only one"):
        representation.learn_variance(LEARNING)
    late = splats()
    late.fit(views, 1)
    with pytest.raises(ValueError, match="before the first step"):
        late.learn_variance(LEARNING)
    with pytest.raises(ValueError, match="there is none"):
        late.variance_reduction(CAMERAS, RULE)


def test_reductions_are_those_of_activated_parameters_camera_by_camera():
    representation = extended()
    variances = torch.exp(torch.randn(representation.primitives, generator=torch.Generator().manual_seed(0)))
    cameras = CAMERAS[np.arange(2)]
    cameras = replace(cameras, sizes=cameras.sizes + np.array([[0, 0], [3, 5]]))
    found = variance_reductions(representation.parameters, variances, cameras, True, RULE)
    assert found.shape == (2,)
    means, quats, scales, opacities = (
        representation.parameters[name].detach() for name in ("means", "quats", "scales", "opacities")
    )
    for c, (width, height) in enumerate(cameras.sizes):
        viewmat, intrinsics = (torch.tensor(x[c]).float() for x in (cameras.world_to_camera, cameras.intrinsics))
        expected = variance_reduction(
            means, quats, scales.exp(), opacities.sigmoid(), variances, viewmat, intrinsics, width, height, True,
            RULE.constant, RULE.weighted, RULE.saturated,
        )  # fmt: skip
        assert found[c] == expected > 0
