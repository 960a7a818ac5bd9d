"""The figure of score maps: whose maps it shows, of which moments, and that no run breaks it."""

import pytest

from avs.nvs.picture_settings import PictureSettings
from avs.nvs.pictures import read_pictures
from avs.nvs.record import Episode
from avs.report.figures.score_maps import _kinds, _moments, write_score_maps
from avs.system.records import read_record
from tests.report.picture_records import PROTOCOL, write_episode, written_scene

METHODS = ["random", "ours-repvit", "oracle-ssim"]


@pytest.fixture
def run(tmp_path):
    """Episodes of a method without maps, one that predicts them, and the oracle, on a portrait scene."""
    scene, _ = written_scene(tmp_path, size=(16, 24))
    return [write_episode(tmp_path, scene, method, maps=method == "ours-repvit") for method in METHODS]


def opened(path):
    record = read_record(path, Episode)
    return record, read_pictures(path, record)


def test_methods_that_predict_maps_or_go_by_the_true_one_are_shown(run):
    kinds = [_kinds(*opened(path)) for path in run]
    assert kinds == [(), ("rendering", "predicted", "true"), ("rendering", "true")]


def test_moments_are_spread_and_count_the_views(run, tmp_path):
    record, pictures = opened(run[1])
    assert [moment.views for moment in _moments(record, pictures, ["true"], 2)] == [5, 7]
    assert [moment.views for moment in _moments(record, pictures, ["true"], 9)] == [5, 6, 7]
    scene, _ = written_scene(tmp_path / "joint")
    path = write_episode(
        tmp_path / "joint", scene, "random", protocol=PROTOCOL.model_copy(update={"views_per_choice": 3})
    )
    assert [moment.views for moment in _moments(*opened(path), ["true"], 5)] == [5]


def test_one_moment_is_enough(run, tmp_path):
    write_score_maps(run, METHODS, 1, "toys", "toy", tmp_path / "maps")
    assert (tmp_path / "maps.png").exists()


def test_the_same_bytes_each_time(run, tmp_path):
    contents = []
    for name, order in (("first", run), ("second", run[::-1])):
        write_score_maps(order, METHODS, 2, "toys", "toy", tmp_path / name / "maps")
        contents.append({path.suffix: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert contents[0] == contents[1]
    assert contents[0].keys() == {".pdf", ".png", ".md"}
    assert b"toy of toys" in contents[0][".md"]


@pytest.mark.parametrize("settings", [PictureSettings(), PictureSettings(choices=False)])
def test_without_maps_it_says_so(tmp_path, settings):
    scene, _ = written_scene(tmp_path)
    methods = ["random"] if settings.choices else ["oracle-ssim"]
    paths = [write_episode(tmp_path, scene, method, settings=settings) for method in methods]
    write_score_maps(paths, methods, 5, "toys", "toy", tmp_path / "maps")
    assert "No maps" in (tmp_path / "maps.md").read_text()
    assert (tmp_path / "maps.png").exists()
