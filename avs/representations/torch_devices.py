"""Where tensors lie."""

from __future__ import annotations

import torch

from avs.system.errors import UserError


def torch_device(name: str) -> torch.device:
    """Return the device ``cpu`` or ``cuda``.

    Raises:
        UserError: the name is another one, or there is no such device here.
    """
    if name not in ("cpu", "cuda"):
        raise UserError(f"device {name!r}", "is not known", "choose cpu or cuda")
    if name == "cuda" and not torch.cuda.is_available():
        raise UserError("device 'cuda'", "is not available on this machine", "choose cpu")
    return torch.device(name)
