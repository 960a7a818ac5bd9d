"""Records on disk: typed, checked when read, written whole as canonical JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from avs.system.errors import UserError
from avs.system.files import write_json
from avs.system.models import first_fault

RecordType = TypeVar("RecordType", bound=BaseModel)


def read_record(path: Path, kind: type[RecordType], remedy: str = "delete it and run again") -> RecordType:
    """Read and check a record; ``remedy`` tells what to do about a damaged one.

    Raises:
        UserError: the file is missing, is not JSON, or does not follow the schema.
    """
    try:
        return kind.model_validate_json(Path(path).read_bytes())
    except OSError as error:
        raise UserError(path, error.strerror or "cannot be read", "run the job that makes it again") from error
    except ValidationError as error:
        raise UserError(path, ": ".join(filter(None, first_fault(error))), remedy) from error


def write_record(path: Path, record: BaseModel) -> None:
    """Write ``record`` atomically as canonical JSON."""
    write_json(path, json.loads(record.model_dump_json()))
