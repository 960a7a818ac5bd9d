"""Settings of one of several kinds, of which one key names the kind: checked, completed, and in a JSON schema."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from pydantic import BaseModel, GetCoreSchemaHandler, ValidationError
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

SettingsT = TypeVar("SettingsT", bound=BaseModel)


@dataclass(frozen=True)
class NamedSettings(Generic[SettingsT]):
    """Annotation of a field that takes settings of any kind, ``Annotated[base, NamedSettings(...)]``.

    Attributes:
        base: the type that the settings of all kinds are of.
        key: the field that names the kind.
        default: the kind of settings without that field.
        section: where the settings stand in the configuration, for faults.
        what: what a kind is called, for faults.
        kinds: returns the type of the settings of each kind, by name. It is asked at every use, since kinds are found
            among modules that may import the one with the annotation.
    """

    base: type[SettingsT]
    key: str
    default: str
    section: str
    what: str
    kinds: Callable[[], Mapping[str, type[SettingsT]]]

    def checked(self, values: object) -> SettingsT:
        """Return ``values`` as the settings of their kind.

        Raises:
            ValidationError: the kind or a setting is unknown, or a value does not fit; it names their keys alone.
        """
        if isinstance(values, self.base):
            return values
        name = values.get(self.key, self.default) if isinstance(values, Mapping) else self.default
        kinds = self.kinds()
        if name in list(kinds):
            return kinds[name].model_validate(values)
        context = {"name": repr(name), "what": self.what, "near": self.near(name)}
        fault = PydanticCustomError("unknown_name", "{name} is no {what}, did you mean {near}?", context)
        raise ValidationError.from_exception_data(
            self.section, [{"type": fault, "loc": (self.key,), "input": name}]
        ) from None

    def near(self, name: object) -> str:
        """Return the kinds with names like ``name``, or all kinds."""
        return ", ".join(difflib.get_close_matches(str(name), self.kinds(), n=3) or self.kinds())

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:  # noqa: ANN401
        """Check by ``checked``: a union of pydantic's own would name the kind as if it were one of the keys."""
        choices = {name: handler.generate_schema(kind) for name, kind in self.kinds().items()}
        union = core_schema.tagged_union_schema(choices, discriminator=self.key)
        return core_schema.no_info_wrap_validator_function(lambda values, _: self.checked(values), union)
