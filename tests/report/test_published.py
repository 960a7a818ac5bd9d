"""The transcription of the paper's tables: form, and the means that can be recomputed."""

import csv
from decimal import Decimal
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "results" / "published"
COLUMNS = ["table", "dataset", "scene", "method", "metric", "value"]
NO_REFERENCE = {"brisque", "niqe", "piqe", "nima", "musiq", "maniqa", "tres", "topiq"}
METHODS = {
    "random",
    "farthest",
    "activenerf",
    "fisherrf",
    "fisherrf4-released",
    "ours-repvit",
    "ours-dinov2",
} | NO_REFERENCE
METRICS = {"psnr", "ssim", "lpips", "scr_percent", "f_score", "depth_mae_metres", "selection_seconds", "gpu_memory_gb"}
ROWS = {
    "nvs_mipnerf360": 14 * 3,
    "nvs_mipnerf360_per_scene": 10 * 10 * 3,
    "nvs_realestate10k": 4 * 3,
    "nvs_mapfree": 4 * 3,
    "nvs_aria_dtc": 2 * 3,
    "coverage_realestate10k": 4 * 2,
    "slam_gibson": 2 * 3,
    "runtime_garden": 3 * 3,
    "runtime_garden_detail": 13 * 2,
}
# Printed means that are not the rounded means of the printed scene values (results/published/README.md).
INCONSISTENT_MEANS = {("fisherrf", "ssim"), ("ours-repvit", "ssim"), ("fisherrf", "lpips")}


def read(name):
    with open(FOLDER / f"{name}.csv", newline="") as stream:
        return list(csv.DictReader(stream))


def values(name):
    return {(row["scene"], row["method"], row["metric"]): Decimal(row["value"]) for row in read(name)}


def test_every_file_is_known():
    assert {path.stem for path in FOLDER.glob("*.csv")} == set(ROWS)


@pytest.mark.parametrize("name", ROWS)
def test_form(name):
    rows = read(name)
    assert list(rows[0]) == COLUMNS
    assert len(rows) == ROWS[name] == len(values(name))
    assert {row["method"] for row in rows} <= METHODS
    assert {row["metric"] for row in rows} <= METRICS
    assert len({(row["table"], row["dataset"]) for row in rows}) == 1


def test_scene_means_are_the_printed_means():
    numbers = values("nvs_mipnerf360_per_scene")
    scenes = sorted({scene for scene, _, _ in numbers} - {"mean"})
    assert len(scenes) == 9
    inconsistent = set()
    for (scene, method, metric), printed in numbers.items():
        if scene != "mean":
            continue
        mean = sum(numbers[each, method, metric] for each in scenes) / 9
        assert abs(mean - printed) <= Decimal("0.01")  # half a unit for the scene values, half for the mean
        if abs(mean - printed) > Decimal("0.005"):
            inconsistent.add((method, metric))
    assert inconsistent == INCONSISTENT_MEANS


def test_tables_that_print_one_quantity_twice_agree():
    main, scenes = values("nvs_mipnerf360"), values("nvs_mipnerf360_per_scene")
    means = {key: value for key, value in scenes.items() if key[0] == "mean"}
    assert means.items() <= main.items()
    runtime, detail = values("runtime_garden"), values("runtime_garden_detail")
    for key, value in runtime.items():
        if key[2] != "gpu_memory_gb":
            assert detail[key] == value
    garden = {key: value for key, value in detail.items() if key in scenes}
    assert len(garden) == 10
    assert all(scenes[key] == value for key, value in garden.items())
