"""The files of installed packages that are none of this project's: what a method of somebody else may be made of."""

from __future__ import annotations

import functools
import importlib.metadata
import importlib.util
import os
import sysconfig
from collections.abc import Iterator
from importlib.machinery import ModuleSpec
from pathlib import Path

from avs.system.file_walk import walk_files

_LEFT_OUT = ("__pycache__", ".pyc", ".dist-info", ".egg-info", ".swp", ".swo", "~")
"""How names end of what is compiled, tells of a package, or is an editor's."""
_OF_TOOLS = (
    *(".DS_Store", ".cache", ".directory", ".git", ".hg", ".idea", ".ipynb_checkpoints", ".mypy_cache", ".nox"),
    *(".pytest_cache", ".ruff_cache", ".snakemake", ".svn", ".tox", ".venv", ".vscode"),
)
"""Hidden files and folders that programs keep for themselves; all others are somebody's."""
_SITE = frozenset(Path(sysconfig.get_path(name)) for name in ("purelib", "platlib"))
_BRACES = frozenset("{}")  # Snakemake takes what stands in them for a wildcard


@functools.cache
def installed_files(module: str) -> tuple[Path, ...]:
    """Return the files that a module may be made of, sorted: code, data and compiled modules.

    They are those of the package that holds it, and of the distribution that brought it, since one can bring modules
    beside each other. Of a distribution that is installed as a link to a folder, no list of files is known: those of
    the packages and modules that it names count, and of a module that is no package, the data beside it.

    Args:
        module: dotted name; one that is not known has no files.
    """
    found = set(_of_package(module))
    for distribution in _distributions(module.partition(".")[0]):
        # What is installed beside the packages, as data in share/, is listed from there, with two dots for a folder up.
        listed = (Path(os.path.normpath(str(path.locate()))) for path in distribution.files or () if counts(path.parts))
        found.update(listed)
        for name in (distribution.read_text("top_level.txt") or "").split():
            found.update(_of_package(name))
    return tuple(sorted(path for path in found if not _BRACES & set(str(path)) and path.is_file()))


def counts(parts: tuple[str, ...]) -> bool:
    """Return whether a file counts, by its path in a folder: not what is compiled, or what tools keep there."""
    return not any(part.endswith(_LEFT_OUT) or part in _OF_TOOLS or part.startswith((".#", ".nfs")) for part in parts)


def _distributions(package: str) -> Iterator[importlib.metadata.Distribution]:
    """Yield the distributions that bring a package; several can share one."""
    for name in _brought_by().get(package, ()):
        yield importlib.metadata.distribution(name)


@functools.cache
def _brought_by() -> dict[str, list[str]]:
    return {package: sorted(set(names)) for package, names in importlib.metadata.packages_distributions().items()}


def _of_package(module: str) -> Iterator[Path]:
    """Yield the files of the outermost package that holds a module and is in one folder, or its own file."""
    parts = module.split(".")
    for depth in range(1, len(parts) + 1):
        spec = _spec(".".join(parts[:depth]))
        if spec is None:
            return
        if spec.origin is not None and spec.has_location:
            origin, folder = Path(spec.origin), Path(spec.origin).parent
            inside = [origin]
            if spec.submodule_search_locations is not None:
                inside = list(walk_files(folder, strict=False))
            elif folder not in _SITE:  # a link to the folder of somebody's project: no list of its data is known
                inside = [path for path in folder.iterdir() if path == origin or path.suffix != ".py"]
            yield from (path for path in inside if counts(path.relative_to(folder).parts))
            return


def _spec(module: str) -> ModuleSpec | None:
    try:
        return importlib.util.find_spec(module)
    except (ImportError, ValueError):  # of what a package does when it is imported others tell
        return None
