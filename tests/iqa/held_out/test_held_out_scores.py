"""The job of a held-out scene: everything that scores is in the record, and a metric that fails leaves the others."""

import numpy as np
import pytest
import torch

from avs.iqa.cross_reference.distortions import write_distortions
from avs.iqa.cross_reference.scorer_checkpoint import save_network
from avs.iqa.held_out.held_out_record import HeldOutScores
from avs.iqa.held_out.held_out_scores import write_held_out_scores
from avs.iqa.held_out.held_out_settings import HeldOutJob
from avs.iqa.render_statistics.regression_fit import fit_statistics
from avs.iqa.render_statistics.regression_settings import RegressionSettings
from avs.iqa.render_statistics.view_geometry import VIEW_GEOMETRY
from avs.selectors.no_reference import NoReferenceSelector
from avs.system.errors import UserError
from avs.system.records import read_record

RESIZE = {"side": "long", "pixels": 56}


@pytest.fixture(scope="module")
def folder(toys, network, tmp_path_factory):
    """Distortion data of two scenes, and the weights of a network and of regressions."""
    made = tmp_path_factory.mktemp("held_out") / "toys_held_out"
    made.mkdir()
    for toy in toys:
        write_distortions(made / f"{toy.scene}.safetensors", toy)
    save_network(made / "network", network)
    data = [made / "toy_2.safetensors"]
    settings = RegressionSettings(resize=RESIZE)
    fit_statistics(data, data, made / "regressions", made / "card.json", settings, lambda _: None)
    return made


NAMED = {"method": "ours-repvit", "label": "Ours-RepViT"}


def score(folder, out, **changes):
    network = {
        "method": "ours-repvit",
        "label": "Ours-RepViT",
        "backbone": "repvit_m0_9",
        "references": {},
        "resize": RESIZE,
    }
    values = {
        "device": "cpu",
        "evaluation": {"references": {"none": {"count": 0}}},
        "networks": [network | {"precision": "float32"}],
        "metrics": [{"method": "piqe", "selector": {"resize": RESIZE}}],
        "statistics": {"resize": RESIZE},
        **changes,
    }
    weights = {"ours-repvit": folder / "network", "statistics": folder / "regressions"}
    paths = [folder / f"{name}.safetensors" for name in ("toy_1", "toy_2")]
    write_held_out_scores(*paths, HeldOutJob.model_validate(values), weights, out, lambda _: None)
    return read_record(out, HeldOutScores)


def test_the_record_has_every_predictor_once(folder, toys, tmp_path):
    record = score(folder, tmp_path / "a.json")
    assert (record.dataset, record.scene, record.other_scene) == ("toys_held_out", "toy_1", "toy_2")
    assert record.ssim == pytest.approx(toys[0].similarity)
    assert record.candidate == toys[0].candidates.tolist()
    found = {each.identifier: each for each in record.scored}
    assert list(found) == [
        *("ours-repvit", "ours-repvit/none", "piqe", "statistics", "statistics/pixels"),
        *("gradient", "opacity", "distance"),
    ]
    for each in found.values():
        assert np.isfinite(each.scores).all()
        assert len(each.scores) == len(toys[0])
        assert (each.pixel_error is not None) == (each.kind in ("network", "references"))
    column = toys[0].geometry[:, VIEW_GEOMETRY.index("opacity")]
    assert found["opacity"].scores == column.tolist()


def test_equal_data_give_equal_bytes(folder, tmp_path):
    for name in ("a", "b"):
        score(folder, tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_metric_that_fails_leaves_the_others(folder, tmp_path):
    mistyped = {"method": "piqe", "selector": {"resise": RESIZE}}
    record = score(folder, tmp_path / "a", networks=[], metrics=[mistyped], statistics=None)
    failed, *others = record.scored
    assert failed.scores is None
    assert "selectors.piqe.resise" in failed.failure
    assert [each.identifier for each in others] == ["gradient", "opacity", "distance"]


@pytest.mark.parametrize("wrong", [lambda images: images.mean(), lambda images: np.full(len(images), np.nan)])
def test_qualities_that_are_no_score_for_each_image_are_a_failure(folder, tmp_path, monkeypatch, wrong):
    monkeypatch.setattr(NoReferenceSelector, "quality", lambda self, images: wrong(images))
    failed, *_ = score(folder, tmp_path / "a", networks=[], statistics=None).scored
    assert failed.scores is None
    assert "finite scores, one for each image" in failed.failure


def test_a_metric_that_changes_a_setting_of_torch_is_a_failure_and_the_others_go_on_without(
    folder, tmp_path, monkeypatch
):
    monkeypatch.setattr(NoReferenceSelector, "quality", lambda self, images: torch.set_default_dtype(torch.float64))
    failed, *_ = score(folder, tmp_path / "a", networks=[], statistics=None).scored
    assert failed.scores is None
    assert "changed settings of torch for all that follows: the default type" in failed.failure
    assert torch.get_default_dtype() == torch.float32


def test_what_a_reader_should_know_of_weights_is_in_the_record(folder, tmp_path):
    found = {each.identifier: each.notes for each in score(folder, tmp_path / "a").scored}
    assert found["ours-repvit"][0].startswith("Ours-RepViT: weights of a training that is not recorded")
    assert found["statistics"][0].startswith("Render statistics: ")
    assert found["ours-repvit/none"] == found["statistics/pixels"] == found["gradient"] == []


def test_regressions_that_see_pixels_alone_have_one_row(folder, tmp_path):
    settings = RegressionSettings(resize=RESIZE, sees=())
    data = [folder / "toy_2.safetensors"]
    fit_statistics(data, data, tmp_path / "blind", tmp_path / "card.json", settings, lambda _: None)
    (tmp_path / "regressions").write_bytes((tmp_path / "blind").read_bytes())
    for name in ("toy_1.safetensors", "toy_2.safetensors"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    record = score(tmp_path, tmp_path / "out", networks=[], metrics=[], statistics=settings.model_dump(mode="json"))
    assert [each.label for each in record.scored if each.kind == "regression"] == ["Render statistics, pixels alone"]


def test_weights_of_another_backbone_are_one_line(folder, tmp_path):
    network = {
        "method": "ours-repvit",
        "label": "Ours-RepViT",
        "backbone": "tf_efficientnet_lite0",
        "references": {},
        "resize": RESIZE,
    }
    with pytest.raises(UserError, match="where tf_efficientnet_lite0 is needed"):
        score(folder, tmp_path / "a", networks=[network | {"precision": "float32"}])
