"""The explorations of a configuration: what each job reads, and what is refused."""

from pathlib import Path

import pytest
import yaml

from avs.config.configuration import load
from avs.config.jobs import settings_of
from avs.config.slam_jobs import explored
from avs.system.errors import UserError
from avs.system.models import laid_over

ROOT = Path(__file__).resolve().parents[2]
BASE = {"scale": "test", "seeds": [0], "methods": ["random"]}
SLAM = {
    "buildings": {
        "flat": {"source": "apartment", "seed": 3},
        "own": {"source": "mesh", "file": "a.glb", "start": [0, 0, 0, 90]},
    },
    "methods": {"nearest": {"kind": "nearest"}, "fvs": {"kind": "selector", "method": "farthest"}},
    "robot": {"exploration": {"steps": 100}},
}


def scale(name):
    return yaml.safe_load((ROOT / "workflows" / "config" / f"{name}.yaml").read_text())


def test_each_job_reads_its_own():
    config = load(BASE | {"slam": SLAM})
    one = settings_of(config, "exploration/own/fvs")
    assert (one.start, one.scorer.method, one.exploration.steps) == ((0, 0, 0, 90), "farthest", 100)
    assert settings_of(config, "exploration/flat/nearest").start is None
    assert settings_of(config, "building/flat").building.seed == 3
    assert settings_of(config, "slam_figure").methods == ("nearest", "fvs")


def test_a_building_that_cannot_be_read_keeps_no_other_from_being_explored(tmp_path):
    (tmp_path / "cut.glb").write_bytes(b"glT")
    slam = SLAM | {"buildings": SLAM["buildings"] | {"cut": {"source": "mesh", "file": str(tmp_path / "cut.glb")}}}
    config = load(BASE | {"slam": slam})
    told = settings_of(config, "slam_figure")
    assert told.buildings == ("flat", "own", "cut")
    assert told.explored == ("flat",)
    assert "a.glb: is no file" in told.absent_buildings["own"].cause
    assert "cut.glb: is no readable glTF file" in told.absent_buildings["cut"].cause
    assert settings_of(config, "page").explorations == {"flat": (("nearest", 0), ("fvs", 0))}
    alone = load(BASE | {"slam": SLAM | {"buildings": {"own": SLAM["buildings"]["own"]}}})
    assert explored(alone) == settings_of(alone, "page").explorations == {}


def test_without_explorations_their_jobs_are_unknown():
    for job in ("exploration/flat/nearest", "building/flat", "slam_figure"):
        with pytest.raises(LookupError):
            settings_of(load(BASE), job)


def test_the_defaults_are_the_released_constants():
    robot = load(
        BASE | {"slam": {"buildings": {"flat": {"source": "apartment"}}, "methods": {"n": {"kind": "fisherrf"}}}}
    )
    told = settings_of(robot, "exploration/flat/n")
    assert (told.exploration.steps, told.exploration.turns, told.motion.forward, told.motion.turn) == (
        2000,
        72,
        0.05,
        5,
    )
    assert (told.mapper.map_every, told.mapper.keyframes.every, told.mapper.keyframes.window) == (10, 4, 32)
    assert (told.exploration.occupancy.cells, told.exploration.frontiers.candidates) == (768, 256)
    assert (told.scorer.endpoint_regularisation, told.scorer.endpoint_weight, told.scorer.gradient) == (0.1, 30, 1e-3)
    assert (told.evaluation.threshold, told.evaluation.poses, told.camera.width) == (0.05, 1000, 800)


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"methods": {"x": {"kind": "nonsense"}}}, "kind"),
        ({"methods": {"Bad Name": {"kind": "nearest"}}}, "Bad Name"),
        ({"methods": {"-x": {"kind": "nearest"}}}, "-x"),
        ({"robot": {"exploration": {"stepz": 3}}}, "stepz"),
        ({"robot": {"camera": {"above_floor": 1.8}}}, "higher than agent.height"),
        ({"robot": {"exploration": {"occupancy": {"low": 2}}}}, "nothing is an obstacle"),
        ({"seeds": [0, 0]}, "twice"),
        ({"methods": {"x": {"kind": "selector", "method": "farthes"}}}, "did you mean farthest"),
        ({"methods": {"x": {"kind": "selector", "method": "activenerf"}}}, "learned_variance"),
        ({"methods": {"x": {"kind": "selector", "method": "oracle-ssim"}}}, "hidden photographs"),
        ({"methods": {"x": {"kind": "selector", "method": "activenerf-views"}}}, "another method's views"),
        ({"methods": {"x": {"kind": "selector", "method": "statistics"}}}, "measures in metres"),
        ({"methods": {"x": {"kind": "selector", "method": "random", "settings": {"reshufle": True}}}}, "reshufle"),
        ({"robot": {"motion": {"turn": 180}}}, "turn"),
    ],
)
def test_faults_are_named(change, fault):
    with pytest.raises(UserError, match=fault):
        load(BASE | {"slam": SLAM | change})


def test_a_method_whose_weights_are_not_here_is_told_of():
    methods = {
        "niqa": {"kind": "selector", "method": "musiq"},
        "ours": {"kind": "selector", "method": "ours-repvit"},
        "nearest": {"kind": "nearest"},
    }
    config = load(BASE | {"slam": SLAM | {"methods": methods}})
    told = settings_of(config, "slam_figure")
    if "niqa" in told.absent:  # the weights may be at hand
        assert "weights" in str(told.absent["niqa"]) or "pyiqa" in str(told.absent["niqa"])
    assert "does not train" in told.absent["ours"].cause
    assert "nearest" not in told.absent


@pytest.mark.parametrize(
    "path", sorted((ROOT / "workflows/config/buildings").glob("*.yaml")), ids=lambda path: path.stem
)
def test_the_lists_of_buildings_fit_the_papers_scale(path):
    config = load(laid_over(scale("paper"), yaml.safe_load(path.read_text())))
    told = settings_of(config, "slam_figure")
    assert len(told.buildings) >= 5
    assert told.seeds == (0, 1, 2)
    assert config.slam.with_tables


def test_small_explores_for_long_but_not_with_the_other_tables():
    slam = load(scale("small")).slam
    assert (slam.with_tables, slam.robot.exploration.steps, list(slam.buildings)) == (False, 2000, ["flat"])
    assert load(scale("paper")).slam.buildings == {}
