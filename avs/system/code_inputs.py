"""Which files of this project a module is made of: what a rule lists as inputs."""

from __future__ import annotations

import ast
import functools
from collections.abc import Iterator
from pathlib import Path

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


@functools.cache
def _imported(path: Path) -> tuple[Path, ...]:
    """Return the files that the module at ``path`` imports, without those that they import in turn."""
    tree = ast.parse(path.read_text(encoding="utf-8"), filename=str(path))
    return tuple(file for module in _names(tree) for file in _files(module))


def _names(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


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
