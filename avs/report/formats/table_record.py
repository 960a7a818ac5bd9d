"""A table as a record: all of its document, for pages and other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from avs.report.document import Document
from avs.system.models import StrictModel
from avs.system.records import read_record, write_record


class TableRecord(StrictModel):
    """A table, with rows in their order, ranks, the paper's values, notes and the numbers of its csv files."""

    schema_version: Literal[1] = 1
    document: Document = Field(description="see ``avs.report.document.Document``")


def write_table_record(path: Path, document: Document) -> None:
    """Write a table as a record, atomically."""
    write_record(path, TableRecord(document=document))


def read_table_record(path: Path) -> Document:
    """Return the table that ``write_table_record`` wrote.

    Raises:
        UserError: the file is missing, damaged, or was changed after it was written.
    """
    return read_record(path, TableRecord, "delete it and run again").document
