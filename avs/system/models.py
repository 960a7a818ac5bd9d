"""What every typed model of the suite shares, and the first fault of a value as words for one line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError


class StrictModel(BaseModel):
    """Base of settings and records: unknown keys are errors, values do not change, numbers are finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @classmethod
    def taken_from(cls, values: BaseModel) -> Self:
        """Return the fields of this model as another has them, which has more."""
        return cls.model_validate(values.model_dump(include=set(cls.model_fields)))


def _different(values: tuple[Any, ...]) -> tuple[Any, ...]:
    repeated = [value for index, value in enumerate(values) if value in values[:index]]
    if repeated:
        raise ValueError(f"{repeated[0]} is there twice")
    return values


Different = AfterValidator(_different)
"""Annotation of a field whose items are all different."""

Share = Annotated[float, Field(ge=0, le=1)]
"""A number in 0..1."""

Color = tuple[Share, Share, Share]
"""Red, green and blue."""

Seed = Annotated[int, Field(ge=0, lt=2**32)]
"""A seed; its digits name a folder."""


def laid_over(values: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return nested ``values`` with ``changes`` in their places; what is no mapping in both is replaced whole."""
    merged = dict(values)
    for key, change in changes.items():
        own = merged.get(key)
        if isinstance(own, Mapping) and isinstance(change, Mapping):
            merged[key] = laid_over(own, change)
        else:
            merged[key] = change
    return merged


def flat(values: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Return nested ``values`` by names such as ``lpips.net``; an empty section is left out."""
    found: dict[str, Any] = {}
    for key, value in values.items():
        name = f"{above}{key}"
        found |= flat(value, f"{name}.") if isinstance(value, Mapping) else {name: value}
    return found


def first_fault(error: ValidationError, *parents: str) -> tuple[str, str]:
    """Return where the first fault of a validation lies, as ``a.b.0``, and what is wrong there.

    Args:
        error: what pydantic raised.
        parents: keys above the validated value. Without any, the place of a fault of the whole value is empty.
    """
    first = error.errors()[0]
    return ".".join(map(str, (*parents, *first["loc"]))), _in_words(first["type"], first["msg"], first.get("ctx", {}))


# What pydantic's types of faults mean to a reader who knows no Python.
_WORDS = {
    "extra_forbidden": "unknown key",
    "missing": "is missing",
    "tuple_type": "must be a list",
    "list_type": "must be a list",
    "dict_type": "must be a section of keys and values",
    "model_type": "must be a section of keys and values",
    "model_attributes_type": "must be a section of keys and values",
    "dataclass_type": "must be a section of keys and values",
    "string_type": "must be text",
    "int_type": "must be a whole number",
    "int_parsing": "must be a whole number",
    "int_parsing_size": "is too large a number",
    "int_from_float": "must be a whole number",
    "float_type": "must be a number",
    "float_parsing": "must be a number",
    "finite_number": "must be a finite number",
    "bool_type": "must be true or false",
    "bool_parsing": "must be true or false",
    "union_tag_not_found": "does not say its {discriminator}",
    "too_short": "must have at least {min_length}, has {actual_length}",
    "too_long": "must have at most {max_length}, has {actual_length}",
    "literal_error": "must be {expected}",
    "greater_than": "must be greater than {gt}",
    "greater_than_equal": "must be at least {ge}",
    "less_than": "must be less than {lt}",
    "less_than_equal": "must be at most {le}",
}
_PATTERNS = {"^[a-z0-9_]+$": "must be of lower-case letters, digits and underscores alone"}


def _in_words(kind: str, message: str, context: dict[str, object]) -> str:
    """Return what is wrong in plain words; what has none keeps pydantic's."""
    if kind == "string_pattern_mismatch":
        return _PATTERNS.get(str(context["pattern"]), message)
    if kind in _WORDS:
        return _WORDS[kind].format_map(context)
    return message.removeprefix("Value error, ")
