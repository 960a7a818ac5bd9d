"""pyiqa's networks with weights from a local file: the same scores as pyiqa's own, no network, no pickle.

The files are made here, from networks with random weights.
"""

import os
import socket

import pytest

from avs.iqa.no_reference.pyiqa_metrics import build
from avs.iqa.no_reference.pyiqa_networks import _random_backbones
from avs.system.compatibility import prepare_torchvision
from avs.system.errors import UserError
from avs.system.weights.manifest import MANIFEST, Weights

torch = pytest.importorskip("torch")

LARGE = pytest.mark.skipif(
    "AVS_TEST_LARGE" not in os.environ, reason="up to half a gigabyte of weights and a minute; AVS_TEST_LARGE=1 runs it"
)
NETWORKS = [
    pytest.param("musiq", "musiq", None, id="musiq"),
    pytest.param("nima", "nima", "params", id="nima", marks=LARGE),
    pytest.param("topiq_nr", "topiq", "params", id="topiq", marks=LARGE),
    pytest.param("tres", "tres", None, id="tres", marks=LARGE),
    pytest.param("maniqa", "maniqa", None, id="maniqa", marks=LARGE),
]


@pytest.fixture(autouse=True)
def without_network(monkeypatch, tmp_path):
    def refuse(*arguments, **options):
        raise AssertionError("the network was used")

    monkeypatch.setattr(socket.socket, "connect", refuse)
    monkeypatch.setattr(socket, "getaddrinfo", refuse)
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path))
    monkeypatch.setenv("TORCH_HOME", str(tmp_path / "torch"))
    prepare_torchvision()


def random_network(metric):
    """Return pyiqa's own metric with random weights."""
    import pyiqa

    with _random_backbones():
        return pyiqa.create_metric(metric, device=torch.device("cpu"), pretrained=False)


@pytest.mark.parametrize(("metric", "name", "wrapper"), NETWORKS)
def test_local_weights_give_the_scores_of_pyiqa(metric, name, wrapper, tmp_path, monkeypatch):
    torch.manual_seed(0)
    expected = random_network(metric)
    entry = Weights("https://example.invalid", "some.pth", "none", "a test")
    monkeypatch.setitem(MANIFEST, name, entry)
    state = dict(expected.net.state_dict())
    torch.save(state if wrapper is None else {wrapper: state}, tmp_path / entry.path)
    before = torch.get_rng_state()
    score = build(metric, name, "cpu")
    assert torch.equal(torch.get_rng_state(), before)
    images = torch.rand(2, 3, 60, 90)
    made = score.__closure__[0].cell_contents
    for network in (expected.net, made.net):
        if hasattr(network, "test_sample"):  # number of crops, each of which costs a second or more
            network.test_sample = 1
    with torch.inference_mode():
        assert torch.equal(score(images), expected(images).reshape(2))


def test_backbone_of_a_network_is_not_downloaded():
    assert random_network("nima").net.base_model is not None


def test_weights_of_another_network_are_refused_in_one_line(tmp_path, monkeypatch):
    entry = Weights("https://example.invalid", "some.pth", "none", "a test")
    monkeypatch.setitem(MANIFEST, "musiq", entry)
    torch.save({"conv_root.weight": torch.zeros(1)}, tmp_path / entry.path)
    with pytest.raises(UserError, match=r"not the weights of MUSIQ \(Missing key") as error:
        build("musiq", "musiq", "cpu")
    assert "\n" not in str(error.value)


def test_absent_weights_are_told():
    with pytest.raises(UserError, match="weights musiq: absent; python -m avs weights fetch musiq"):
        build("musiq", "musiq", "cpu")
