"""One exception for everything that a user can correct: bad input, bad configuration, a missing capability."""


class UserError(Exception):
    """A fault in what the user supplied, in one line: subject, fault and remedy.

    The command line prints it without a traceback and exits with status 2. Raise it only where the reader of the line
    can do something about the fault; a programming error keeps its traceback.
    """

    def __init__(self, subject: object, fault: str, remedy: str) -> None:
        """Join the three parts; ``subject`` is most often a path."""
        super().__init__(f"{subject}: {fault}; {remedy}")
