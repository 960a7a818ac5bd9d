"""Adaptive density control: gsplat's ``DefaultStrategy`` with a budget, an own generator, a working opacity reset."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from gsplat.strategy import DefaultStrategy
from gsplat.strategy.ops import reset_opa
from torch import Tensor

from avs.rasterizer.adam import Adam
from avs.representations.gaussians.gaussian_settings import Densification
from avs.representations.gaussians.parameters import Parameters

STATISTICS = ("grad2d", "count")
"""Names of the running sums in the state of gsplat's strategy: gradient norms, and the views that they come from."""


@dataclass
class BudgetedStrategy(DefaultStrategy):  # type: ignore[misc]
    """``DefaultStrategy`` that never grows beyond ``max_gaussians``.

    Cloning and splitting each add one Gaussian. Where fewer places are left than Gaussians want to grow, those of the
    largest mean gradients grow: the threshold rises for this one time.
    """

    max_gaussians: int | None = None

    def _grow_gs(
        self, params: Parameters, optimizers: Mapping[str, Adam], state: dict[str, Any], step: int
    ) -> tuple[int, int]:
        gradients = state["grad2d"] / state["count"].clamp_min(1)
        wanted = int((gradients > self.grow_grad2d).sum())
        places = wanted if self.max_gaussians is None else self.max_gaussians - len(gradients)
        if places <= 0:
            return 0, 0
        changed = replace(self)
        if wanted > places:
            # The largest gradient that must not grow; the comparison in the base class is strict, so ties do not grow
            # either.
            changed.grow_grad2d = float(torch.topk(gradients, places + 1).values[-1])
        grown: tuple[int, int] = DefaultStrategy._grow_gs(changed, params, optimizers, state, step)
        return grown


class DensityControl:
    """Adds and removes Gaussians during the optimisation, as ``settings`` say."""

    def __init__(self, settings: Densification, extent: float) -> None:
        """Start without statistics; ``extent`` is that of the scene."""
        self._settings = settings
        self._strategy = BudgetedStrategy(
            prune_opa=settings.prune_opacity,
            grow_grad2d=settings.gradient_threshold,
            grow_scale3d=settings.split_scale,
            prune_scale3d=settings.prune_scale,
            reset_every=settings.opacity_reset_every,
            absgrad=settings.absolute_gradient,
            max_gaussians=settings.max_gaussians,
        )
        self._state: dict[str, Any] = self._strategy.initialize_state(scene_scale=extent)

    def statistics(self) -> dict[str, Tensor]:
        """Return the running sums since the last change, ``[n]`` each; none before the first step."""
        return {name: self._state[name] for name in STATISTICS if self._state[name] is not None}

    def restore(self, statistics: Mapping[str, Tensor]) -> None:
        """Take over what ``statistics`` returned."""
        self._state |= {name: statistics.get(name) for name in STATISTICS}

    def before_step(
        self, parameters: Parameters, optimizers: Mapping[str, Adam], step: int, generator: np.random.Generator
    ) -> None:
        """Change the number of Gaussians and reset opacities, where the step before made that due.

        3DGS does so at the end of that step, which is the same to the optimisation. Here it waits for the next one,
        because views may be chosen in between: every addition of the paper's schedule falls on a step of densification,
        two on resets of opacities, and a model just after a reset renders almost black. FisherRF chooses views at the
        start of the iteration, before both.

        Args:
            parameters: changed in place; its tensors are replaced.
            optimizers: one per parameter; their moments follow the Gaussians.
            step: number of the step that is about to begin, from 1.
            generator: source of the offsets of split Gaussians.
        """
        settings, done = self._settings, step - 1
        if not 0 < done < settings.until:
            return
        if done > settings.start and done % settings.every == 0:
            with _seeded(generator, parameters["means"].device):
                self._strategy._grow_gs(parameters, optimizers, self._state, done)
            self._strategy._prune_gs(parameters, optimizers, self._state, done)
            for name in STATISTICS:
                self._state[name].zero_()
        if done % settings.opacity_reset_every == 0:
            # gsplat 1.5.3 tests `step % reset_every == 0 & step > 0`, which Python reads as `... == 0 > 0`: never true.
            reset_opa(parameters, optimizers, self._state, value=settings.opacity_reset_value)

    def before_backward(
        self, parameters: Parameters, optimizers: Mapping[str, Adam], step: int, meta: dict[str, Any]
    ) -> None:
        """Ask for the gradient of the image plane positions, where it is going to be read."""
        if step < self._settings.until:
            self._strategy.step_pre_backward(parameters, optimizers, self._state, step, meta)

    def after_backward(self, step: int, meta: dict[str, Any]) -> None:
        """Add the image plane gradients of ``step`` to the statistics; ``meta`` is what the rasteriser told.

        As gsplat's ``DefaultStrategy`` does for one camera, with the same bits; adding 0 where it picks Gaussians out
        takes half the time.
        """
        if step >= self._settings.until:
            return
        positions = meta["means2d"]
        gradients = (positions.absgrad if self._settings.absolute_gradient else positions.grad)[0].clone()
        # In coordinates that go from -1 to 1 over the image, as gsplat has them.
        gradients[:, 0] *= meta["width"] / 2.0
        gradients[:, 1] *= meta["height"] / 2.0
        seen = (meta["radii"][0] > 0).all(dim=-1)
        norms = torch.where(seen, gradients.norm(dim=-1), 0.0)
        for name, values in (("grad2d", norms), ("count", seen.float())):
            known = self._state[name]
            self._state[name] = values if known is None else known.add_(values)


@contextmanager
def _seeded(generator: np.random.Generator, device: torch.device) -> Iterator[None]:
    """Seed torch's global generator, which gsplat's ``split`` draws from, inside the context, and restore it after."""
    devices = [device] if device.type == "cuda" else []
    with torch.random.fork_rng(devices=devices):
        torch.manual_seed(int(generator.integers(2**63)))
        yield
