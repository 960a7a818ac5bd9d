"""A reconstruction on CUDA: it learns as on the CPU, is copied and restored, and has every capability."""

import numpy as np
import pytest
import torch
from test_gaussians import CAMERAS, CLOUD, SETTINGS, psnr, same, views  # noqa: F401
from tolerances import CUDA_CAPABILITY, CUDA_FIT, CUDA_IMAGE

from avs.representations.gaussians.splats import GaussianSplats
from avs.representations.learned_variance import VarianceLearning, VarianceReduction

pytestmark = pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU that torch can use")

LEARNING = VarianceLearning(learning_rate=None, constant=1e-4, floor=0.1, attenuated=False)


def splats(device, variance=False):
    made = GaussianSplats(CLOUD, 1.0, SETTINGS, np.random.default_rng(1), device)
    if variance:
        made.learn_variance(LEARNING)
    return made


def pair(tmp_path, views, variance=False):  # noqa: F811
    """Return the same fitted reconstruction on the CPU and on the GPU."""
    here = splats("cpu", variance)
    here.fit(views, 60)
    here.save(tmp_path / "here.safetensors")
    there = splats("cuda", variance)
    there.load(tmp_path / "here.safetensors")
    return here, there


@pytest.mark.parametrize("variance", [False, True])
def test_fits_as_well_as_on_the_cpu(views, variance):  # noqa: F811
    reached = []
    for device in ("cpu", "cuda"):
        representation = splats(device, variance)
        representation.fit(views, 200)
        assert representation.parameters["means"].device.type == device
        reached.append(psnr(representation, views))
    assert reached[1] == pytest.approx(reached[0], abs=CUDA_FIT)


def test_renders_what_the_cpu_renders(views, tmp_path):  # noqa: F811
    here, there = (representation.render(CAMERAS) for representation in pair(tmp_path, views))
    assert np.abs(here.rgb - there.rgb).max() < CUDA_IMAGE
    assert np.abs(here.alpha - there.alpha).max() < CUDA_IMAGE
    assert np.abs(here.depth - there.depth).max() < CUDA_IMAGE * here.depth.max()


def test_a_checkpoint_goes_back_and_forth(views, tmp_path):  # noqa: F811
    here, there = pair(tmp_path, views)
    there.save(tmp_path / "there.safetensors")
    back = splats("cpu")
    back.load(tmp_path / "there.safetensors")
    assert same(here, back)
    there.export(tmp_path)
    assert (tmp_path / "splats.ply").is_file()


def test_a_copy_goes_its_own_way(views, tmp_path):  # noqa: F811
    _, there = pair(tmp_path, views)
    before = {name: values.detach().clone() for name, values in there.parameters.items()}
    twin = there.copy()
    twin.fit(views, 5)
    assert twin.parameters["means"].is_cuda
    assert all(torch.equal(before[name], there.parameters[name]) for name in before)
    assert not torch.equal(twin.parameters["means"], there.parameters["means"])


def test_callers_generators_are_left_alone(views):  # noqa: F811
    states = torch.random.get_rng_state(), torch.cuda.get_rng_state()
    splats("cuda").fit(views, 60)
    assert torch.equal(torch.random.get_rng_state(), states[0])
    assert torch.equal(torch.cuda.get_rng_state(), states[1])


def test_capabilities(views, tmp_path):  # noqa: F811
    here, there = pair(tmp_path, views, variance=True)
    groups = ("means", "f_dc", "f_rest", "scales", "opacities")
    image = np.linspace(0, 1, 24 * 32, dtype=np.float32).reshape(24, 32)
    values = np.linspace(0, 1, here.primitives, dtype=np.float32)

    def found(representation):
        yield representation.centres
        for information in representation.fisher_diagonal(CAMERAS[:2], "once", groups):
            yield information.values
        for information in representation.fisher_probes(CAMERAS[:2], "once", groups, 4, [1, 2]):
            yield information.values
        yield representation.blended_values(CAMERAS[:1], values)
        yield representation.front_weights(CAMERAS[:1], image, 0.5)[0]
        yield representation.variance_reduction(CAMERAS, VarianceReduction(1e-4, True, False))

    for x, y in zip(found(here), found(there), strict=True):
        assert x.shape == y.shape
        assert np.linalg.norm(x - y) <= CUDA_CAPABILITY * np.linalg.norm(x)
