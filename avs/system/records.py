"""Records on disk: typed, checked when read, written whole as canonical JSON with a digest of what they say."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from avs.system.errors import UserError
from avs.system.files import canonical_json, write_text
from avs.system.models import first_fault

RecordType = TypeVar("RecordType", bound=BaseModel)

DIGEST = "digest"
"""The key of a record that holds the SHA-256 of all the others, as canonical JSON."""

_REMEDY = "delete it and run again"

CHANGED = "was changed after it was written"
"""The fault of a file that is not as the job wrote it that makes it."""


def record_text(record: BaseModel) -> str:
    """Return what ``write_record`` writes: canonical JSON, with the digest of all that it says."""
    values = json.loads(record.model_dump_json())
    return canonical_json(values | {DIGEST: _digest(canonical_json(values))})


def write_record(path: Path, record: BaseModel) -> None:
    """Write ``record`` atomically, see ``record_text``."""
    write_text(path, record_text(record))


def read_record(path: Path, kind: type[RecordType], remedy: str = _REMEDY, *, edited: bool = False) -> RecordType:
    """Read and check a record.

    Args:
        path: the file.
        kind: the model that it follows.
        remedy: what to do about a damaged one.
        edited: whether the record may have been written or changed by hand, so that its digest says nothing.

    Raises:
        UserError: the file is missing, is not JSON, does not follow the schema, or is not as it was written.
    """
    text, digest = _content(path, remedy)
    if not edited and digest != _digest(text):
        raise UserError(path, "its digest is missing" if digest is None else CHANGED, remedy)
    return _validated(path, kind, text, remedy)


def is_as_written(path: Path) -> bool:
    """Return whether a record carries the digest of what it says.

    Raises:
        UserError: the file is missing, or is not a JSON object.
    """
    text, digest = _content(path, _REMEDY)
    return digest == _digest(text)


def read_settings(path: Path, kind: type[RecordType]) -> RecordType:
    """Read settings: those that the workflow wrote are checked by their digest, others, written by hand, have none.

    Raises:
        UserError: the file is missing, is not JSON, does not follow the schema, or is not as it was written.
    """
    text, digest = _content(path, _REMEDY)
    told = _validated(path, kind, text, _REMEDY)
    if digest is not None and digest != _digest(text):
        raise UserError(path, CHANGED, f"{_REMEDY}, or remove its digest if the change was on purpose")
    return told


def _content(path: Path, remedy: str) -> tuple[str, object]:
    """Return what a record says, as canonical JSON, and the digest that it carries, or None."""
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise UserError(path, error.strerror or "cannot be read", "run the job that makes it again") from error
    try:
        values = json.loads(content)
        digest = values.pop(DIGEST, None)
        return canonical_json(values), digest
    except (ValueError, AttributeError, TypeError, RecursionError) as error:
        raise UserError(path, f"is not a JSON object ({str(error)[:100]})", remedy) from error


def _validated(path: Path, kind: type[RecordType], text: str, remedy: str) -> RecordType:
    try:
        return kind.model_validate_json(text)
    except ValidationError as error:
        raise UserError(path, ": ".join(filter(None, first_fault(error))), remedy) from error


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
