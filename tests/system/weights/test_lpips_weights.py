"""The weights of LPIPS: absence is reported at once and without a network; what is there is checked and read."""

import dataclasses
import hashlib
import socket
import urllib.request

import pytest

from avs.system.errors import UserError
from avs.system.weights import cache, locate, missing
from avs.system.weights.lpips_weights import lpips_absent_reason, read_lpips
from avs.system.weights.manifest import MANIFEST

torch = pytest.importorskip("torch")


@pytest.fixture(autouse=True)
def empty_folders(tmp_path, monkeypatch):
    """No weights anywhere, and any use of the network is an error."""

    def refuse(*arguments, **options):
        raise AssertionError("the network was used")

    monkeypatch.setattr(urllib.request, "urlopen", refuse)
    monkeypatch.setattr(torch.hub, "download_url_to_file", refuse)
    monkeypatch.setattr(socket.socket, "connect", refuse)
    monkeypatch.setattr(socket, "getaddrinfo", refuse)
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path / "weights"))
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))


def put(name, folder, tmp_path, state):
    """Save a state dictionary as the file of a manifest entry, and return its path and hash."""
    path = tmp_path / folder / cache.find(name).path.split("/")[1]
    path.parent.mkdir(parents=True)
    torch.save(state, path)
    return path, hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize(("net", "file"), [("vgg", "vgg16-397923af.pth"), ("alex", "alexnet-owt-7be5be79.pth")])
def test_absent_weights_are_reported_without_the_network_or_a_path(net, file):
    assert lpips_absent_reason(net) == f"weights {file} absent: python -m avs weights fetch lpips-{net}"
    with pytest.raises(UserError, match=f"weights lpips-{net}: absent"):
        read_lpips(net)


@pytest.mark.parametrize("variable", ["AVS_WEIGHTS", "XDG_CACHE_HOME"])
@pytest.mark.parametrize("net", ["vgg", "alex"])
def test_cache_folder_and_command_are_those_of_the_weights_manager(net, variable, tmp_path, monkeypatch):
    monkeypatch.delenv("AVS_WEIGHTS")
    monkeypatch.setenv(variable, str(tmp_path / "cache"))
    name = f"lpips-{net}"
    assert lpips_absent_reason(net).endswith(f": {missing([name]).remedy}")
    path = cache.folder() / cache.find(name).path
    path.parent.mkdir(parents=True)
    path.touch()
    assert lpips_absent_reason(net) is None
    assert locate(name) == path


@pytest.mark.parametrize("folder", ["weights/torchvision", "hub/checkpoints"])
def test_weights_are_found_in_both_folders_and_their_hash_is_checked(folder, tmp_path, monkeypatch):
    path, digest = put("lpips-alex", folder, tmp_path, {"features.0.bias": torch.arange(3.0)})
    assert lpips_absent_reason("alex") is None
    with pytest.raises(UserError, match="SHA-256") as error:
        read_lpips("alex")
    assert str(path) in str(error.value)
    monkeypatch.setitem(MANIFEST, "lpips-alex", dataclasses.replace(MANIFEST["lpips-alex"], sha256=digest[:8]))
    backbone, linear = read_lpips("alex")
    assert torch.equal(backbone["features.0.bias"], torch.arange(3.0))
    assert set(linear) == {f"lin{layer}.model.1.weight" for layer in range(5)}


@pytest.mark.parametrize(("state", "fault"), [("text", "holds no dictionary"), ({"a": 1}, "holds no dictionary")])
def test_what_is_no_state_dictionary_is_refused_in_one_line(state, fault, tmp_path, monkeypatch):
    _, digest = put("lpips-vgg", "weights/torchvision", tmp_path, state)
    monkeypatch.setitem(MANIFEST, "lpips-vgg", dataclasses.replace(MANIFEST["lpips-vgg"], sha256=digest[:8]))
    with pytest.raises(UserError, match=fault) as error:
        read_lpips("vgg")
    assert "\n" not in str(error.value)


def test_a_truncated_file_is_refused_in_one_line(tmp_path, monkeypatch):
    path, _ = put("lpips-alex", "weights/torchvision", tmp_path, {"features.0.weight": torch.ones(1000)})
    path.write_bytes(path.read_bytes()[:1000])
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    monkeypatch.setitem(MANIFEST, "lpips-alex", dataclasses.replace(MANIFEST["lpips-alex"], sha256=digest[:8]))
    with pytest.raises(UserError, match="cannot be read") as error:
        read_lpips("alex")
    assert "\n" not in str(error.value)
