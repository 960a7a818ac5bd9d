"""A digest that lies inside the file that it is of: computed while zeros stand in its place."""

from __future__ import annotations

import hashlib

UNKNOWN = "0" * 64
"""Stands in the digest's place while it is computed, and once in what ``sealed`` takes."""


def sealed(content: bytes) -> bytes:
    """Return a file's content with its SHA-256 in the place of the first ``UNKNOWN``."""
    return content.replace(UNKNOWN.encode(), hashlib.sha256(content).hexdigest().encode(), 1)


def is_sealed(content: bytes, digest: str) -> bool:
    """Return whether ``content``, which holds ``digest``, is as ``sealed`` left it."""
    return hashlib.sha256(content.replace(digest.encode(), UNKNOWN.encode(), 1)).hexdigest() == digest
