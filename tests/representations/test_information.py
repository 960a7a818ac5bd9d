"""Fisher information of the parameters, exact and by probes, against the Jacobian of every pixel in float64."""

import numpy as np
import pytest
import torch

from avs.representations.capabilities import HasFisherDiagonal, HasFisherProbes
from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.parameter_information import GROUPS
from avs.representations.gaussians.splats import GaussianSplats
from avs.scene.cameras import Cameras
from avs.system.errors import UserError
from tests import tolerances
from tests.factories import ring
from tests.rasterizer import reference_renderer as reference

DEGREE = 1
SETTINGS = GaussianSettings(sh_degree=2, sh_increase_every=7, background=(0.1, 0.3, 0.2))
CAMERAS = ring(6, size=(7, 5))
BLIND = ("means", "f_dc", "f_rest", "scales", "opacities")


def splats():
    """Gaussians of all shapes, half of them off the image, at a step where the degree is 1 of 2."""
    generator = np.random.default_rng(3)
    cloud = PointCloud(generator.normal(size=(24, 3)) * np.array([1.0, 1.0, 3.0]), generator.random((24, 3)))
    representation = GaussianSplats(cloud, 1.0, SETTINGS, np.random.default_rng(0), "cpu")
    with torch.no_grad():
        for name, spread in (("scales", 0.7), ("quats", 1.0), ("opacities", 1.5), ("sh", 0.4)):
            values = representation.parameters[name]
            values += spread * torch.from_numpy(generator.normal(size=tuple(values.shape))).float()
    representation.iteration = 7
    assert representation.sh_degree == DEGREE
    return representation


def jacobian(representation, camera):
    """Return the derivatives of each pixel's channel sum by the parameters: ``[pixels, Gaussians, ...]`` by group."""
    names = ("means", "quats", "scales", "opacities", "sh")
    (width, height), view = camera.sizes[0].tolist(), torch.tensor(camera.world_to_camera[0])
    intrinsics = torch.tensor(camera.intrinsics[0])

    def channel_sums(means, quats, scales, opacities, sh):
        options = {"sh_degree": DEGREE, "background": torch.tensor(SETTINGS.background, dtype=torch.float64)}
        tensors = (means, quats, scales.exp(), opacities.sigmoid(), sh)
        return reference.render(*tensors, view, intrinsics, width, height, **options)[0].sum(dim=-1).reshape(-1)

    tensors = tuple(representation.parameters[name].detach().double() for name in names)
    found = dict(zip(names, torch.autograd.functional.jacobian(channel_sums, tensors), strict=True))
    found["f_dc"], found["f_rest"] = found["sh"][:, :, 0], found["sh"][:, :, 1 : (DEGREE + 1) ** 2]
    return {name: found[name].reshape(width * height, 24, -1) for name in GROUPS}


def expected_information(representation, camera, chain, groups):
    """Square, sum over pixels, and take one factor of an activation out of the square for the chain ``once``."""
    squares = {name: (values**2).sum(dim=0) for name, values in jacobian(representation, camera).items()}
    if chain == "once":
        scales = representation.parameters["scales"].detach().double().exp()
        opacities = representation.parameters["opacities"].detach().double().sigmoid()[:, None]
        squares["scales"] = squares["scales"] / scales
        squares["opacities"] = squares["opacities"] / (opacities * (1 - opacities))
    return torch.cat([squares[name] for name in GROUPS if name in groups], dim=1).numpy()


def dense(information):
    values = np.zeros((information.primitives, information.values.shape[1]))
    values[information.rows] = information.values
    return values


@pytest.mark.parametrize("chain", ["once", "squared"])
@pytest.mark.parametrize("groups", [BLIND, ("quats", "opacities"), ("f_rest",)])
def test_exact_information_is_the_sum_of_squares(chain, groups):
    representation = splats()
    assert isinstance(representation, HasFisherDiagonal)
    found = list(representation.fisher_diagonal(CAMERAS[:2], chain, groups))
    for index, information in enumerate(found):
        expected = expected_information(representation, CAMERAS[index], chain, groups)
        assert information.values.dtype == np.float32
        assert 5 < len(information.rows) < information.primitives == 24
        assert (np.diff(information.rows) > 0).all()
        allowed = tolerances.FISHER_DIAGONAL * (expected + 1e-6 * expected.max())
        assert (np.abs(dense(information) - expected) <= allowed).all()


@pytest.mark.parametrize("chain", ["once", "squared"])
def test_probes_estimate_it_without_bias(chain):
    representation = splats()
    assert isinstance(representation, HasFisherProbes)
    probes = 400
    (found,) = representation.fisher_probes(CAMERAS[:1], chain, GROUPS, probes, [11])
    expected = expected_information(representation, CAMERAS[:1], chain, GROUPS)
    assert expected.max(axis=0).all()
    deviation = np.sqrt(2 / probes) * expected
    errors = np.abs(dense(found) - expected) - tolerances.FISHER_DIAGONAL * (expected + 1e-6 * expected.max())
    assert (errors <= tolerances.PROBES_DEVIATIONS * deviation).all()


def test_with_one_pixel_a_probe_is_exact():
    """The square of a sign is 1."""
    representation = splats()
    camera = ring(6, size=(1, 1))[:1]
    (exact,) = representation.fisher_diagonal(camera, "once", GROUPS)
    (probed,) = representation.fisher_probes(camera, "once", GROUPS, 1, [0])
    exact, probed = dense(exact), dense(probed)
    assert exact.any()
    assert (np.abs(exact - probed) <= tolerances.FISHER_DIAGONAL * (exact + 1e-6 * exact.max())).all()


def test_an_estimate_depends_on_its_own_seed_alone():
    representation = splats()
    first, second = representation.fisher_probes(CAMERAS[:2], "once", BLIND, 2, [5, 6])
    (alone,) = representation.fisher_probes(CAMERAS[1], "once", BLIND, 2, [6])
    (other,) = representation.fisher_probes(CAMERAS[1], "once", BLIND, 2, [7])
    np.testing.assert_array_equal(second.values, alone.values)
    assert not np.array_equal(other.values, alone.values)
    assert first.values.shape[1] == second.values.shape[1] == 3 + 3 + 9 + 3 + 1


def test_cameras_of_several_sizes_and_unknown_options():
    representation = splats()
    sizes = np.array([[7, 5], [4, 9]])
    mixed = Cameras(CAMERAS.world_to_camera[:2], CAMERAS.intrinsics[:2], sizes)
    assert len(list(representation.fisher_diagonal(mixed, "once", BLIND))) == 2
    assert len(list(representation.fisher_probes(mixed, "once", BLIND, 1, [0, 1]))) == 2
    with pytest.raises(UserError, match="once, squared"):
        representation.fisher_diagonal(CAMERAS, "twice", BLIND)
    with pytest.raises(UserError, match="means, f_dc"):
        representation.fisher_probes(CAMERAS, "once", ("rotations",), 1, [0])
