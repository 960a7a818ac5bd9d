"""Which device a process computes on, and how the processes of one machine share its GPUs."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from avs.system.errors import UserError

VARIABLE = "AVS_DEVICES"
"""Environment variable with the GPUs to be shared, such as ``0,1,2,3``: numbers or identifiers as of nvidia-smi -L."""

_VISIBLE = "CUDA_VISIBLE_DEVICES"
_LOOK_EVERY = 0.5
_NO_GPU = ("device cuda", "torch finds no GPU here", "set device: cpu, or run where there is one")
# The lock of the device that this process has: it is given back when the process ends, however it ends.
_taken: list[int] = []


def take_device(device: str) -> None:
    """Make sure that ``device``, ``cpu`` or ``cuda``, can be used; of several shared GPUs, take one for this process.

    Where ``AVS_DEVICES`` lists GPUs, the first that no other process has taken becomes the only one that this process
    sees; while all are taken, it waits. Must be called before anything is computed on a GPU.

    Raises:
        UserError: torch finds no GPU, or the variable does not list devices.
    """
    if device != "cuda":
        return
    listed = os.environ.get(VARIABLE)
    if listed is not None and not _taken:
        os.environ[_VISIBLE] = _free_one(_names(listed))
    import torch

    if not torch.cuda.is_available():
        raise UserError(*_NO_GPU)


def smallest_gpu() -> int:
    """Return the bytes of the smallest GPU that jobs would get; another process asks for them, which loads torch.

    Raises:
        UserError: torch finds no GPU, or ``AVS_DEVICES`` does not list devices.
    """
    listed = os.environ.get(VARIABLE)
    seen = {} if listed is None else {_VISIBLE: ",".join(_names(listed))}
    look = (
        "import torch; "
        "print(min(torch.cuda.get_device_properties(n).total_memory for n in range(torch.cuda.device_count())))"
    )
    found = subprocess.run(
        [sys.executable, "-c", look], capture_output=True, check=False, text=True, env={**os.environ, **seen}
    )
    if found.returncode != 0:
        raise UserError(*_NO_GPU)
    return int(found.stdout)


def _names(listed: str) -> list[str]:
    names = [name.strip() for name in listed.split(",")]
    plain = all(name and name.replace("-", "").isalnum() for name in names)
    if not plain or len(set(names)) < len(names):
        raise UserError(VARIABLE, f"{listed!r} is no list of different devices", "set it to numbers such as 0,1,2,3")
    return names


def _free_one(names: list[str]) -> str:
    """Lock the first of ``names`` that is free, as soon as one is, and return it."""
    folder = Path(tempfile.gettempdir()) / f"avs-devices-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    while True:
        for name in names:
            lock = os.open(folder / name, os.O_RDWR | os.O_CREAT, 0o600)
            with suppress(BlockingIOError):
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                _taken.append(lock)
                return name
            os.close(lock)
        time.sleep(_LOOK_EVERY)
