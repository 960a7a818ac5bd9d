"""Which files of this project a module is made of, and how a rule knows that one of its inputs has changed."""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from avs.system.file_walk import walk_files
from avs.system.files import SMALL, file_hash
from avs.system.installed_files import counts, installed_files
from avs.system.known_digests import known_digest
from avs.system.numerics import asked

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("avs", "metrics")
READ_OPTION = "--read"
ABSENT = "absent"


def sources(*modules: str) -> list[str]:
    """Return the files of ``modules`` and of all that they import from this project, directly or not.

    Imports inside functions count too. Modules that are found by name at run time, such as selectors, do not:
    name them.

    Args:
        modules: dotted names, such as ``avs.nvs.loop``. Files beside these and beside what they import that are no
            modules, such as data, are returned too. Of one outside this project, its package and what was installed
            with it are returned, without what they import.

    Returns:
        Paths relative to the project's root, or absolute ones outside of it, sorted.
    """
    return list(_sources(frozenset(modules)))


@functools.cache
def _sources(modules: frozenset[str]) -> tuple[str, ...]:
    found: set[Path] = set()
    waiting = [path for module in modules for path in _files(module)]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting.extend(_imported(path))
    # The project's own folder holds more than data of code, as its results.
    data = {path for folder in {file.parent for file in found} - {ROOT} for path in _beside(folder)}
    installed = {
        str(path) for module in modules if module.partition(".")[0] not in PACKAGES for path in installed_files(module)
    }
    return tuple(sorted({str(path.relative_to(ROOT)) for path in found | data} | installed))


def stamp(paths: Iterable[str]) -> str:
    """Return a digest of files that no job makes, by which a change is seen whatever their times.

    Snakemake compares times: a file that an older one replaces, as ``cp -p``, ``mv`` or ``rsync -a`` leave it, is not
    newer than what was made from the one before, nor is one that was edited while a job ran. Files of more than
    ``SMALL`` bytes are not read at every look: see ``avs.system.known_digests``. The numerics asked for go into the
    digest too, because the same files give other bits with others.
    """
    found = sorted(set(paths))
    told = "\n".join([f"numerics {asked()}", *(f"{path} {digest(path) or ABSENT}" for path in found)])
    return hashlib.sha256(told.encode(errors="surrogateescape")).hexdigest()


def with_contents(paths: Iterable[str]) -> list[str]:
    """Return paths of files, in place of a folder those of all files in it, which a change of one can be seen by.

    Links to folders are followed. What Python compiles and what tools keep for themselves, as ``.git``, is left out.
    """
    return [str(path) for each in map(Path, paths) for path in (_inside(each) if each.is_dir() else [each])]


def _inside(folder: Path) -> list[Path]:
    return sorted(path for path in walk_files(folder, strict=False) if counts(path.relative_to(folder).parts))


def sources_of_inputs(results: str) -> Callable[[object, Iterable[str]], list[str]]:
    """Return the function that a rule takes for a parameter: what its command is told of where its inputs come from.

    That is the ``stamp`` of those outside of a folder, then the option ``--read`` with each of those inside of it.

    Args:
        results: the folder that jobs write to.
    """

    def made_of(wildcards: object, input: Iterable[str]) -> list[str]:
        made = sorted({path for path in map(str, input) if path.startswith(f"{results}/")})
        return [stamp(set(map(str, input)).difference(made)), *(word for path in made for word in (READ_OPTION, path))]

    return made_of


@functools.cache
def digest(path: str) -> str | None:
    """Return the SHA-256 of a file as this process has met it first, or None where there is none."""
    return digest_now(path)


def digest_now(path: str) -> str | None:
    """Return the SHA-256 of a file as it is now, or None where there is none."""
    try:
        status = Path(path).stat()
        return file_hash(path) if status.st_size <= SMALL else known_digest(path)
    except OSError:
        return None


@functools.cache
def _imported(path: Path) -> tuple[Path, ...]:
    """Return the files that the module at ``path`` imports, without those that they import in turn."""
    tree = ast.parse(path.read_text(encoding="utf-8"), filename=str(path))
    return tuple(file for module in _names(tree, path.relative_to(ROOT).parts[:-1]) for file in _files(module))


def _names(tree: ast.AST, package: tuple[str, ...]) -> Iterator[str]:
    """Yield the modules that a file of ``package`` may import; a name that is imported from one may be one too."""
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parents = package[: len(package) + 1 - node.level] if node.level else ()
            module = ".".join((*parents, *filter(None, [node.module])))
            yield module
            yield from (f"{module}.{alias.name}" for alias in node.names)


_HOLDS_STATEMENTS = (ast.stmt, ast.excepthandler, ast.match_case)


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all statements; expressions, most of a tree, hold none and are passed over."""
    waiting = [tree]
    while waiting:
        for _, value in ast.iter_fields(waiting.pop()):
            if isinstance(value, list) and value and isinstance(value[0], _HOLDS_STATEMENTS):
                yield from value
                waiting.extend(value)


@functools.cache
def _beside(folder: Path) -> tuple[Path, ...]:
    """Return the files in a folder, and in folders in it that are no packages, which are no code of Python."""
    folders = [path for path in folder.iterdir() if path.is_dir() and not (path / "__init__.py").exists()]
    found = [path for path in folder.iterdir() if path.is_file()]
    found += [path for each in folders if counts((each.name,)) for path in _inside(each)]
    return tuple(path for path in found if path.suffix != ".py" and counts(path.relative_to(folder).parts))


@functools.cache
def _files(module: str) -> tuple[Path, ...]:
    """Return the file of ``module``, if it is in this project's folder, and those of the packages that hold it.

    Jobs run in that folder, so that they find a module beside the Snakefile, too, before any installed one.
    """
    parts = module.split(".")
    if not all(parts):  # an import relative to no package
        return ()
    found = []
    for depth in range(1, len(parts) + 1):
        base = ROOT.joinpath(*parts[:depth])
        found += [path for path in (base / "__init__.py", base.with_suffix(".py")) if path.is_file()]
    return tuple(found)
