"""Text from records, which may hold anything, before a format escapes what it takes as a command."""

from __future__ import annotations

import unicodedata


def one_line(text: str) -> str:
    """Return ``text`` on one line: white space of any kind becomes one space; control characters are dropped."""
    spaced = " ".join(text.split())
    return "".join(character for character in spaced if unicodedata.category(character) not in ("Cc", "Cf", "Cs"))
