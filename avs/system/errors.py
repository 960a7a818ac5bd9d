"""One exception for everything that a user can correct: bad input, bad configuration, a missing capability."""

from __future__ import annotations


class UserError(Exception):
    """A fault in what the user supplied, in one line: subject, fault and remedy.

    The command line prints it without a traceback and exits with status 2. Raise it only where the reader of the line
    can do something about the fault; a programming error keeps its traceback.
    """

    def __init__(self, subject: object, fault: str, remedy: str) -> None:
        """Join the three parts; ``subject`` is most often a path."""
        super().__init__(_one_line(f"{subject}: {fault}; {remedy}"))


def _one_line(text: str) -> str:
    """Return ``text`` without line breaks, and with escapes for what a terminal would act on or cannot show.

    Parts of it come from damaged files.
    """
    text = text.translate(dict.fromkeys(map(ord, "\t\n\r"), " "))
    return "".join(character if character.isprintable() else ascii(character)[1:-1] for character in text)
