"""Operations of torch on the CPU whose bits, or speed, MKL would make depend on the processor.

Torch leaves the functions below to MKL's vector library, which starts from the processor's approximate reciprocals:
those differ between makers, whatever mode MKL is held to, and even a square root is not always the nearest number then.
NumPy computes them instead. Products and convolutions with one pixel's window would be the same everywhere in MKL's
compatible mode but take up to four times as long there; NumPy's OpenBLAS and oneDNN, held to one instruction set, take
a third to a half of that.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from torch import Tensor

# Torch's elementwise functions for which MKL's results on one processor were seen to differ from another's.
_ELEMENTWISE: dict[str, Callable[..., Any]] = {
    "acos": np.arccos,
    "asin": np.arcsin,
    "atan": np.arctan,
    "log": np.log,
    "log10": np.log10,
    "sqrt": np.sqrt,
    "tan": np.tan,
}


@functools.cache
def replace_operations() -> Any:  # noqa: ANN401 - torch has no types here
    """Let torch find the operations of this module for tensors on the CPU, for the rest of this process.

    Returns:
        What holds them in place; this function's own cache keeps it.
    """
    import torch

    library: Any = torch.library.Library("aten", "IMPL")  # type: ignore[no-untyped-call]
    operations: dict[str, Callable[..., Any]] = {
        "mm": _product,
        "bmm": _product,
        "addmm": _added_product,
        "baddbmm": _added_product,
        "_slow_conv2d_forward": _convolution,
    }
    for name, function in _ELEMENTWISE.items():
        operations |= _forms(name, function)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Warning only once for all operators", UserWarning)  # to replace is the aim
        for name, operation in operations.items():
            library.impl(name, operation, "CPU", allow_override=True)
    return library


def _forms(name: str, function: Callable[..., Any]) -> dict[str, Callable[..., Any]]:
    """Return the forms that an elementwise function has in torch: new, in place, into another tensor."""
    applied = functools.partial(_in_numpy, function)

    def into(tensor: Tensor, *, out: Tensor) -> Tensor:
        result = applied(tensor)
        return out.resize_(result.shape).copy_(result)

    return {name: applied, f"{name}_": lambda tensor: tensor.copy_(applied(tensor)), f"{name}.out": into}


def _in_numpy(function: Callable[..., Any], *tensors: Tensor) -> Tensor:
    """Return a function's value as torch types it: whole numbers give float32, short floats are computed in float32."""
    import torch

    kind = tensors[0].dtype
    kept = kind in (torch.float32, torch.float64) or kind.is_complex
    arrays = [(tensor if kept else tensor.float()).detach().numpy() for tensor in tensors]
    with np.errstate(all="ignore"):  # torch says nothing of the root of a negative number either
        result = torch.from_numpy(np.asarray(function(*arrays)))
    return result.to(kind) if kind.is_floating_point and not kept else result


def _product(first: Tensor, second: Tensor) -> Tensor:
    if first.dtype.is_floating_point or first.dtype.is_complex:
        return _in_numpy(np.matmul, first, second)
    import torch

    return torch.from_numpy(np.matmul(first.detach().numpy(), second.detach().numpy()))


def _added_product(added: Tensor, first: Tensor, second: Tensor, *, beta: float = 1, alpha: float = 1) -> Tensor:
    result = _product(first, second)
    if alpha != 1:
        result *= alpha
    if beta == 0:  # what is added may hold no numbers then
        return result
    return result + (added if beta == 1 else beta * added)


def _convolution(
    pictures: Tensor,
    weight: Tensor,
    kernel_size: tuple[int, int],
    bias: Tensor | None,
    stride: tuple[int, int],
    padding: tuple[int, int],
) -> Tensor:
    """Return the convolution that torch leaves to MKL: of one pixel's window in float32, or of any in float64."""
    import torch

    if pictures.dtype == torch.float32:
        return torch.mkldnn_convolution(pictures, weight, bias, padding, stride, [1, 1], 1)
    columns = torch.nn.functional.unfold(pictures, tuple(kernel_size), padding=tuple(padding), stride=tuple(stride))
    result = weight.flatten(1) @ columns
    if bias is not None:
        result += bias[:, None]
    sizes = zip(pictures.shape[2:], kernel_size, stride, padding, strict=True)
    return result.view(*result.shape[:2], *((side + 2 * pad - width) // step + 1 for side, width, step, pad in sizes))
