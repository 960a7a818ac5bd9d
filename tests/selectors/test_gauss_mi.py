"""GauSS-MI against its formulas in plain loops, with the weights of the slow renderer."""

import math

import numpy as np
import pytest
from factories import MeanColor, named_views, ring, selected, state_of
from tolerances import FLOAT64_GEOMETRY, GAUSS_MI

from avs.scene.cameras import Cameras
from avs.selection.contract import Resources
from avs.selectors.gauss_mi import GaussMiSelector, GaussMiSettings, direction_weights, horizontal_axes
from avs.system.errors import UserError
from tests.rasterizer.blending_twin import splats, weights

CAMERAS = ring(9, size=(13, 9))
CAPTURED = 3
IMAGES = tuple(np.random.default_rng(5).integers(0, 256, (9, 13, 3), dtype=np.uint8) for _ in range(CAPTURED))


def select(representation, k=1, **settings):
    state = state_of(
        representation, named_views(CAMERAS[:CAPTURED], IMAGES), CAMERAS[CAPTURED:], np.random.default_rng(0), 0
    )
    return selected("gauss-mi", GaussMiSelector(GaussMiSettings(**settings), Resources()), state, k)


def along(centre, camera):
    """Return the four parts of a viewing direction; the ring's cameras stand upright along z."""
    ray = centre - camera.centers[0]
    x, y, _ = ray / np.linalg.norm(ray)
    return [x if x >= 0 else 0, y if y >= 0 else 0, -x if x < 0 else 0, -y if y < 0 else 0]


def twin(representation, limit, least_pixels):
    centres = representation.parameters["means"].detach().double().numpy()
    odds = [[0.0] * 4 for _ in centres]
    for view in range(CAPTURED):
        camera = CAMERAS[view]
        weight, before = weights(representation, camera)
        rendered = representation.render(camera).rgb[0].astype(np.float64).reshape(-1, 3)
        loss = np.abs(rendered - IMAGES[view].reshape(-1, 3) / 255).mean(axis=1)
        for g, centre in enumerate(centres):
            pixels = [p for p in range(len(loss)) if weight[p, g] > 0 and before[p, g] > limit]
            if len(pixels) < least_pixels:
                continue
            evidence = sum(weight[p, g] * -math.log(max(1.7 * loss[p], 1e-4)) for p in pixels)
            for d, share in enumerate(along(centre, camera)):
                step = min(max(10 * share * evidence, -10), 10)
                probability = 1 - 1 / (1 + math.exp(odds[g][d] + step))
                probability = min(max(probability, 1e-4), 0.9999)
                odds[g][d] = math.log(probability / (1 - probability))
    scores = []
    for row in range(CAPTURED, len(CAMERAS)):
        total = weights(representation, CAMERAS[row])[0].sum(axis=0)
        scores.append(0.0)
        for g, centre in enumerate(centres):
            shares = along(centre, CAMERAS[row])
            scores[-1] += total[g] * sum(s * math.log(1 + math.exp(-o)) for s, o in zip(shares, odds[g], strict=True))
    return np.array(scores)


@pytest.mark.parametrize(("limit", "least_pixels"), [(0.8, 5), (0.3, 1)])
def test_scores(limit, least_pixels):
    representation = splats()
    selection = select(representation, k=6, least_transmittance=limit, least_pixels=least_pixels)
    scores = twin(representation, limit, least_pixels)
    np.testing.assert_allclose(selection.scores, scores, rtol=GAUSS_MI)
    assert selection.indices.tolist() == np.argsort(-scores).tolist()


def test_unjudged_gaussians_keep_even_odds():
    """Then a score is log 2 times the horizontal parts of the viewing directions, blended."""
    representation = splats()
    selection = select(representation, least_pixels=10**6)
    centres = representation.centres.astype(np.float64)
    for row, score in enumerate(selection.scores):
        camera = CAMERAS[CAPTURED + row]
        shares = np.array([sum(along(centre, camera)) for centre in centres])
        expected = (weights(representation, camera)[0] @ shares).sum() * math.log(2)
        assert score == pytest.approx(expected, rel=GAUSS_MI)


def test_directions_follow_the_cameras_when_the_world_is_turned():
    np.testing.assert_allclose(horizontal_axes(CAMERAS), [[1, 0, 0], [0, 1, 0]], atol=1e-12)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    transform = np.eye(4)
    transform[:3, :3] = turn.T
    turned = Cameras(CAMERAS.world_to_camera @ transform, CAMERAS.intrinsics, CAMERAS.sizes)
    axes = horizontal_axes(turned)
    np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=FLOAT64_GEOMETRY)
    np.testing.assert_allclose(axes @ turn[:, 2], 0, atol=FLOAT64_GEOMETRY)
    assert np.cross(*axes) @ turn[:, 2] == pytest.approx(1)


def test_a_gaussian_at_a_camera_has_no_direction():
    camera = CAMERAS[0]
    shares = direction_weights(camera.centers.astype(np.float32), camera, np.eye(3)[:2])
    assert np.isfinite(shares).all()


def test_a_representation_without_blending_weights_is_a_clear_error():
    with pytest.raises(UserError, match="gauss-mi: needs the capability blending_weights, which MeanColor lacks"):
        select(MeanColor())
