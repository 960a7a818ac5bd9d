"""Where captures are: which folders hold one, what each is called, which are left out, and what files each has.

One folder that cannot be used never keeps the others from being used.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from avs.datasets.image_names import is_image
from avs.system.errors import UserError
from avs.system.file_walk import walk_files
from avs.system.files import CAN_BE_NAMED, can_be_named, explained, file_hash
from avs.system.reasons import Reason

PARTS = ("images", "sparse", "colmap/sparse")
"""What is read of a capture: nothing else in its folder matters."""

_LONGEST_NAME = 100
"""Characters of a scene's name, which names of files are made from; most systems allow those 255."""


@dataclass(frozen=True)
class Layout:
    """How the folders of a data set are told from others, and what is read of each.

    Attributes:
        holds: whether a path is a folder of this layout, or a part of one; it may raise ``OSError``.
        files: every file that the scene in a folder may be read from, ascending; it may raise ``OSError``.
        photographs: those of the files that are photographs; it may raise ``OSError``.
        wanted: what a user should give, for messages.
    """

    holds: Callable[[Path], bool]
    files: Callable[[Path], list[Path]]
    photographs: Callable[[Path], list[Path]]
    wanted: str

    def key(self, folder: Path) -> tuple[object, ...] | None:
        """Return what tells the photographs of a folder from others, whatever they are called; None without any.

        That is the sizes of all of them and the hash of the smallest one: photographs of one scene seldom have as many
        bytes as one another, and to read all of them takes minutes.

        Raises:
            OSError: a file cannot be read.
        """
        sizes = sorted((path.stat().st_size, path) for path in self.photographs(folder))
        smallest = [path for size, path in sizes if size == sizes[0][0]]
        if not sizes or not sizes[-1][0]:
            return None
        return (tuple(size for size, _ in sizes), min(file_hash(path) for path in smallest))


@dataclass(frozen=True)
class FoundCaptures:
    """The captures of a folder.

    Attributes:
        folders: each capture's folder, by scene name, ascending.
        left_out: why another is not among them, by the name of its folder.
    """

    folders: dict[str, Path]
    left_out: dict[str, Reason]


def find_captures(folder: Path, layout: Layout | None = None) -> FoundCaptures:
    """Find the captures in ``folder``: its subfolders of a layout, by default COLMAP's, or the folder itself.

    A scene is called after its folder: lower case, with ``_`` for every character other than a letter, a digit or
    ``_``. A link is called after itself, not after what it leads to.

    Raises:
        UserError: there is no capture that can be used, or ``folder`` cannot be read.
    """
    folder, layout = Path(folder), layout or COLMAP
    with explained():
        if not folder.is_dir():
            raise UserError(_shown(folder), "there is no such folder", "give the folder that holds your captures")
        candidates = [folder]
        if not layout.holds(folder):  # of two folders of one scene name, that which has it stays, and links go
            inside = [path for path in folder.iterdir() if not path.name.startswith(".")]
            candidates = sorted(inside, key=lambda path: (path.is_symlink(), path.name != _scene_name(path), path.name))
    folders: dict[str, Path] = {}
    left_out: dict[str, Reason] = {}
    keys: dict[tuple[object, ...], Path] = {}
    for path in candidates:
        try:
            if not layout.holds(path):
                continue
            reason = _why_unusable(path, folders, layout) or _why_copy(path, keys, layout)
        except OSError as error:
            cause = f"cannot be read ({(error.strerror or str(error)).lower()})"
            reason = Reason(cause=cause, remedy="give yourself the permission, or mend the link")
        if reason is None:
            folders[_scene_name(path)] = path
        else:
            left_out[_shown(_name(path))] = reason
    if not folders:
        fault, remedy = "holds no capture", f"give a folder of folders that have {layout.wanted} in them"
        if left_out:
            told = "; ".join(f"{name}: {reason}" for name, reason in left_out.items())
            fault, remedy = f"holds no capture that can be used ({told})", "mend one of them"
        raise UserError(_shown(folder), fault, remedy)
    return FoundCaptures(dict(sorted(folders.items())), dict(sorted(left_out.items())))


def capture_files(folder: Path) -> list[Path]:
    """Return every file that the capture in ``folder`` may be read from, ascending; folders that are links count too.

    Raises:
        OSError: a folder cannot be read.
    """
    return sorted(path for part in PARTS for path in walk_files(folder / part))


def photographs_of(folder: Path) -> list[Path]:
    """Return the photographs of the capture in ``folder``: all images in ``images``, however deep.

    What a system leaves there, such as ``Thumbs.db``, ``.DS_Store`` and ``._a.jpg``, is none; without a file that is
    called as images are, all are.

    Raises:
        OSError: a folder cannot be read.
    """
    files = list(walk_files(folder / "images"))
    return [path for path in files if is_image(path) and not path.name.startswith(".")] or files


def is_folder(path: Path) -> bool:
    """Whether ``path`` is a folder, or a link to one.

    Raises:
        OSError: it is a link that leads nowhere, or cannot be looked at.
    """
    if path.is_symlink() and not path.exists():
        raise FileNotFoundError(None, "a link that leads nowhere", str(path))
    return path.is_dir()


def _is_capture(path: Path) -> bool:
    """Whether ``path`` is a folder that holds a part of a capture.

    Raises:
        OSError: it cannot be looked at.
    """
    if not is_folder(path):
        return False
    present = {entry.name for entry in path.iterdir()}
    return any(part.partition("/")[0] in present and (path / part).is_dir() for part in PARTS)


COLMAP = Layout(_is_capture, capture_files, photographs_of, "images/ and sparse/0/")
"""The layout that COLMAP writes."""


def _why_unusable(path: Path, folders: dict[str, Path], layout: Layout) -> Reason | None:
    """Say why a capture cannot be a scene beside ``folders``, or return None."""
    name = _scene_name(path)
    for other in folders.values():
        if other.samefile(path):
            return Reason(cause=f"is the same folder as {_shown(_name(other))}", remedy="take the link away")
    if name in folders:
        return Reason(
            cause=f"has the same scene name, {name}, as {_shown(_name(folders[name]))}", remedy="rename one of them"
        )
    if len(name) > _LONGEST_NAME or re.search(r"(.+)\1{19}$", name):  # Snakemake takes the latter for a circle
        cause = f"has a scene name of more than {_LONGEST_NAME} characters, or one that ends in 20 repetitions"
        return Reason(cause=cause, remedy="give it a short name of letters from a to z")
    remedy = CAN_BE_NAMED
    if not can_be_named(path):
        return Reason(cause="has a name that the workflow cannot take", remedy=remedy)
    for file in layout.files(path):
        if not can_be_named(file):
            name = _shown(file.relative_to(path))
            return Reason(cause=f"has a file whose name the workflow cannot take, {name}", remedy=remedy)
    return None


def _why_copy(path: Path, keys: dict[tuple[object, ...], Path], layout: Layout) -> Reason | None:
    """Say of which capture another is a copy, or add it to ``keys`` and return None: a scene does not count twice."""
    key = layout.key(path)
    first = path if key is None else keys.setdefault(key, path)
    if first == path:
        return None
    cause = f"has the same photographs as {_shown(_name(first))}"
    return Reason(cause=cause, remedy="take one away, or give it a data set of its own")


def _name(path: Path) -> str:
    """Return the name of a folder, also where the path is ``.`` or ends in ``..``; a link keeps its own."""
    # resolve() would follow links
    return Path(os.path.abspath(path)).name  # noqa: PTH100


def _scene_name(path: Path) -> str:
    return re.sub("[^a-z0-9_]", "_", _name(path).lower())


def _shown(path: Path | str) -> str:
    """Return a path as text that can be printed, whatever its bytes are."""
    text = os.fsencode(path).decode(errors="backslashreplace")
    return "".join(character if character.isprintable() else repr(character)[1:-1] for character in text)
