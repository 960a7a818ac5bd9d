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
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from avs.system.code_inputs import PACKAGES, ROOT
from avs.system.installed_files import counts

_opened: set[str] = set()
# Whether the hook is there, which cannot be taken away again, and whether code of others runs here.
_state = {"hooked": False, "wanted": False}
_HOME_OF_PROGRAMS = (".cache", ".config", ".nv", ".triton")


def watch_opened() -> None:
    """Note each file that this process opens for reading from now on, by Python's own audit events.

    Libraries that open files by themselves, without Python, raise no such event.
    """
    if not _state["hooked"]:
        _state["hooked"] = True
        sys.addaudithook(_note)


def expect_code_of_others() -> None:
    """Say that code runs in this process which somebody else may have written, so that what it reads matters."""
    _state["wanted"] = True


def opened() -> set[Path]:
    """Return the absolute paths of the files that this process has opened for reading since ``watch_opened``."""
    return {_absolute(path) for path in list(_opened)}


def loaded() -> set[Path]:
    """Return the absolute paths of the modules that are loaded, compiled ones too."""
    files = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    return {_absolute(path) for path in files if isinstance(path, str)}


def read_beside(known: Iterable[Path]) -> list[Path]:
    """Return the files that this process has opened or loaded as modules, sorted, without those that others tell of.

    These are: ``known`` ones, this project's code and results, the standard library, installed packages, whose files
    the workflow lists where a method brought them, the system's own, and what is gone by now. Nothing is returned where
    no code of others was to be expected.
    """
    if not _state["wanted"]:
        return []
    paths = opened() | loaded()
    return sorted(path for path in paths.difference(map(_absolute, known)) if not _told_of(path) and path.is_file())


def _absolute(path: str | Path) -> Path:
    """Return an absolute path without dots, whose links stay: what is listed is listed by the name that was given."""
    return Path(os.path.normpath(Path(path).absolute()))


def _note(event: str, arguments: tuple[Any, ...]) -> None:
    if event != "open" or not isinstance(arguments[0], str | bytes | os.PathLike):
        return
    path, mode, flags = arguments
    writes = any(letter in mode for letter in "wax+") if isinstance(mode, str) else flags & (os.O_WRONLY | os.O_RDWR)
    if not writes:
        _opened.add(os.fsdecode(path))


def _told_of(path: Path) -> bool:
    """Return whether a file is none that a method may have been made of, or the workflow lists it."""
    project = next((folder for folder in (Path.cwd(), ROOT) if path.is_relative_to(folder)), None)
    if project is not None:
        own = path.relative_to(project).parts
        return own[0] in ("results", "tests") or (own[0] in PACKAGES and path.suffix == ".py") or not counts(own)
    return not counts(path.parts[-1:]) or "\n" in str(path) or any(path.is_relative_to(each) for each in _elsewhere())


@functools.cache
def _elsewhere() -> list[Path]:
    """Return the folders outside of this project's whose files are none of a method's."""
    libraries = [sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    system = ["/proc", "/sys", "/dev", "/etc", "/usr", "/lib", "/lib64", "/bin", "/run", "/var"]
    home = [Path.home() / name for name in _HOME_OF_PROGRAMS]
    return [*map(Path, (*libraries, site.getusersitepackages(), *system)), *home]
