"""Adam (Kingma and Ba 2015) for the tensors of a radiance field, by name.

``avs.rasterizer.adam`` has the constants of Gaussians and one tensor whose rows come and go. ``torch.optim`` imports
torch's compiler, which takes 1.7 s in every process.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import torch
from torch import Tensor
from torch.nn import Parameter

from avs.rasterizer.kernels import Floats, kernel


@dataclass
class FieldAdam:
    """Adam with one learning rate a tensor.

    Attributes:
        betas: decay of the two moments.
        epsilon: added to the root of the second moment.
        moments: both moments of each tensor, by name; nothing before its first step.
        steps: number of steps of each tensor since its moments were nothing.
    """

    betas: tuple[float, float]
    epsilon: float
    moments: dict[str, tuple[Tensor, Tensor]] = field(default_factory=dict)
    steps: dict[str, int] = field(default_factory=dict)

    def forget(self, names: Iterable[str]) -> None:
        """Start anew for tensors that were replaced."""
        for name in names:
            self.moments.pop(name, None)
            self.steps.pop(name, None)

    @torch.no_grad()
    def step(self, parameters: Mapping[str, Parameter], rates: Mapping[str, float]) -> None:
        """Update every tensor that has a gradient, with its rate, and drop the gradients."""
        for name, parameter in parameters.items():
            if parameter.grad is None:
                continue
            if name not in self.moments:
                self.moments[name] = (torch.zeros_like(parameter), torch.zeros_like(parameter))
            self.steps[name] = count = self.steps.get(name, 0) + 1
            corrections = (1 - self.betas[0] ** count, 1 - self.betas[1] ** count)
            update = _update_on_cpu if parameter.device.type == "cpu" else _update
            update(
                parameter, self.moments[name], self.betas, rates[name] / corrections[0], corrections[1], self.epsilon
            )
            parameter.grad = None


def _update(
    parameter: Parameter,
    moments: tuple[Tensor, Tensor],
    betas: tuple[float, float],
    rate: float,
    correction: float,
    epsilon: float,
) -> None:
    """Update one tensor; ``rate`` has the first moment's correction already."""
    first, second = moments
    assert parameter.grad is not None
    first.lerp_(parameter.grad, 1 - betas[0])
    second.mul_(betas[1]).addcmul_(parameter.grad, parameter.grad, value=1 - betas[1])
    parameter.sub_(first / second.div(correction).sqrt_().add_(epsilon), alpha=rate)


def _update_on_cpu(
    parameter: Parameter,
    moments: tuple[Tensor, Tensor],
    betas: tuple[float, float],
    rate: float,
    correction: float,
    epsilon: float,
) -> None:
    """Do the same in one pass over the memory."""
    assert parameter.grad is not None
    flat = [tensor.detach().reshape(-1).numpy() for tensor in (parameter, parameter.grad.contiguous(), *moments)]
    constants = (*betas, rate, correction**-0.5, epsilon)
    _update_flat(*flat, *(np.float32(each) for each in constants))


@partial(kernel, fastmath={"contract", "nsz"})
def _update_flat(  # type: ignore[no-untyped-def]  # noqa: ANN202
    parameter: Floats, gradient: Floats, first: Floats, second: Floats,
    beta1: float, beta2: float, rate: float, scale: float, epsilon: float,
):  # fmt: skip
    one = np.float32(1)
    for i in range(len(parameter)):
        first[i] = beta1 * first[i] + (one - beta1) * gradient[i]
        second[i] = beta2 * second[i] + (one - beta2) * gradient[i] * gradient[i]
        parameter[i] -= rate * first[i] / (np.sqrt(second[i]) * scale + epsilon)
