"""What chooses a path: FisherRF's formulas by hand, directions of methods, aggregates, the oracle."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from building_factory import room, textured
from tolerances import SLAM_FISHER

from avs.selection import untouched
from avs.selection.contract import Method, Selection
from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.simulator import Simulator
from avs.slam.evaluation.seen_surface import SeenSurface, surface_samples
from avs.slam.exploration.frontiers import Candidate
from avs.slam.exploration.planned_paths import PlannedPath
from avs.slam.loop import clocks
from avs.slam.mapping.map_view import MapView
from avs.slam.mapping.mapper import Mapper
from avs.slam.mapping.mapper_settings import KeyframeSettings, MapperSettings
from avs.slam.scoring.fisher_path_scorer import FisherPathScorer
from avs.slam.scoring.oracle_scorer import OracleScorer
from avs.slam.scoring.path_scorer import Moment, Shortlist
from avs.slam.scoring.path_settings import FisherPathSettings, SelectorPathSettings
from avs.slam.scoring.plain_scorers import NearestScorer
from avs.slam.scoring.selector_scorer import SelectorScorer
from avs.system.errors import UserError

CAMERA = CameraSettings(width=48, height=36)
SIMULATOR = Simulator(textured(room()))
POSES = (Pose(1.0, 1.5, 0.0, 0.2), Pose(1.5, 1.0, 0.0, 1.5), Pose(2.0, 2.0, 0.0, 3.0))


@pytest.fixture(scope="module")
def moment():
    mapper = Mapper(MapperSettings(keyframes=KeyframeSettings(every=1), iterations=3), 0)
    for yaw in (0.0, 0.3, 0.6):
        camera = camera_at(Pose(1.0, 1.5, 0.0, yaw), CAMERA)
        mapper.add(SIMULATOR.observe(camera), camera)
    candidates = tuple(Candidate(pose, 0) for pose in POSES)
    rng = np.random.default_rng(0)
    return Moment(Pose(1.0, 1.5, 0.0, 0.6), candidates, mapper.tensors, mapper.keyframes, CAMERA, rng, 0)


def paths(moment):
    """Return a path of ten poses to each candidate, on a straight line."""
    found = []
    for index, candidate in enumerate(moment.candidates):
        ends = moment.pose, candidate.pose
        poses = [
            replace(ends[0], x=ends[0].x + k / 10 * (ends[1].x - ends[0].x), yaw=ends[1].yaw) for k in range(1, 11)
        ]
        found.append(PlannedPath(index, ("forward",) * 10, tuple(poses), 0.5 + index))
    return found


def information(moment, pose, frame="world"):
    """Return the information ``[n, 4]`` of a view by brute force: one backward pass for every pixel."""
    tensors, camera = moment.tensors, camera_at(pose, CAMERA)
    viewmat = torch.tensor(camera.world_to_camera[0], dtype=torch.float32)
    intrinsics = torch.tensor(camera.intrinsics[0], dtype=torch.float32)
    from avs.rasterizer.rasterization import rasterization

    means = tensors["means"].detach()
    if frame == "camera":
        means, viewmat = means @ viewmat[:3, :3].T + viewmat[:3, 3], torch.eye(4)
    means = means.clone().requires_grad_()
    opacities = tensors["opacities"].detach().sigmoid().requires_grad_()
    count = len(means)
    image, _, _ = rasterization(
        means=means,
        quats=torch.tensor([1.0, 0, 0, 0]).repeat(count, 1),
        scales=tensors["scales"].detach().exp().expand(count, 3),
        opacities=opacities,
        colors=tensors["rgb"].detach(),
        viewmats=viewmat[None],
        Ks=intrinsics[None],
        width=6,
        height=4,
    )
    total = np.zeros((count, 4))
    for value in image[0].sum(dim=-1).ravel():
        parts = torch.autograd.grad(value, (means, opacities), retain_graph=True)
        total[:, :3] += parts[0].numpy().astype(float) ** 2
        total[:, 3] += parts[1].numpy().astype(float) ** 2
    return total


@pytest.mark.parametrize("frame", ["camera", "world"])
def test_information_is_that_of_every_pixel(moment, frame):
    from avs.slam.scoring import fisher_path_scorer

    settings = FisherPathSettings(frame=frame, gradient=1.0)
    camera = camera_at(POSES[0], CAMERA)
    small = type(camera)(camera.world_to_camera, camera.intrinsics, np.array([[6, 4]]))
    found = fisher_path_scorer._of_camera(moment.tensors, small, settings)
    dense = np.zeros((len(moment.tensors["means"]), 4))
    dense[found.rows] = found.values
    twin = information(moment, POSES[0], frame)
    assert np.allclose(dense, twin, rtol=SLAM_FISHER, atol=SLAM_FISHER * twin.max())


def test_the_axes_change_the_parts_and_not_their_sum(moment):
    from avs.slam.scoring import fisher_path_scorer

    camera = camera_at(POSES[1], CAMERA)
    one, other = (
        fisher_path_scorer._of_camera(moment.tensors, camera, FisherPathSettings(frame=frame))
        for frame in ("camera", "world")
    )
    assert not np.allclose(one.values[:, 0], other.values[:, 0], rtol=0.05)
    assert np.allclose(one.values[:, :3].sum(), other.values[:, :3].sum(), rtol=1e-3)


def test_released_scores_are_their_formula(moment):
    from avs.slam.scoring import fisher_path_scorer

    settings = FisherPathSettings()

    def dense(camera):
        found = fisher_path_scorer._of_camera(moment.tensors, camera, settings)
        values = np.zeros((len(moment.tensors["means"]), 4))
        values[found.rows] = found.values
        return values

    scorer = FisherPathScorer(settings)
    listed = scorer.shortlist(moment, 2)
    known = sum(dense(keyframe.camera) for keyframe in moment.keyframes)
    endpoints = [(dense(camera_at(pose, CAMERA)) / (known + 0.1)).sum() for pose in POSES]
    assert np.allclose(listed.scores, endpoints)
    assert listed.indices.tolist() == np.argsort(endpoints)[::-1][:2].tolist()
    path = paths(moment)[1]
    along, seen = 0.0, known.copy()
    for pose in (path.poses[3], path.poses[8]):  # after the 4th and the 9th action: its counter is one ahead
        own = dense(camera_at(pose, CAMERA))
        along += math.log((own / (seen + 1e-6)).sum())
        seen += own
    expected = along / 10 + 30 * endpoints[1]
    assert scorer.score(moment, listed, paths(moment))[1] == pytest.approx(expected)
    logged = FisherPathScorer(FisherPathSettings(endpoint="logarithm"))
    assert logged.score(moment, logged.shortlist(moment, 2), paths(moment))[1] == pytest.approx(
        along / 10 + 30 * math.log(endpoints[1])
    )


def test_unseen_surface_scores_higher(moment):
    scores = FisherPathScorer(FisherPathSettings()).shortlist(moment, 3).scores
    # the last candidate looks where nothing was mapped: there is no Gaussian, and so no information at all
    assert scores[0] > scores[2]


def test_a_way_that_shows_nothing_is_worth_less_than_one_that_shows_little(moment):
    scorer, first = FisherPathScorer(FisherPathSettings()), paths(moment)[0]
    away = Pose(1.0, 1.5, 0.0, 0.6 + math.pi)  # from where all pictures were taken, with nothing of them in view
    ways = [replace(first, poses=(pose,) * len(first.poses)) for pose in (POSES[0], away)]
    scores = scorer.score(moment, scorer.shortlist(moment, 3), ways)
    assert np.isfinite(scores).all()
    assert scores[0] - scores[1] > 100


def selector(direction):
    class Brightness:
        def score(self, state):
            self.state = state
            return state.representation.render(state.candidates).rgb.mean(axis=(1, 2, 3)).astype(float)

    own = Brightness()
    return Method("Brightness", "2D-based", "-", direction, lambda settings, resources: own), own


@pytest.mark.parametrize(
    ("aggregate", "combine"), [("mean", np.mean), ("best", np.max), ("worst", np.min), ("sum", np.sum)]
)
def test_a_method_scores_the_views_of_a_path_in_its_own_direction(moment, aggregate, combine):
    rendered = MapView(moment.tensors)
    expected = []
    for path in paths(moment):
        poses = [path.poses[4], path.poses[9], moment.candidates[path.candidate].pose]
        expected.append([rendered.render(camera_at(pose, CAMERA)).rgb.mean() for pose in poses])
    for direction, sign in (("highest", 1), ("lowest", -1)):
        method, own = selector(direction)
        settings = SelectorPathSettings(method="brightness", aggregate=aggregate)
        scores = SelectorScorer(method, own, settings).score(moment, Shortlist(np.arange(3)), paths(moment))
        assert np.allclose(scores, [combine(sign * np.array(values)) for values in expected], atol=1e-6)


def test_a_method_is_shown_keyframes_as_captured_views(moment):
    method, own = selector("lowest")
    SelectorScorer(method, own, SelectorPathSettings(method="b", views="endpoint", keyframes=2)).score(
        moment, Shortlist(np.arange(3)), paths(moment)
    )
    assert own.state.captured.names == ("frame-000000", "frame-000002")
    assert len(own.state.candidates) == 3
    assert own.state.truth is None
    assert own.state.captured.images[0].dtype == np.uint8


def test_looking_whether_a_method_changed_anything_is_no_part_of_its_time(moment, monkeypatch):
    passed = [0.0]

    def taking(seconds, value=None):
        passed[0] += seconds
        return value

    monkeypatch.setattr(clocks, "time", SimpleNamespace(perf_counter=lambda: passed[0]))
    monkeypatch.setattr(untouched, "_pixels", lambda state: taking(100.0))
    method, own = selector("lowest")
    own.score = lambda state: taking(1.0, np.zeros(len(state.candidates)))
    scorer, watch = SelectorScorer(method, own, SelectorPathSettings(method="b", views="endpoint")), clocks.Clocks()
    begin = watch.now()
    with watch.of("score"):
        scorer.score(replace(moment, aside=watch.aside), Shortlist(np.arange(3)), paths(moment))
    assert (watch.seconds["score"], watch.now() - begin, passed[0]) == (1.0, 1.0, 201.0)


def test_a_map_renders_for_methods_as_for_itself(moment):
    from avs.slam.mapping.gaussian_map import map_seen

    camera = camera_at(POSES[0], CAMERA)
    rendering, seen = MapView(moment.tensors).render(camera), map_seen(moment.tensors, camera)
    assert np.allclose(rendering.rgb[0], seen.rgb.clamp(0, 1).numpy(), atol=1e-5)
    assert np.allclose(rendering.alpha[0], seen.alpha.numpy(), atol=1e-5)
    assert np.allclose(rendering.depth[0] * rendering.alpha[0], seen.depth.numpy(), atol=1e-4)


def test_the_nearest_is_the_shortest_way(moment):
    scorer = NearestScorer()
    assert scorer.score(moment, scorer.shortlist(moment, 3), paths(moment)).argmax() == 0
    assert scorer.shortlist(moment, 1).indices.tolist() == [0]


def test_the_oracle_goes_where_most_is_new(moment):
    points = surface_samples(SIMULATOR, 5000, np.random.default_rng(0))
    surface = SeenSurface(points, SIMULATOR, 0.05)
    scorer = OracleScorer(surface)
    even = [replace(path, length=1.0) for path in paths(moment)]
    before = scorer.score(moment, Shortlist(np.arange(3)), even)
    assert before.argmax() == int(np.argmax([surface.new_from(camera_at(pose, CAMERA)) for pose in POSES]))
    best = POSES[int(before.argmax())]
    surface.look(camera_at(best, CAMERA), SIMULATOR.depth(camera_at(best, CAMERA)))
    assert scorer.score(moment, Shortlist(np.arange(3)), even)[before.argmax()] == 0
    far = [replace(path, length=10.0) for path in even]
    assert np.allclose(
        scorer.score(moment, Shortlist(np.arange(3)), far) * 10, scorer.score(moment, Shortlist(np.arange(3)), even)
    )


def test_a_method_that_leaves_views_unscored_is_refused(moment):
    class Some:
        def select(self, state, k):
            scores = np.arange(len(state.names), dtype=np.float64)
            return Selection(np.array([1]), scores, scored=np.arange(len(scores)) == 1)

    method = Method("Some", "2D-based", "scores one view", "highest", lambda settings, resources: Some())
    scorer = SelectorScorer(method, Some(), SelectorPathSettings(method="some"))
    with pytest.raises(UserError, match="Some: does not score every view"):
        scorer.score(moment, Shortlist(np.arange(3)), paths(moment))
