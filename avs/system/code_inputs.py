"""Which files of this project a module is made of, and how a rule knows that one of its inputs has changed."""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from avs.system.files import SMALL, file_hash
from avs.system.known_digests import known_digest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("avs", "metrics")


def sources(*modules: str) -> list[str]:
    """Return the files of ``modules`` and of all that they import from this project, directly or not.

    Imports inside functions count too. Modules that are found by name at run time, such as selectors, do not:
    name them.

    Args:
        modules: dotted names, such as ``avs.nvs.loop``. Modules outside this project are left out.

    Returns:
        Paths relative to the project's root, sorted.
    """
    found: set[Path] = set()
    waiting = [path for module in modules for path in _files(module)]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting.extend(_imported(path))
    return sorted(str(path.relative_to(ROOT)) for path in found)


def stamp(paths: Iterable[str]) -> str:
    """Return a digest of files that no job makes, by which a change is seen whatever their times.

    Snakemake compares times: a file that an older one replaces, as ``cp -p``, ``mv`` or ``rsync -a`` leave it, is not
    newer than what was made from the one before, nor is one that was edited while a job ran. Files of more than
    ``SMALL`` bytes are not read at every look: see ``avs.system.known_digests``.
    """
    found = sorted(set(paths))
    told = "\n".join(f"{path} {_stamp(path)}" for path in found)
    return hashlib.sha256(told.encode(errors="surrogateescape")).hexdigest()


def stamp_of_inputs(results: str) -> Callable[[object, Iterable[str]], str]:
    """Return the function that a rule takes for a parameter: the ``stamp`` of its inputs outside of a folder.

    Args:
        results: the folder that jobs write to; what lies in it is known by the jobs' own lists.
    """

    def made_of(wildcards: object, input: Iterable[str]) -> str:
        return stamp(path for path in map(str, input) if not path.startswith(f"{results}/"))

    return made_of


@functools.cache
def _stamp(path: str) -> str:
    try:
        status = Path(path).stat()
        return file_hash(path) if status.st_size <= SMALL else known_digest(path)
    except OSError:
        return "absent"


@functools.cache
def _imported(path: Path) -> tuple[Path, ...]:
    """Return the files that the module at ``path`` imports, without those that they import in turn."""
    tree = ast.parse(path.read_text(encoding="utf-8"), filename=str(path))
    return tuple(file for module in _names(tree, path.relative_to(ROOT).parts[:-1]) for file in _files(module))


def _names(tree: ast.AST, package: tuple[str, ...]) -> Iterator[str]:
    """Yield the modules that a file of ``package`` may import; a name that is imported from one may be one too."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parents = package[: len(package) + 1 - node.level] if node.level else ()
            module = ".".join((*parents, *filter(None, [node.module])))
            yield module
            yield from (f"{module}.{alias.name}" for alias in node.names)


def _files(module: str) -> list[Path]:
    """Return the file of ``module``, if it is one of this project's, and those of the packages that hold it."""
    parts = module.split(".")
    if parts[0] not in PACKAGES:
        return []
    found = []
    for depth in range(1, len(parts) + 1):
        base = ROOT.joinpath(*parts[:depth])
        found += [path for path in (base / "__init__.py", base.with_suffix(".py")) if path.is_file()]
    return found
