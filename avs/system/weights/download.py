"""The explicit command's download: verified, and whole or not at all."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

import requests

from avs.system.errors import UserError
from avs.system.files import atomic_path, write_text
from avs.system.weights.cache import damage, find, folder, hash_file
from avs.system.weights.manifest import Weights

_CONNECT_SECONDS, _SILENCE_SECONDS = 10, 60
_CHUNK = 1 << 20


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
        UserError: the entry is unknown, the server cannot be reached, or what it sends is not what was expected.
    """
    entry = find(name)
    target = folder() / entry.path
    if target.is_file() and damage(entry, target) is None:
        progress(f"{name}: already there, {target}")
        return target
    progress(f"{name}: {entry.url}")
    try:
        with requests.get(entry.url, stream=True, timeout=(_CONNECT_SECONDS, _SILENCE_SECONDS)) as response:
            response.raise_for_status()
            with atomic_path(target) as temporary:
                digest, size = _save(response, temporary)
                stated = _stated_hash(response)
                _compare(name, entry, digest, size, stated)
    except requests.RequestException as error:
        remedy = f"check the network and run the command again, or put the file at {target} yourself"
        raise UserError(entry.url, f"cannot be downloaded ({_reason(error)})", remedy) from error
    write_text(hash_file(target), f"{digest}  {target.name}\n")
    known = "hash verified" if entry.sha256 or stated else "its hash is stated nowhere, and was recorded"
    progress(f"{name}: {target}, {size} bytes, {known}")
    return target


def _save(response: requests.Response, target: Path) -> tuple[str, int]:
    """Write the body to a file; return its SHA-256 and length."""
    digest, size = hashlib.sha256(), 0
    with open(target, "wb") as stream:
        for chunk in response.iter_content(_CHUNK):
            stream.write(chunk)
            digest.update(chunk)
            size += len(chunk)
    length = response.headers.get("Content-Length")
    if length is not None and "Content-Encoding" not in response.headers and size != int(length):
        raise requests.ConnectionError(f"{size} of {length} bytes came")
    return digest.hexdigest(), size


def _stated_hash(response: requests.Response) -> str | None:
    """Return the SHA-256 that Hugging Face states of a large file, in its answer or in the redirection before it."""
    for answer in (*response.history, response):
        digits = answer.headers.get("X-Linked-ETag", "").strip('"')
        if len(digits) == 64:
            return digits
    return None


def _compare(name: str, entry: Weights, digest: str, size: int, stated: str | None) -> None:
    fault = None
    if entry.bytes is not None and size != entry.bytes:
        fault = f"the download has {size} bytes instead of {entry.bytes}"
    for digits in (entry.sha256, stated):
        if fault is None and digits is not None and not digest.startswith(digits):
            fault = f"the SHA-256 of the download starts with {digest[:8]} instead of {digits[:8]}"
    if fault is not None:
        raise UserError(f"weights {name}", fault, "nothing was kept; try again later, or tell the authors of the file")


def _reason(error: requests.RequestException) -> str:
    """Return a short reason: the innermost exception tells more than the chain of those around it."""
    if error.response is not None:
        return f"HTTP {error.response.status_code}"
    cause: BaseException = error
    while cause.__cause__ is not None or cause.__context__ is not None:
        cause = cause.__cause__ or cause.__context__ or cause
    return str(cause) or type(cause).__name__
