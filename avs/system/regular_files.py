"""Guards for files of the user's that a program would wait on for ever, or read for ever."""

from __future__ import annotations

import stat
from pathlib import Path

from avs.system.errors import UserError


def check_regular(path: Path) -> None:
    """Raise a ``UserError`` if ``path`` is a pipe, a device or a socket; links are followed, folders pass.

    Raises:
        OSError: there is no such file, or it cannot be looked at.
        UserError: see above.
    """
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise UserError(path, "is a pipe or a device, not a file", "put a file in its place")
