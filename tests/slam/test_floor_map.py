"""The floor of rooms whose every measure is known, moves on it, and paths on grids."""

import itertools
import math

import numpy as np
import pytest
from building_factory import box_faces, building, quad, room

from avs.datasets.embedded.geometry.raycast import Caster
from avs.slam.building.robot_camera import Pose
from avs.slam.navigation.agent_settings import AgentSettings, MotionSettings
from avs.slam.navigation.floor_map import find_floor
from avs.slam.navigation.grid_paths import in_sight, shortest_path, straightened, travel_costs
from avs.slam.navigation.robot_motion import move, random_poses
from avs.system.errors import UserError

AGENT = AgentSettings()
# One row of cells on each side of a floor may count or not.
CELL = AGENT.cell


def floor_of(mesh, agent=AGENT):
    return find_floor(Caster(mesh.vertices, mesh.triangles), mesh.box, agent, "mesh")


def test_the_floor_ends_a_radius_before_the_walls():
    found = floor_of(room())
    assert found.islands.max() == 0
    assert found.area(0) == pytest.approx(3.8 * 2.8, abs=2 * (3.8 + 2.8) * CELL)
    assert found.floor_at(2.0, 1.5, 0.0) == pytest.approx(0.0, abs=1e-5)
    assert found.floor_at(0.07, 1.5, 0.0) is None
    assert found.floor_at(50.0, 1.5, 0.0) is None


def test_a_mesh_with_a_stray_triangle_far_away_is_one_line():
    with pytest.raises(UserError, match="is 100000 x 3 m wide"):
        floor_of(
            building([*box_faces((0, 0, 0), (4, 3, 2.5)), quad((1e5, 0, 0), (1e5, 1, 0), (1e5, 1, 1), (1e5, 0, 1))])
        )


def test_furniture_is_left_out_and_its_top_is_no_way_on():
    found = floor_of(room(things=[((1.5, 1.0, 0.0), (2.5, 2.0, 0.8))]))
    around = 3.8 * 2.8 - (1.2 * 1.2 - (4 - math.pi) * 0.01)
    assert found.area(0) == pytest.approx(around, abs=(2 * (3.8 + 2.8) + 4.8) * CELL)
    assert found.floor_at(2.0, 1.5, 0.0) is None
    assert found.floor_at(2.0, 1.5, 0.7) == pytest.approx(0.8, abs=1e-5)
    assert found.islands[:, *found.cells(np.array([2.0, 1.5]))].max() == 1


def test_nothing_stands_below_what_is_too_low():
    shelf = [quad((1, 1, 1.4), (3, 1, 1.4), (3, 2, 1.4), (1, 2, 1.4))]
    mesh = building(box_faces((0, 0, 0), (4, 3, 2.5)) + shelf)
    assert floor_of(mesh).floor_at(2.0, 1.5, 0.0) is None
    assert floor_of(mesh, AgentSettings(height=1.3)).floor_at(2.0, 1.5, 0.0) is not None


@pytest.mark.parametrize(("height", "islands"), [(0.15, 1), (0.4, 2)])
def test_a_step_is_climbed_where_it_is_low(height, islands):
    found = floor_of(room(things=[((2.0, 0.0, 0.0), (4.0, 3.0, height))]))
    assert found.islands.max() + 1 == islands


def two_storeys():
    """Return two rooms above each other, and stairs of 12 steps in a hole between them."""
    walls = box_faces((0, 0, 0), (6, 4, 5))
    upper = [quad((0, 0, 2.4), (6, 0, 2.4), (6, 2.8, 2.4), (0, 2.8, 2.4))]
    upper += [quad((4.6, 2.8, 2.4), (6, 2.8, 2.4), (6, 4, 2.4), (4.6, 4, 2.4))]
    stairs = [
        face for k in range(12) for face in box_faces((1.6 + 0.25 * k, 2.8, 0), (1.85 + 0.25 * k, 4, 0.2 * (k + 1)))
    ]
    return building(walls + upper + stairs)


def test_two_storeys_are_one_island_by_their_stairs():
    found = floor_of(two_storeys())
    assert found.floor_at(5.0, 1.0, 0.0) == pytest.approx(0.0, abs=1e-5)
    assert found.floor_at(5.0, 1.0, 2.4) == pytest.approx(2.4, abs=1e-5)
    column, row = found.cells(np.array([5.0, 1.0]))
    assert np.count_nonzero(found.islands[:, column, row] == 0) == 2
    storey = found.storey(Pose(5.0, 1.0, 2.4, 0.0))
    assert np.nanmin(found.heights[storey]) > 1.8
    assert storey[:, column, row].sum() == 1


def test_a_robot_climbs_stairs():
    found, pose = floor_of(two_storeys()), Pose(1.0, 3.4, 0.0, 0.0)
    for _ in range(90):
        pose = move(found, pose, "forward", MotionSettings()).pose
    assert pose.floor == pytest.approx(2.4, abs=1e-4)
    assert pose.x > 4.6


def test_a_roof_is_no_floor_but_an_open_floor_is_kept():
    assert floor_of(room()).heights[~np.isnan(floor_of(room()).heights)].max() < 0.1
    opened = building([box_faces((0, 0, 0), (4, 3, 2.5))[k] for k in (0, 2, 3, 4, 5)])
    found = floor_of(opened)
    assert "no floor has a ceiling" in found.notes[0]
    assert found.floor_at(2.0, 1.5, 0.0) is not None


@pytest.mark.parametrize(
    ("pose", "fault"),
    [
        (Pose(2.0, 1.5, 0.0, 0.0), "wall, furniture or nothing|the floor there is at 0.80"),
        (Pose(9.0, 1.5, 0.0, 0.0), "wall, furniture or nothing"),
        (Pose(1.0, 0.5, 1.2, 0.0), "the floor there is at 0.00 m"),
        (Pose(2.0, 1.5, 0.8, 0.0), "lies on an island of"),
    ],
)
def test_a_start_that_is_none_is_one_line_with_another_place(pose, fault):
    found = floor_of(room(things=[((1.5, 1.0, 0.0), (2.4, 1.9, 0.8))]))
    with pytest.raises(UserError, match=fault) as caught:
        found.storey(pose)
    x, y, z = map(float, str(caught.value).rsplit("such as (", 1)[1].rstrip(")").split(","))
    assert found.storey(Pose(x, y, z, 0.0)).any()


def test_a_building_without_floor_is_refused():
    with pytest.raises(UserError, match="no floor"):
        floor_of(building(box_faces((0, 0, 0), (4, 3, 2.5))[2:]))


def test_actions_are_five_centimetres_and_five_degrees():
    found, pose = floor_of(room()), Pose(1.0, 1.0, 0.0, 0.0)
    moved = move(found, pose, "forward", MotionSettings())
    assert (moved.pose.x, moved.pose.y, moved.collided) == (pytest.approx(1.05), 1.0, False)
    assert math.degrees(move(found, pose, "left", MotionSettings()).pose.yaw) == pytest.approx(5.0)
    assert math.degrees(move(found, pose, "right", MotionSettings()).pose.yaw) == pytest.approx(-5.0)
    for _ in range(72):
        pose = move(found, pose, "left", MotionSettings()).pose
    assert pose.yaw == pytest.approx(0.0, abs=1e-9)


def test_a_wall_stops_and_an_oblique_one_is_slid_along():
    found = floor_of(room())
    pose = Pose(3.7, 1.5, 0.0, 0.0)
    for _ in range(10):
        moved = move(found, pose, "forward", MotionSettings())
        pose = moved.pose
    assert moved.collided
    assert 3.85 <= pose.x <= 3.95
    assert abs(pose.y - 1.5) < 0.2  # straight on there is little to slide along
    pose = Pose(3.7, 1.0, 0.0, math.radians(60))
    for _ in range(20):
        pose = move(found, pose, "forward", MotionSettings()).pose
    assert pose.y > 1.0 + 20 * 0.05 * math.sin(math.radians(60)) * 0.75
    assert found.floor_at(pose.x, pose.y, pose.floor) is not None


def test_a_robot_never_leaves_the_floor():
    found = floor_of(room(things=[((1.5, 1.0, 0.0), (2.5, 2.0, 0.8))]))
    rng = np.random.default_rng(0)
    pose = Pose(0.5, 0.5, 0.0, 0.3)
    for action in rng.choice(["forward", "forward", "forward", "left", "right"], 2000):
        pose = move(found, pose, str(action), MotionSettings()).pose
        assert found.floor_at(pose.x, pose.y, pose.floor) is not None


def test_random_poses_stand_on_the_floor_and_fill_it():
    found = floor_of(room())
    poses = random_poses(found, found.islands == 0, 500, np.random.default_rng(0))
    assert all(found.floor_at(pose.x, pose.y, pose.floor) is not None for pose in poses)
    x, y = np.array([(pose.x, pose.y) for pose in poses]).T
    assert np.histogram2d(x, y, 2, [[0.1, 3.9], [0.1, 2.9]])[0].min() > 90
    assert poses == random_poses(found, found.islands == 0, 500, np.random.default_rng(0))


FREE = np.zeros((12, 9), bool)
FREE[1:11, 1:8] = True
FREE[5, 1:6] = False
NOTHING = np.zeros(FREE.shape, np.float32)


def cells(*pairs):
    return [np.array(pair) for pair in pairs]


def test_a_path_goes_around_a_wall_and_no_other_is_shorter():
    start, goal = cells((2, 2), (8, 2))
    path = shortest_path(FREE, NOTHING, start, goal)
    assert FREE[path[:, 0], path[:, 1]].all()
    assert path[0].tolist() == [2, 2]
    assert path[-1].tolist() == [8, 2]
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert length == pytest.approx(travel_costs(FREE, NOTHING, start)[8, 2])
    assert length == pytest.approx(2 * math.hypot(2, 4) + 2 + 2 * (math.hypot(1, 0) - 1), abs=1.5)


def test_costs_move_a_path_aside():
    cost = NOTHING.copy()
    cost[:, 3] = 10
    path = shortest_path(np.ones(FREE.shape, bool), cost, *cells((1, 3), (10, 3)))
    assert np.count_nonzero(path[:, 1] == 3) <= 3


def test_there_is_no_path_through_a_wall_or_to_one():
    closed = FREE.copy()
    closed[5] = False
    assert shortest_path(closed, NOTHING, *cells((2, 2), (8, 2))) is None
    assert shortest_path(FREE, NOTHING, *cells((2, 2), (5, 2))) is None
    assert np.isinf(travel_costs(closed, NOTHING, np.array([2, 2]))[8, 2])
    assert shortest_path(FREE, NOTHING, *cells((2, 2), (2, 2))).tolist() == [[2, 2]]


def test_diagonals_do_not_cut_corners():
    corner = np.ones((3, 3), bool)
    corner[1, 0] = False
    assert shortest_path(corner, np.zeros((3, 3)), *cells((0, 0), (1, 1))).tolist() == [[0, 0], [0, 1], [1, 1]]


def test_a_straightened_path_keeps_only_corners_in_sight():
    path = shortest_path(FREE, NOTHING, *cells((2, 2), (8, 2)))
    corners = straightened(FREE, path)
    assert len(corners) < len(path)
    assert all(in_sight(FREE, a, b) for a, b in itertools.pairwise(corners))
    assert not in_sight(FREE, *cells((2, 2), (8, 2)))
