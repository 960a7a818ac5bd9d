import json
import os

import numpy as np
import pytest
import safetensors.torch
import torch

from avs.iqa.cross_reference import network as network_module
from avs.iqa.cross_reference import training as training_module
from avs.iqa.cross_reference.backbones import RepViT
from avs.iqa.cross_reference.distortions import write_distortions
from avs.iqa.cross_reference.network import build_network
from avs.iqa.cross_reference.scorer_checkpoint import load_network, read_training
from avs.iqa.cross_reference.scorer_settings import (
    DINOv2Settings,
    ReferenceSettings,
    RepViTSettings,
    ScorerSettings,
    TrainingSettings,
)
from avs.iqa.cross_reference.training import CHECKPOINT, train
from avs.iqa.cross_reference.training_batches import Sampler
from avs.iqa.cross_reference.training_loss import centered_loss, predicted_maps
from avs.iqa.resizing import ResizeSettings
from avs.system.compatibility import prepare_torchvision
from avs.system.errors import UserError
from avs.system.weights.cache import VARIABLE
from tests import tolerances

SETTINGS = ScorerSettings(
    training=TrainingSettings(
        backbone_weights="scratch",
        backbone_frozen=True,
        cache_features=True,
        resize=ResizeSettings(pixels=56),
        crop=28,
        batch=4,
        queries_per_set=4,
        steps=12,
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


def _settings(**changes):
    return SETTINGS.model_copy(update={"training": SETTINGS.training.model_copy(update=changes)})


def test_training_lowers_the_error_and_repeats_to_the_bit(paths, tmp_path):
    weights, card, lines = _train(paths, tmp_path / "a")
    other_weights, other_card, _ = _train(paths, tmp_path / "b")
    assert weights.read_bytes() == other_weights.read_bytes()
    assert card.read_bytes() == other_card.read_bytes()
    content = json.loads(card.read_text())
    errors = [point["training"] for point in content["mean_absolute_error"]]
    assert [point["step"] for point in content["mean_absolute_error"]] == [4, 8, 12]
    assert errors[-1] < 0.9 * errors[0]
    assert content["backbone_weights"] == "random"
    assert content["held_out"]["images"] == 24
    assert -1 <= content["held_out"]["candidate_spearman"] <= 1
    assert len(lines) == 3
    training = read_training(weights)
    assert (training.scenes, training.held_out, training.steps, training.backbone) == (1, 1, 12, None)
    assert training.candidate_spearman == content["held_out"]["candidate_spearman"]


def test_centered_loss_sees_the_order_within_a_set_alone():
    true = torch.rand(2, 3, 4, 4, generator=torch.Generator().manual_seed(0))
    shifted = true + torch.tensor([0.3, -0.2])[:, None, None, None]
    assert float(centered_loss(shifted, true)) == pytest.approx(0, abs=1e-6)
    exchanged = true[:, [1, 0, 2]]
    scores = true.double().mean(dim=(2, 3))
    expected = (scores[:, [1, 0, 2]] - scores).abs().mean()  # means of sets are equal and drop out
    assert float(centered_loss(exchanged, true)) == pytest.approx(float(expected), rel=1e-5)


def test_centered_loss_is_part_of_the_training(paths, tmp_path):
    plain = _train(paths, tmp_path / "plain", _settings(steps=2, evaluations=1))[0]
    centered = _train(paths, tmp_path / "centered", _settings(steps=2, evaluations=1, centered=1.0))[0]
    assert plain.read_bytes() != centered.read_bytes()
    with pytest.raises(ValueError, match="queries_per_set must be 2 or more"):
        TrainingSettings(centered=1.0)


def test_frozen_random_backbone_keeps_its_convolutions(paths, tmp_path):
    weights, _, _ = _train(paths, tmp_path / "frozen", _settings(cache_features=False, steps=1, evaluations=1))
    network = load_network(weights)
    assert not network.training
    trained = dict(network.backbone.named_modules())
    initial = dict(build_network(SETTINGS.network, SETTINGS.seed).backbone.named_modules())
    for name, module in initial.items():
        if isinstance(module, torch.nn.Conv2d):
            assert torch.equal(trained[name].weight, module.weight)
        if isinstance(module, torch.nn.BatchNorm2d):
            assert not torch.equal(trained[name].running_var, module.running_var)
            assert trained[name].weight.any()


def test_a_frozen_backbone_sees_some_images_after_others(toys, monkeypatch):
    network = build_network(SETTINGS.network, SETTINGS.seed).eval()
    batch = Sampler(list(toys), _settings(crop=56).training, np.random.default_rng(0)).batch()
    together = predicted_maps(network, batch)
    network.backbone.requires_grad_(False)
    monkeypatch.setattr(network_module, "ENCODED_AT_ONCE", 3)
    apart = predicted_maps(network, batch)
    torch.testing.assert_close(apart, together, rtol=0, atol=tolerances.FLOAT32_NETWORK)
    apart.mean().backward()
    assert all(parameter.grad is None for parameter in network.backbone.parameters())
    assert network.projections[0].weight.grad.abs().sum() > 0


def test_random_backbone_is_trained_unless_told_otherwise(paths, tmp_path):
    settings = _settings(backbone_frozen=None, cache_features=False, steps=2, evaluations=1)
    first, second = (_train(paths, tmp_path / name, settings)[0] for name in "ab")
    assert first.read_bytes() == second.read_bytes()
    trained = load_network(first).backbone.state_dict()
    initial = build_network(SETTINGS.network, SETTINGS.seed).backbone.state_dict()
    changed = [key for key in initial if not torch.equal(trained[key], initial[key])]
    assert "stem.conv1.c.weight" in changed
    assert "stem.conv1.bn.running_mean" in changed


def test_standardized_channels_have_mean_0_and_deviation_1_and_are_kept(paths, toys, tmp_path):
    network = RepViTSettings(standardized=True)
    settings = _settings(crop=56, steps=1, evaluations=1).model_copy(update={"network": network})
    trained = load_network(_train(paths, tmp_path / "out", settings)[0])
    with torch.no_grad():
        images = torch.from_numpy(np.stack(toys[0].photographs)).permute(0, 3, 1, 2) / 255
        features = trained.features(images).flatten(0, 2)
    standard = (features - trained.feature_means) / trained.feature_deviations
    middle = standard.quantile(0.5, dim=1)
    assert float(middle.abs().mean()) < 0.5
    assert float(standard.std(dim=0).median()) == pytest.approx(1, abs=0.3)


def test_pretrained_backbone_is_frozen_as_it_is(paths, tmp_path, monkeypatch):
    path = tmp_path / "timm" / "repvit_m0_9.dist_450e_in1k.safetensors"
    path.parent.mkdir()
    prepare_torchvision()
    import timm

    model = timm.create_model("repvit_m0_9", num_classes=0)
    safetensors.torch.save_file({key: value.contiguous() for key, value in model.state_dict().items()}, path)
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    weights, card, _ = _train(
        paths, tmp_path / "out", _settings(backbone_weights="auto", backbone_frozen=None, steps=2, evaluations=1)
    )
    backbone = RepViT("A", path).state_dict()
    trained = load_network(weights).backbone.state_dict()
    assert all(torch.equal(trained[key], backbone[key]) for key in backbone)
    assert json.loads(card.read_text())["backbone_weights"]["file"] == path.name


def test_dinov2_is_trained_by_the_same_code(paths, tmp_path):
    settings = _settings(steps=6, evaluations=2, learning_rate=2e-4).model_copy(update={"network": DINOv2Settings()})
    weights, card, _ = _train(paths, tmp_path / "dinov2", settings)
    network = load_network(weights, backbone="vit_small_patch14_dinov2")
    scales = [value for key, value in network.backbone.state_dict().items() if key.endswith("gamma")]
    assert len(scales) == 24
    assert all((value == 1).all() for value in scales)
    errors = [point["training"] for point in json.loads(card.read_text())["mean_absolute_error"]]
    assert errors[-1] < errors[0]


def test_features_three_tokens_wide_are_not_taken_for_colours(paths, tmp_path):
    _, card, _ = _train(paths, tmp_path / "three", _settings(crop=42, steps=1, evaluations=1))
    assert len(json.loads(card.read_text())["mean_absolute_error"]) == 1


def test_held_out_scene_must_be_another(paths, tmp_path):
    with pytest.raises(UserError, match="both for training and held out"):
        _train([paths[0], paths[0]], tmp_path / "same")


def test_absent_pretrained_weights_are_an_error_only_if_demanded(paths, tmp_path, monkeypatch):
    monkeypatch.setattr("avs.iqa.cross_reference.training.find_weights", lambda *_: None)
    with pytest.raises(UserError, match="no local file"):
        _train(paths, tmp_path / "pretrained", _settings(backbone_weights="pretrained"))


class Stopped(Exception):
    pass


def _stopped_at(paths, folder, step, settings):
    """Train until ``step``, where the process ends; a checkpoint is written at each."""
    folder.mkdir()

    def stop(line):
        if line.startswith(f"step {step} of") and "error" not in line:
            raise Stopped

    with pytest.raises(Stopped):
        train(paths[:1], paths[1:], folder / "weights.safetensors", folder / "card.json", settings, stop)


def _gone_on(paths, folder, settings):
    lines = []
    train(paths[:1], paths[1:], folder / "weights.safetensors", folder / "card.json", settings, lines.append)
    return lines


@pytest.mark.parametrize(
    "changes",
    [
        {"centered": 1.0, "schedule": "cosine", "warmup": 3},
        {"backbone_frozen": None, "cache_features": False, "steps": 7},
        {"references": ReferenceSettings(count=2, choice="nearest"), "centered": 1.0},
    ],
)
def test_a_training_that_was_killed_goes_on_to_the_same_bits(paths, tmp_path, monkeypatch, changes):
    settings = _settings(**changes)
    whole = _train(paths, tmp_path / "whole", settings)
    monkeypatch.setattr(training_module, "SECONDS_BETWEEN", 0.0)
    killed = tmp_path / "killed"
    _stopped_at(paths, killed, 6, settings)
    assert not (killed / "weights.safetensors").exists()
    lines = _gone_on(paths, killed, settings)
    assert lines[0] == f"goes on from step 6 of {killed / CHECKPOINT}"
    assert (killed / "weights.safetensors").read_bytes() == whole[0].read_bytes()
    assert (killed / "card.json").read_bytes() == whole[1].read_bytes()
    assert sorted(path.name for path in killed.iterdir()) == ["card.json", "weights.safetensors"]


def test_a_checkpoint_of_something_else_is_left_in_one_line(paths, tmp_path, monkeypatch):
    whole = _train(paths, tmp_path / "whole")[0].read_bytes()
    monkeypatch.setattr(training_module, "SECONDS_BETWEEN", 0.0)
    killed = tmp_path / "killed"
    _stopped_at(paths, killed, 6, _settings(learning_rate=1e-3))
    assert "is of other data, settings or code" in _gone_on(paths, killed, SETTINGS)[0]
    assert (killed / "weights.safetensors").read_bytes() == whole
    damaged = tmp_path / "damaged"
    _stopped_at(paths, damaged, 6, SETTINGS)
    content = bytearray((damaged / CHECKPOINT).read_bytes())
    content[-5] ^= 1
    (damaged / CHECKPOINT).write_bytes(content)
    assert "was changed after it was written" in _gone_on(paths, damaged, SETTINGS)[0]
    assert (damaged / "weights.safetensors").read_bytes() == whole


def _errors(card):
    content = json.loads(card.read_text())["mean_absolute_error"]
    return [point[name] for point in content for name in ("training", "held_out")]


def test_the_choice_of_references_reaches_the_training(paths, tmp_path):
    near, drawn = (
        _train(paths, tmp_path / choice, _settings(references=ReferenceSettings(count=2, choice=choice)))
        for choice in ("nearest", "random")
    )
    assert near[0].read_bytes() != drawn[0].read_bytes()
    told = [json.loads(card.read_text())["held_out"]["pearson"] for _, card, _ in (near, drawn)]
    assert told[0] != told[1]


@pytest.mark.parametrize("choice", ["random", "nearest"])
def test_two_processes_that_share_three_sets_have_the_errors_of_one(paths, tmp_path, choice):
    references = ReferenceSettings(choice=choice)
    changes = {"batch": 6, "queries_per_set": 2, "crop": 56, "centered": 1.0, "learning_rate": 1e-3}
    settings = _settings(references=references, **changes)
    # Without standard channels the features of these pictures hardly differ, and gradients are rounding.
    settings = settings.model_copy(update={"network": RepViTSettings(standardized=True)})
    alone = _train(paths, tmp_path / "alone", settings)[1]
    training = settings.training.model_copy(update={"processes": 2})
    shared = _train(paths, tmp_path / "shared", settings.model_copy(update={"training": training}))[1]
    assert _errors(shared) == pytest.approx(_errors(alone), rel=tolerances.SHARED_TRAINING)
    assert _errors(alone)[-2] < _errors(alone)[0]


def test_what_processes_cannot_share_is_refused(paths, tmp_path):
    with pytest.raises(UserError, match="a batch has 1 sets of queries to share"):
        _train(paths, tmp_path / "few", _settings(processes=2))
    with pytest.raises(UserError, match="a backbone that is trained"):
        _train(paths, tmp_path / "trained", _settings(processes=2, queries_per_set=2, backbone_frozen=False))


def test_a_process_that_ends_before_its_time_ends_the_training(paths, tmp_path, monkeypatch):
    monkeypatch.setattr(training_module, "_help", _die)
    with pytest.raises(UserError, match="one of 2 processes ended before its time"):
        _train(paths, tmp_path / "died", _settings(processes=2, queries_per_set=2))


def _die(group, told):
    os._exit(3)


def test_bfloat16_trains(paths, tmp_path):
    errors = _errors(_train(paths, tmp_path / "half", _settings(precision="bfloat16"))[1])
    assert errors[-2] < 0.9 * errors[0]
