"""A whole exploration of two small rooms: its record, its determinism, a kill and its resumption, every chooser."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from building_factory import box_faces, building, quad, textured

from avs.datasets.embedded.apartment import ply_bytes
from avs.selection.contract import Method, Resources
from avs.slam.building.robot_camera import camera_at
from avs.slam.evaluation.seen_surface import SeenSurface
from avs.slam.evaluation.trajectory_error import absolute_trajectory_error
from avs.slam.loop import exploration_run
from avs.slam.loop.exploration_checkpoint import program_of
from avs.slam.loop.exploration_loop import Exploration
from avs.slam.loop.exploration_record import CoveragePoint, ExplorationRecord
from avs.slam.loop.exploration_run import CHECKPOINT, curve_area, farthest_kept, run_exploration
from avs.slam.loop.robot_world import open_world
from avs.slam.loop.slam_settings import RobotSettings, SlamSettings
from avs.slam.mapping import mapper
from avs.slam.mapping.mapper_settings import RELEASED_MAPPING, MapperSettings
from avs.slam.scoring.path_choice import build_scorer
from avs.system.errors import UserError
from avs.system.records import read_record
from avs.system.tensor_files import read_tensors


def two_rooms():
    """Return two rooms of 3 x 3 m with a door of 1 m between them."""
    faces = box_faces((0, 0, 0), (6, 3, 2.5))
    faces += [
        quad((3, 0, 0), (3, 1, 0), (3, 1, 2.5), (3, 0, 2.5)),
        quad((3, 2, 0), (3, 3, 0), (3, 3, 2.5), (3, 2, 2.5)),
    ]
    faces += [quad((3, 1, 2), (3, 2, 2), (3, 2, 2.5), (3, 1, 2.5))]
    return textured(building(faces))


@pytest.fixture
def mesh(tmp_path):
    made = two_rooms()
    colors = np.random.default_rng(0).integers(40, 220, made.vertices.shape).astype(np.uint8)
    (tmp_path / "rooms.ply").write_bytes(ply_bytes(made.vertices, made.triangles, colors))
    return tmp_path / "rooms.ply"


SPLATAM = MapperSettings().model_dump(mode="json")


def settings(scorer=None, steps=110, **more):
    return SlamSettings.model_validate(
        {
            "simulator": {"samples": 1},
            "camera": {"width": 64, "height": 48},
            "mapper": {**SPLATAM, "map_every": 12, "iterations": 4, "keyframes": {"every": 6, "window": 4}},
            "exploration": {
                "steps": steps,
                "turns": min(72, steps - 1),
                "occupancy": {"cells": 200},
                "frontiers": {"considered": 3, "candidates": 24, "erosion": 5},
                "paths": {"shortlist": 5, "horizon": 15},
            },
            "evaluation": {"points": 2000, "poses": 4, "every": 40},
            "scorer": scorer or {"kind": "nearest"},
            "start": (1.0, 1.0, 0.0, 20.0),
            **more,
        }
    )


def run(mesh, out, scorer=None, seed=0, **more):
    run_exploration(mesh, "rooms", "method", settings(scorer, **more), seed, None, out, lambda line: None)
    return read_record(out / "exploration.json", ExplorationRecord)


def test_a_run_is_recorded_with_every_choice(mesh, tmp_path):
    record = run(mesh, tmp_path / "out")
    assert record.steps == 110
    assert record.ended == "all actions were done"
    assert record.decisions[0].step == 72
    assert sum(one.executed for one in record.decisions) == 110 - 72
    for one in record.decisions:
        scores = [path.score for path in one.paths]
        assert one.chosen == int(np.argmax(scores))
        assert len(one.candidates) == len(one.frontier_of)
        assert all(set(path.actions) <= set("FLR") and len(path.actions) <= 15 for path in one.paths)
    assert [point.step for point in record.curve] == [0, 40, 80, 110]
    assert 0 < record.final.scr_means <= 1
    assert record.final.seen >= record.curve[0].seen
    assert record.final.poses == 4
    arrays, _ = read_tensors(tmp_path / "out" / "maps.safetensors", "maps", "run again")
    assert len(arrays["trajectory"]) == 111
    assert len(arrays["surface"]) == len(arrays["distance"]) == record.surface_points
    assert (arrays["distance"] < 0.05).mean() == pytest.approx(record.final.scr_means)
    assert not (tmp_path / "out" / CHECKPOINT).exists()


def test_equal_runs_write_equal_bytes_and_another_seed_does_not(mesh, tmp_path):
    scorer = {"kind": "random"}
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        run(mesh, tmp_path / name, scorer, seed)
    first, second, third = (tmp_path / name for name in "abc")
    for file in ("exploration.json", "maps.safetensors"):
        assert (first / file).read_bytes() == (second / file).read_bytes(), file
    assert (first / "exploration.json").read_bytes() != (third / "exploration.json").read_bytes()


def test_a_killed_run_goes_on_to_the_same_bytes(mesh, tmp_path, monkeypatch):
    monkeypatch.setattr(exploration_run, "_DECISIONS_BETWEEN", 1)
    run(mesh, tmp_path / "whole", steps=120)
    decide = exploration_run.Exploration.decide_and_go
    left = [2]

    def dies(self, scorer):
        if not left[0]:
            raise KeyboardInterrupt
        left[0] -= 1
        decide(self, scorer)

    monkeypatch.setattr(exploration_run.Exploration, "decide_and_go", dies)
    with pytest.raises(KeyboardInterrupt):
        run(mesh, tmp_path / "killed", steps=120)
    assert (tmp_path / "killed" / CHECKPOINT).exists()
    monkeypatch.setattr(exploration_run.Exploration, "decide_and_go", decide)
    monkeypatch.setattr(exploration_run.Exploration, "begin", lambda self: pytest.fail("it began anew"))
    run(mesh, tmp_path / "killed", steps=120)
    for file in ("exploration.json", "maps.safetensors"):
        assert (tmp_path / "killed" / file).read_bytes() == (tmp_path / "whole" / file).read_bytes(), file


def test_a_checkpoint_of_something_else_or_a_damaged_one_is_not_gone_on_from(mesh, tmp_path, monkeypatch):
    monkeypatch.setattr(exploration_run, "_DECISIONS_BETWEEN", 1)
    decide = exploration_run.Exploration.decide_and_go
    out = tmp_path / "out"

    def dies(self, scorer):
        if self.decisions:
            raise KeyboardInterrupt
        decide(self, scorer)

    monkeypatch.setattr(exploration_run.Exploration, "decide_and_go", dies)
    with pytest.raises(KeyboardInterrupt):
        run(mesh, out)
    monkeypatch.setattr(exploration_run.Exploration, "decide_and_go", decide)
    kept = (out / CHECKPOINT).read_bytes()
    (out / CHECKPOINT).write_bytes(kept[:-100])
    assert run(mesh, out).steps == 110
    (out / CHECKPOINT).write_bytes(kept)
    assert run(mesh, out, {"kind": "random"}).label == "Random path"


@pytest.mark.parametrize(
    ("scorer", "label"),
    [
        ({"kind": "random"}, "Random path"),
        ({"kind": "oracle"}, "Greedy oracle"),
        ({"kind": "fisherrf"}, "FisherRF"),
        ({"kind": "fisherrf", "endpoint": "logarithm", "frame": "world", "keyframes": 2}, "FisherRF"),
        ({"kind": "selector", "method": "random"}, "Random"),
        ({"kind": "selector", "method": "farthest", "views": "endpoint"}, "FVS"),
        ({"kind": "selector", "method": "fisherrf", "aggregate": "best", "keyframes": 3}, "FisherRF"),
        ({"kind": "selector", "method": "warprf", "keyframes": 3}, "WarpRF"),
    ],
)
def test_every_chooser_explores(mesh, tmp_path, scorer, label):
    record = run(mesh, tmp_path / "out", scorer, steps=90)
    assert record.label == label
    assert record.decisions
    assert (record.decisions[0].endpoint_scores is not None) == (scorer["kind"] == "fisherrf")


def test_a_new_method_explores_without_a_line_of_its_own(mesh, tmp_path, monkeypatch):
    from avs.selection import registry

    class Darkest:
        def score(self, state):
            return state.representation.render(state.candidates).rgb.mean(axis=(1, 2, 3))

    own = Method("Darkest", "2D-based", "the darkest rendering", "lowest", lambda settings, resources: Darkest())
    found = registry.methods() | {"darkest": registry.Registered(own, "example")}
    monkeypatch.setattr(registry, "methods", lambda: found)
    record = run(mesh, tmp_path / "out", {"kind": "selector", "method": "darkest"}, steps=90)
    assert record.label == "Darkest"


@pytest.mark.parametrize(
    ("method", "fault"),
    [("activenerf", "learned_variance"), ("oracle-ssim", "hidden photographs"), ("nonsense", "unknown")],
)
def test_a_method_that_cannot_explore_is_one_line(mesh, tmp_path, method, fault):
    with pytest.raises(UserError, match=fault):
        run(mesh, tmp_path / "out", {"kind": "selector", "method": method})


def test_a_closed_room_is_explored_and_the_run_goes_on_anywhere(tmp_path):
    made = building(box_faces((0, 0, 0), (3, 3, 2.5)))
    (tmp_path / "room.ply").write_bytes(ply_bytes(made.vertices, made.triangles))
    record = run(tmp_path / "room.ply", tmp_path / "out", steps=150)
    assert not record.decisions[-1].frontiers
    assert set(record.decisions[-1].frontier_of) == {-1}
    assert record.final.seen > 0.6
    assert "surfaces without texture and colours are grey" in record.notes[0]


def test_a_robot_that_cannot_move_ends_with_a_note(tmp_path):
    # free space that is eroded more than it is wide leaves no place to go to
    made = building(box_faces((0, 0, 0), (1.1, 1.3, 2.5)))
    (tmp_path / "cell.ply").write_bytes(ply_bytes(made.vertices, made.triangles))
    more = {"agent": {"least_island": 0.5}, "simulator": {"samples": 1, "frame": {"up": "z"}}}
    exploration = {"steps": 110, "turns": 72, "occupancy": {"cells": 200}, "frontiers": {"erosion": 80}}
    more |= {"exploration": exploration}
    record = run(tmp_path / "cell.ply", tmp_path / "out", start=(0.5, 0.6, 0.0, 0.0), **more)
    assert record.steps < 110
    assert "no frontier is left that can be reached" in record.ended
    assert any("ended after" in note for note in record.notes)


def test_tracked_poses_have_an_error(mesh, tmp_path):
    tracking = {"iterations": 3}
    mapper = {**SPLATAM, "map_every": 12, "iterations": 4, "keyframes": {"every": 6, "window": 4}, "tracking": tracking}
    record = run(mesh, tmp_path / "out", steps=74, mapper=mapper)
    assert record.final.trajectory_error > 0


def test_an_error_of_a_trajectory_is_what_a_rigid_motion_leaves():
    rng = np.random.default_rng(0)
    truth = rng.normal(size=(50, 3))
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    assert absolute_trajectory_error(truth @ turn.T + [1, 2, 3], truth) == pytest.approx(0, abs=1e-12)
    assert absolute_trajectory_error(truth * 1.02, truth) > 0.01
    noise = rng.normal(0, 0.01, truth.shape)
    assert absolute_trajectory_error(truth + noise, truth) == pytest.approx(0.01 * np.sqrt(3), rel=0.2)


def test_the_area_under_a_curve_goes_on_after_an_early_end():
    def points(*pairs):
        return [CoveragePoint(step=x, scr_means=y, seen=0, gaussians=0, path_length=0) for x, y in pairs]

    assert curve_area(points((0, 0.0), (100, 1.0)), 100) == 0.5
    assert curve_area(points((0, 0.0), (100, 1.0)), 200) == 0.75
    assert curve_area(points((0, 0.3)), 10) == pytest.approx(0.3)


def test_records_are_canonical_and_sealed(mesh, tmp_path):
    run(mesh, tmp_path / "out", steps=74)
    path = tmp_path / "out" / "exploration.json"
    values = json.loads(path.read_text())
    values["final"]["scr_means"] = 0.99
    path.write_text(json.dumps(values))
    with pytest.raises(UserError, match="changed after it was written"):
        read_record(path, ExplorationRecord)


def test_an_exploration_is_shown_as_an_animation(mesh, tmp_path):
    from PIL import Image

    from avs.report.figures.slam_animation import write_slam_animation

    run(mesh, tmp_path / "out", steps=74)
    arguments = (tmp_path / "out" / "exploration.json", tmp_path / "out" / "maps.safetensors", mesh)
    for name in ("a.gif", "b.gif"):
        write_slam_animation(*arguments, tmp_path / name)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()
    with Image.open(tmp_path / "a.gif") as shown:
        assert shown.n_frames > 30
        assert shown.height == 180


def test_another_mesh_makes_no_animation(mesh, tmp_path):
    from avs.report.figures.slam_animation import write_slam_animation

    run(mesh, tmp_path / "out", steps=10)
    mesh.write_bytes(mesh.read_bytes() + b"\n")
    with pytest.raises(UserError, match="is not the building that"):
        write_slam_animation(*(tmp_path / "out" / name for name in ("exploration.json", "maps.safetensors")), mesh, "a")


def test_a_program_is_that_of_the_method_and_of_its_weights(tmp_path):
    def program(method, weights=None):
        return program_of(settings({"kind": "selector", "method": method}), weights)

    (tmp_path / "weights").write_bytes(b"one")
    (tmp_path / "others").write_bytes(b"two")
    told = [program("random"), program("farthest"), *(program("random", tmp_path / n) for n in ("weights", "others"))]
    assert len(set(told)) == 4


@pytest.mark.parametrize(
    ("more", "note"),
    [
        ({"occupancy": {"cells": 60}}, "of the floor lies beyond the robot's grid of 3 m around its start"),
        ({"occupancy": {"cells": 200}}, None),
    ],
)
def test_a_grid_that_is_too_small_is_told_of(mesh, more, note):
    notes = open_world(mesh, "rooms", settings(exploration=more), 0).notes
    assert any(note in one for one in notes) if note else not any("grid" in one for one in notes)


def test_a_camera_that_sees_nothing_from_the_floor_is_one_line(tmp_path):
    (tmp_path / "plane.ply").write_bytes(ply_bytes(*floor_alone()))
    told = settings(
        camera={"field_of_view": 20, "width": 64, "height": 48}, simulator={"frame": {"up": "z", "metres": 1}}
    )
    with pytest.raises(UserError, match="shows no surface to a level camera"):
        open_world(tmp_path / "plane.ply", "plane", told, 0)


def floor_alone():
    made = building([quad((0, 0, 0), (3, 0, 0), (3, 3, 0), (0, 3, 0))])
    return made.vertices, made.triangles


def test_one_setting_of_the_mapper_leaves_the_others_those_of_the_released_code():
    told = RobotSettings.model_validate({"mapper": {"growth": {"spacing": 0.04}}}).mapper
    growth = RELEASED_MAPPING.growth.model_copy(update={"spacing": 0.04})
    assert told == RELEASED_MAPPING.model_copy(update={"growth": growth})


def test_a_map_that_is_pruned_at_its_birth_is_told_of(mesh, tmp_path):
    record = run(mesh, tmp_path / "out", steps=3, camera={"width": 16, "height": 12})
    assert any("m from the camera are pruned as too large" in note for note in record.notes)
    told = settings(mapper=SPLATAM | {"pruning": {"iterations": [70]}})
    assert farthest_kept(1.0, told) == math.inf
    assert farthest_kept(1.5, settings()) == pytest.approx(0.1 * 1.5 * 32)


def test_a_tracked_robot_votes_and_plans_from_where_it_takes_itself_to_be(mesh, monkeypatch):
    def misled(tensors, frame, guess, told):
        true = camera_at(exploration.pose, exploration.settings.camera)
        shift = np.eye(4)
        shift[0, 3] = -0.5  # half a metre too far along x
        return replace(true, world_to_camera=true.world_to_camera @ shift), 0.0

    monkeypatch.setattr(mapper, "tracked", misled)
    told = settings(mapper=SPLATAM | {"map_every": 12, "iterations": 1, "tracking": {"iterations": 1}})
    world = open_world(mesh, "rooms", told, 0)
    exploration = Exploration(world, told, 0, SeenSurface(world.surface, world.simulator, 0.05))
    exploration.begin()
    assert exploration.believed.x == pytest.approx(exploration.pose.x + 0.5)
    assert exploration.believed.yaw == pytest.approx(exploration.pose.yaw)
    assert exploration.believed.floor == pytest.approx(exploration.pose.floor)
    column = exploration.grid.cell_of(0.5, 1.5)  # where it takes the wall at x = 0 to be, from the second picture on
    assert exploration.grid.occupied[column[0] - 1 : column[0] + 2, column[1]].any()
    scorer = build_scorer(told.scorer, exploration.surface, Resources(None))
    assert exploration.options(scorer)[0].pose == exploration.believed
