"""The optimisers of 3DGS and their schedules."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from avs.rasterizer.adam import Adam
from avs.representations.gaussians.gaussian_settings import GaussianSettings, LearningRates
from avs.representations.gaussians.parameters import Parameters, PrimitiveParameter

Optimizers = dict[str, Adam]

CHANNELS = 3

_NOTHING: Mapping[str, PrimitiveParameter] = MappingProxyType({})


def create_optimizers(
    parameters: Parameters,
    settings: GaussianSettings,
    extent: float,
    extra: Mapping[str, PrimitiveParameter] = _NOTHING,
) -> Optimizers:
    """Return one optimiser per parameter, without moments.

    Args:
        parameters: the tensors.
        settings: of the reconstruction.
        extent: of the scene; positions have a rate in units of it.
        extra: those of ``parameters`` that are not of 3DGS.
    """
    rates, epsilon = settings.learning_rates, settings.adam_epsilon
    optimizers = {
        "means": Adam(parameters["means"], rates.means * extent, epsilon),
        "scales": Adam(parameters["scales"], rates.scales, epsilon),
        "quats": Adam(parameters["quats"], rates.quats, epsilon),
        "opacities": Adam(parameters["opacities"], rates.opacities, epsilon),
        "sh": Adam(parameters["sh"], rates.f_dc, epsilon, rest=(CHANNELS, rates.f_rest)),
    }
    for name, parameter in extra.items():
        rate = rates.opacities if parameter.learning_rate is None else parameter.learning_rate
        optimizers[name] = Adam(parameters[name], rate, epsilon)
    return optimizers


def follow_schedules(optimizers: Optimizers, settings: GaussianSettings, extent: float, step: int) -> int:
    """Set the rates of optimisation step ``step``, counted from 1, and return the degree of the spherical harmonics."""
    degree = active_degree(settings, step)
    optimizers["means"].set_rate(means_rate(settings.learning_rates, step / settings.iterations) * extent)
    optimizers["sh"].set_active(CHANNELS * (degree + 1) ** 2)
    return degree


def active_degree(settings: GaussianSettings, step: int) -> int:
    """Return the degree of the spherical harmonics in use at ``step``: one more every ``sh_increase_every`` steps."""
    return min(settings.sh_degree, step // settings.sh_increase_every)


def means_rate(rates: LearningRates, progress: float) -> float:
    """Return the rate of the positions: log-linear from ``means`` at progress 0 to ``means_final`` from 1 on."""
    part = min(max(progress, 0.0), 1.0)
    return math.exp((1 - part) * math.log(rates.means) + part * math.log(rates.means_final))
