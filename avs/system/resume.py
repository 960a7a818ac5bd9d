"""Completes a run that was killed: Snakemake's lock is removed only if no run is alive in this folder."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

from avs.system.errors import UserError
from avs.system.parent_process import die_with_parent, outlive_parent


def resume(arguments: list[str]) -> None:
    """Unlock the working directory and replace this process by ``snakemake`` with ``arguments``.

    Raises:
        UserError: a run is alive in this folder, or Snakemake cannot unlock it.
    """
    alive = next(runs_in(Path.cwd()), None)
    if alive is not None:
        raise UserError(Path.cwd(), f"a run is alive (process {alive})", "wait for it, or stop it")
    # Killed in the meantime, this process leaves nothing behind that the next call would take for a run.
    words = ["snakemake", "--unlock", *arguments]
    unlocked = subprocess.run(words, capture_output=True, text=True, check=False, preexec_fn=die_with_parent)
    if unlocked.returncode:
        raise UserError(Path.cwd(), f"cannot be unlocked: {unlocked.stderr.strip()}", "correct that and run again")
    outlive_parent()  # as Snakemake does that is called by itself, in the background of a shell that ends
    os.execvp("snakemake", ["snakemake", *arguments])


def runs_in(folder: Path) -> Iterator[int]:
    """Yield the processes that run Snakemake in ``folder``."""
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
            here = (entry / "cwd").resolve() == folder.resolve()
        except OSError:
            continue  # ended in the meantime, or another user's
        if here and any(Path(word.decode(errors="replace")).name == "snakemake" for word in words[:3]):
            yield int(entry.name)
