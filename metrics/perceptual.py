"""LPIPS through the package ``lpips``, with backbone weights that are already on the machine.

The package ships its linear layers; the backbones it would download through torchvision, which also means minutes of
waiting where there is no network. Here a backbone is looked for on disk, and its absence is told at once.

``lpips`` imports torchvision. Where torchvision does not import beside the installed torch, the caller cures that
before it makes an ``Lpips``.
"""

from __future__ import annotations

import hashlib
import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from metrics.image import Image, check_pair

if TYPE_CHECKING:
    import torch

Net = Literal["vgg", "alex"]
Range = Literal["zero_one", "minus_one"]

WEIGHTS_VARIABLE = "AVS_WEIGHTS"
"""Environment variable: the cache folder of weights; ``avs/weights`` in the user's folder of caches by default."""

# torchvision's ImageNet classifiers, by their file names; the digits are the first of the file's SHA-256.
_BACKBONES: dict[Net, str] = {"vgg": "vgg16-397923af.pth", "alex": "alexnet-owt-7be5be79.pth"}

_COMMAND = "python -m avs weights fetch lpips"


class Lpips:
    """Learned perceptual image patch similarity (Zhang et al. 2018, version 0.1); lower is better.

    Args:
        net: the backbone, ``vgg`` (as 3DGS) or ``alex`` (as the authors recommend for evaluation).
        range: what the network is fed with. ``minus_one`` is the correct -1..1; ``zero_one`` feeds 0..1 as the
            evaluation code of 3DGS does, whose values are lower (graphdeco-inria/gaussian-splatting, issue 1239).
        device: where to compute, such as ``cpu`` or ``cuda``.
        weights: file of the backbone's weights, a state dictionary in torchvision's naming; None looks for
            torchvision's file in the folders of ``lpips_absent_reason`` and checks its hash.

    Raises:
        FileNotFoundError: the weights are absent; the message is ``lpips_absent_reason``.
        ValueError: the weights are damaged, or of another network.
    """

    def __init__(self, net: Net, range: Range, device: str = "cpu", weights: Path | None = None) -> None:
        self._model = _model(net, weights or _verified(net)).to(device)
        self._minus_one = range == "minus_one"
        self._device = device

    def __call__(self, image: Image, reference: Image) -> float:
        """Return the distance of two images ``[height, width, 3]``, float in 0..1 or uint8, of at least 64x64 pixels.

        Raises:
            ValueError: wrong shapes, types or value ranges (``metrics.image.check_pair``), or a side under 64 pixels.
        """
        import torch

        check_pair(image, reference)
        if min(image.shape[:2]) < 64:
            raise ValueError(f"the images have the shape {image.shape}; LPIPS needs at least 64 pixels a side")
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


def lpips_absent_reason(net: Net) -> str | None:
    """Return None if the weights of ``net`` are on this machine, or one line that says what is missing.

    Looks in the folder ``torchvision`` of the cache folder and in ``hub/checkpoints`` of torch; never at the network.
    The text is the same on every machine, so that a record can hold it.
    """
    if _find(net) is not None:
        return None
    return f"weights {_BACKBONES[net]} absent: {_COMMAND}-{net}"


def _find(net: Net) -> Path | None:
    import torch

    caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    cache = Path(os.environ.get(WEIGHTS_VARIABLE) or caches / "avs" / "weights")
    folders = (cache / "torchvision", Path(torch.hub.get_dir()) / "checkpoints")
    return next((folder / _BACKBONES[net] for folder in folders if (folder / _BACKBONES[net]).is_file()), None)


def _verified(net: Net) -> Path:
    """Find torchvision's file and compare its SHA-256 with the digits in its name."""
    path = _find(net)
    if path is None:
        raise FileNotFoundError(lpips_absent_reason(net))
    with open(path, "rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    expected = path.stem.rsplit("-", 1)[1]
    if not digest.startswith(expected):
        raise ValueError(f"{path}: its SHA-256 starts with {digest[:8]}, not {expected}; {_COMMAND}-{net}")
    return path


def _model(net: Net, weights: Path) -> torch.nn.Module:
    """Build the network without a random start: that would take seconds for VGG's unused classifier, and global RNG."""
    import lpips
    import torch

    with torch.device("meta"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # lpips calls torchvision by parameters that are deprecated since 0.13
        model = lpips.LPIPS(net=net, pretrained=False, pnet_rand=True, verbose=False)
    model.scaling_layer = lpips.ScalingLayer()
    linear = Path(lpips.__file__).parent / "weights" / "v0.1" / f"{net}.pth"
    state = dict(_load(linear))
    backbone = _load(weights)
    for name in model.net.state_dict():  # slice2.5.weight holds features.5.weight
        source = "features." + name.split(".", 1)[1]
        if source not in backbone:
            raise ValueError(f"{weights}: {source} is missing; the file must hold torchvision's {_BACKBONES[net]}")
        state[f"net.{name}"] = backbone[source]
    state |= {f"scaling_layer.{name}": value for name, value in model.scaling_layer.state_dict().items()}
    # The module list repeats the linear layers under a second name; strict loading covers both.
    state |= {name.replace("lin", "lins.", 1): value for name, value in state.items() if name.startswith("lin")}
    try:
        model.load_state_dict(state, assign=True)
    except RuntimeError as error:
        raise ValueError(f"{weights}: not the weights of {net}: {' '.join(str(error).split())}") from error
    module: torch.nn.Module = model.eval().requires_grad_(False)
    return module


def _load(path: Path) -> dict[str, Any]:
    import torch

    try:
        state: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # torch raises many types for a damaged file
        raise ValueError(f"{path}: cannot be read as weights: {' '.join(str(error).split())}") from error
    return state
