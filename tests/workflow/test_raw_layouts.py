"""Every data set of the paper, as a miniature of its raw layout, goes through the workflow to a row of its table."""

import csv

import pytest
import yaml

from tests.datasets.captures_factory import make_capture
from tests.datasets.test_llff import make as make_llff
from tests.datasets.test_map_free import make as make_map_free
from tests.datasets.test_nerfstudio import make as make_transforms
from tests.datasets.test_realestate10k import photograph, poses, text_of, write_video
from tests.workflow.project import METHODS, checkout, run, tiny

DATASETS = {
    "mipnerf360": {"source": "mipnerf360", "folder": "raw/mipnerf360", "long_side": 150},
    "realestate10k": {
        "source": "realestate10k",
        "folder": "raw/realestate10k",
        "videos": "raw/realestate10k/videos",
        "only": ["0bf152ef84195293", "3c35b868a8ec3433"],
    },
    "mapfree": {"source": "map_free", "folder": "raw/mapfree/train"},
    "aria_dtc": {"source": "aria_dtc", "folder": "raw/aria_dtc", "axes": "opencv"},
    "terrace": {"source": "nerfstudio", "folder": "raw/terrace", "axes": "opengl"},
    "fern": {"source": "llff", "folder": "raw/fern"},
}


def make_all(raw):
    make_capture(raw / "mipnerf360" / "garden", count=16)
    (raw / "realestate10k" / "test").mkdir(parents=True)
    (raw / "realestate10k" / "test" / "0bf152ef84195293.txt").write_text(text_of(late=0))
    (raw / "realestate10k" / "test" / "3c35b868a8ec3433.txt").write_text(text_of("bJyPo9pESu0"))
    frames = [photograph(pose) for pose in poses(10)]
    write_video(raw / "realestate10k" / "videos" / "QShWPZxTDoE.mp4", frames[:1] * 20 + frames)
    make_map_free(raw / "mapfree" / "train" / "s00003")
    rectified = raw / "aria_dtc" / "Dish_active" / "camera-rgb-rectified-600-h1000"
    make_transforms(rectified, axes="opencv", shift=0.5, keys=("fx", "fy", "image_path"), camera_model="linear")
    make_transforms(raw / "terrace")
    make_llff(raw / "fern")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("raw_layouts"))
    make_all(folder / "raw")
    (folder / "raw" / "mapfree" / "train" / "s00009").mkdir()
    (folder / "raw" / "mapfree" / "train" / "s00009" / "poses.txt").write_text("seq0/frame_00000.jpg 0 0 0 0 0 0 0\n")
    values = tiny() | {"datasets": DATASETS, "distortions": None, "common_states": None}
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    return folder, run(folder, "-j2", "--keep-going", "tables")


@pytest.mark.parametrize("dataset", DATASETS)
def test_a_data_set_has_its_rows(dataset, finished):
    folder, result = finished
    kind = "tables_incomplete" if dataset == "mapfree" else "tables"  # one of its scenes is damaged
    table = folder / "results" / "tiny" / kind / f"nvs_{dataset}.csv"
    assert table.exists(), result.stdout + result.stderr
    with open(table, newline="") as stream:
        rows = {row["method"]: row for row in csv.DictReader(stream) if row["metric"] == "psnr"}
    assert set(rows) == set(METHODS)
    assert all(float(row["mean"]) > 3 for row in rows.values())
    if dataset == "mipnerf360":
        assert rows["random"]["published"]


def test_what_is_missing_or_damaged_is_named_and_the_others_go_on(finished):
    told = finished[1].stdout + finished[1].stderr
    assert "left out of realestate10k: 3c35b868a8ec3433 lacks its video, bJyPo9pESu0" in told
    assert "left out of mipnerf360: bicycle is not there" in told
    assert "s00009/intrinsics.txt: is missing; get the archive again" in told
