"""Text from records, which may hold anything, before a format escapes what it takes as a command."""

from __future__ import annotations

import unicodedata


def one_line(text: str) -> str:
    """Return ``text`` on one line: white space of any kind becomes one space, of which none is at the ends.

    Control characters are dropped first, so that none of them keeps a space.
    """
    kept = (each for each in text if each.isspace() or unicodedata.category(each) not in ("Cc", "Cf", "Cs"))
    return " ".join("".join(kept).split())
