"""LPIPS: absence is told at once and without a network; local weights load and compute."""

import socket
import urllib.request

import numpy as np
import pytest

from metrics import perceptual
from metrics.perceptual import Lpips, lpips_absent_reason
from tests import tolerances

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
    from avs.system.compatibility import prepare_torchvision

    prepare_torchvision()


def backbone(net, seed=0):
    """Random weights of the convolutions, in torchvision's naming."""
    import torchvision

    with torch.device("meta"):
        network = {"vgg": torchvision.models.vgg16, "alex": torchvision.models.alexnet}[net]()
    generator = torch.Generator().manual_seed(seed)
    return {
        f"features.{name}": 0.05 * torch.randn(value.shape, generator=generator)
        for name, value in network.features.state_dict().items()
    }


@pytest.fixture
def alexnet(tmp_path):
    path = tmp_path / "random.pth"
    torch.save(backbone("alex"), path)
    return path


def images(size=64):
    generator = np.random.default_rng(0)
    return generator.random((size, size + 10, 3)), generator.random((size, size + 10, 3))


@pytest.mark.parametrize("net", ["vgg", "alex"])
def test_absent_weights_are_told_without_the_network_or_a_path(net, tmp_path):
    reason = lpips_absent_reason(net)
    assert reason is not None
    assert "\n" not in reason
    assert str(tmp_path) not in reason
    assert reason == lpips_absent_reason(net)
    with pytest.raises(FileNotFoundError, match="absent"):
        Lpips(net, "minus_one")


@pytest.mark.parametrize("variable", ["AVS_WEIGHTS", "XDG_CACHE_HOME"])
@pytest.mark.parametrize("net", ["vgg", "alex"])
def test_cache_folder_and_command_are_those_of_the_weights_manager(net, variable, tmp_path, monkeypatch):
    from avs.system.weights import cache, locate, missing

    monkeypatch.delenv("AVS_WEIGHTS")
    monkeypatch.setenv(variable, str(tmp_path / "cache"))
    name = f"lpips-{net}"
    assert lpips_absent_reason(net).endswith(missing([name]).split(": ")[1])
    path = cache.folder() / cache.find(name).path
    path.parent.mkdir(parents=True)
    path.touch()
    assert lpips_absent_reason(net) is None
    assert locate(name) == path


@pytest.mark.parametrize("folder", ["weights/torchvision", "hub/checkpoints"])
def test_weights_are_found_in_both_folders_and_their_hash_is_checked(folder, alexnet, tmp_path, monkeypatch):
    place = tmp_path / folder
    place.mkdir(parents=True)
    target = place / perceptual._BACKBONES["alex"]
    target.write_bytes(alexnet.read_bytes())
    assert lpips_absent_reason("alex") is None
    with pytest.raises(ValueError, match="SHA-256"):
        Lpips("alex", "minus_one")
    import hashlib

    name = f"alexnet-{hashlib.sha256(target.read_bytes()).hexdigest()[:8]}.pth"
    target.rename(place / name)
    monkeypatch.setitem(perceptual._BACKBONES, "alex", name)
    assert Lpips("alex", "minus_one")(*images()) > 0


@pytest.mark.parametrize("range_", ["zero_one", "minus_one"])
def test_local_weights_give_the_value_of_the_package(alexnet, range_):
    import lpips

    expected_model = lpips.LPIPS(net="alex", pnet_rand=True, verbose=False)
    state = backbone("alex")
    expected_model.net.load_state_dict(
        {name: state["features." + name.split(".", 1)[1]] for name in expected_model.net.state_dict()}
    )
    first, second = images()
    tensors = [torch.from_numpy(image.transpose(2, 0, 1)).float()[None] for image in (first, second)]
    with torch.no_grad():
        expected = expected_model(*tensors, normalize=range_ == "minus_one").item()
    metric = Lpips("alex", range_, weights=alexnet)
    assert metric(first, second) == pytest.approx(expected, rel=tolerances.LPIPS_SAME_NETWORK)
    assert metric(first, first) == 0.0


def test_construction_leaves_the_global_generator_alone(alexnet):
    before = torch.get_rng_state()
    metric = Lpips("alex", "minus_one", weights=alexnet)
    assert torch.equal(torch.get_rng_state(), before)
    eight_bit = [np.round(image * 255).astype(np.uint8) for image in images()]
    as_float = [image / 255.0 for image in eight_bit]
    assert metric(*eight_bit) == pytest.approx(metric(*as_float), rel=tolerances.LPIPS_SAME_NETWORK)


def test_vgg_loads_in_its_own_layout(tmp_path):
    path = tmp_path / "random.pth"
    torch.save(backbone("vgg"), path)
    assert Lpips("vgg", "zero_one", weights=path)(*images()) > 0


def test_wrong_or_damaged_weights_are_refused_in_one_line(alexnet, tmp_path):
    with pytest.raises(ValueError, match=r"is missing") as error:
        Lpips("vgg", "minus_one", weights=alexnet)
    assert "\n" not in str(error.value)
    truncated = tmp_path / "truncated.pth"
    truncated.write_bytes(alexnet.read_bytes()[:1000])
    with pytest.raises(ValueError, match="cannot be read") as error:
        Lpips("alex", "minus_one", weights=truncated)
    assert "\n" not in str(error.value)


def test_small_images_are_refused(alexnet):
    with pytest.raises(ValueError, match="64 pixels"):
        Lpips("alex", "minus_one", weights=alexnet)(*images(size=63))
