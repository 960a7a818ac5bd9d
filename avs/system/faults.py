"""How a command ends that meets something it cannot go on with: one line, a status, and whether a traceback helps."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from avs.system.errors import UserError
from avs.system.files import as_user_error

USERS_FAULT = 2
"""Status of a fault that the reader of the line can correct."""

PROGRAMS_FAULT = 1
"""Status of a fault of the program, or of code that was plugged into it; the traceback tells where."""

INTERRUPTED, TERMINATED = 130, 143
"""Statuses of what was stopped from outside, as shells have them: 128 and the number of the signal."""

# What torch says of memory that it cannot have, where it raises a plain RuntimeError.
_OUT_OF_MEMORY = ("can't allocate memory", "not enough memory", "out of memory", "unable to allocate")


class Terminated(BaseException):
    """The signal TERM has come. No ``Exception``, so that nothing but the end of the command catches it."""


@dataclass(frozen=True)
class Ending:
    """The end of a command.

    Attributes:
        line: subject, fault and remedy, without the word ``error``.
        status: what the process exits with.
        traceback: whether the traceback belongs in the log.
    """

    line: str
    status: int
    traceback: bool = False


def ending(error: BaseException) -> Ending:
    """Return how a command ends for which ``error`` has come out of its work.

    A compiled function that a signal interrupts lets Python raise a ``SystemError`` over what the signal raised, and
    the function that called it another one over that.
    """
    if isinstance(error, SystemError):
        error = next((each for each in _below(error) if isinstance(each, (KeyboardInterrupt, Terminated))), error)
    for kind, make in _ENDINGS.items():
        if isinstance(error, kind):
            return make(error)
    if isinstance(error, RuntimeError) and any(words in str(error).lower() for words in _OUT_OF_MEMORY):
        return _memory(error)
    return _programs_fault(error)


def _below(error: BaseException) -> Iterator[BaseException]:
    """Yield the exceptions over which an exception was raised, the nearest first."""
    seen: set[int] = set()
    found = error.__cause__ or error.__context__
    while found is not None and id(found) not in seen:
        seen.add(id(found))
        yield found
        found = found.__cause__ or found.__context__


def _users_fault(error: BaseException) -> Ending:
    return Ending(_one_line(error), USERS_FAULT)


def _system(error: BaseException) -> Ending:
    assert isinstance(error, OSError)
    return Ending(_one_line(as_user_error(error)), USERS_FAULT, traceback=error.errno is None)


def _memory(error: BaseException) -> Ending:
    asked = f" ({_one_line(error)})" if str(error) else ""
    remedy = "run fewer jobs at a time (-j1), or lower the size of images or the number of primitives"
    return Ending(f"memory: there is not enough{asked}; {remedy}", USERS_FAULT, traceback=True)


_ENVIRONMENT = "say source .venv/bin/activate, or install environment.txt where there is no .venv"


def _import(error: BaseException) -> Ending:
    name = getattr(error, "name", None) or "a package"
    if name.split(".")[0] in ("avs", "metrics"):
        return _programs_fault(error)
    return Ending(f"{name}: {_one_line(error)}; {_ENVIRONMENT}", USERS_FAULT, traceback=True)


def _exit(error: BaseException) -> Ending:
    assert isinstance(error, SystemExit)
    told = f" ({_one_line(error)})" if error.code not in (None, 0) else ""
    line = ": ".join([*_notes(error), _place(error), f"ended the program{told}"])
    return Ending(f"{line}; let it raise an exception, or leave it out", PROGRAMS_FAULT, traceback=True)


def _programs_fault(error: BaseException) -> Ending:
    line = ": ".join([*_notes(error), _place(error), type(error).__name__, _one_line(error)]).removesuffix(": ")
    remedy = "a fault of the program or of code plugged into it: see the traceback"
    return Ending(f"{line}; {remedy}", PROGRAMS_FAULT, traceback=True)


def _notes(error: BaseException) -> list[str]:
    """Return what was noted of the part of the program that raised ``error``, such as the method."""
    return [" ".join(note.split()) for note in getattr(error, "__notes__", [])]


def _place(error: BaseException) -> str:
    """Return file and line where ``error`` was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    return f"{Path(frames[-1].filename).name}, line {frames[-1].lineno}" if frames else "the program"


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())


# In order: the first that fits.
_ENDINGS: dict[type[BaseException], Callable[[BaseException], Ending]] = {
    UserError: _users_fault,
    ImportError: _import,
    MemoryError: _memory,
    OSError: _system,
    KeyboardInterrupt: lambda _: Ending("interrupted: the job was stopped; run the same line again", INTERRUPTED),
    Terminated: lambda _: Ending("terminated: the job was stopped from outside; run the same line again", TERMINATED),
    SystemExit: _exit,
}
