import json

import pytest

from avs.errors import UserError
from avs.scorer.checkpoint import load_network
from avs.scorer.distortions import write_distortions
from avs.scorer.settings import ResizeSettings, ScorerSettings, TrainingSettings
from avs.scorer.training import train

SETTINGS = ScorerSettings(
    training=TrainingSettings(
        backbone_weights="scratch",
        resize=ResizeSettings(pixels=56),
        crop=28,
        batch=4,
        queries_per_set=4,
        steps=9,
        evaluations=3,
    )
)


@pytest.fixture(scope="module")
def paths(toys, tmp_path_factory):
    folder = tmp_path_factory.mktemp("renders")
    for toy in toys:
        write_distortions(folder / f"{toy.scene}.safetensors", toy)
    return [folder / f"{toy.scene}.safetensors" for toy in toys]


def _train(paths, folder, settings=SETTINGS):
    folder.mkdir()
    lines = []
    train(paths[:1], paths[1:], folder / "weights.safetensors", folder / "card.json", settings, lines.append)
    return folder / "weights.safetensors", folder / "card.json", lines


def test_training_lowers_the_error_and_repeats_to_the_bit(paths, tmp_path):
    weights, card, lines = _train(paths, tmp_path / "a")
    other_weights, other_card, _ = _train(paths, tmp_path / "b")
    assert weights.read_bytes() == other_weights.read_bytes()
    assert card.read_bytes() == other_card.read_bytes()
    content = json.loads(card.read_text())
    errors = [point["training"] for point in content["mean_absolute_error"]]
    assert [point["step"] for point in content["mean_absolute_error"]] == [3, 6, 9]
    assert errors[-1] < 0.9 * errors[0]
    assert content["backbone_weights"] == "random"
    assert content["held_out"]["images"] == 24
    assert -1 <= content["held_out"]["candidate_spearman"] <= 1
    assert len(lines) == 3
    assert not load_network(weights).training


def test_frozen_backbone_keeps_weights_and_statistics(paths, tmp_path, network):
    training = SETTINGS.training.model_copy(update={"backbone_frozen": True, "steps": 2, "evaluations": 1})
    weights, _, _ = _train(paths, tmp_path / "frozen", SETTINGS.model_copy(update={"training": training}))
    trained = load_network(weights).backbone.state_dict()
    from avs.scorer.network import build_network

    initial = build_network(SETTINGS.network, SETTINGS.seed).backbone.state_dict()
    assert all(bool((trained[key] == initial[key]).all()) for key in initial)


def test_held_out_scene_must_be_another(paths, tmp_path):
    with pytest.raises(UserError, match="both for training and held out"):
        _train([paths[0], paths[0]], tmp_path / "same")


def test_absent_pretrained_weights_are_an_error_only_if_demanded(paths, tmp_path, monkeypatch):
    monkeypatch.setattr("avs.scorer.training.find_weights", lambda *_: None)
    training = SETTINGS.training.model_copy(update={"backbone_weights": "pretrained"})
    with pytest.raises(UserError, match="no local file"):
        _train(paths, tmp_path / "pretrained", SETTINGS.model_copy(update={"training": training}))
