"""A digest of a job's command: what it is told beside the files that it reads, such as their order and use."""

from __future__ import annotations

import hashlib
import json
import shlex
from collections.abc import Sequence

MODULE = " -m avs "
"""Stands in a line of the shell before the options of all commands and the command."""

_QUOTES = frozenset("'\"\\")


def command_digest(words: Sequence[str]) -> str:
    """Return a digest of a command and its arguments.

    The options of all commands before it are left out: they tell of code and of files, whose digests are compared by
    themselves.

    Args:
        words: all behind ``python -m avs``; each option before the command has a value.
    """
    first = next((place for place in range(0, len(words), 2) if not words[place].startswith("--")), len(words))
    return hashlib.sha256(json.dumps(list(words[first:])).encode()).hexdigest()


def digest_of_line(line: str) -> str:
    """Return the ``command_digest`` of a command as a line of the shell that starts it."""
    told = line.partition(MODULE)[2]
    quoted = not _QUOTES.isdisjoint(told)
    return command_digest(shlex.split(told) if quoted else told.split())  # 0.4 ms a job, or a tenth of that
