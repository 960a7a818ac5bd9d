"""Whether the code that a process has loaded is the code that the workflow planned its job with."""

from __future__ import annotations

import time
from collections.abc import Container, Iterable
from pathlib import Path

from avs.system.checksums import checksum_lines, read_checksums
from avs.system.code_inputs import ABSENT, PACKAGES, ROOT, digest
from avs.system.errors import UserError
from avs.system.files import atomic_path
from avs.system.opened_files import libraries, loaded, opened

_STARTED = time.time()


def write_sources(target: Path, others: Iterable[str] = ()) -> None:
    """List this project's code with its hashes, as ``sha256sum`` does: what a run plans with.

    Args:
        target: the list.
        others: paths of files elsewhere that methods are made of, as ``avs.system.code_inputs.sources`` returns them.
    """
    own = sorted(path.relative_to(ROOT) for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
    elsewhere = sorted(set(others).difference(map(str, own)))
    lines = [checksum_lines(own, ROOT), *(f"{digest(path) or ABSENT:64}  {path}\n" for path in elsewhere)]
    with atomic_path(target, listed=False) as temporary:
        temporary.write_text("".join(lines), encoding="utf-8", errors="surrogateescape")


def check_loaded(listed: Path) -> None:
    """Compare what this process has loaded and opened with what ``write_sources`` listed when the run began.

    The stamp of a job's sources is taken when the run is planned, and jobs read the code later. A file that changed in
    between and was put back before the next run would leave results of other code that pass for current ones.

    Raises:
        UserError: a file is another one, or was written since this process began.
        OSError: the list cannot be read.
    """
    told = read_checksums(listed)
    for path in _loaded(told):
        if told.get(_name(str(path))) != digest(str(path)) or path.stat().st_mtime > _STARTED:
            raise UserError(path, "changed while the run went on, so that nothing of this job is kept", "run again")


def _name(path: str) -> str:
    """Return the path of a file as lists have it: from this project's folder, where it is in there."""
    return path.removeprefix(f"{ROOT}/")


def _loaded(told: Container[str]) -> Iterable[Path]:
    """Return the modules of this project that are loaded, and what else is listed and was loaded or opened."""
    modules = loaded()
    outside = (path for path in modules if path.endswith(".py") and not path.startswith(libraries()))
    own = {path for path in (Path(each).resolve() for each in outside) if _is_own(path)}
    others = {Path(path) for path in modules | opened() if _name(path) in told and Path(path).is_file()}
    return sorted(own | others)


def _is_own(path: Path) -> bool:
    return any(path.is_relative_to(ROOT / package) for package in PACKAGES)
