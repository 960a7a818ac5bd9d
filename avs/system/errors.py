"""One exception for everything that a user can correct: bad input, bad configuration, a missing capability."""

from __future__ import annotations


class UserError(Exception):
    """A fault in what the user supplied, in one line: subject, fault and remedy.

    The command line prints it without a traceback and exits with status 2. Raise it only where the reader of the line
    can do something about the fault; a programming error keeps its traceback.

    Attributes:
        subject: what is at fault, most often a path.
        fault: what is wrong with it.
        remedy: what the reader can do.
    """

    def __init__(self, subject: object, fault: str, remedy: str) -> None:
        """Join the three parts."""
        super().__init__(_one_line(f"{subject}: {fault}; {remedy}"))
        self.subject, self.fault, self.remedy = subject, fault, remedy

    def __reduce__(self) -> tuple[type[UserError], tuple[object, str, str]]:
        """Pickle by the three parts, as a process that is not the one at fault needs it."""
        return UserError, (self.subject, self.fault, self.remedy)


def _one_line(text: str) -> str:
    """Return ``text`` without line breaks, and with escapes for what a terminal would act on or cannot show.

    Parts of it come from damaged files.
    """
    text = text.translate(dict.fromkeys(map(ord, "\t\n\r"), " "))
    return "".join(character if character.isprintable() else ascii(character)[1:-1] for character in text)
