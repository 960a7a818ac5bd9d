"""The weights of LPIPS: the backbone is torchvision's classifier, the linear layers come with the package ``lpips``.

The package would download the backbone through torchvision, which also means minutes of waiting where there is no
network. Here it is looked for on disk, and its absence is reported at once.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

from avs.system.errors import UserError
from avs.system.weights.cache import COMMAND, find, locate, verified
from avs.system.weights.reading import read_state


def lpips_absent_reason(net: str) -> str | None:
    """Return None if the backbone ``net``, ``vgg`` or ``alex``, is on this machine, or one line: what is missing.

    Reads no file and uses no network. The line is the same on every machine, so that a record can hold it.
    """
    name = f"lpips-{net}"
    return None if locate(name) else f"weights {Path(find(name).path).name} absent: {COMMAND} {name}"


def read_lpips(net: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return two state dictionaries: of the backbone ``net``, ``vgg`` or ``alex``, and of its linear layers (0.1).

    Raises:
        UserError: the backbone is absent, not the published file, or no dictionary of tensors; or the package ``lpips``
            is not installed.
    """
    name = f"lpips-{net}"
    backbone = read_state(verified(name), f"{COMMAND} {name}")
    package = importlib.util.find_spec("lpips")
    if package is None or package.origin is None:
        raise UserError("lpips", "not installed", "install environment.txt")
    linear = Path(package.origin).parent / "weights" / "v0.1" / f"{net}.pth"
    return backbone, read_state(linear, "install the package lpips again")
