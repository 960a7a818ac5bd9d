"""What every job needs around its work: a log, one clear line for a fault, and an end with its parent."""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

from avs.system.errors import UserError
from avs.system.files import explained, touched
from avs.system.ledger import write_ledger

_PR_SET_PDEATHSIG = 1


def die_with_parent() -> None:
    """Ask Linux to kill this process when its parent dies, so that no job outlives a killed run and goes on writing."""
    if not sys.platform.startswith("linux"):
        return
    parent = os.getppid()
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # the parent died before the request took effect
        os.kill(os.getpid(), signal.SIGKILL)


class Console:
    """Writes progress to the log, line by line, and to a terminal, if there is one, as one line that is overwritten."""

    def __init__(self, terminal: int | None) -> None:
        """Keep the terminal's file descriptor; None where there is no terminal."""
        self._terminal = terminal

    def progress(self, line: str) -> None:
        """Report one step."""
        print(line, flush=True)
        self._overwrite(line)

    def close(self) -> None:
        """Clear the terminal's line."""
        self._overwrite("")

    def _overwrite(self, line: str) -> None:
        if self._terminal is not None:
            width = shutil.get_terminal_size().columns
            os.write(self._terminal, f"\r\x1b[K{line[: width - 1]}".encode())


@contextlib.contextmanager
def job(log: Path | None) -> Iterator[Console]:
    """Run the body as a job: output goes to ``log``, faults of the user's input end it with one line and status 2.

    Args:
        log: file for everything that is printed, by libraries too, beside which the written files are listed; None
            leaves it on the standard streams.
    """
    error_stream = os.dup(2)
    terminal = error_stream if log is not None and os.isatty(error_stream) else None
    if log is not None:
        log.parent.mkdir(parents=True, exist_ok=True)
        with open(log, "wb") as stream:
            os.dup2(stream.fileno(), 1)
            os.dup2(stream.fileno(), 2)
    console = Console(terminal)
    earlier = len(touched())
    try:
        with explained():
            yield console
            if log is not None:
                write_ledger(log, touched()[earlier:])
    except UserError as error:
        line = f"error: {' '.join(str(error).split())}"
        sys.stdout.flush()  # what was printed before comes first, where standard output is buffered too
        print(line, file=sys.stderr, flush=True)
        console.close()
        if log is not None:
            os.write(error_stream, f"{line}\n".encode())
        sys.exit(2)
    finally:
        console.close()
        sys.stdout.flush()
