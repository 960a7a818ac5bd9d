"""Tensors that lie in a file without a name, so that memory holds what is read of them and no more."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryFile

import torch
from torch import Tensor


def on_disk(tensors: Iterable[Tensor], folder: Path | None) -> list[Tensor]:
    """Write tensors to a file, one after another, and return them as parts of it; the same bits, of the same shapes.

    The system keeps in memory what was read lately, as long as nothing else needs the room. The file has no name, so
    that nothing is left of it when the tensors are gone or the process is, however it ends.

    Args:
        tensors: float32, at most one of them at a time in memory where this is a generator; where there is none, there
            is no file.
        folder: of the file system that has room for them; None is where temporary files are.

    Raises:
        OSError: there is no room for them.
    """
    shapes = []
    with TemporaryFile(dir=folder, buffering=0) as file:
        for tensor in tensors:
            shapes.append(tensor.shape)
            left = memoryview(tensor.contiguous().numpy().tobytes())
            while left:
                left = left[file.write(left) :]
        sizes = [math.prod(shape) for shape in shapes]
        if not sum(sizes):
            return [torch.empty(shape) for shape in shapes]
        # torch forgets the file where it has mapped it; numpy would keep one open for each list, and 1,024 are allowed.
        flat = torch.from_file(f"/dev/fd/{file.fileno()}", shared=True, size=sum(sizes), dtype=torch.float32)
    return [part.view(shape) for part, shape in zip(torch.split(flat, sizes), shapes, strict=True)]
