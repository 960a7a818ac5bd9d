"""LPIPS: state dictionaries load, and give the values of the package."""

from pathlib import Path

import numpy as np
import pytest

from metrics.perceptual import Lpips
from tests import tolerances

torch = pytest.importorskip("torch")


@pytest.fixture(autouse=True)
def torchvision_imports():
    """The caller of LPIPS makes torchvision importable."""
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


def linear(net):
    """The linear layers that the package brings."""
    import lpips

    path = Path(lpips.__file__).parent / "weights" / "v0.1" / f"{net}.pth"
    return torch.load(path, map_location="cpu", weights_only=True)


def metric_of(net, range_, seed=0):
    return Lpips(net, range_, backbone(net, seed), linear(net))


def images(size=64):
    generator = np.random.default_rng(0)
    return generator.random((size, size + 10, 3)), generator.random((size, size + 10, 3))


@pytest.mark.parametrize("range_", ["zero_one", "minus_one"])
def test_local_weights_give_the_value_of_the_package(range_):
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
    metric = metric_of("alex", range_)
    assert metric(first, second) == pytest.approx(expected, rel=tolerances.LPIPS_SAME_NETWORK)
    assert metric(first, first) == 0.0


def test_construction_leaves_the_global_generator_alone():
    weights = backbone("alex"), linear("alex")
    before = torch.get_rng_state()
    metric = Lpips("alex", "minus_one", *weights)
    assert torch.equal(torch.get_rng_state(), before)
    eight_bit = [np.round(image * 255).astype(np.uint8) for image in images()]
    as_float = [image / 255.0 for image in eight_bit]
    assert metric(*eight_bit) == pytest.approx(metric(*as_float), rel=tolerances.LPIPS_SAME_NETWORK)


def test_vgg_loads_in_its_own_layout():
    assert metric_of("vgg", "zero_one")(*images()) > 0


def test_weights_of_another_network_are_refused_in_one_line():
    with pytest.raises(ValueError, match="is missing") as error:
        Lpips("vgg", "minus_one", backbone("alex"), linear("vgg"))
    assert "\n" not in str(error.value)
    with pytest.raises(ValueError, match="not the weights of alex") as error:
        Lpips("alex", "minus_one", backbone("alex"), linear("vgg"))
    assert "\n" not in str(error.value)


def test_small_images_are_refused():
    with pytest.raises(ValueError, match="64 pixels"):
        metric_of("alex", "minus_one")(*images(size=63))
