"""The figures of times: the front, the names beside points, the axis in two parts, and what is no time of a choice."""

import numpy as np
import pytest

from avs.report.collect import read_dataset, read_episodes
from avs.report.figures.point_labels import placed
from avs.report.figures.teaser import Point, pareto_front, points_of, write_teaser
from avs.report.figures.time_and_psnr import linear_up_to, selection_times, write_time_and_psnr
from avs.report.tables.selection_times_numbers import read_runtimes
from avs.system.records import write_record
from tests.report.picture_records import PROTOCOL, write_episode, written_scene
from tests.report.timing_records import make_record

METHODS = ["random", "farthest", "fisherrf", "oracle-ssim"]


def point(method, seconds, psnr, group="2D-based"):
    return Point(method, method, group, seconds, psnr)


def test_no_method_is_faster_and_better_than_one_on_the_front():
    fast, equal, good, slow = point("a", 0.1, 20), point("b", 0.1, 19), point("c", 1.0, 22), point("d", 2.0, 21)
    assert pareto_front([slow, equal, good, fast]) == [fast, good]
    assert pareto_front([]) == []


@pytest.mark.parametrize("count", [1, 2, 24])
def test_names_cover_neither_points_nor_one_another(count):
    rng = np.random.default_rng(count)
    points = rng.uniform(0.3, [2.6, 1.8], (count, 2))
    sizes = np.stack([rng.uniform(0.2, 0.6, count), np.full(count, 0.1)], axis=1)
    corners = placed(points, sizes, (2.9, 2.1), [np.array([0.0, 1.0, 2.9, 1.02])])
    boxes = np.concatenate([corners, corners + sizes], axis=1)
    assert (corners >= 0).all()
    assert (boxes[:, 2:] <= [2.9, 2.1]).all()
    for row, box in enumerate(boxes):
        others = np.delete(boxes, row, axis=0)
        apart = (box[:2] >= others[:, 2:]).any(axis=1) | (box[2:] <= others[:, :2]).any(axis=1)
        assert apart.all()
        assert not ((points > box[:2]) & (points < box[2:])).all(axis=1).any()
        assert box[1] >= 1.02 or box[3] <= 1.0  # what is kept free


def test_a_name_whose_point_is_alone_stands_right_beside_it():
    corner = placed(np.array([[1.0, 1.0]]), np.array([[0.5, 0.1]]), (3.0, 2.0))[0]
    np.testing.assert_allclose(corner, [1.05, 0.95])


def test_there_is_always_a_place():
    corners = placed(np.full((9, 2), 0.2), np.tile([0.9, 0.3], (9, 1)), (0.5, 0.4))
    assert np.isfinite(corners).all()


def test_times_are_the_medians_of_the_table(episode, written, tmp_path):
    paths = [tmp_path / f"{method}.json" for method in METHODS]
    for path, method in zip(paths, METHODS, strict=True):
        write_record(path, make_record(method, group="Oracle" if method == "oracle-ssim" else "3D-based"))
    (episodes,) = read_episodes(written([episode("fisherrf", psnr=(22.0,)), episode("random", psnr=(20.0,))]), METHODS)
    found = points_of(read_runtimes(paths), episodes, METHODS)
    assert [(each.method, each.seconds, each.psnr) for each in found] == [
        ("random", 0.3, 20.0),
        ("fisherrf", 0.3, 22.0),
    ]


@pytest.mark.parametrize("count", [1, 24])
def test_a_teaser_of_any_number_of_methods_has_the_same_bytes_each_time(episode, written, tmp_path, count):
    methods = [f"method-{number}" for number in range(count)]
    records = [tmp_path / f"{method}.json" for method in methods]
    for number, (path, method) in enumerate(zip(records, methods, strict=True)):
        write_record(path, make_record(method, total=(0.1 + number % 5,), chosen=1 + 3 * (number == 1)))
    episodes = written([episode(method, psnr=(20.0 + number % 7,)) for number, method in enumerate(methods)])
    contents = []
    for name in ("first", "second"):
        write_teaser(records, episodes, methods, tmp_path / name / "teaser")
        contents.append({path.suffix: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert contents[0] == contents[1]
    assert contents[0].keys() == {".pdf", ".png", ".md"}
    told = " ".join((tmp_path / "first" / "teaser.md").read_text().split())
    assert "44 candidates, 12 captured views" in told
    assert ("method-1 chooses 4 views at a time." in told) == (count > 1)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, None),
        ({"packages": {"torch": "2"}}, "methods were timed with other versions of torch"),
        ({"other_cores": 1.9}, "there was more work than cores"),
    ],
)
def test_a_teaser_has_a_front_where_times_may_be_compared(changes, said, episode, written, tmp_path):
    records = [tmp_path / f"{method}.json" for method in METHODS]
    for path, method in zip(records, METHODS, strict=True):
        write_record(path, make_record(method, **(changes if method == "random" else {})))
    write_teaser(records, written([episode("fisherrf"), episode("random")]), METHODS, tmp_path / "teaser")
    told = " ".join((tmp_path / "teaser.md").read_text().split())
    assert ("Pareto front" in told) == (said is None)
    assert said is None or f"Times have no marks, because {said}" in told


def test_a_method_that_lacks_an_episode_is_not_on_the_front(episode, written, tmp_path):
    paths = [tmp_path / f"{method}.json" for method in METHODS]
    for path, method in zip(paths, METHODS, strict=True):
        write_record(path, make_record(method))
    written_ones = written([episode("fisherrf", seed=0), episode("fisherrf", seed=1), episode("random", seed=0)])
    (episodes,) = read_episodes(written_ones, METHODS)
    found = points_of(read_runtimes(paths), episodes, METHODS)
    assert {each.method: each.whole for each in found} == {"fisherrf": True, "random": False}


def test_a_teaser_without_a_point_says_so(episode, written, tmp_path):
    write_record(tmp_path / "fisherrf.json", make_record())
    write_teaser([tmp_path / "fisherrf.json"], written([episode("random")]), METHODS, tmp_path / "teaser")
    assert "No method has both" in (tmp_path / "teaser.md").read_text()


def test_the_axis_is_linear_up_to_a_power_of_ten_below_the_longest_time():
    assert linear_up_to([0.1, *[20.0] * 5]) == 1.0  # the paper's
    assert linear_up_to([50.0, *[0.7] * 20]) == pytest.approx(0.1)  # the first took long
    assert linear_up_to([2.6]) == pytest.approx(0.1)
    assert linear_up_to([0.0]) > 0
    assert linear_up_to([]) > 0


@pytest.fixture
def run(tmp_path):
    scene, _ = written_scene(tmp_path)
    joint = PROTOCOL.model_copy(update={"views_per_choice": 3})
    return [
        write_episode(tmp_path, scene, "random"),
        write_episode(tmp_path, scene, "random", seed=1),
        write_episode(tmp_path, scene, "fisherrf4", protocol=joint),
        write_episode(tmp_path, scene, "fisherrf4", seed=1, protocol=joint),
    ]


def test_a_time_stands_where_views_are_chosen(run):
    episodes = read_dataset(run, ["random", "fisherrf4"], "toys")
    cells = [("toy", 0), ("toy", 1)]
    assert selection_times(episodes, "random", cells)[0] == [4, 5, 6]
    views, seconds = selection_times(episodes, "fisherrf4", cells)
    assert views == [4]
    assert seconds[0] > 0


def test_a_choice_that_was_made_elsewhere_has_no_time(run):
    episodes = read_dataset(run[:1], ["random"], "toys")
    cell = ("toy", 0)
    record = episodes.cells["random"][cell]
    steps = [step.model_copy(update={"scores": None}) for step in record.steps]
    episodes.cells["random"][cell] = record.model_copy(update={"steps": steps})
    assert selection_times(episodes, "random", [cell]) == ([], [])


def test_times_and_psnr_become_files(run, tmp_path):
    for paths, name in ((run, "all"), (run[:1], "one")):
        write_time_and_psnr(paths, ["random", "fisherrf4"], "toys", "random", tmp_path / name / "figure")
        assert {path.suffix for path in (tmp_path / name).iterdir()} == {".pdf", ".png", ".md"}
    write_time_and_psnr([run[0], run[3]], ["random", "fisherrf4"], "toys", None, tmp_path / "none" / "figure")
    assert "share no scene and seed" in (tmp_path / "none" / "figure.md").read_text()
