import json

import pytest
import safetensors.torch
import torch

from avs.iqa.cross_reference.network import build_network
from avs.iqa.cross_reference.scorer_checkpoint import load_network, save_network
from avs.iqa.cross_reference.scorer_settings import DINOv2Settings
from avs.system.errors import UserError

REPVIT = {"backbone": "repvit_m0_9"}


@pytest.fixture(scope="module")
def saved(network, tmp_path_factory):
    path = tmp_path_factory.mktemp("scorer") / "scorer.safetensors"
    save_network(path, network)
    return path


def test_network_is_read_as_it_was_written(network, saved):
    read = load_network(saved)
    assert read.settings == network.settings
    assert not read.training
    expected, actual = network.state_dict(), read.state_dict()
    assert expected.keys() == actual.keys()
    assert all(torch.equal(expected[key], actual[key]) for key in expected)
    assert "positions.codes" in actual


def test_equal_networks_give_equal_bytes(network, saved, tmp_path):
    save_network(tmp_path / "again.safetensors", network)
    assert (tmp_path / "again.safetensors").read_bytes() == saved.read_bytes()


def test_network_of_another_architecture_is_refused(saved):
    line = "holds a network on repvit_m0_9, where vit_small_patch14_dinov2 is needed; pass the weights of the scorer"
    with pytest.raises(UserError, match=line):
        load_network(saved, backbone="vit_small_patch14_dinov2")
    assert load_network(saved, backbone="repvit_m0_9").settings.backbone == "repvit_m0_9"


def test_dinov2_is_read_as_it_was_written(tmp_path):
    network = build_network(DINOv2Settings(), seed=5)
    save_network(tmp_path / "dinov2.safetensors", network)
    read = load_network(tmp_path / "dinov2.safetensors", backbone="vit_small_patch14_dinov2")
    assert read.settings == network.settings
    assert all(torch.equal(value, read.state_dict()[key]) for key, value in network.state_dict().items())


def _write(path, state, header):
    safetensors.torch.save_file(state, path, metadata={"network": json.dumps(header)})


def test_bad_files_are_refused_with_one_line(saved, tmp_path):
    state = safetensors.torch.load_file(saved)
    header = {"format": "avs-cross-reference-1", "settings": REPVIT}
    (tmp_path / "truncated").write_bytes(saved.read_bytes()[: saved.stat().st_size // 2])
    (tmp_path / "no_safetensors").write_bytes(b"\x80\x04pickle" * 50)
    (tmp_path / "empty").write_bytes(b"")
    safetensors.torch.save_file({"x": torch.zeros(1)}, tmp_path / "foreign")
    _write(tmp_path / "other_format", state, {**header, "format": "avs-cross-reference-9"})
    _write(tmp_path / "other_shapes", state, {**header, "settings": {**REPVIT, "channels": 128}})
    _write(tmp_path / "missing_weight", {k: v for k, v in state.items() if k != "head.0.weight"}, header)
    _write(tmp_path / "unknown_setting", state, {**header, "settings": {**REPVIT, "depth": 3}})
    names = [path.name for path in tmp_path.iterdir()]
    assert len(names) == 8
    for name in (*names, "absent"):
        with pytest.raises(UserError, match=name) as caught:
            load_network(tmp_path / name)
        assert "\n" not in str(caught.value), name
