"""LPIPS through the package ``lpips``, with weights that the caller has read.

``lpips`` imports torchvision. Where torchvision does not import beside the installed torch, the caller cures that
before it makes an ``Lpips``.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from metrics.image import Image, check_pair

if TYPE_CHECKING:
    import torch

Net = Literal["vgg", "alex"]
Range = Literal["zero_one", "minus_one"]

_SMALLEST = 64


class Lpips:
    """Learned perceptual image patch similarity (Zhang et al. 2018, version 0.1); lower is better.

    Args:
        net: the backbone, ``vgg`` (as 3DGS) or ``alex`` (as the authors recommend for evaluation).
        range: what the network is fed with. ``minus_one`` is the correct -1..1; ``zero_one`` feeds 0..1 as the
            evaluation code of 3DGS does, whose values are lower (graphdeco-inria/gaussian-splatting, issue 1239).
        backbone: state dictionary of torchvision's ``vgg16`` or ``alexnet``; the convolutions are enough.
        linear: state dictionary of the linear layers, as the package ``lpips`` stores them.
        device: where to compute, such as ``cpu`` or ``cuda``.

    Raises:
        ValueError: a parameter is missing, or of another network.
    """

    def __init__(
        self,
        net: Net,
        range: Range,
        backbone: Mapping[str, torch.Tensor],
        linear: Mapping[str, torch.Tensor],
        device: str = "cpu",
    ) -> None:
        self._model = _model(net, backbone, linear).to(device)
        self._minus_one = range == "minus_one"
        self._device = device

    def __call__(self, image: Image, reference: Image) -> float:
        """Return the distance of two images ``[height, width, 3]``, float in 0..1 or uint8, of at least 64x64 pixels.

        Raises:
            ValueError: wrong shapes, types or value ranges (``metrics.image.check_pair``), or a side under 64 pixels.
        """
        import torch

        check_pair(image, reference)
        if min(image.shape[:2]) < _SMALLEST:
            raise ValueError(f"the images have the shape {image.shape}; LPIPS needs at least {_SMALLEST} pixels a side")
        with torch.inference_mode():
            distance = self._model(self._fed(image), self._fed(reference))
        return float(distance.item())

    def _fed(self, image: Image) -> torch.Tensor:
        import torch

        unit = image.astype(np.float32)
        if image.dtype == np.uint8:
            unit /= np.float32(255.0)
        tensor = torch.from_numpy(np.ascontiguousarray(unit.transpose(2, 0, 1)))[None].to(self._device)
        return tensor * 2.0 - 1.0 if self._minus_one else tensor


def _model(net: Net, backbone: Mapping[str, torch.Tensor], linear: Mapping[str, torch.Tensor]) -> torch.nn.Module:
    """Build the network without a random start: that would take seconds for VGG's unused classifier, and global RNG."""
    import lpips
    import torch

    with torch.device("meta"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # lpips calls torchvision by parameters that are deprecated since 0.13
        model = lpips.LPIPS(net=net, pretrained=False, pnet_rand=True, verbose=False)
    model.scaling_layer = lpips.ScalingLayer()
    state: dict[str, Any] = dict(linear)
    for name in model.net.state_dict():  # slice2.5.weight holds features.5.weight
        source = "features." + name.split(".", 1)[1]
        if source not in backbone:
            raise ValueError(f"{source} is missing in the weights of {net}, which torchvision's classifier has")
        state[f"net.{name}"] = backbone[source]
    state |= {f"scaling_layer.{name}": value for name, value in model.scaling_layer.state_dict().items()}
    # The module list repeats the linear layers under a second name; strict loading covers both.
    state |= {name.replace("lin", "lins.", 1): value for name, value in state.items() if name.startswith("lin")}
    try:
        model.load_state_dict(state, assign=True)
    except RuntimeError as error:
        raise ValueError(f"not the weights of {net}: {' '.join(str(error).split())}") from error
    module: torch.nn.Module = model.eval().requires_grad_(False)
    return module
