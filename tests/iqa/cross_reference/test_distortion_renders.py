from itertools import pairwise

import numpy as np
import pytest
from factories import MeanColor, small_scene

from avs.iqa.cross_reference.distortion_renders import collect
from avs.iqa.cross_reference.distortions import decoded
from avs.iqa.cross_reference.scorer_settings import RenderSettings
from avs.iqa.render_statistics.view_geometry import VIEW_GEOMETRY
from avs.system.errors import UserError
from metrics.image import ssim_map


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene(tmp_path_factory.mktemp("scene") / "toy", count=14)


def _collect(scene, seed=0, **settings):
    built = []

    def build(captured, run_seed):
        built.append((captured.tolist(), run_seed, MeanColor()))
        return built[-1][2]

    values = {"views": (4, 6, 9), "iterations": (5, 20, 40), "runs": 2, "cameras": 7, **settings}
    return collect(scene, build, RenderSettings(**values), seed, lambda _: None), built


def test_reconstruction_grows_from_moment_to_moment(scene):
    data, built = _collect(scene)
    assert [(m.run, m.iteration, len(m.captured)) for m in data.moments] == [
        (run, iteration, views) for run in range(2) for views, iteration in ((4, 5), (6, 20), (9, 40))
    ]
    for run, (captured, _, representation) in enumerate(built):
        moments = data.moments[3 * run : 3 * run + 3]
        assert captured == list(moments[0].captured)
        assert representation.fits == [(4, 5), (6, 15), (9, 20)]
        for earlier, later in pairwise(moments):
            assert later.captured[: len(earlier.captured)] == earlier.captured
    assert data.moments[0].captured != data.moments[3].captured
    assert built[0][1] != built[1][1]


def test_maps_are_those_of_the_renderings(scene):
    data, _ = _collect(scene)
    assert len(data) == 6 * 7
    assert data.moment_of == tuple(np.repeat(range(6), 7))
    captured = [image in data.moments[m].captured for image, m in zip(data.images, data.moment_of, strict=True)]
    assert 0 < sum(captured) < len(captured)
    for rendering, code, image in zip(data.renderings, data.maps, data.images, strict=True):
        expected = ssim_map(rendering, data.photographs[image]).clip(0, 1)
        np.testing.assert_allclose(decoded(code), expected, atol=1 / 32767)


def test_geometry_is_that_of_the_views_captured_so_far(scene):
    data, _ = _collect(scene)
    centers = scene.cameras.centers
    np.testing.assert_array_equal(data.centers, centers)
    for row, image, m in zip(data.geometry, data.images, data.moment_of, strict=True):
        nearest = np.linalg.norm(centers[list(data.moments[m].captured)] - centers[image], axis=1).min()
        known = dict(zip(VIEW_GEOMETRY, row, strict=True))
        assert known["distance"] == pytest.approx(nearest)
        assert known["opacity"] == 1  # MeanColor's


def test_same_seed_gives_the_same_data(scene):
    first, second, other = (_collect(scene, seed)[0] for seed in (0, 0, 1))
    assert first.moments == second.moments
    assert first.images == second.images
    assert first.moments != other.moments


def test_moments_that_leave_no_view_are_left_out(scene):
    whole, _ = _collect(scene, views=(4, 6, 13))
    fewer, _ = _collect(scene, views=(4, 6, 14))
    assert [moment.iteration for moment in whole.moments] == [5, 20, 40] * 2
    assert [moment.iteration for moment in fewer.moments] == [5, 20] * 2
    with pytest.raises(UserError, match="14 images, of which 14 are captured at the first moment"):
        _collect(scene, views=(14, 15, 16))
