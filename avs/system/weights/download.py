"""The explicit command's download: verified, and whole or not at all."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from avs.system.downloads import download
from avs.system.errors import UserError
from avs.system.files import write_text
from avs.system.weights.cache import damage, find, folder, hash_file, remedy


def fetch(name: str, progress: Callable[[str], None]) -> Path:
    """Download the weights called ``name`` into the cache folder, unless a good file is there.

    The length is compared with the server's and the manifest's, the hash with the manifest's and with the one that the
    server states, as Hugging Face does. Where neither is known, the hash is recorded beside the file, so that later
    damage is found.

    Args:
        name: an entry of the manifest.
        progress: receives one line about each step.

    Returns:
        The file.

    Raises:
        UserError: the entry is unknown, or comes by pip; or as of ``avs.system.downloads.download``.
    """
    entry = find(name)
    target = folder() / entry.path
    if target.is_file() and damage(entry, target) is None:
        progress(f"{name}: already there, {target}")
        return target
    if entry.pip is not None:
        raise UserError(f"weights {name}", "are part of a package", remedy(name))
    progress(f"{name}: {entry.url}")
    found = download(entry.url, target, progress, entry.bytes, entry.sha256)
    write_text(hash_file(target), f"{found.sha256}  {target.name}\n")
    known = "hash verified" if found.verified else "its hash is stated nowhere, and was recorded"
    progress(f"{name}: {target}, {found.size} bytes, {known}")
    return target
