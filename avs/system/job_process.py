"""What every job needs around its work: a log, one clear line for a fault, and an end with its parent."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import stat
import sys
import traceback
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

from avs.system.code_inputs import ABSENT, digest
from avs.system.faults import Terminated, ending
from avs.system.files import touched
from avs.system.job_command import command_digest
from avs.system.ledger import Origin, from_here, write_ledger
from avs.system.loaded_sources import check_loaded
from avs.system.opened_files import read_beside, watch_opened

_READER_GONE = 141  # as shells have it: 128 and the number of the signal PIPE

# What this process was told of what its job is made from, and a list of the code.
_origins: list[Origin] = []
_planned_with: list[Path] = []


def remember_sources(stamp: str | None, read: Iterable[str], planned_with: Path | None, words: Sequence[str]) -> None:
    """Keep what the workflow tells of the files that a job reads, for the end of this process's job.

    Args:
        stamp: of those that no job makes; goes into the list of what is written, with a digest of the command.
        read: those that other jobs make; their hashes, as they are now, go there, too.
        planned_with: see ``avs.system.loaded_sources.check_loaded``.
        words: the command and its arguments; see ``avs.system.job_command.command_digest``.
    """
    _origins[:] = []
    if stamp is not None:
        watch_opened()
        _origins.append(Origin(f"{stamp} {command_digest(words)}", {path: digest(path) or ABSENT for path in read}))
    _planned_with[:] = [] if planned_with is None else [planned_with]


def _with_opened(origin: Origin, written: Sequence[Path]) -> Origin:
    """Return where a job's results come from, with the files that it has read beside those it was told of."""
    known = [*map(Path, origin.read), *written]
    paths = (str(from_here(path)) for path in read_beside(known))
    return replace(origin, opened={path: digest(path) or ABSENT for path in paths})


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
    """Run the body as a job: output goes to ``log``, and whatever it cannot go on with ends it with one line.

    Args:
        log: file for everything that is printed, by libraries too, beside which the written files are listed; None
            leaves it on the standard streams.

    Raises:
        SystemExit: the body raised anything; its status is that of ``avs.system.faults.ending``.
    """
    error_stream = os.dup(2)
    terminal = error_stream if log is not None and os.isatty(error_stream) else None
    console = Console(terminal)
    earlier = len(touched())
    signal.signal(signal.SIGTERM, _terminate)
    aside = None  # where the line goes besides standard error, once that is the log
    try:
        if log is not None:
            _print_to(log)
            aside = error_stream
        yield console
        for listed in _planned_with:
            check_loaded(listed)
        if log is not None:
            written = touched()[earlier:]
            write_ledger(log, written, *(_with_opened(origin, written) for origin in _origins))
    except BaseException as error:
        console.close()
        _end(error, aside)
    finally:
        console.close()
        try:
            sys.stdout.flush()
        except BrokenPipeError:
            _print_to_nobody()
        except OSError:
            pass


@contextlib.contextmanager
def guard() -> Iterator[None]:
    """Let the command line end with one line for whatever goes wrong outside of a job, such as an import.

    Raises:
        SystemExit: the body raised anything; a ``SystemExit`` of its own passes.
    """
    try:
        yield
    except SystemExit:
        raise
    except BaseException as error:
        _end(error, None, logged=False)


def _end(error: BaseException, terminal: int | None, *, logged: bool = True) -> NoReturn:
    """End the process for ``error``: the traceback, if it helps, then the line, which the terminal gets alone.

    Args:
        error: what ends it.
        terminal: file descriptor of standard error where the log has taken its place, or None.
        logged: whether there can be a log; without one a traceback is for faults of the program alone.
    """
    if isinstance(error, BrokenPipeError) and stat.S_ISFIFO(os.fstat(1).st_mode):
        _print_to_nobody()
        sys.exit(_READER_GONE)
    end = ending(error)
    line = f"error: {end.line}"
    with contextlib.suppress(OSError):  # the disk of the log may be the one that is full
        sys.stdout.flush()  # what was printed before comes first, where standard output is buffered too
        if end.traceback and (logged or end.status == 1):
            traceback.print_exception(error)
        print(line, file=sys.stderr, flush=True)
    if terminal is not None:
        with contextlib.suppress(OSError):  # its reader may be gone
            os.write(terminal, f"{line}\n".encode())
    sys.exit(end.status)


def _print_to_nobody() -> None:
    """Let what is still to be printed go nowhere: its reader, such as ``head``, has had enough, which is no fault."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)


def _print_to(log: Path) -> None:
    """Let all that this process prints go to ``log``."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with open(log, "wb") as stream:
        os.dup2(stream.fileno(), 1)
        os.dup2(stream.fileno(), 2)


def _terminate(number: int, frame: object) -> None:
    raise Terminated
