"""Downloads of large files: verified, whole or not at all, and gone on with where one was broken off."""

from __future__ import annotations

import base64
import hashlib
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import requests

from avs.system.errors import UserError
from avs.system.files import file_hash, publish, write_text

_CONNECT_SECONDS, _SILENCE_SECONDS, _REPORT_SECONDS = 10, 60, 10
_CHUNK = 1 << 16  # what a connection that breaks loses, at most
_TRIES = 5
"""Times that a download which had begun is gone on with by itself; each has to bring something."""


@dataclass(frozen=True)
class Downloaded:
    """What came.

    Attributes:
        sha256: of the file, in hexadecimal.
        size: in bytes.
        verified: whether a hash was known to compare with, the caller's or one that the server states.
    """

    sha256: str
    size: int
    verified: bool


def download(
    url: str, target: Path, progress: Callable[[str], None], size: int | None = None, sha256: str | None = None
) -> Downloaded:
    """Fetch ``url`` to ``target``, going on with what an earlier call left in ``<target>.part``.

    The server is asked to go on only if its file is still the one of the part, by its ETag; without one, no part is
    kept. Length and hash are compared with those given, and with those that the server states: Hugging Face a SHA-256,
    Google's storage an MD5.

    Args:
        url: the file.
        target: where it goes; its folder is made if need be.
        progress: receives a line every ten seconds.
        size: bytes that are expected, if known.
        sha256: of the file, or the first digits of it, if known.

    Raises:
        UserError: the server cannot be reached or breaks off, what it sends is not what was expected, or there is no
            room for it.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f"{target.name}.part")
    answer = _fetched(url, part, target, progress)
    fault, digest, verified = _compare(part, answer, size, sha256)
    if fault is not None:
        _forget(part)
        raise UserError(url, fault, "nothing was kept; try again later, or tell the authors of the file")
    length = part.stat().st_size
    publish(part, target)
    _forget(part)
    return Downloaded(digest, length, verified)


def _fetched(url: str, part: Path, target: Path, progress: Callable[[str], None]) -> requests.Response:
    """Bring the whole of ``url`` into ``part`` and return the server's last answer."""
    tries = 0
    while True:
        before = _length(part)
        try:
            return _go_on(url, part, progress)
        except requests.RequestException as error:
            if not _etag_file(part).is_file():
                _forget(part)
            came = _length(part) - before
            tries += 1
            if came > 0 and tries < _TRIES:
                progress(f"{target.name}: broken off at {_length(part) / 1e6:.0f} MB, going on")
                continue
            kept = f"; {_length(part) / 1e6:.0f} MB of it are kept" if _length(part) else ""
            remedy = f"check the network and run the command again, or put the file at {target} yourself"
            raise UserError(url, f"cannot be downloaded ({_reason(error)}){kept}", remedy) from error


def _go_on(url: str, part: Path, progress: Callable[[str], None]) -> requests.Response:
    """Ask for what ``part`` lacks, or for all if it is of another file, and append it."""
    headers = {"Accept-Encoding": "identity"}
    etag_file = _etag_file(part)
    if part.is_file() and etag_file.is_file():
        headers |= {"Range": f"bytes={_length(part)}-", "If-Range": etag_file.read_text(encoding="utf-8")}
    with requests.get(url, headers=headers, stream=True, timeout=(_CONNECT_SECONDS, _SILENCE_SECONDS)) as response:
        if response.status_code == requests.codes.requested_range_not_satisfiable:
            _forget(part)  # it is longer than the file
            raise requests.ConnectionError("the part that an earlier call left was too long, and is removed")
        response.raise_for_status()
        going_on = response.status_code == requests.codes.partial_content
        if not going_on:
            _forget(part)
            _keep_etag(response, etag_file)
        length = response.headers.get("Content-Length")
        total = None if length is None else int(length) + (_length(part) if going_on else 0)
        _check_room(part, total)
        _save(response, part, total, progress)
        if total is not None and "Content-Encoding" not in response.headers and _length(part) != total:
            raise requests.ConnectionError(f"{_length(part)} of {total} bytes came")
        return response


def _save(response: requests.Response, part: Path, total: int | None, progress: Callable[[str], None]) -> None:
    told = time.monotonic()
    with open(part, "ab") as stream:
        for chunk in response.iter_content(_CHUNK):
            stream.write(chunk)
            if time.monotonic() - told > _REPORT_SECONDS:
                told = time.monotonic()
                of = "" if total is None else f" of {total / 1e6:.0f}"
                progress(f"{part.stem}: {stream.tell() / 1e6:.0f}{of} MB")


def _keep_etag(response: requests.Response, etag_file: Path) -> None:
    """Keep by what the server knows this version of the file.

    A weak ETag does not tell bytes apart (RFC 9110, 13.1.5).
    """
    etag = response.headers.get("ETag", "")
    if etag and not etag.startswith("W/"):
        write_text(etag_file, etag)


def _check_room(part: Path, total: int | None) -> None:
    free = shutil.disk_usage(part.parent).free
    if total is not None and total - _length(part) > free:
        fault = f"needs {total / 1e9:.1f} GB, but {free / 1e9:.1f} GB are free"
        raise UserError(part.parent, fault, "free some space, or choose another folder")


def _compare(
    part: Path, answer: requests.Response, size: int | None, sha256: str | None
) -> tuple[str | None, str, bool]:
    """Return what is wrong with the file, its SHA-256, and whether there was a hash to compare with."""
    digest, length = file_hash(part), part.stat().st_size
    if size is not None and length != size:
        return f"the download has {length} bytes instead of {size}", digest, False
    expected = [digits for digits in (sha256, _stated_sha256(answer)) if digits is not None]
    for digits in expected:
        if not digest.startswith(digits.lower()):
            return f"the SHA-256 of the download starts with {digest[:8]} instead of {digits[:8]}", digest, True
    stated = _stated_md5(answer)
    if stated is not None:
        with open(part, "rb") as stream:
            if hashlib.file_digest(stream, "md5").digest() != stated:
                return "its MD5 is not the one that the server states", digest, True
    return None, digest, bool(expected) or stated is not None


def _stated_sha256(response: requests.Response) -> str | None:
    """Return the SHA-256 that Hugging Face states of a large file, in its answer or in the redirection before it."""
    for answer in (*response.history, response):
        digits = answer.headers.get("X-Linked-ETag", "").strip('"')
        if len(digits) == 64:
            return digits
    return None


def _stated_md5(response: requests.Response) -> bytes | None:
    """Return the MD5 that Google's storage states (https://cloud.google.com/storage/docs/xml-api/reference-headers)."""
    for part in response.headers.get("x-goog-hash", "").split(","):
        name, _, value = part.strip().partition("=")
        if name == "md5":
            return base64.b64decode(value)
    return None


def _etag_file(part: Path) -> Path:
    return part.with_name(f"{part.name}.etag")


def _length(part: Path) -> int:
    return part.stat().st_size if part.is_file() else 0


def _forget(part: Path) -> None:
    for path in (part, _etag_file(part)):
        path.unlink(missing_ok=True)


def _reason(error: requests.RequestException) -> str:
    """Return a short reason: the innermost exception tells more than the chain of those around it."""
    if error.response is not None:
        return f"HTTP {error.response.status_code}"
    cause: BaseException = error
    while cause.__cause__ is not None or cause.__context__ is not None:
        cause = cause.__cause__ or cause.__context__ or cause
    return str(cause) or type(cause).__name__
