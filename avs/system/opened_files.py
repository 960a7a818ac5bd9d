"""Files that a process has read and that no list of inputs tells of: somebody's method may read whatever it likes.

A rule lists what its modules import and the data beside them. What a method finds in another way, as a module on
``PYTHONPATH`` or a file in the user's home, is known only once it was read.
"""

from __future__ import annotations

import functools
import os
import site
import sys
import sysconfig
import threading
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from avs.system.code_inputs import PACKAGES, ROOT
from avs.system.installed_files import counts

_opened: set[str] = set()
_code_of_others = threading.Event()
_HOME_OF_PROGRAMS = (".cache", ".config", ".nv", ".triton")
_SYSTEM = ("/proc", "/sys", "/dev", "/etc", "/usr", "/lib", "/lib64", "/bin", "/run", "/var")


@functools.cache
def watch_opened() -> None:
    """Note each file that this process opens for reading from now on, by Python's own audit events.

    Libraries that open files by themselves, without Python, raise no such event.
    """
    sys.addaudithook(_note)


def expect_code_of_others() -> None:
    """Say that code runs in this process which somebody else may have written, so that what it reads matters."""
    _code_of_others.set()


def opened() -> set[str]:
    """Return the absolute paths of the files that this process has opened for reading since ``watch_opened``."""
    return _absolute(list(_opened))


def loaded() -> set[str]:
    """Return the absolute paths of the modules that are loaded, compiled ones too."""
    files = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    return _absolute(path for path in files if isinstance(path, str))


def read_beside(known: Iterable[Path]) -> list[Path]:
    """Return the files that this process has opened or loaded as modules, sorted, without those that others tell of.

    These are: ``known`` ones, this project's code and results, the standard library, installed packages, whose files
    the workflow lists where a method brought them, the system's own, and what is gone by now. Nothing is returned where
    no code of others was to be expected.
    """
    if not _code_of_others.is_set():
        return []
    told = _absolute(map(str, known))
    found = sorted(path for path in opened() | loaded() if path not in told and not _told_of(path))
    return [path for path in map(Path, found) if path.is_file()]


@functools.cache
def libraries() -> tuple[str, ...]:
    """Return what the paths of the standard library and of installed packages begin with."""
    folders = [sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    return tuple(f"{folder}/" for folder in (*folders, site.getusersitepackages()))


def _absolute(paths: Iterable[str]) -> set[str]:
    """Return absolute paths without dots, whose links stay: what is listed is listed by the name that was given."""
    here = Path.cwd()
    return {os.path.normpath(path if path.startswith("/") else here / path) for path in paths}


def _note(event: str, arguments: tuple[Any, ...]) -> None:
    if event != "open" or not isinstance(arguments[0], str | bytes | os.PathLike):
        return
    path, mode, flags = arguments
    writes = any(letter in mode for letter in "wax+") if isinstance(mode, str) else flags & (os.O_WRONLY | os.O_RDWR)
    if not writes:
        _opened.add(os.fsdecode(path))


def _told_of(name: str) -> bool:
    """Return whether an absolute path is of nothing that a method may have been made of, or lists tell of it."""
    if name.startswith(libraries()):  # nearly all of some thousand: before a path is made of it
        return True
    path = Path(name)
    project = next((folder for folder in (Path.cwd(), ROOT) if path.is_relative_to(folder)), None)
    if project is not None:
        own = path.relative_to(project).parts
        return own[0] in ("results", "tests") or (own[0] in PACKAGES and path.suffix == ".py") or not counts(own)
    elsewhere = (*map(Path, _SYSTEM), *(Path.home() / each for each in _HOME_OF_PROGRAMS))
    return not counts(path.parts[-1:]) or "\n" in name or any(path.is_relative_to(each) for each in elsewhere)
