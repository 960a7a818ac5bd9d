"""What the numbers of a record may depend on and the record, which is deterministic, does not hold."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from avs.system import provenance
from avs.system.models import StrictModel
from avs.system.records import write_record


class ComputedBy(StrictModel):
    """``*.meta.json``: with what a record was computed."""

    schema_version: Literal[1] = 1
    device: str = Field(description="cpu or cuda")
    machine: dict[str, str] = Field(description="processor, cores, operating system")
    packages: dict[str, str] = Field(description="versions of the packages that compute")
    revision: str | None = Field(description="git revision of the code, with '+' where the tree had changes")


def write_computed_by(record: Path, device: str) -> None:
    """Write beside ``record`` with what this process computes on ``device``."""
    told = ComputedBy(
        device=device,
        machine=provenance.machine(device),
        packages=provenance.packages(),
        revision=provenance.revision(),
    )
    write_record(record.with_suffix(".meta.json"), told)
