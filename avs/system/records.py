"""Records on disk: typed, checked when read, written whole as canonical JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from avs.system.errors import UserError
from avs.system.files import write_json

RecordType = TypeVar("RecordType", bound=BaseModel)


def read_record(path: Path, kind: type[RecordType]) -> RecordType:
    """Read and check a record.

    Raises:
        UserError: the file is missing, is not JSON, or does not follow the schema.
    """
    try:
        return kind.model_validate_json(Path(path).read_bytes())
    except OSError as error:
        raise UserError(path, error.strerror or "cannot be read", "run the job that makes it again") from error
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"]) or "file"
        raise UserError(path, f"{place}: {first['msg']}", "delete it and run again") from error


def write_record(path: Path, record: BaseModel) -> None:
    """Write ``record`` atomically as canonical JSON."""
    write_json(path, json.loads(record.model_dump_json()))
