"""Fitting, rendering and checkpoints of Gaussians, on a scene of Gaussians of known parameters."""

import numpy as np
import pytest
import torch
from factories import named_views

from avs.rasterizer.losses import prepare_target
from avs.representations.gaussians.gaussian_settings import Densification, GaussianSettings, InitialPoints
from avs.representations.gaussians.initialization import PointCloud
from avs.representations.gaussians.splats import GaussianSplats, build
from avs.scene.cameras import Cameras
from avs.scene.views import Views
from avs.system.errors import UserError
from tests.factories import ring, small_scene

DENSIFICATION = Densification(start=20, every=20, until=150, opacity_reset_every=70, prune_scale=10.0, max_gaussians=70)
SETTINGS = GaussianSettings(iterations=200, sh_degree=2, sh_increase_every=40, densification=DENSIFICATION)
RNG = np.random.default_rng(0)
CLOUD = PointCloud(RNG.normal(size=(50, 3)) * 0.7, RNG.random((50, 3)))
CAMERAS = ring(6, size=(32, 24))


def splats(settings=SETTINGS, seed=1, noise=0.1):
    generator = np.random.default_rng(seed)
    cloud = PointCloud(CLOUD.positions + noise * generator.normal(size=CLOUD.positions.shape), CLOUD.colors * 0 + 0.5)
    return GaussianSplats(cloud, 1.0, settings, generator, "cpu")


@pytest.fixture(scope="module")
def views():
    opaque = GaussianSettings(sh_degree=0, points=InitialPoints(opacity=0.9))
    truth = GaussianSplats(CLOUD, 1.0, opaque, np.random.default_rng(0), "cpu").render(CAMERAS)
    return named_views(CAMERAS, tuple(np.round(image * 255).astype(np.uint8) for image in truth.rgb))


def psnr(representation, views):
    difference = representation.render(views.cameras).rgb - np.stack(views.images) / 255
    return -10 * np.log10(np.mean(difference**2))


def same(first, second):
    return all(torch.equal(first.parameters[name], second.parameters[name]) for name in first.parameters)


def test_fit_raises_psnr(views):
    representation = splats()
    before = psnr(representation, views)
    representation.fit(views, 200)
    assert representation.iteration == 200
    assert psnr(representation, views) > before + 4


def test_same_seed_same_bits_and_other_seed_other_bits(views):
    first, second = splats(), splats()
    first.fit(views, 60)
    state = torch.random.get_rng_state()
    second.fit(views, 60)
    assert same(first, second)
    assert torch.equal(torch.random.get_rng_state(), state), "the caller's generator was touched"
    other = GaussianSplats(PointCloud(CLOUD.positions, CLOUD.colors), 1.0, SETTINGS, np.random.default_rng(9), "cpu")
    other.fit(views, 5)
    again = GaussianSplats(PointCloud(CLOUD.positions, CLOUD.colors), 1.0, SETTINGS, np.random.default_rng(8), "cpu")
    again.fit(views, 5)
    assert not same(other, again)


def test_a_resumed_run_has_the_same_bits(views, tmp_path):
    """The interruption lies between two densification steps and inside a round of the views."""
    straight, interrupted, resumed = splats(), splats(), splats(seed=5)
    straight.fit(views, 100)
    interrupted.fit(views, 50)
    interrupted.save(tmp_path / "half.safetensors")
    resumed.load(tmp_path / "half.safetensors")
    assert same(resumed, interrupted)
    resumed.fit(views, 50)
    assert same(resumed, straight)
    resumed.save(tmp_path / "resumed.safetensors")
    straight.save(tmp_path / "straight.safetensors")
    assert (tmp_path / "resumed.safetensors").read_bytes() == (tmp_path / "straight.safetensors").read_bytes()


def test_changes_wait_for_the_next_step(views):
    """A view that is chosen after a step sees neither freshly split Gaussians nor opacities just reset."""
    representation = splats(
        SETTINGS.model_copy(update={"densification": DENSIFICATION.model_copy(update={"start": 60})})
    )
    representation.fit(views, 70)
    before = representation.parameters["opacities"].detach().sigmoid().max()
    assert before > 0.05
    representation.fit(views, 1)
    assert representation.parameters["opacities"].detach().sigmoid().max() < 0.02
    representation.fit(views, 9)
    assert representation.primitives == 50
    representation.fit(views, 1)
    assert representation.primitives != 50


def test_a_wrong_checkpoint_is_refused(views, tmp_path):
    path = tmp_path / "splats.safetensors"
    with pytest.raises(UserError, match=r"splats\.safetensors: no such file"):
        splats().load(path)
    splats().save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[:-50])
    with pytest.raises(UserError, match="not a readable safetensors file"):
        splats().load(path)
    path.write_bytes(whole)
    with pytest.raises(UserError, match="other settings"):
        splats(SETTINGS.model_copy(update={"iterations": 99})).load(path)
    from safetensors.torch import save_file

    save_file({"x": torch.zeros(2)}, path)
    with pytest.raises(UserError, match="its header has no entry state"):
        splats().load(path)


def test_new_views_enter_at_once(views):
    seen = []
    representation = splats()
    original = representation._step
    representation._step = lambda target, camera: (seen.append(float(camera.centers[0, 0])), original(target, camera))
    four = named_views(views.cameras[:4], views.images[:4])
    representation.fit(four, 6)
    assert set(seen[:4]) == set(views.cameras.centers[:4, 0])
    representation.fit(views, 6)
    assert set(seen[6:]) == set(views.cameras.centers[:, 0])


def test_views_of_mixed_sizes(views):
    small = ring(6, size=(20, 30))[:2]
    images = tuple(np.full((30, 20, 3), 128, dtype=np.uint8) for _ in range(2))
    mixed = views.extended(Views(small, images, ("small_0.png", "small_1.png")))
    representation = splats()
    representation.fit(mixed, 10)
    assert representation.iteration == 10


def test_the_degree_of_the_harmonics_follows_its_schedule(views):
    representation = splats()
    degrees = []
    for _ in range(3):
        representation.fit(views, 39)
        degrees.append(representation.sh_degree)
        high = representation.parameters["sh"][:, (representation.sh_degree + 1) ** 2 :]
        assert not bool(high.any())
    assert degrees == [0, 1, 2]
    assert bool(representation.parameters["sh"][:, 4:].any())


def test_rendering_has_shapes_and_ranges(views):
    representation = splats()
    representation.fit(views, 5)
    rendering = representation.render(CAMERAS)
    assert rendering.rgb.shape == (6, 24, 32, 3)
    assert rendering.depth.shape == rendering.alpha.shape == (6, 24, 32)
    for values in (rendering.rgb, rendering.depth, rendering.alpha):
        assert values.dtype == np.float32
    assert rendering.rgb.min() >= 0
    assert rendering.rgb.max() <= 1
    seen = rendering.alpha > 0.5
    assert seen.any()
    assert 0.5 < rendering.depth[seen].min() <= rendering.depth[seen].max() < 7
    assert (rendering.depth[rendering.alpha == 0] == 0).all()
    one = representation.render(CAMERAS[3])
    np.testing.assert_array_equal(one.rgb[0], rendering.rgb[3])


def test_cameras_of_several_sizes_are_not_rendered_together():
    sizes = CAMERAS.sizes.copy()
    sizes[2] = (20, 30)
    with pytest.raises(ValueError, match="one image size"):
        splats().render(Cameras(CAMERAS.world_to_camera, CAMERAS.intrinsics, sizes))


def test_the_background_shows_where_nothing_is():
    settings = GaussianSettings(background=(0.2, 0.4, 0.6))
    cloud = PointCloud(CLOUD.positions * 0.01, CLOUD.colors)
    rendering = GaussianSplats(cloud, 1.0, settings, np.random.default_rng(0), "cpu").render(CAMERAS)
    np.testing.assert_allclose(rendering.rgb[0, 0, 0], [0.2, 0.4, 0.6], atol=1e-6)


def test_parameters_that_are_not_finite_stop_the_fit(views):
    representation = splats()
    with torch.no_grad():
        representation.parameters["means"][0, 0] = float("nan")
    with pytest.raises(UserError, match="means stopped being finite"):
        representation.fit(views, 1)


def test_build_takes_the_points_of_the_scene(tmp_path):
    scene = small_scene(tmp_path / "toy")
    captured = np.array([5, 6, 7])
    settings = GaussianSettings(points=InitialPoints(choice="selected"))
    assert build(scene, captured, settings, 0, "cpu").primitives == 5
    settings = GaussianSettings(points=InitialPoints(random_count=30))
    first, second = (build(scene, captured, settings, seed, "cpu") for seed in (0, 1))
    assert first.primitives == 30
    assert not same(first, second)
    with pytest.raises(UserError, match="choose cpu or cuda"):
        build(scene, captured, settings, 0, "tpu")
    if not torch.cuda.is_available():
        with pytest.raises(UserError, match="not available"):
            build(scene, captured, settings, 0, "cuda")


def test_a_photograph_is_converted_once_under_its_name(views, monkeypatch):
    converted = []

    def prepare(image, device):
        converted.append(image)
        return prepare_target(image, device)

    monkeypatch.setattr("avs.representations.gaussians.splats.prepare_target", prepare)
    representation = splats()
    representation.fit(views[[0, 1]], 1)
    read_again = Views(views.cameras, tuple(image.copy() for image in views.images), views.names)
    representation.fit(read_again[[0, 1, 2]], 1)
    assert [image is view for image, view in zip(converted, views.images, strict=False)] == [True, True, False]
    assert len(converted) == 3
