"""CrossScore's checkpoint: its names of parameters, its architecture, and what is refused."""

import collections
import math
import pathlib
import pickle
import sys
import types

import pytest
import torch
from torch import nn
from torch.nn import functional

from avs.iqa.cross_reference.crossscore import read_crossscore
from avs.iqa.cross_reference.scorer_checkpoint import load_network
from avs.system.compatibility import prepare_torchvision
from avs.system.errors import UserError
from tests.tolerances import FLOAT32_NETWORK, FLOAT32_TRANSFORMER

WIDTH, SIDE = 384, 40


def transformer(seed=0):
    """Return DINOv2-small of the transformers library, with random weights of which all count."""
    prepare_torchvision()
    from transformers import Dinov2Config, Dinov2Model

    torch.manual_seed(seed)
    config = Dinov2Config(hidden_size=WIDTH, num_attention_heads=6, num_hidden_layers=12, image_size=518, patch_size=14)
    model = Dinov2Model(config).eval()
    with torch.no_grad():
        for parameter in model.parameters():
            parameter.add_(0.02 * torch.randn_like(parameter))
    return model


def published_names(model):
    """Return a transformer's weights by their names in transformers 4.33, with which CrossScore was trained."""
    names = {
        "q_proj": "attention.query",
        "k_proj": "attention.key",
        "v_proj": "attention.value",
        "o_proj": "output.dense",
    }
    state = {}
    for key, value in model.state_dict().items():
        for new, old in names.items():
            key = key.replace(f".attention.{new}.", f".attention.{old}.")
        state[f"model.backbone.{key}"] = value
    return state


class Behind(nn.Module):
    """What CrossScore puts behind its backbone, out of torch's own layers."""

    def __init__(self):
        super().__init__()
        layer = nn.TransformerDecoderLayer(WIDTH, 8, WIDTH, dropout=0.0, batch_first=True)
        self.attn = nn.TransformerDecoder(layer, 2)
        self.head = nn.Sequential(nn.Linear(WIDTH, WIDTH), nn.LeakyReLU(), nn.Linear(WIDTH, 196), nn.Sigmoid())


@pytest.fixture(scope="module")
def parts():
    """The published network with random weights: backbone, what follows it, position codes."""
    backbone = transformer()
    torch.manual_seed(1)
    behind = Behind().eval()
    with torch.no_grad():
        for parameter in behind.attn.parameters():
            parameter.add_(0.05 * torch.randn_like(parameter))
    return backbone, behind, torch.randn(1, SIDE, SIDE, WIDTH)


def content(parts, **others):
    """Return what Lightning saves of such a network."""
    backbone, behind, codes = parts
    state = published_names(backbone) | {f"model.ref_cross.{key}": value for key, value in behind.state_dict().items()}
    state |= {"model.pos_enc_fn.PE": codes, "model.img_mean_std": torch.zeros(6)}
    moments = {0: {"step": torch.tensor(3.0), "exp_avg": torch.zeros(5)}}
    return {
        "epoch": 8,
        "pytorch-lightning_version": "2.1.3",
        "state_dict": state,
        "optimizer_states": [{"state": moments, "param_groups": [{"lr": 5e-4, "params": [0]}]}],
        "hyper_parameters": {"model": {"patch_size": 14}},
        **others,
    }


@pytest.fixture(scope="module")
def checkpoint(parts, tmp_path_factory):
    path = tmp_path_factory.mktemp("crossscore") / "small.ckpt"
    torch.save(content(parts), path)
    return path


def pictures(count, height, width, seed=2):
    return torch.rand(count, 3, height, width, generator=torch.Generator().manual_seed(seed))


def normalized(images):
    mean, deviation = (torch.tensor(v).view(1, 3, 1, 1) for v in ((0.485, 0.456, 0.406), (0.229, 0.224, 0.225)))
    return (images - mean) / deviation


@pytest.mark.parametrize(("height", "width"), [(70, 98), (60, 45), (28, 518)])
def test_backbone_is_that_of_transformers(parts, checkpoint, height, width):
    network = read_crossscore(checkpoint)
    images = pictures(2, height, width)
    rows, columns = height // 14, width // 14
    with torch.inference_mode():
        expected = parts[0](normalized(images)).last_hidden_state[:, 1:]
        actual = network.features(images)
    assert actual.shape == (2, rows, columns, WIDTH)
    torch.testing.assert_close(actual.flatten(1, 2), expected, rtol=0, atol=FLOAT32_TRANSFORMER)


def test_no_position_is_resized_at_518_pixels(checkpoint):
    backbone = read_crossscore(checkpoint).backbone
    assert torch.equal(backbone._position_embeddings(37, 37), backbone.positions[:, 1:])


def test_map_is_that_of_the_publication(parts, checkpoint):
    """Query and references through torch's own layers, in the order of CrossScore's forward pass."""
    backbone, behind, codes = parts
    network = read_crossscore(checkpoint)
    rows, columns = 4, 6
    images = pictures(4, 14 * rows, 14 * columns)
    with torch.inference_mode():
        grid = functional.interpolate(codes.permute(0, 3, 1, 2), (rows, columns), mode="bilinear", align_corners=True)
        tokens = backbone(normalized(images)).last_hidden_state[:, 1:] + grid.flatten(2).transpose(1, 2)
        patches = behind.head(behind.attn(tokens[:1], tokens[1:].reshape(1, -1, WIDTH)))
        expected = torch.empty(1, 14 * rows, 14 * columns)
        for number, patch in enumerate(patches[0]):
            top, left = 14 * (number // columns), 14 * (number % columns)
            expected[0, top : top + 14, left : left + 14] = patch.view(14, 14)
        own = network.encode(images)
        actual = network.predict(own[:1], network.memory(own[1:].reshape(1, -1, WIDTH)))
    torch.testing.assert_close(actual, expected, rtol=0, atol=FLOAT32_NETWORK)
    assert float(expected.std()) > 100 * FLOAT32_NETWORK


def test_number_of_parameters_is_that_of_the_publication(checkpoint):
    """DINOv2-small has 22,056,576, of which 384 are a mask that serves its training only; what follows 3.2 million."""
    network = read_crossscore(checkpoint)
    sizes = {
        part: sum(p.numel() for p in getattr(network, part).parameters()) for part in ("backbone", "decoder", "head")
    }
    assert sizes["backbone"] == 22_056_576 - WIDTH
    assert sizes["decoder"] + sizes["head"] == 2 * (8 * WIDTH**2 + 8 * WIDTH + 2 * WIDTH**2 + 2 * WIDTH + 6 * WIDTH) + (
        WIDTH**2 + WIDTH + WIDTH * 196 + 196
    )
    assert math.isclose(sizes["decoder"] + sizes["head"], 3.2e6, rel_tol=0.02)
    assert network.positions.codes.shape == (1, WIDTH, SIDE, SIDE)


def test_hyper_parameters_of_other_libraries_are_passed_over(parts, tmp_path, monkeypatch):
    module = types.ModuleType("omegaconf.dictconfig")

    class DictConfig:
        def __init__(self):
            self.values = {"patch_size": 14}

    DictConfig.__module__, DictConfig.__qualname__ = module.__name__, "DictConfig"
    module.DictConfig = DictConfig
    monkeypatch.setitem(sys.modules, "omegaconf", types.ModuleType("omegaconf"))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    others = [collections.defaultdict(list, a=[1]), pathlib.PurePosixPath("/data"), int, {"b": 2}]
    values = content(parts, hyper_parameters=DictConfig(), others=others)
    values["state_dict"] = {key: torch.zeros(1).expand(value.shape) for key, value in values["state_dict"].items()}
    torch.save(values, tmp_path / "omegaconf.ckpt")
    monkeypatch.undo()
    assert read_crossscore(tmp_path / "omegaconf.ckpt").settings.backbone == "vit_small_patch14_dinov2"


class Malicious:
    """Would make a folder if it were unpickled as usual."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        import os

        return os.mkdir, (str(self.path),)


def test_bad_checkpoints_are_refused_with_one_line(parts, tmp_path):
    trap = tmp_path / "trap"
    # one number in the shape of each weight, so that the files are small
    state = {key: torch.zeros(1).expand(value.shape) for key, value in content(parts)["state_dict"].items()}
    torch.save({"state_dict": state, "callbacks": Malicious(trap)}, tmp_path / "malicious")
    good = tmp_path / "good"
    torch.save({"state_dict": state}, good)
    assert read_crossscore(good).settings.backbone == "vit_small_patch14_dinov2"
    (tmp_path / "truncated").write_bytes(good.read_bytes()[: good.stat().st_size // 2])
    (tmp_path / "overwritten").write_bytes(good.read_bytes()[:200] + b"\xff" * 200 + good.read_bytes()[400:])
    good.unlink()
    torch.save({"x": torch.zeros(1)}, tmp_path / "foreign")
    torch.save({"state_dict": {"model.x": torch.zeros(1)}}, tmp_path / "other_names")
    torch.save({"state_dict": {**state, "model.pos_enc_fn.PE": torch.zeros(3)}}, tmp_path / "other_dimensions")
    torch.save({"state_dict": {k: v for k, v in state.items() if ".linear1." not in k}}, tmp_path / "missing_weight")
    torch.save({"state_dict": {k: v[..., :7] for k, v in state.items() if v.ndim}}, tmp_path / "other_shapes")
    names = [path.name for path in tmp_path.iterdir()]
    assert len(names) == 8
    for name in names:
        with pytest.raises(UserError, match=name) as caught:
            read_crossscore(tmp_path / name)
        assert "\n" not in str(caught.value), name
        assert len(str(caught.value)) < 400
    assert not trap.exists()


def test_a_checkpoint_that_is_not_the_published_one_is_refused(checkpoint):
    with pytest.raises(UserError, match=r"not CrossScore's published checkpoint .*; run: avs weights fetch crossscore"):
        load_network(checkpoint)


def test_a_bare_pickle_is_refused(tmp_path):
    path = tmp_path / "bare"
    path.write_bytes(pickle.dumps(Malicious(tmp_path / "trap")))
    with pytest.raises(UserError, match="bare"):
        load_network(path)
    assert not (tmp_path / "trap").exists()
