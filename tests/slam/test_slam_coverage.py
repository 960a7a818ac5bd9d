"""Coverage of rooms whose visible surface is known, and the quality of renderings."""

import math

import numpy as np
import pytest
from building_factory import box_faces, building, quad, room, textured
from tolerances import SLAM_AREA_SHARE

from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.simulator import Simulator
from avs.slam.evaluation.evaluation_settings import EvaluationSettings
from avs.slam.evaluation.map_quality import coverage_of, fused_cloud, map_quality
from avs.slam.evaluation.seen_surface import SeenSurface, surface_samples, visible_from_floor
from avs.slam.evaluation.top_view import CELL, top_view
from avs.slam.mapping.gaussian_map import empty_map
from avs.slam.mapping.mapper import Mapper
from avs.slam.mapping.mapper_settings import KeyframeSettings, MapperSettings
from avs.slam.navigation.agent_settings import AgentSettings
from avs.slam.navigation.floor_map import find_floor

CAMERA = CameraSettings(width=96, height=72)
SETTINGS = EvaluationSettings()


def visible(mesh, count=20_000, camera=CAMERA):
    simulator = Simulator(mesh)
    floor_map = find_floor(simulator.caster, mesh.box, AgentSettings(), "mesh")
    points = surface_samples(simulator, count, np.random.default_rng(0))
    return simulator, points, visible_from_floor(simulator, floor_map, floor_map.islands == 0, camera, points, 0.5)


def test_samples_are_uniform_over_the_area():
    mesh = room()
    points = surface_samples(Simulator(mesh), 40_000, np.random.default_rng(0))
    total = 2 * (4 * 3 + 4 * 2.5 + 3 * 2.5)
    on_floor = np.abs(points[:, 2]) < 1e-6
    assert on_floor.mean() == pytest.approx(12 / total, abs=SLAM_AREA_SHARE)
    assert (points[on_floor, 0] < 1).mean() == pytest.approx(0.25, abs=2 * SLAM_AREA_SHARE)


def test_all_of_an_empty_room_can_be_seen():
    _, _, seen = visible(room())
    assert seen.mean() > 0.995


def test_a_closed_box_is_seen_from_outside_alone():
    # a thing with double walls: of the inner box, of area 6 x 0.8^2, nothing can be seen
    low, high = np.array([2.0, 1.0, 0.1]), np.array([3.0, 2.0, 1.1])
    faces = box_faces((0, 0, 0), (4, 3, 2.5)) + box_faces(low, high) + box_faces(low + 0.1, high - 0.1)
    _, points, seen = visible(building(faces))
    inside = ((points > low + 0.05) & (points < high - 0.05)).all(axis=1)
    assert inside.sum() > 500
    assert not seen[inside].any()
    outside = ((points > low - 1e-3) & (points < high + 1e-3)).all(axis=1) & ~inside
    assert seen[outside & (points[:, 2] > 0.6)].mean() > 0.98


def test_a_room_without_a_door_cannot_be_seen():
    second = box_faces((5, 0, 0), (7, 2, 2.5))
    _, points, seen = visible(building(box_faces((0, 0, 0), (4, 3, 2.5)) + second))
    assert not seen[points[:, 0] > 4.5].any()
    assert seen[points[:, 0] < 4.01].mean() > 0.99


def test_what_the_field_of_view_never_reaches_does_not_count():
    low = CameraSettings(width=96, height=24)
    _, points, seen = visible(room(), camera=low)
    # straight ahead rays rise by a quarter of their length
    assert points[seen, 2].max() < 1.25 + 0.25 * math.hypot(3.8, 2.8)
    assert not seen[(points[:, 2] > 2.49)].any()


def test_a_look_sees_what_is_in_front_and_not_what_is_behind():
    simulator, points, seen = visible(room(things=[((2.0, 1.2, 0.0), (2.2, 1.8, 2.5))]))
    surface = SeenSurface(points[seen], simulator, 0.05)
    camera = camera_at(Pose(1.0, 1.5, 0.0, 0.0), CAMERA)
    expected = surface.new_from(camera)
    surface.look(camera, simulator.depth(camera))
    assert surface.seen.sum() == expected > 0
    assert surface.new_from(camera) == 0
    shown = surface.points[surface.seen]
    assert (shown[:, 0] > 1.0).all()
    hidden = (np.abs(surface.points[:, 1] - 1.5) < 0.2) & (surface.points[:, 0] > 3.9)
    assert not surface.seen[hidden].any()
    assert surface.share == pytest.approx(expected / len(surface.points))


def test_coverage_is_a_share_within_five_centimetres():
    points = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)], float)
    cloud = np.array([(0, 0, 0.049), (1, 0, 0.0501), (2.01, 0, 0)])
    assert coverage_of(points, cloud, 0.05) == 0.5
    assert coverage_of(points, np.zeros((0, 3)), 0.05) == 0.0
    # units: the same in millimetres
    assert coverage_of(points * 1000, cloud * 1000, 50) == 0.5


def test_an_empty_map_covers_nothing_and_renders_black():
    simulator = Simulator(room())
    pose = Pose(1.0, 1.5, 0.0, 0.0)
    quality = map_quality(empty_map(), simulator, [pose], CAMERA, SETTINGS)
    truth = simulator.observe(camera_at(pose, CAMERA))
    assert quality.depth_mae == pytest.approx(truth.depth.mean(), rel=1e-5)
    assert quality.empty == 1.0
    assert len(fused_cloud(empty_map(), [camera_at(pose, CAMERA)], SETTINGS)) == 0


def test_a_map_of_half_a_room_covers_what_it_has_seen():
    simulator, points, seen = visible(textured(room()))
    mapper = Mapper(MapperSettings(keyframes=KeyframeSettings(every=1), iterations=20), 0)
    surface, cameras = SeenSurface(points[seen], simulator, 0.05), []
    for k in range(5):
        cameras.append(camera_at(Pose(2.0, 1.5, 0.0, -0.4 + 0.2 * k), CAMERA))
        frame = simulator.observe(cameras[-1])
        mapper.add(frame, cameras[-1])
        surface.look(cameras[-1], frame.depth)
    by_means = coverage_of(surface.points, mapper.tensors["means"].detach().numpy(), 0.05)
    by_depth = coverage_of(surface.points, fused_cloud(mapper.tensors, cameras, SETTINGS), 0.05)
    assert 0.2 < surface.share < 0.6
    assert by_depth == pytest.approx(surface.share, abs=0.05)
    assert by_means == pytest.approx(by_depth, abs=0.05)
    poses = [Pose(2.0, 1.5, 0.0, 0.05)]
    good = map_quality(mapper.tensors, simulator, poses, CAMERA, SETTINGS)
    assert good.psnr > 23
    assert good.depth_mae < 0.1
    bad = map_quality(mapper.tensors, simulator, [Pose(2.0, 1.5, 0.0, math.pi)], CAMERA, SETTINGS)
    assert bad.empty > 0.9


def test_both_sides_of_a_thin_wall_count():
    wall = quad((2, 0, 0), (2, 2, 0), (2, 2, 2.5), (2, 0, 2.5))
    _, points, seen = visible(building([*box_faces((0, 0, 0), (4, 3, 2.5)), wall]))
    on_wall = (np.abs(points[:, 0] - 2) < 1e-4) & (points[:, 1] < 1.99)
    assert seen[on_wall].mean() > 0.98


def test_the_view_from_above_shows_the_floor_and_what_stands_on_it():
    colors = np.full((12, 3), 0.2)
    colors[7] = (0.8, 0.4, 0.0)  # the top of the table
    faces = box_faces((0, 0, 0), (4, 3, 2.5)) + box_faces((1, 1, 0), (2, 2, 0.8))
    mesh = building(faces, colors)
    simulator = Simulator(mesh)
    above = top_view(simulator, surface_samples(simulator, 2000, np.random.default_rng(0)), 0.0)

    def at(x, y):
        return above.rgb[tuple(((np.array([x, y]) - above.origin) / CELL).astype(int))].tolist()

    assert at(1.5, 1.5) == [204, 102, 0]
    assert at(3.0, 1.5) == [51, 51, 51]
    assert at(-0.1, 1.5) == [255, 255, 255]
