"""What a robot knows of a floor, frontiers, candidates and paths, on rooms whose every measure is known."""

import math

import numpy as np
import pytest
from building_factory import room

from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.simulator import Simulator
from avs.slam.exploration.exploration_settings import FrontierSettings, OccupancySettings, PathSettings
from avs.slam.exploration.frontiers import Candidate, candidates, eroded, frontiers
from avs.slam.exploration.occupancy import empty_occupancy, free_space, vote
from avs.slam.exploration.planned_paths import followed, obstacle_cost, planned_paths
from avs.slam.navigation.agent_settings import MotionSettings

CAMERA = CameraSettings(width=160, height=120)
SETTINGS = OccupancySettings(cells=160)
NO_MAP = np.zeros((0, 3), np.float32)
TABLE = ((2.5, 1.0, 0.0), (3.0, 1.6, 0.9))


def looked(simulator, pose, turns=1, settings=SETTINGS):
    """Return the grid after ``turns`` pictures, evenly over a whole turn."""
    grid = empty_occupancy(pose, settings)
    for k in range(turns):
        camera = camera_at(Pose(pose.x, pose.y, pose.floor, pose.yaw + 2 * math.pi * k / turns), CAMERA)
        vote(grid, simulator.depth(camera), camera, pose, 0.1)
    return grid


def at(grid, x, y):
    cell = tuple(grid.cell_of(x, y))
    return grid.occupied[cell], grid.free[cell]


def test_a_room_is_free_up_to_its_walls():
    pose = Pose(1.0, 1.5, 0.0, 0.0)
    grid = looked(Simulator(room()), pose, turns=12)
    free = free_space(grid, NO_MAP, pose)
    assert free.sum() * 0.05**2 == pytest.approx(4 * 3, rel=0.06)
    assert at(grid, 4.02, 1.5)[0] > 0 or at(grid, 3.98, 1.5)[0] > 0
    assert at(grid, 4.3, 1.5) == (0, 0)
    assert at(grid, 1.0, 1.5)[1] == 12  # what it stands on
    assert not frontiers(grid, free, pose, FrontierSettings())


def test_furniture_is_occupied_and_what_it_hides_unknown():
    pose = Pose(1.0, 1.3, 0.0, 0.0)
    grid = looked(Simulator(room(height=2.5, things=[((2.5, 1.0, 0.0), (3.0, 1.6, 2.5))])), pose)
    assert at(grid, 2.48, 1.3)[0] + at(grid, 2.52, 1.3)[0] > 0
    assert at(grid, 3.5, 1.3) == (0, 0)
    assert at(grid, 2.0, 1.3)[1] > 0


def test_what_is_too_high_or_too_low_is_no_obstacle():
    pose = Pose(1.0, 1.5, 0.0, 0.0)
    shelf, sill = ((2.0, 0.5, 1.6), (2.5, 2.5, 1.7)), ((2.0, 0.5, 0.0), (2.5, 2.5, 0.05))
    grid = looked(Simulator(room(things=[shelf, sill])), pose, turns=4)
    assert at(grid, 2.2, 1.5)[0] == 0
    assert at(grid, 2.2, 1.5)[1] > 0


def test_a_floor_on_another_height_is_judged_from_there():
    mesh = room()
    raised = type(mesh)(**{**vars(mesh), "vertices": mesh.vertices + np.array([0, 0, -2.5], np.float32)})
    pose = Pose(1.0, 1.5, -2.5, 0.0)
    grid = looked(Simulator(raised), pose, turns=12)
    assert free_space(grid, NO_MAP, pose).sum() * 0.05**2 == pytest.approx(12, rel=0.06)


def test_depth_beyond_the_reach_is_not_used():
    pose = Pose(1.0, 1.5, 0.0, 0.0)
    grid = looked(Simulator(room(width=12.0)), pose, settings=OccupancySettings(cells=400, reach=5.0))
    assert at(grid, 11.98, 1.5) == (0, 0)
    assert np.flatnonzero(grid.free.any(axis=1)).max() < grid.cell_of(6.1, 0)[0]


def test_cells_full_of_gaussians_and_cells_that_were_bumped_into_are_not_free():
    pose = Pose(1.0, 1.5, 0.0, 0.0)
    grid = looked(Simulator(room()), pose, turns=12)
    crowd = np.tile(np.array([[2.02, 1.52, 0.5]], np.float32), (26, 1))
    cell = tuple(grid.cell_of(2.02, 1.52))
    assert free_space(grid, NO_MAP, pose)[cell]
    assert not free_space(grid, crowd, pose)[cell]
    assert free_space(grid, crowd[:25], pose)[cell]
    assert free_space(grid, crowd + np.array([0, 0, 2], np.float32), pose)[cell]
    grid.blocked[cell] = True
    assert not free_space(grid, NO_MAP, pose)[cell]


def test_frontiers_lie_where_the_floor_goes_on():
    pose = Pose(1.0, 1.5, 0.0, 0.0)
    grid = looked(Simulator(room()), pose)
    free = free_space(grid, NO_MAP, pose)
    found = frontiers(grid, free, pose, FrontierSettings())
    # one picture of 90 degrees: a border with the unknown on either side, and around what the robot stands on
    assert sum(len(one.cells) for one in found) > 80
    assert found[0].merit >= found[-1].merit
    for one in found:
        assert grid.unknown[one.cells[:, 0], one.cells[:, 1]].all()
        assert len(one.cells) > 10
    assert not frontiers(grid, free, pose, FrontierSettings(least=100_000))


def test_candidates_look_at_the_frontier_from_an_annulus():
    pose = Pose(1.0, 1.5, 0.0, 0.0)
    grid = looked(Simulator(room()), pose)
    free = free_space(grid, NO_MAP, pose)
    inner = eroded(free, 4)
    found = frontiers(grid, free, pose, FrontierSettings())
    drawn = candidates(grid, inner, found, pose, FrontierSettings(considered=2), np.random.default_rng(0))
    assert 0 < len(drawn) <= 256
    assert {each.frontier for each in drawn} <= {0, 1}
    for each in drawn:
        offset = found[each.frontier].centroid - (each.pose.x, each.pose.y)
        assert inner[tuple(grid.cell_of(each.pose.x, each.pose.y))]
        assert np.linalg.norm(offset) < 1.0 * 1.5**4 + 1e-9
        assert math.remainder(each.pose.yaw - math.atan2(offset[1], offset[0]), 2 * math.pi) == pytest.approx(
            0, abs=1e-9
        )


def test_without_frontiers_candidates_are_anywhere_and_without_floor_nowhere():
    pose = Pose(1.0, 1.5, 0.0, 0.0)
    grid = looked(Simulator(room()), pose, turns=12)
    inner = eroded(free_space(grid, NO_MAP, pose), 4)
    drawn = candidates(grid, inner, [], pose, FrontierSettings(), np.random.default_rng(0))
    assert len(drawn) == 256
    assert {each.frontier for each in drawn} == {-1}
    assert np.std([each.pose.x for each in drawn]) > 0.7
    assert candidates(grid, np.zeros_like(inner), [], pose, FrontierSettings(), np.random.default_rng(0)) == []


def test_following_corners_ends_at_them():
    pose = Pose(0.0, 0.0, 0.0, 0.0)
    corners = np.array([(1.0, 0.3), (1.0, 1.5), (-0.4, 1.2)])
    actions, poses = followed(pose, corners, 0.3, MotionSettings())
    assert len(actions) == len(poses)
    assert math.hypot(poses[-1].x + 0.4, poses[-1].y - 1.2) <= 0.05
    assert abs(poses[-1].yaw - 0.3) <= math.radians(2.5) + 1e-9
    walked = actions.count("forward") * 0.05
    assert walked == pytest.approx(math.hypot(1, 0.3) + 1.2 + math.hypot(1.4, 0.3), rel=0.05)
    for corner in corners:
        assert min(math.hypot(each.x - corner[0], each.y - corner[1]) for each in poses) < 0.06


def test_paths_lead_around_furniture_up_to_the_horizon():
    pose = Pose(1.0, 1.3, 0.0, 0.0)
    simulator = Simulator(room(things=[TABLE]))
    grid = looked(simulator, pose, turns=12)
    other = looked(simulator, Pose(3.5, 0.5, 0.0, 0.0), turns=12)
    behind = empty_occupancy(pose, SETTINGS)
    for source in (Pose(3.5, 0.5, 0, 0), Pose(3.5, 2.5, 0, 0)):
        for k in range(12):
            camera = camera_at(Pose(source.x, source.y, 0.0, k * math.pi / 6), CAMERA)
            vote(grid, simulator.depth(camera), camera, source, 0.1)
    assert other.free.any()
    assert not behind.free.any()
    free = free_space(grid, NO_MAP, pose)
    inner = eroded(free, 5)
    goal = Candidate(Pose(3.5, 1.3, 0.0, 1.0), 0)
    long = PathSettings(horizon=500)
    (path,) = planned_paths(grid, free, inner, pose, [(7, goal)], long, MotionSettings())
    assert path.candidate == 7
    assert path.length > 2.6
    assert math.hypot(path.poses[-1].x - 3.5, path.poses[-1].y - 1.3) < 0.06
    cells = [tuple(grid.cell_of(each.x, each.y)) for each in path.poses]
    assert all(free[cell] for cell in cells)
    (short,) = planned_paths(grid, free, inner, pose, [(7, goal)], PathSettings(horizon=30), MotionSettings())
    assert len(short.actions) == 30
    assert short.actions == path.actions[:30]
    assert short.length == path.length


def test_unreachable_and_repeated_candidates_give_no_path():
    pose = Pose(1.0, 1.5, 0.0, 0.0)
    grid = looked(Simulator(room()), pose, turns=12)
    free = free_space(grid, NO_MAP, pose)
    goal = Pose(2.0, 1.5, 0.0, 0.0)
    wanted = [
        (0, Candidate(goal, 0)),
        (1, Candidate(goal, 1)),
        (2, Candidate(Pose(3.9, 5.0, 0.0, 0.0), 0)),
        (3, Candidate(pose, 0)),
    ]
    found = planned_paths(grid, free, eroded(free, 4), pose, wanted, PathSettings(), MotionSettings())
    assert [path.candidate for path in found] == [0]


def test_cells_at_obstacles_cost_more():
    free = np.zeros((20, 20), bool)
    free[1:-1, 1:-1] = True
    cost = obstacle_cost(free, 0.05, PathSettings())
    assert cost[10, 10] == 0
    assert cost[1, 10] == pytest.approx(3 * (1 - 0.05 / 0.3))
    assert not obstacle_cost(free, 0.05, PathSettings(clearance=0)).any()
