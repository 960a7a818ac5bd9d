"""A copy of Gaussians goes on with the same bits, and the two leave each other alone."""

import numpy as np
import pytest
import torch
from factories import named_views, ring

from avs.representations.capabilities import Copyable
from avs.representations.gaussians.gaussian_settings import Densification, GaussianSettings, InitialPoints
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.splats import GaussianSplats
from avs.selection import registry
from avs.selection.contract import Resources

# Splits draw from the generator in the steps after the copy, too.
DENSIFICATION = Densification(start=5, every=10, until=100, prune_scale=10.0, max_gaussians=90)
SETTINGS = GaussianSettings(iterations=100, sh_degree=1, sh_increase_every=10, densification=DENSIFICATION)


@pytest.fixture(params=["plain", "extended"])
def fitted(request):
    rng = np.random.default_rng(0)
    cameras = ring(5, size=(32, 24))
    cloud = PointCloud(rng.normal(size=(40, 3)) * 0.7, rng.random((40, 3)))
    scene = GaussianSplats(cloud, 1.0, GaussianSettings(points=InitialPoints(opacity=0.9)), rng, "cpu")
    views = named_views(cameras, tuple(np.round(image * 255).astype(np.uint8) for image in scene.render(cameras).rgb))
    splats = GaussianSplats(cloud, 1.0, SETTINGS, rng, "cpu")
    if request.param == "extended":
        method = registry.find("activenerf").method
        method.build(method.settings(), Resources()).prepare(splats)
    splats.fit(views, 17)
    return splats, views


def state(splats, path):
    """All that further steps depend on, as the checkpoint has it."""
    splats.save(path)
    return path.read_bytes()


def test_a_copy_goes_on_with_the_same_bits(fitted, tmp_path):
    splats, views = fitted
    twin = splats.copy()
    assert isinstance(splats, Copyable)
    before = splats.primitives
    assert state(twin, tmp_path / "twin") == state(splats, tmp_path / "original")
    for each in (twin, splats):
        each.fit(views, 40)
    assert splats.primitives != before
    assert state(twin, tmp_path / "twin") == state(splats, tmp_path / "original")


def test_a_copy_with_a_seed_has_choices_of_its_own(fitted, tmp_path):
    splats, views = fitted
    before = state(splats, tmp_path / "before")
    twins = [splats.copy(seed) for seed in (1, 1, 2)]
    for twin in twins:
        np.testing.assert_array_equal(twin.centres, splats.centres)
        twin.fit(views, 20)
    first, same, other = (state(twin, tmp_path / "twin") for twin in twins)
    assert first == same
    assert first != other
    assert state(splats, tmp_path / "after") == before


def test_fitting_a_copy_changes_nothing_of_the_original(fitted, tmp_path):
    splats, views = fitted
    before = state(splats, tmp_path / "before")
    twin = splats.copy()
    twin.fit(views[[0, 2]], 30)
    with torch.no_grad():
        twin.parameters["means"] += 1
    assert state(splats, tmp_path / "after") == before
    assert state(twin, tmp_path / "twin") != before


def test_photographs_are_shared(fitted):
    splats, views = fitted
    twin = splats.copy()
    assert list(twin._targets) == list(splats._targets) == list(views.names)
    assert all(twin._targets[name] is target for name, target in splats._targets.items())
