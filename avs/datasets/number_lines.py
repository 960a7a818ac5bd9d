"""Text files with a record of numbers in each line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from avs.system.errors import UserError
from avs.system.regular_files import check_regular


@dataclass(frozen=True)
class TextLine:
    """A line of a file that is not blank.

    Attributes:
        path: the file.
        number: of the line, from 1.
        text: the line without blanks at its ends.
    """

    path: Path
    number: int
    text: str

    @property
    def words(self) -> list[str]:
        """What blanks separate."""
        return self.text.split()


def text_lines(path: Path, remedy: str) -> list[TextLine]:
    """Return the lines of a file that are not blank.

    Raises:
        UserError: the file is missing, or no text; ``remedy`` says what to do.
    """
    if not path.exists():
        raise UserError(path, "is missing", remedy)
    check_regular(path)
    try:
        lines = path.read_text(encoding="utf-8-sig").split("\n")
    except UnicodeDecodeError as error:
        raise UserError(path, "is no text", remedy) from error
    found = [TextLine(path, number, line.strip()) for number, line in enumerate(lines, 1)]
    return [line for line in found if line.text]


def numbers_of(line: TextLine, words: Sequence[str], count: int, remedy: str) -> list[float]:
    """Return ``words`` of a line as finite numbers.

    Raises:
        UserError: there are not ``count`` of them, or one is no finite number.
    """
    if len(words) != count:
        fault = f"line {line.number} has {len(words)} numbers, not {count}: it is damaged or cut off"
        raise UserError(line.path, fault, remedy)
    try:
        numbers = [float(word) for word in words]
    except ValueError as error:
        raise UserError(line.path, f"line {line.number} is damaged: '{line.text[:60]}'", remedy) from error
    if not all(map(math.isfinite, numbers)):
        raise UserError(line.path, f"line {line.number} has a number that is not finite", remedy)
    return numbers
