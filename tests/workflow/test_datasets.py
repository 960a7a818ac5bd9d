"""Several data sets in one run: each has its own scenes, episodes and tables, even where scenes are called the same."""

import csv

import pytest
import yaml
from factories import small_scene

from avs.nvs.record import Episode
from avs.scene.scene import read_scene
from avs.system.records import read_record
from tests.workflow.project import METHODS, checkout, run, tiny

QUICK = {"views": 16, "texture_levels": 6, "gather_rays": 8, "bounces": 0}


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    """A finished run on two sizes of one embedded scene, and on a capture."""
    folder = checkout(tmp_path_factory.mktemp("several"))
    small_scene(folder / "photographs" / "Orbit 0", count=16, name="orbit_0")
    values = tiny() | {"runtime": {"repeats": 1, "views": 5, "scene": "fine/orbit_0"}}
    orbit = {"source": "embedded", "pattern": "orbit", "seeds": [0]}
    for name, side in (("orbit", 36), ("fine", 48)):
        values["datasets"][name] = orbit | {"capture": QUICK | {"long_side": side}}
    values["datasets"]["photographs"] = {"source": "captures", "folder": "photographs", "published": "mipnerf360"}
    values["datasets"]["photographs"] |= {"methods": ["random"], "tables": []}
    values["datasets"]["idle"] = orbit | {"methods": ["warprf"]}
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    result = run(folder, "-j2", "tables")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "left out: idle: the run has none of its methods, warprf\n" in result.stderr
    return folder / "results" / "tiny"


DATASETS = ("orbit", "fine", "photographs")


@pytest.mark.parametrize("dataset", DATASETS)
def test_every_data_set_has_its_tables(dataset, several):
    with open(several / "tables" / f"nvs_{dataset}.csv", newline="") as stream:
        rows = {row["method"]: row for row in csv.DictReader(stream) if row["metric"] == "psnr"}
    alone = dataset == "photographs"
    assert set(rows) == ({"random"} if alone else set(METHODS))
    assert {path.name for path in (several / "episodes" / dataset / "orbit_0").iterdir()} == set(rows)
    assert bool(rows["random"]["published"]) == (dataset != "fine")
    assert (several / "tables" / f"ranking_{dataset}.csv").exists() != alone
    assert (several / "common_states" / dataset).exists() != alone


def test_scenes_of_one_name_stay_apart(several):
    scenes = {dataset: read_scene(several / "scenes" / dataset / "orbit_0") for dataset in DATASETS}
    assert {name: scene.dataset for name, scene in scenes.items()} == dict(zip(DATASETS, DATASETS, strict=True))
    assert len({scene.content_hash for scene in scenes.values()}) == len(DATASETS)
    for dataset, scene in scenes.items():
        episode = read_record(several / f"episodes/{dataset}/orbit_0/random/0/episode.json", Episode)
        assert (episode.dataset, episode.scene, episode.scene_hash) == (dataset, "orbit_0", scene.content_hash)


def test_selections_are_timed_on_the_scene_that_is_named(several):
    assert [path.name for path in (several / "runtime").iterdir()] == ["fine"]


def test_a_data_set_that_is_added_reruns_none_of_the_others(several):
    folder = several.parents[1]
    values = yaml.safe_load((folder / "tiny.yaml").read_text())
    values["datasets"]["rooms"] = {"source": "embedded", "pattern": "walkthrough", "seeds": [1], "capture": QUICK}
    values["datasets"]["fine"]["seeds"] = [0, 2]
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    result = run(folder, "-n", "tables")
    assert result.returncode == 0, result.stderr
    lines = [line for line in result.stdout.splitlines() if line.startswith("Job ") and "scene " in line]
    assert sorted(line.split(": ")[1] for line in lines) == ["scene orbit_2 of fine", "scene walkthrough_1 of rooms"]
    episodes = [line for line in result.stdout.splitlines() if "episode: " in line]
    assert len(episodes) == 2 * len(METHODS)
