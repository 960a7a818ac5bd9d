"""What every radiance field promises: fitting, renderings, checkpoints and copies, on a scene of coloured Gaussians."""

import numpy as np
import pytest
import torch
from factories import named_views, ring

from avs.representations import kinds
from avs.representations.gaussians.gaussian_settings import GaussianSettings, InitialPoints
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.splats import GaussianSplats
from avs.scene.cameras import Cameras
from avs.scene.scene import Scene
from avs.system.errors import UserError
from tests import tolerances
from tests.factories import small_scene

SMALL = {
    "tensorf": {
        "iterations": 200,
        "rays": 128,
        "samples": 32,
        "density_components": 4,
        "appearance_components": 8,
        "density_shift": -3,
        "grid_rate": 0.05,
        "hidden": 16,
        "grid": {"initial": 8, "final": 16, "refine_at": [30, 60]},
        "empty_space": {"every": 20, "cells": 16, "opacity": 0.01},
    },
    "nerfacto": {
        "iterations": 200,
        "rays": 128,
        "grid": {"levels": 4, "coarsest": 4, "finest": 32, "log2_entries": 11},
        "proposals": [{"samples": 16, "grid": {"levels": 2, "coarsest": 4, "finest": 16, "log2_entries": 10}}],
        "samples": 16,
        "hidden": 16,
        "appearance": 4,
        "annealing": 50,
        "initial_density": 0.2,
        "learning_rate": 0.02,
    },
}
CAMERAS = ring(6, size=(32, 24))
every_field = pytest.mark.parametrize("kind", SMALL)


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Scene:
    return small_scene(tmp_path_factory.mktemp("fields") / "toy", count=16)


@pytest.fixture(scope="module")
def views():
    rng = np.random.default_rng(0)
    cloud = PointCloud(rng.normal(size=(50, 3)) * 0.7, rng.random((50, 3)))
    opaque = GaussianSettings(sh_degree=0, points=InitialPoints(opacity=0.9))
    truth = GaussianSplats(cloud, 1.0, opaque, np.random.default_rng(0), "cpu").render(CAMERAS)
    return named_views(CAMERAS, tuple(np.round(image * 255).astype(np.uint8) for image in truth.rgb))


def built(scene, kind, seed=1, **changes):
    return kinds.build(
        scene, np.arange(4), kinds.create_settings({"kind": kind, **SMALL[kind], **changes}), seed, "cpu"
    )


def psnr(representation, views):
    difference = representation.render(views.cameras).rgb - np.stack(views.images) / 255
    return -10 * np.log10(np.mean(difference**2))


def same(first, second):
    ours, theirs = first.field.parameters, second.field.parameters
    return ours.keys() == theirs.keys() and all(torch.equal(ours[name], theirs[name]) for name in ours)


@every_field
def test_fit_raises_psnr(scene, views, kind):
    representation = built(scene, kind)
    before = psnr(representation, views)
    representation.fit(views, 150)
    assert representation.iteration == 150
    assert psnr(representation, views) > before + 3


@every_field
def test_same_seed_same_bits_and_other_seed_other_bits(scene, views, kind):
    first, second, other = (built(scene, kind, seed) for seed in (1, 1, 2))
    state = torch.random.get_rng_state()
    for representation in (first, second, other):
        representation.fit(views, 35)
    assert same(first, second)
    assert not same(first, other)
    assert torch.equal(torch.random.get_rng_state(), state), "the caller's generator was touched"


@every_field
def test_a_resumed_run_has_the_same_bits(scene, views, kind, tmp_path):
    """The interruption lies between changes of the field, and a view comes after it."""
    straight, interrupted, resumed = built(scene, kind), built(scene, kind), built(scene, kind, seed=5)
    straight.fit(views[np.arange(4)], 45)
    interrupted.fit(views[np.arange(4)], 45)
    interrupted.render(views.cameras)
    interrupted.save(tmp_path / "half.safetensors")
    resumed.load(tmp_path / "half.safetensors")
    assert same(resumed, interrupted)
    straight.fit(views, 25)
    resumed.fit(views, 25)
    assert same(resumed, straight)
    resumed.save(tmp_path / "resumed.safetensors")
    straight.save(tmp_path / "straight.safetensors")
    assert (tmp_path / "resumed.safetensors").read_bytes() == (tmp_path / "straight.safetensors").read_bytes()


@every_field
def test_a_copy_goes_on_by_itself(scene, views, kind):
    original = built(scene, kind)
    original.fit(views, 10)
    before, twin, other = original.fingerprint(), original.copy(), original.copy(seed=3)
    twin.fit(views, 25)
    other.fit(views, 25)
    assert original.fingerprint() == before
    original.fit(views, 25)
    assert same(original, twin)
    assert not same(original, other)


@every_field
def test_rendering_has_shapes_and_ranges_and_changes_nothing(scene, views, kind):
    representation = built(scene, kind)
    representation.fit(views, 60)
    before = representation.fingerprint(), representation.primitives
    rendering = representation.render(CAMERAS)
    assert (representation.fingerprint(), representation.primitives) == before
    assert rendering.rgb.shape == (6, 24, 32, 3)
    assert rendering.depth.shape == rendering.alpha.shape == (6, 24, 32)
    for values in (rendering.rgb, rendering.depth, rendering.alpha):
        assert values.dtype == np.float32
        assert np.isfinite(values).all()
    for values in (rendering.rgb, rendering.alpha):
        assert 0 <= values.min() <= values.max() <= 1
    assert (rendering.depth[rendering.alpha == 0] == 0).all()
    assert rendering.depth.max() > 0
    one = representation.render(CAMERAS[3])
    np.testing.assert_array_equal(one.rgb[0], rendering.rgb[3])
    sizes = CAMERAS.sizes.copy()
    sizes[2] = (20, 30)
    with pytest.raises(ValueError, match="one image size"):
        representation.render(Cameras(CAMERAS.world_to_camera, CAMERAS.intrinsics, sizes))


@every_field
def test_a_wrong_checkpoint_is_refused(scene, views, kind, tmp_path):
    representation = built(scene, kind)
    representation.fit(views, 2)
    path = tmp_path / "field.safetensors"
    with pytest.raises(UserError, match="no such file"):
        representation.load(path)
    representation.save(path)
    with pytest.raises(UserError, match="other settings"):
        built(scene, kind, iterations=99).load(path)
    whole = path.read_bytes()
    path.write_bytes(whole[:-50])
    with pytest.raises(UserError, match="not a readable safetensors file"):
        representation.load(path)
    representation.export(tmp_path)
    with pytest.raises(UserError, match="it is an export"):
        representation.load(tmp_path / kinds.find(kind).exports)


@every_field
def test_parameters_that_are_not_finite_stop_the_fit(scene, views, kind):
    representation = built(scene, kind)
    with torch.no_grad():
        next(iter(representation.field.parameters.values())).fill_(float("nan"))
    with pytest.raises(UserError, match="stopped being finite"):
        representation.fit(views, 1)


def test_views_that_come_undo_what_counts_as_empty(scene, views):
    representation = built(scene, "tensorf", empty_space={"every": 20, "cells": 16, "opacity": 0.5})
    representation.fit(views[np.arange(4)], 25)
    assert not bool(representation.field.filled.all())
    representation.fit(views, 1)
    assert bool(representation.field.filled.all())


@pytest.mark.parametrize("decoder", ["mlp", "sh"])
def test_the_kernels_and_the_twin_fit_alike(scene, views, monkeypatch, decoder):
    """The twin runs where tensors lie elsewhere than on the CPU; here it is made to."""
    from avs.representations.tensorf import vector_matrix_field, vector_matrix_twin

    ours, theirs = (built(scene, "tensorf", decoder=decoder) for _ in range(2))
    ours.fit(views, 40)
    monkeypatch.setattr(vector_matrix_field, "products", vector_matrix_twin.products)
    monkeypatch.setattr(
        vector_matrix_field,
        "marched",
        lambda planes, lines, *rays, march=None: vector_matrix_twin.march(
            planes, lines, rays[-1].filled, *rays[:-1], rays[-1].numbers, rays[-1].samples
        ),
    )
    theirs.fit(views, 40)
    assert psnr(ours, views) == pytest.approx(psnr(theirs, views), abs=tolerances.FIELD_FIT)


def test_nerfacto_fits_alike_with_its_twin(scene, views, monkeypatch):
    from avs.representations.nerfacto import hash_grid, nerfacto_networks

    ours, theirs = (built(scene, "nerfacto") for _ in range(2))
    ours.fit(views, 40)
    monkeypatch.setattr(nerfacto_networks, "looked_up", hash_grid.looked_up_by_torch)
    theirs.fit(views, 40)
    assert psnr(ours, views) == pytest.approx(psnr(theirs, views), abs=tolerances.FIELD_FIT)
