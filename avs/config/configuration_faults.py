"""The first fault of a configuration as one line, with the key that was meant where one is near."""

from __future__ import annotations

import difflib
import itertools
from collections.abc import Collection, Mapping, Sequence
from typing import Any

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
        known = [tag.strip(" '") for tag in first["ctx"]["expected_tags"].split(",")]
        return UserError(subject, *_unknown(first["ctx"]["tag"], first["ctx"]["discriminator"].strip("'"), known))
    if first["type"] == "union_tag_not_found" and first["loc"][0] != "datasets":
        return UserError(subject, fault, f"add {first['ctx']['discriminator']}")
    if first["type"] == "union_tag_not_found":
        return UserError(subject, "names no source", f"add source: {' or '.join(readers())}")
    if first["type"] not in ("missing", "extra_forbidden"):
        return UserError(subject, fault, "correct the value")
    word = str(first["loc"][-1])
    keys = (*parents, *map(str, first["loc"]))
    if first["type"] == "missing":
        found = _places(word, model.model_json_schema())
        near = max(found, key=lambda place: (_shared(place, keys), -len(place)), default=None)
        return UserError(subject, fault, "add it" if near is None else f"add it: {_meaning(found[near])}")
    others = [name for name, reader in readers().items() if word in reader.model_fields]
    if keys[0] == "datasets" and len(keys) == 4 and others:
        return UserError(subject, f"is a key of source {' or '.join(others)}, not of {keys[2]}", "remove it")
    places = _places(word, model.model_json_schema())
    if places:
        near = max(places, key=lambda place: (_shared(place, keys), -len(place)))
        where = f"write it as {'.'.join(near)}" if len(near) > 1 else f"write {word} outside of all sections"
        return UserError(subject, "is no key of this section", where)
    return UserError(subject, *_unknown(word, "key", _all_keys(model)))


def check_numbers(values: object, checked: object, *keys: str) -> None:
    """Refuse true and false where a number is meant: they would count as 1 and 0.

    Args:
        values: a part of the configuration, as it was read.
        checked: the same part, typed.
        keys: the keys above it.

    Raises:
        UserError: names the first such value.
    """
    if isinstance(values, bool) and isinstance(checked, int | float) and not isinstance(checked, bool):
        raise UserError(f"configuration: {'.'.join(keys)}", "must be a number, not true or false", "correct the value")
    if isinstance(values, Mapping):
        typed = dict(checked) if isinstance(checked, BaseModel | Mapping) else {}
        for key, value in values.items():
            check_numbers(value, typed.get(key), *keys, str(key))
    elif isinstance(values, list | tuple) and isinstance(checked, list | tuple):
        for index, (value, each) in enumerate(zip(values, checked, strict=False)):
            check_numbers(value, each, *keys, str(index))


def _meaning(schema: Mapping[str, Any]) -> str:
    """Return what a field is for and, where only some values are allowed, which."""
    described = str(schema.get("description", "docs/data.md and workflows/schemas/config.json say what it is for"))
    choices = [choice for choice in map(str, schema.get("enum", [])) if choice not in described]
    return f"{described} ({', '.join(choices)})" if choices else described


def _places(word: str, schema: dict[str, Any]) -> dict[tuple[str, ...], dict[str, Any]]:
    """Return where a model has fields called ``word``: the keys above it and itself; ``NAME`` stands for any name.

    Beside each place stands the schema of the field.
    """
    definitions = schema.get("$defs", {})
    found: dict[tuple[str, ...], dict[str, Any]] = {}
    waiting: list[tuple[tuple[str, ...], dict[str, Any]]] = [((), schema)]
    while waiting:
        keys, part = waiting.pop()
        if "$ref" in part:
            waiting.append((keys, definitions[part["$ref"].rpartition("/")[2]]))
        for key, inside in part.get("properties", {}).items():
            waiting.append(((*keys, key), inside))
            found |= {(*keys, key): inside} if key == word else {}
        waiting += [(keys, each) for kind in ("anyOf", "oneOf", "allOf") for each in part.get(kind, [])]
        named = [*part.get("patternProperties", {}).values(), part.get("additionalProperties")]
        waiting += [((*keys, "NAME"), each) for each in named if isinstance(each, dict)]
    return dict(sorted(found.items()))


def _shared(place: Sequence[str], other: Sequence[str]) -> int:
    """Return how many keys two places have in common from the top on; ``NAME`` is any."""
    pairs = itertools.takewhile(lambda pair: pair[0] in (pair[1], "NAME"), zip(place, other, strict=False))
    return sum(1 for _ in pairs)


def _unknown(word: str, kind: str, known: Collection[str]) -> tuple[str, str]:
    """Return the fault and the remedy of a word that is not known."""
    return f"unknown {kind}", remedy_of_unknown(word, known)


def remedy_of_unknown(word: str, known: Collection[str]) -> str:
    """Return what to do about a word that is not known: the nearest one that is, if there is one that is near."""
    near = difflib.get_close_matches(word, sorted(known), n=1)
    return f"did you mean {near[0]}?" if near else "remove it"


def _all_keys(model: type[BaseModel]) -> set[str]:
    """Return the names of all fields of ``model`` and of the models inside it."""
    names = set(model.model_fields)
    for definition in model.model_json_schema().get("$defs", {}).values():
        names.update(definition.get("properties", {}))
    return names
