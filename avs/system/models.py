"""What every typed model of the suite shares, and the first fault of a value as words for one line."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, ValidationError


class StrictModel(BaseModel):
    """Base of settings and records: unknown keys are errors, values do not change, numbers are finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def first_fault(error: ValidationError, *parents: str) -> tuple[str, str]:
    """Return where the first fault of a validation lies, as ``a.b.0``, and what is wrong there.

    Args:
        error: what pydantic raised.
        parents: keys above the validated value. Without any, the place of a fault of the whole value is empty.
    """
    first = error.errors()[0]
    return ".".join(map(str, (*parents, *first["loc"]))), first["msg"]
