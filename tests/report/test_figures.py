"""The curves of PSNR over views: what is averaged, what the band is; the files are the same to the byte."""

import numpy as np
import pytest

from avs.report.collect import read_episodes
from avs.report.figures.curves import panels
from avs.report.figures.end_labels import spread
from avs.report.figures.method_lines import PROPOSED, emphasised, legend_styles, line_styles
from avs.report.figures.psnr_over_views import write_psnr_over_views

METHODS = ["random", "farthest", "ours-repvit"]


@pytest.fixture
def drawn(written):
    def draw(episodes, methods=METHODS):
        return [panel for collected in read_episodes(written(episodes), methods) for panel in panels(collected)]

    return draw


def test_curve_is_the_mean_over_scenes_and_seeds(episode, drawn):
    episodes = [
        episode(method, scene, seed, psnr=(base + step + 0.5 * seed,))
        for method, step in (("random", 0.0), ("ours-repvit", 1.0))
        for scene, base in (("attic", 20.0), ("cellar", 30.0))
        for seed in (0, 1)
    ]
    (panel,) = drawn(episodes)
    assert panel.title == "orbit: 2 scenes, 2 seeds"
    random, ours = panel.curves
    assert random.views.tolist() == [4, 5, 6]
    np.testing.assert_allclose(random.mean, [23.25, 24.25, 25.25])
    # 1 dB apart in every scene with every seed: the 10 dB between the scenes are not in the band.
    for curve, expected in ((random, -0.5), (ours, 0.5)):
        np.testing.assert_allclose([curve.difference, curve.low, curve.high], expected)


def test_methods_that_call_themselves_the_same_are_told_apart(episode, drawn):
    episodes = [episode(method).model_copy(update={"label": "FVS"}) for method in ("farthest", "random")]
    (panel,) = drawn(episodes)
    assert sorted(curve.label for curve in panel.curves) == ["FVS (farthest)", "FVS (random)"]


def test_band_is_the_interval_over_three_scenes(episode, drawn):
    episodes = [
        episode(method, scene, psnr=(20.0 + gain,))
        for method, gains in (("random", [0, 0, 0]), ("ours-repvit", [0, 2, 4]))
        for scene, gain in zip(("attic", "cellar", "hall"), gains, strict=True)
    ]
    (panel,) = drawn(episodes)
    ours = panel.curves[1]
    assert panel.over == "scenes"
    # Differences 0, 1 and 2: standard error 1 / sqrt(3), and 4.303 is the quantile of two degrees of freedom.
    half = 4.3026527 / 3**0.5
    np.testing.assert_allclose([ours.low[-1], ours.difference[-1], ours.high[-1]], [1 - half, 1, 1 + half])


def test_band_of_two_scenes_is_over_their_seeds(episode, drawn):
    episodes = [
        episode(method, scene, seed, psnr=(20.0 + gain * (seed + far),))
        for method, gain in (("random", 0), ("ours-repvit", 2))
        for scene, far in (("attic", 0), ("cellar", 10))
        for seed in (0, 1)
    ]
    (panel,) = drawn(episodes)
    ours = panel.curves[1]
    assert panel.over == "seeds"
    # Within each scene 0 and 1 apart from its mean: variances 1/2 each, so two degrees of freedom; error 1/2 / sqrt(2).
    half = 4.3026527 * 0.5 / 2**0.5
    np.testing.assert_allclose([ours.low[-1], ours.difference[-1], ours.high[-1]], [5.5 - half, 5.5, 5.5 + half])


def test_one_scene_and_seed_has_no_band(episode, drawn):
    (panel,) = drawn([episode("random"), episode("farthest")])
    assert panel.title == "orbit: attic, 1 seed"
    assert panel.curves[0].low is None
    assert panel.over is None


def test_oracles_are_no_part_of_the_mean(episode, written):
    oracle = episode("oracle-ssim", group="Oracle", psnr=(30.0,))
    paths = written([oracle, episode("random", psnr=(20.0,)), episode("farthest", psnr=(22.0,))])
    (panel,) = panels(read_episodes(paths, ["oracle-ssim", "random", "farthest"])[0])
    assert [curve.difference[-1] for curve in panel.curves] == [9.0, -1.0, 1.0]


def test_scenes_that_end_earlier_have_their_own_panel(episode, drawn):
    episodes = [
        episode(method, scene, budget=budget)
        for method in METHODS
        for scene, budget in (("attic", 6), ("cellar", 6), ("hall", 5))
    ]
    large, small = drawn(episodes)
    assert large.title == "orbit: 2 scenes, 1 seed"
    assert large.curves[0].views.tolist() == [4, 5, 6]
    assert small.title == "orbit: hall, 1 seed"
    assert small.curves[0].views.tolist() == [4, 5]


def test_all_curves_of_a_panel_are_over_the_same_scenes(episode, drawn):
    episodes = [episode(method, scene) for method in METHODS for scene in ("attic", "cellar")]
    (panel,) = drawn([each for each in episodes if (each.method, each.scene) != ("random", "cellar")])
    assert panel.title == "orbit: attic, 1 seed"
    assert [curve.label for curve in panel.curves] == ["Random", "FVS", "Ours-RepViT"]


def test_files_are_the_same_to_the_byte(episode, written, tmp_path):
    episodes = [
        episode(method, scene, dataset=dataset)
        for dataset in ("orbit", "captures")
        for method in METHODS
        for scene in ("attic", "cellar")
    ]
    paths = written(episodes)
    contents = []
    for name, order in (("first", paths), ("second", paths[::-1])):
        out = tmp_path / name / "psnr_over_views"
        write_psnr_over_views(order, METHODS, out)
        contents.append({path.name: path.read_bytes() for path in out.parent.iterdir()})
    assert contents[0] == contents[1]
    assert contents[0]["psnr_over_views.pdf"].startswith(b"%PDF")
    assert contents[0]["psnr_over_views.png"].startswith(b"\x89PNG")
    assert contents[0].keys() == {f"psnr_over_views.{suffix}" for suffix in ("pdf", "png", "md")}


def test_a_label_is_text_whatever_it_holds(episode, written, tmp_path):
    paths = written([episode("random", label="$\\foo_{$ 50%\nof"), episode("farthest")])
    write_psnr_over_views(paths, METHODS, tmp_path / "psnr_over_views")
    assert (tmp_path / "psnr_over_views.png").exists()


def test_methods_that_add_several_views_at_once_keep_their_own_points(episode, drawn):
    batched = episode("farthest", psnr=(25.0,))
    batched = batched.model_copy(update={"curve": [batched.curve[0], batched.curve[-1]]})
    (panel,) = drawn([episode("random", psnr=(20.0,)), batched, episode("ours-repvit", psnr=(21.0,))])
    assert [curve.views.tolist() for curve in panel.curves] == [[4, 5, 6], [4, 6], [4, 5, 6]]
    # At five views the mean is that of the two methods measured there.
    np.testing.assert_allclose(panel.curves[0].difference, [-2.0, -0.5, -2.0])


def test_colours_are_groups_and_the_reference_and_the_best_two_are_thick(episode, drawn):
    psnr = {"random": 20.0, "farthest": 19.0, "niqe": 22.0, "ours-repvit": 23.0, "oracle-gain": 30.0}
    groups = {"farthest": "Geometric", "oracle-gain": "Oracle"}
    (panel,) = drawn(
        [episode(name, psnr=(value,), group=groups.get(name, "2D-based")) for name, value in psnr.items()], list(psnr)
    )
    assert emphasised(panel.curves, "farthest") == ["farthest", "ours-repvit", "niqe"]
    assert emphasised(panel.curves, None) == ["ours-repvit", "niqe"]
    styles = line_styles(panel.curves, "farthest")
    assert styles["random"]["color"] == styles["niqe"]["color"] != styles["ours-repvit"]["color"]
    assert styles["farthest"]["linewidth"] == styles["niqe"]["linewidth"] > styles["random"]["linewidth"]
    assert styles["oracle-gain"]["linestyle"] != "-"
    assert styles["oracle-gain"]["zorder"] < styles["random"]["zorder"] < styles["niqe"]["zorder"]
    assert list(legend_styles(panel.curves)) == ["Geometric", "2D-based", PROPOSED, "Oracle"]


def test_names_keep_their_distance_and_their_order():
    wanted = np.array([0.5, 0.52, 0.1, 0.5, 0.99])
    found = spread(wanted, 0.1, 0.0, 1.0)
    assert np.diff(np.sort(found)).min() >= 0.1 - 1e-12
    assert np.argsort(found, kind="stable").tolist() == np.argsort(wanted, kind="stable").tolist()
    np.testing.assert_allclose(found[[2, 4]], [0.1, 0.95])  # undisturbed, and moved in by half a name
    np.testing.assert_allclose(found[[0, 3, 1]].mean(), wanted[[0, 3, 1]].mean())
    crowded = spread(np.full(24, 0.9), 0.1, 0.0, 1.0)  # more than there is room for
    assert np.diff(np.sort(crowded)).min() > 0.04
    assert crowded.min() >= 0
    assert crowded.max() <= 1


@pytest.mark.parametrize("count", [1, 24])
def test_any_number_of_methods_fits(episode, written, tmp_path, count):
    methods = [f"method-{number}" for number in range(count)]
    paths = written([episode(name, psnr=(20.0 + number % 3,)) for number, name in enumerate(methods)])
    write_psnr_over_views(paths, methods, tmp_path / "psnr_over_views", "farthest")
    assert (tmp_path / "psnr_over_views.png").exists()
