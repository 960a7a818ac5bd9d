"""The first fault of a configuration as one line, with the key that was meant where one is near."""

from __future__ import annotations

import difflib
from collections.abc import Collection

from pydantic import BaseModel, ValidationError

from avs.datasets.reader_registry import readers
from avs.system.errors import UserError
from avs.system.models import first_fault


def readable(error: ValidationError, model: type[BaseModel], *parents: str) -> UserError:
    """Return the first fault of a validation as one line.

    Args:
        error: what pydantic raised.
        model: of the whole configuration, whose keys an unknown one is compared with.
        parents: the keys above the validated part.
    """
    first = error.errors()[0]
    place, fault = first_fault(error, *parents)
    if first["loc"][:1] == ("datasets",):  # behind the name of a data set, pydantic puts that of its reader
        place = ".".join(str(key) for depth, key in enumerate(first["loc"]) if depth != 2)
    subject = f"configuration: {place}" if place else "configuration"
    if first["type"] == "union_tag_invalid":
        return UserError(subject, *_unknown(first["ctx"]["tag"], "source", readers()))
    if first["type"] == "union_tag_not_found":
        return UserError(subject, "names no source", f"add source: {' or '.join(readers())}")
    if first["type"] != "extra_forbidden":
        return UserError(subject, fault, "correct the value")
    return UserError(subject, *_unknown(str(first["loc"][-1]), "key", _all_keys(model)))


def _unknown(word: str, kind: str, known: Collection[str]) -> tuple[str, str]:
    """Return the fault and the remedy of a word that is not known."""
    near = difflib.get_close_matches(word, sorted(known), n=1)
    return f"unknown {kind}", f"did you mean {near[0]}?" if near else "remove it"


def _all_keys(model: type[BaseModel]) -> set[str]:
    """Return the names of all fields of ``model`` and of the models inside it."""
    names = set(model.model_fields)
    for definition in model.model_json_schema().get("$defs", {}).values():
        names.update(definition.get("properties", {}))
    return names
