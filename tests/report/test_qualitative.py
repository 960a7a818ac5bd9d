"""The figure of renderings: which methods, images and parts it shows is a rule, and no input breaks it."""

import numpy as np
import pytest

from avs.nvs.picture_settings import PICTURES, PictureSettings
from avs.report.collect import read_episodes
from avs.report.figure_settings import FigureSettings
from avs.report.figures.differing_regions import cut, differing_windows
from avs.report.figures.qualitative import write_qualitative
from avs.report.figures.shown_methods import best_methods, image_psnr, most_differing, shown_methods, shown_scenes
from avs.system.errors import UserError
from tests.report.picture_records import write_episode, written_scene

METHODS = ["random", "farthest", "fisherrf", "ours-repvit"]


def collected(written, episodes):
    (found,) = read_episodes(written(episodes), ["oracle-ssim", *METHODS])
    return found


def test_words_stand_for_methods_and_each_is_shown_once(episode, written):
    episodes = collected(
        written, [episode(name, psnr=(20.0 + step,)) for step, name in enumerate(["random", "ours-repvit", "farthest"])]
    )
    wanted = FigureSettings().methods
    assert shown_methods(episodes, wanted, "farthest") == ["random", "farthest", "ours-repvit"]  # best is farthest
    assert shown_methods(episodes, ("best", "random"), None) == ["farthest", "random"]
    assert shown_methods(episodes, ("reference", "niqe"), None) == []


def test_an_oracle_is_not_the_best_and_means_are_over_shared_scenes(episode, written):
    episodes = [
        episode("oracle-ssim", "attic", group="Oracle", psnr=(40.0,)),
        episode("random", "attic", psnr=(20.0,)),
        episode("random", "cellar", psnr=(50.0,)),  # which the other lacks
        episode("farthest", "attic", psnr=(21.0,)),
    ]
    assert best_methods(collected(written, episodes)) == ["farthest", "random"]


def test_rows_go_round_the_data_sets():
    scenes = {"orbit": ["a", "b", "c"], "handheld": ["d"], "captures": ["e", "f"]}
    expected = [("orbit", "a"), ("handheld", "d"), ("captures", "e"), ("orbit", "b")]
    assert shown_scenes(scenes, 4) == expected
    assert shown_scenes(scenes, 9)[4:] == [("captures", "f"), ("orbit", "c")]


def test_squares_lie_where_pictures_differ_most_and_do_not_overlap():
    truth = np.zeros((40, 60, 3), dtype=np.uint8)
    first, second = truth.copy(), truth.copy()
    second[5:15, 40:50] = 200
    second[25:33, 3:11] = 90
    (left, top, edge), other = differing_windows([first, second], truth, 2)
    assert edge == 11
    assert cut(second, (left, top, edge)).sum() == second[5:15, 40:50].sum()
    assert cut(second, other).sum() == second[25:33, 3:11].sum()
    assert max(abs(left - other[0]), abs(top - other[1])) >= edge
    # Of one picture it is where it differs from the photograph.
    assert differing_windows([second], truth, 1) == [(left, top, edge)]
    assert len(differing_windows([first[:3, :3]], truth[:3, :3], 20)) == 9  # squares of one pixel


@pytest.fixture
def run(tmp_path):
    """A small run: two scenes, one of them portrait, and a method that has no episode of one."""
    toy, first = written_scene(tmp_path)
    tall, second = written_scene(tmp_path, "tall", size=(16, 24))
    paths = [write_episode(tmp_path, toy, method, shift=3 * step) for step, method in enumerate(METHODS)]
    paths += [write_episode(tmp_path, tall, method) for method in METHODS[:2]]
    return paths, [first, second]


def test_the_same_bytes_each_time_and_a_caption(run, tmp_path):
    paths, scenes = run
    contents = []
    for name, order in (("first", paths), ("second", paths[::-1])):
        write_qualitative(order, scenes, METHODS, FigureSettings(), "farthest", tmp_path / name / "qualitative")
        contents.append({path.suffix: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert contents[0] == contents[1]
    assert contents[0].keys() == {".pdf", ".png", ".md"}
    assert b"with seed 0" in contents[0][".md"].replace(b"\n", b" ")


def test_one_scene_and_one_method_are_enough_and_many_fit(tmp_path):
    scene, folder = written_scene(tmp_path)
    one = write_episode(tmp_path, scene, "random")
    write_qualitative([one], [folder], ["random"], FigureSettings(), "farthest", tmp_path / "one")
    many = [f"method-{number}" for number in range(24)]
    paths = [write_episode(tmp_path, scene, method, shift=number) for number, method in enumerate(many)]
    write_qualitative(paths, [folder], many, FigureSettings(methods=tuple(many)), None, tmp_path / "many")
    assert (tmp_path / "many.png").stat().st_size > (tmp_path / "one.png").stat().st_size


def test_without_pictures_it_says_so(tmp_path):
    scene, folder = written_scene(tmp_path)
    path = write_episode(tmp_path, scene, "random", settings=PictureSettings(test_images=0))
    write_qualitative([path], [folder], ["random"], FigureSettings(), None, tmp_path / "none")
    assert "No renderings" in (tmp_path / "none.md").read_text()
    assert (tmp_path / "none.pdf").exists()


def test_the_test_image_is_the_one_that_methods_render_most_differently(episode):
    from avs.nvs.record import KeptPictures

    kept = KeptPictures(sha256="", test=["000.png", "002.png"])
    episodes = [
        episode("random", psnr=(20.0, 9.0, 21.0), pictures=kept),
        episode("farthest", psnr=(22.0, 30.0, 20.0), pictures=kept),
    ]
    assert most_differing(episodes) == "000.png"  # 001.png is not kept
    assert image_psnr(episodes[1], "002.png") == 20.0
    assert most_differing([episode("random")]) is None


def test_pictures_of_another_episode_are_refused(run, tmp_path):
    paths, scenes = run
    paths[0].with_name(PICTURES).write_bytes(paths[2].with_name(PICTURES).read_bytes())
    with pytest.raises(UserError, match="is not the file that the record beside it tells of"):
        write_qualitative(paths, scenes, METHODS, FigureSettings(), "farthest", tmp_path / "qualitative")


def test_a_scene_of_another_version_is_refused(run, tmp_path):
    paths, _ = run
    _, folder = written_scene(tmp_path / "other", darkest=20)
    with pytest.raises(UserError, match="is not the scene of"):
        write_qualitative(paths, [folder], METHODS, FigureSettings(), None, tmp_path / "qualitative")
