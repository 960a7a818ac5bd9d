"""Names of methods and groups as a reader sees them: told apart where they look alike."""

from __future__ import annotations

import functools
import unicodedata
from collections import Counter
from collections.abc import Mapping

from avs.report.formats.plain_text import one_line
from avs.selection.contract import UNRANKED

GROUPS = ("Geometric", "3D-based", "2D-based")
"""Order of the groups; those that a plug-in adds follow, those that do not compete are the last."""

# No white space to Unicode, but empty where they are printed: fillers of Hangul, and Braille without a dot.
_BLANK = dict.fromkeys(map(ord, "\u115f\u1160\u3164\uffa0\u2800"), " ")
# Nothing by themselves: joiners of graphemes and selectors of a variant of the character before.
_UNSEEN = dict.fromkeys(
    [0x034F, 0x17B4, 0x17B5, *range(0x180B, 0x1810), *range(0xFE00, 0xFE10), *range(0xE0100, 0xE01F0)]
)


def visible(text: str) -> str:
    """Return ``text`` on one line, as far as anything of it can be seen, its characters composed."""
    return unicodedata.normalize("NFC", one_line(text.translate(_BLANK).translate(_UNSEEN)))


@functools.cache
def look(text: str) -> str:
    """Return what two texts share that look alike in one of the formats: there, accents may be lost."""
    parts = unicodedata.normalize("NFKD", visible(text))
    return visible("".join(part for part in parts if unicodedata.category(part) not in ("Mn", "Cn")))


def told_apart(labels: Mapping[str, str]) -> dict[str, str]:
    """Return printed names by identifier: labels as far as they can be seen, each alike another with its identifier.

    Args:
        labels: by identifier; one of which nothing is seen is the identifier itself.
    """
    plain = {name: visible(label) if look(label) else name for name, label in labels.items()}
    found, before = plain, dict[str, str]()
    while found != before:
        before, counted = found, Counter(map(look, found.values()))
        found = {name: f"{plain[name]} ({name})" if counted[look(told)] > 1 else told for name, told in found.items()}
    return found


def group_of(text: str) -> str:
    """Return the row group that a reader takes ``text`` for: one of those known, or the text as it is seen."""
    alike = (known for known in (*GROUPS, *UNRANKED) if look(known) == look(text))
    return next(alike, visible(text))
