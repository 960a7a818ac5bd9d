"""The fit to distortion data: what it reads, what its card says, and that it learns what is there to be learnt."""

import json

import numpy as np
import pytest

from avs.iqa.cross_reference.distortions import write_distortions
from avs.iqa.render_statistics.pixel_statistics import PIXEL_STATISTICS
from avs.iqa.render_statistics.regression_file import read_regressions
from avs.iqa.render_statistics.regression_fit import columns_seen, fit_statistics, predicted, statistics_of
from avs.iqa.render_statistics.regression_settings import RegressionSettings
from avs.iqa.resizing import ResizeSettings
from metrics.ranking import spearman


@pytest.fixture
def files(toys, tmp_path):
    paths = [tmp_path / f"{toy.scene}.safetensors" for toy in toys]
    for path, toy in zip(paths, toys, strict=True):
        write_distortions(path, toy)
    return paths


def fit(files, folder, **settings):
    weights, card = folder / "weights", folder / "card.json"
    values = {"resize": ResizeSettings(pixels=56), **settings}
    fit_statistics(files[:1], files[1:], weights, card, RegressionSettings(**values), lambda _: None)
    return read_regressions(weights), json.loads(card.read_text())


def test_columns_are_those_that_the_settings_let_it_see():
    assert columns_seen(RegressionSettings(sees=())) == PIXEL_STATISTICS
    assert columns_seen(RegressionSettings(sees=("angle", "depth")))[9:] == ("depth", "depth_spread", "angle")


def test_noise_is_recognised_on_a_scene_that_it_has_not_seen(files, toys, tmp_path):
    fitted, card = fit(files, tmp_path)
    assert card["held_out_scenes"][0]["name"] == "toy_2"
    assert card["facts"]["candidates"] == toys[0].candidates.sum()
    scores = predicted(fitted.regressions["pixels"], statistics_of(toys[1], ResizeSettings(pixels=56)))
    assert spearman(scores, toys[1].similarity).value > 0.6
    assert card["facts"]["candidate_spearman"]["pixels"] == fitted.facts.candidate_spearman["pixels"]


def test_equal_data_give_equal_bytes(files, tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        fit(files, tmp_path / name)
    assert (tmp_path / "a/weights").read_bytes() == (tmp_path / "b/weights").read_bytes()
    assert (tmp_path / "a/card.json").read_bytes() == (tmp_path / "b/card.json").read_bytes()


def test_candidates_are_the_views_that_were_not_captured(toys):
    expected = [image not in range(moment + 3) for moment in range(3) for image in range(8)]
    np.testing.assert_array_equal(toys[0].candidates, expected)
