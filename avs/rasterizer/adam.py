"""Adam (Kingma and Ba 2015) for one tensor, with one learning rate for its first columns and another for the rest.

``torch.optim.Adam`` has one rate per tensor, so that 3DGS implementations keep the spherical harmonics of degree 0 and
of higher degrees apart and join copies of them at every step. With two rates they stay one tensor. On the CPU one numba
loop does the update and leaves out the columns of harmonics that are not in use yet, whose gradients and moments are
zero.

The class is no ``torch.optim.Optimizer``: gsplat's strategies need its ``param_groups`` and ``state`` alone, and its
constructor imports torch's compiler, which takes 1.7 s in every process.
"""

from __future__ import annotations

from collections import defaultdict
from functools import partial
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn import Parameter

from avs.rasterizer.kernels import kernel

BETA1, BETA2 = 0.9, 0.999


class Adam:
    """Adam for one parameter ``[n, ...]``, seen as ``[n, columns]``.

    Attributes:
        param_groups: the parameter (``params``) and what its update depends on, as in ``torch.optim``.
        state: of the parameter: ``exp_avg``, ``exp_avg_sq`` and ``step``, as in ``torch.optim.Adam``; nothing before
            the first step. gsplat's strategies edit both when Gaussians are added or removed.
    """

    def __init__(
        self, parameter: Parameter, rate: float, epsilon: float, rest: tuple[int, float] | None = None
    ) -> None:
        """Start without moments.

        Args:
            parameter: the tensor to optimise.
            rate: learning rate.
            epsilon: added to the root of the second moment.
            rest: a column and the learning rate from that column on, if it differs.
        """
        columns = parameter[0].numel()
        first, rest_rate = rest or (columns, rate)
        self.param_groups: list[dict[str, Any]] = [
            {"params": [parameter], "lr": rate, "rest": (first, rest_rate), "active": columns, "epsilon": epsilon}
        ]
        self.state: defaultdict[Parameter, dict[str, Any]] = defaultdict(dict)

    def set_rate(self, rate: float) -> None:
        """Change the learning rate of the first columns."""
        self.param_groups[0]["lr"] = rate

    def set_active(self, columns: int) -> None:
        """Promise that the gradient is zero from this column on, and has always been."""
        self.param_groups[0]["active"] = columns

    @torch.no_grad()
    def step(self) -> None:
        """Update the parameter by its gradient; without gradient or without rows it stays as it is."""
        group = self.param_groups[0]
        parameter: Parameter = group["params"][0]
        if parameter.grad is None or not len(parameter):
            return
        state = self.state[parameter]
        if not state:
            state.update(step=0, exp_avg=torch.zeros_like(parameter), exp_avg_sq=torch.zeros_like(parameter))
        state["step"] += 1
        tensors = tuple(x.detach() for x in (parameter, parameter.grad, state["exp_avg"], state["exp_avg_sq"]))
        update = _update_cpu if parameter.device.type == "cpu" else _update
        update(tensors, group, 1 - BETA1 ** state["step"], 1 - BETA2 ** state["step"])

    def zero_grad(self) -> None:
        """Drop the gradient."""
        self.param_groups[0]["params"][0].grad = None


def _update(tensors: tuple[Tensor, ...], group: dict[str, Any], correction1: float, correction2: float) -> None:
    """Update ``tensors``: parameter, gradient, first and second moment, each ``[n, ...]``."""
    parameter, gradient, first, second = (tensor.reshape(len(tensor), -1) for tensor in tensors)
    first.lerp_(gradient, 1 - BETA1)
    second.mul_(BETA2).addcmul_(gradient, gradient, value=1 - BETA2)
    change = first / second.div(correction2).sqrt_().add_(group["epsilon"])
    column, rest_rate = group["rest"]
    parameter[:, :column].sub_(change[:, :column], alpha=group["lr"] / correction1)
    parameter[:, column:].sub_(change[:, column:], alpha=rest_rate / correction1)


def _update_cpu(tensors: tuple[Tensor, ...], group: dict[str, Any], correction1: float, correction2: float) -> None:
    """Do the same as ``_update`` in one pass over the memory."""
    column, rest_rate = group["rest"]
    active = group["active"]
    # Of arrays views are quicker than of tensors.
    arrays = tuple(tensor.numpy().reshape(len(tensor), -1) for tensor in tensors)
    if active == column == arrays[0].shape[1]:
        # One rate throughout: one long row is quicker than many short ones.
        arrays = tuple(array.reshape(1, -1) for array in arrays)
        column = active = arrays[0].size
    column = min(column, active)
    scale, epsilon = np.float32(correction2**-0.5), np.float32(group["epsilon"])
    _update_columns(arrays, 0, column, np.float32(group["lr"] / correction1), scale, epsilon)
    if active > column:
        _update_columns(arrays, column, active, np.float32(rest_rate / correction1), scale, epsilon)


_B1, _B2 = np.float32(BETA1), np.float32(BETA2)
_A1, _A2 = np.float32(1 - BETA1), np.float32(1 - BETA2)


@partial(kernel, fastmath={"contract", "nsz"})
def _update_columns(arrays, begin, end, rate, scale, epsilon):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Update columns ``begin`` to ``end``. Divisions stay as written: epsilon may be 1e-15, 0 / epsilon must be 0."""
    parameter, gradient, first, second = arrays
    for i in range(len(parameter)):
        # Slices, so that the index starts at 0: numba wraps an index that may be negative, which keeps the loop scalar.
        p, g = parameter[i, begin:end], gradient[i, begin:end]
        m, v = first[i, begin:end], second[i, begin:end]
        for j in range(end - begin):
            m[j] = _B1 * m[j] + _A1 * g[j]
            v[j] = _B2 * v[j] + _A2 * g[j] * g[j]
            p[j] -= rate * m[j] / (np.sqrt(v[j]) * scale + epsilon)
