"""Lets a run's server start this process's command, if there is one: see ``avs.system.job_server``.

This module is all that such a process imports, and so needs the standard library alone.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import struct
import sys
from pathlib import Path

VARIABLE = "AVS_JOB_SERVER"
"""The environment variable that names the socket of a run's server."""

ACCEPTED, REFUSED = b"+", b"-"
STATUS = struct.Struct("!i")
"""How a job's end is told: as ``os.waitstatus_to_exitcode`` has it."""

LENGTH = struct.Struct("!I")
"""What a request begins with: how many bytes of JSON follow."""

_CREDENTIALS = struct.Struct("3i")  # of Linux: process, user, group


def run_by_server() -> None:
    """Let this run's server do this process's work, and end as that ended; return if the work is to be done here.

    A job that the server runs has the environment, the folder, the arguments and the standard streams of this process,
    ends with it, gets its SIGTERM, and, as it is in its process group, the terminal's signals.
    """
    name = os.environ.get(VARIABLE)
    if name is None or sys.platform != "linux":
        return
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        connection.connect(f"\0{name}")
        # Who listens is the run itself, whose child this is; another's run, whose variable was handed on, is not asked.
        if peer(connection) != (os.getppid(), os.getuid()):
            return
        _ask(connection)
        if received(connection, 1) != ACCEPTED:
            return
    except OSError:
        return
    signal.signal(signal.SIGTERM, lambda number, frame: _pass_on(connection, number))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the job gets its own
    try:
        (status,) = STATUS.unpack(received(connection, STATUS.size))
    except (OSError, struct.error):  # the server was killed, and its jobs with it
        status = -signal.SIGKILL
    if status < 0:
        with contextlib.suppress(OSError):  # SIGKILL has no handler
            signal.signal(-status, signal.SIG_DFL)
        os.kill(os.getpid(), -status)
    os._exit(status)


def peer(connection: socket.socket) -> tuple[int, int]:
    """Return the process, and its user, that is at the other end of a local socket, as the kernel knows it."""
    option = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    process, user, _ = _CREDENTIALS.unpack(option)
    return process, user


def received(connection: socket.socket, count: int) -> bytes:
    """Return the next ``count`` bytes, fewer where the other end is closed."""
    found = b""
    while len(found) < count and (more := connection.recv(count - len(found))):
        found += more
    return found


def _pass_on(connection: socket.socket, number: int) -> None:
    with contextlib.suppress(OSError):  # the job has just ended
        connection.send(bytes([number]))


def _ask(connection: socket.socket) -> None:
    """Send what tells of this process's work, and its standard streams."""
    about = {
        "executable": sys.executable,
        "arguments": sys.argv[1:],
        "folder": str(Path.cwd()),
        "environment": dict(os.environ),
    }
    text = json.dumps(about).encode()
    socket.send_fds(connection, [LENGTH.pack(len(text))], [0, 1, 2])
    connection.sendall(text)
