"""Whether the code that a process has loaded is the code that the workflow planned its job with."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from pathlib import Path

from avs.system.checksums import checksum_lines, read_checksums
from avs.system.code_inputs import PACKAGES, ROOT
from avs.system.errors import UserError
from avs.system.files import atomic_path, file_hash

_STARTED = time.time()


def write_sources(target: Path) -> None:
    """List this project's code with its hashes, as ``sha256sum`` does: what a run plans with."""
    paths = sorted(path.relative_to(ROOT) for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
    with atomic_path(target, listed=False) as temporary:
        temporary.write_text(checksum_lines(paths, ROOT), encoding="utf-8")


def check_loaded(listed: Path) -> None:
    """Compare the modules of this project that are loaded with what ``write_sources`` listed when the run began.

    The stamp of a job's sources is taken when the run is planned, and jobs read the code later. A file that changed in
    between and was put back before the next run would leave results of other code that pass for current ones.

    Raises:
        UserError: a file is another one, or was written since this process began.
        OSError: the list cannot be read.
    """
    told = read_checksums(listed)
    for path in _loaded():
        name = path.relative_to(ROOT).as_posix()
        if told.get(name) != file_hash(path) or path.stat().st_mtime > _STARTED:
            raise UserError(path, "changed while the run went on, so that nothing of this job is kept", "run again")


def _loaded() -> Iterable[Path]:
    files = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    paths = sorted({Path(file).resolve() for file in files if file and file.endswith(".py")})
    return [path for path in paths if any(path.is_relative_to(ROOT / package) for package in PACKAGES)]
