"""Fitted regressions on disk: one safetensors file whose header says what they read and what they were fitted on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt
from pydantic import Field

from avs.iqa.render_statistics.regression_settings import RegressionSettings
from avs.iqa.render_statistics.ssim_regression import Regression
from avs.system.errors import UserError
from avs.system.models import StrictModel
from avs.system.tensor_files import read_tensors, write_tensors

Sighted = Literal["seen", "pixels"]
"""The two regressions of a file: on all that the settings let it see, and on the pixels of the rendering alone."""

_FORMAT = "avs-render-statistics-1"
_HEADER = "regressions"
_REMEDY = "delete it and fit it again"
_PARTS = ("means", "deviations", "coefficients")


class RegressionFacts(StrictModel):
    """What a reader of results needs to know of the fit."""

    settings: RegressionSettings = Field(description="what the regressions read")
    scenes: int = Field(description="scenes that they were fitted on")
    candidates: int = Field(description="renderings of views that could have been chosen, of all these scenes")
    held_out: int = Field(description="scenes that only measured them")
    candidate_spearman: dict[Sighted, float | None] = Field(
        description="rank correlation with the true SSIM among the candidates of one moment of one held-out scene, "
        "mean over moments and then over scenes"
    )


@dataclass(frozen=True)
class FittedRegressions:
    """Both regressions with what they were fitted on."""

    regressions: Mapping[Sighted, Regression]
    facts: RegressionFacts


def write_regressions(path: Path, fitted: FittedRegressions) -> None:
    """Write regressions to ``path``, whole or not at all; equal content gives equal bytes."""
    arrays = {
        f"{name}/{part}": getattr(regression, part)
        for name, regression in fitted.regressions.items()
        for part in _PARTS
    }
    told = {name: {"columns": each.columns, "level": each.level} for name, each in fitted.regressions.items()}
    header = {"format": _FORMAT, "regressions": told, "facts": fitted.facts.model_dump(mode="json")}
    write_tensors(path, arrays, _HEADER, header)


def read_regressions(path: Path) -> FittedRegressions:
    """Read what ``write_regressions`` wrote.

    Raises:
        UserError: the file is missing, truncated, changed, or something else.
    """
    arrays, header = read_tensors(path, _HEADER, _REMEDY)
    try:
        if header["format"] != _FORMAT:
            raise UserError(path, f"format {header['format']!r}, expected {_FORMAT!r}", _REMEDY)
        facts = RegressionFacts.model_validate(header["facts"])
        found: dict[Sighted, Regression] = {
            name: _regression(name, header["regressions"][name], arrays) for name in get_args(Sighted)
        }
    except (KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:100]
        raise UserError(path, f"not regressions that avs statistics_fit wrote ({reason})", _REMEDY) from error
    return FittedRegressions(found, facts)


def _regression(name: str, told: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> Regression:
    """Return one regression, once its parts are found to fit together."""
    columns = tuple(map(str, told["columns"]))
    means, deviations, coefficients = (np.asarray(arrays[f"{name}/{part}"], dtype=np.float64) for part in _PARTS)
    if any(part.shape != (len(columns),) or not np.isfinite(part).all() for part in (means, deviations, coefficients)):
        raise ValueError(f"{name} is not {len(columns)} finite numbers")
    return Regression(columns, means, deviations, coefficients, float(told["level"]))
