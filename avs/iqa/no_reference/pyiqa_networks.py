"""pyiqa's metrics as pyiqa builds them; its networks with weights that are read here."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avs.system.errors import UserError
from avs.system.weights.reading import read_state

if TYPE_CHECKING:
    from torch import Tensor, nn


def build_plain(metric: str, device: str) -> Callable[[Tensor], Tensor]:
    """Return a metric of pyiqa that has no weights; see ``build_network``."""
    import pyiqa
    import torch

    made: nn.Module = pyiqa.create_metric(metric, device=torch.device(device))
    return lambda images: made(images).reshape(len(images))


def build_network(metric: str, path: Path, device: str, remedy: str) -> Callable[[Tensor], Tensor]:
    """Return a metric of pyiqa that maps images ``[n, 3, height, width]`` in 0..1 to ``[n]`` scores.

    Args:
        metric: its name in pyiqa.
        path: a file with all of its weights.
        device: ``cpu`` or ``cuda``.
        remedy: what the user can do if the file is bad.

    Raises:
        UserError: the weights are damaged, hold objects, or are not this network's.
    """
    import pyiqa
    import torch

    state = read_state(path, remedy)
    with torch.random.fork_rng(devices=[]), _random_backbones():
        made = pyiqa.create_metric(metric, device=torch.device(device), pretrained=False)
    network: Any = made.net
    load(network, state, path)
    return lambda images: made(images).reshape(len(images))


def load(network: nn.Module, state: dict[str, Any], source: object) -> None:
    """Give a network all of its parameters and buffers.

    Raises:
        UserError: one is missing, superfluous or of another shape; ``source`` is the subject of the line.
    """
    try:
        network.load_state_dict(state, strict=True)
    except RuntimeError as error:
        lines = str(error).splitlines()
        fault = f"not the weights of {type(network).__name__} ({lines[min(1, len(lines) - 1)].strip()[:150]})"
        raise UserError(source, fault, "put the file there that avs weights list names") from error


@contextlib.contextmanager
def _random_backbones() -> Iterator[None]:
    """Let pyiqa make its backbones with random weights.

    NIMA, MANIQA and TReS demand the ImageNet weights of their backbones, a download, though their own checkpoints hold
    every parameter of the backbone and replace them at once (``load`` refuses a checkpoint that does not).
    """
    import timm
    import torchvision

    create_model, resnet50 = timm.create_model, torchvision.models.resnet50
    timm.create_model = lambda *arguments, **options: create_model(*arguments, **options | {"pretrained": False})
    torchvision.models.resnet50 = lambda **options: resnet50(**options | {"weights": None})
    try:
        yield
    finally:
        timm.create_model, torchvision.models.resnet50 = create_model, resnet50
