"""A small run with all kinds of records, and its page, for the tests of the page."""

import json
from pathlib import Path

import numpy as np
from factories import small_scene

from avs.nvs.record import Episode
from avs.report.page.exploration_script import write_exploration_script
from avs.report.page.page_settings import PageSettings
from avs.report.page.scene_scripts import SceneInputs, write_scene_scripts
from avs.report.page.site import PageFacts, PageInputs, write_page
from avs.report.tables.view_synthesis import write_nvs_table
from avs.representations.gaussians.ply import write_ply
from avs.sfm.cloud import Cloud
from avs.sfm.cloud_file import write_cloud
from avs.slam.loop.exploration_record import MAPS_HEADER
from avs.system.reasons import Reason
from avs.system.records import read_record, write_record
from avs.system.tensor_files import write_tensors
from tests.report.coverage_records import make_coverage
from tests.report.picture_records import write_episode
from tests.report.state_records import make_states, scored, state
from tests.report.test_slam_report import write as write_exploration
from tests.representations.test_ply import gaussians

SHIFTS = {"random": 3, "farthest": 11, "fisherrf": 19, "ours-repvit": 27}
METHODS = [*SHIFTS, "niqe"]
ABSENT = {"niqe": Reason(cause="weights niqe absent", remedy="python -m avs weights fetch niqe")}
SCENES = ("toy", "attic")
SEEDS = (0, 1)


def write_run(root, scenes=SCENES, seeds=SEEDS):
    """Write scenes with episodes of four methods, one of which predicts maps; the first has coverage and states."""
    inputs = {}
    for name in scenes:
        folder = root / "scenes" / "toys" / name
        scene = small_scene(folder, name=name)
        paths = [
            write_episode(root, scene, method, seed, shift=shift + 5 * seed, maps=method == "ours-repvit")
            for method, shift in SHIFTS.items()
            for seed in seeds
        ]
        for path in paths:
            write_ply(path.with_name("splats.ply"), gaussians(count=40), scene.to_capture)
        first = name == scenes[0]
        inputs[name] = SceneInputs(
            folder, paths, [_coverage(paths[0], root)] if first else [], [_states(scene, root)] if first else []
        )
    return inputs


def write_whole_page(root, inputs, page, settings=None, seeds=SEEDS):
    """Write the page of a run, and return its folder."""
    settings = settings or PageSettings()
    for name, each in inputs.items():
        share = 1 / len(inputs)
        write_scene_scripts(each, METHODS, ABSENT, settings, share, page / "scenes" / "toys" / name)
    paths = [path for each in inputs.values() for path in each.episodes]
    write_nvs_table(paths, METHODS, "toys", None, root / "tables" / "nvs_toys", ABSENT, "farthest")
    figure = root / "figures" / "psnr_over_views_toys.png"
    figure.parent.mkdir(exist_ok=True)
    picture = next((root / "scenes").rglob("*.png"))
    figure.write_bytes(picture.read_bytes())
    card = root / "scorer" / "repvit" / "card.json"
    card.parent.mkdir(parents=True, exist_ok=True)
    card.write_text(json.dumps({"held_out": {"pearson": 0.5, "images": 4.0}, "parameters": 9}))
    write_exploration_script(_exploration(root), settings, page)
    facts = PageFacts(
        "trial", {"toys": tuple(inputs)}, METHODS, ABSENT, {"scale": "trial"}, {"flat": (("fisherrf", 0),)}
    )
    write_page(PageInputs([root / "tables" / "nvs_toys.json"], [figure], [card]), facts, page)
    return page


def _coverage(path, root):
    """Write the coverage of an episode with a cloud of which each point is as far off as its place says."""
    episode = read_record(path, Episode)
    folder = root / "coverage" / "toys" / episode.scene / episode.method / str(episode.seed)
    write_record(folder / "coverage.json", make_coverage(episode))
    cloud = Cloud(
        np.random.default_rng(0).normal(size=(30, 3)), np.full((30, 3), 90, np.uint8), np.ones(30, np.float32)
    )
    write_cloud(folder / "covered.ply", cloud, {"distance": np.linspace(0, 2, 30, dtype=np.float32)})
    return folder / "coverage.json"


def _states(scene, root):
    names = [scene.names[row] for row in scene.pool[:4]]
    moments = [
        state().model_copy(update={"candidates": names}),
        state(gains=None).model_copy(update={"candidates": names}),
    ]
    scores = [[1.0, 2.0, 3.0, 4.0], [4.0, None, 2.0, 1.0]]
    record = make_states(
        moments, [scored("fisherrf", *scores), scored("random", None, scores[0], failure="no scores")],
        scene=scene.name, dataset="toys", scene_hash=scene.content_hash, captured=names[:1],
    )  # fmt: skip
    path = root / "common_states" / "toys" / scene.name / "0.json"
    write_record(path, record)
    return path


def _exploration(root) -> Path:
    path = write_exploration(root / "slam", method="fisherrf")
    arrays = {
        "trajectory": np.linspace([0, 0, 0, 0], [3, 2, 0, 1], 101),
        "above_rgb": np.full((80, 60, 3), 200, np.uint8),
        "above_origin": np.array([-0.5, -0.5]),
    }
    write_tensors(path.with_name("maps.safetensors"), arrays, MAPS_HEADER, {})
    return path
