"""Starts a run's jobs from one process that has imported the libraries already, which takes seconds in each job.

A run starts one server (``start``), which forks itself for each job; ``avs.system.job_client`` asks it to. Only
libraries are imported before the fork: this project's code, and that of methods, a job reads when it begins, as one
does that starts by itself. The environment is the run's own, so that libraries have read the same variables.

Who may ask is a child of the same run. What the server could not do as that child would have done, it refuses, and the
child does it itself: in another environment, or once packages have been installed anew since the server began.

Linux only: the socket has no file, and so ends with the server, and the kernel tells who is at its other end.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import importlib
import json
import os
import runpy
import selectors
import signal
import socket
import struct
import subprocess
import sys
import sysconfig
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TextIO

from avs.system.compatibility import prepare_environment
from avs.system.job_client import ACCEPTED, LENGTH, REFUSED, STATUS, VARIABLE, peer, received
from avs.system.parent_process import die_with_parent

# What most jobs import: 2.7 s of the 3.2 s of processor time that an episode imports for (AMD EPYC Milan).
LIBRARIES = ("numpy", "torch", "numba", "PIL.Image", "scipy.spatial", "pydantic", "typer", "yaml")

# Variables that a job may have otherwise than its server: no library reads them when it is imported, or each job sets
# them itself (``prepare_environment``). Snakemake sets the numbers of threads and the folder of temporary files.
_OF_JOB = {"_", "OLDPWD", "PWD", "SHLVL", "TEMP", "TEMPDIR", "TMP", "TMPDIR"}
_THREADS = {f"{each}_NUM_THREADS" for each in ("GOTO", "MKL", "NUMEXPR", "OMP", "OPENBLAS")}
_MAY_DIFFER = _OF_JOB | _THREADS | {"VECLIB_MAXIMUM_THREADS", VARIABLE}

_PATIENCE = 5.0  # seconds for a request to arrive


@dataclass(frozen=True)
class Request:
    """What a job is: as ``avs.system.job_client`` tells it, its standard streams, and the process that asks for it."""

    executable: str
    arguments: list[str]
    folder: str
    environment: dict[str, str] = field(repr=False)
    streams: list[int]
    asking: int


def start() -> None:
    """Start a server for the jobs of this process, and tell its children of it; nothing where there can be none.

    The server ends with the calling thread. It imports nothing before the first job asks.
    """
    if sys.platform != "linux":
        return
    name = f"avs-{os.getpid()}-{os.urandom(8).hex()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listening:
        try:
            os.close(os.pidfd_open(os.getpid()))
            listening.bind(f"\0{name}")
            listening.listen(64)
        except OSError:  # a sandbox, or a kernel from before 2019
            return
        words = [sys.executable, "-m", "avs.system.job_server", str(listening.fileno()), str(os.getpid())]
        subprocess.Popen(words, stdin=subprocess.DEVNULL, pass_fds=[listening.fileno()])
    os.environ[VARIABLE] = name


class Server:
    """Answers requests one after another, and keeps the jobs that run."""

    def __init__(self, listening: socket.socket) -> None:
        """Remember the environment that the libraries are going to read."""
        self._listening = listening
        self._environment = dict(os.environ)
        self._loaded = _packages(), _other_modules()
        self._selector = selectors.DefaultSelector()
        self._processes: dict[socket.socket, int] = {}

    def serve(self) -> Request:
        """Answer until this process is killed; return, in one that was forked for a job, what is to be done there."""
        self._selector.register(self._listening, selectors.EVENT_READ, self._accept)
        while True:
            for key, _ in self._selector.select():
                request: Request | None = key.data()
                if request is not None:
                    return request

    def _accept(self) -> Request | None:
        connection, _ = self._listening.accept()
        connection.settimeout(_PATIENCE)
        streams: list[int] = []
        process = None
        try:
            header, streams, _, _ = socket.recv_fds(connection, LENGTH.size, 3)
            told = json.loads(received(connection, LENGTH.unpack(header)[0]))
            request = Request(**told, streams=streams, asking=peer(connection)[0])
            may = self._may(connection, request)
            connection.send(ACCEPTED if may else REFUSED)  # first, so that no job has begun where no answer came
            process = os.fork() if may else None
        except (OSError, ValueError, struct.error):  # who asked was killed meanwhile, or there is no room for a process
            pass
        if process == 0:
            self._selector.close()
            for each in (self._listening, connection, *self._processes):
                each.close()
            return request
        for stream in streams:
            os.close(stream)
        if process is None:
            connection.close()
        else:
            self._keep(connection, process)
        return None

    def _may(self, connection: socket.socket, request: Request) -> bool:
        """Return whether a job that is forked here is the one that would be started there."""
        _, user = peer(connection)
        return (
            user == os.getuid()
            and _parent(request.asking) == os.getppid()
            and request.executable == sys.executable
            and _told(request.environment) == _told(self._environment)
            and _import_libraries()
            and (_packages(), _other_modules()) == self._loaded
            and len(list(Path("/proc/self/task").iterdir())) == 1  # threads are not forked, and may hold locks
        )

    def _keep(self, connection: socket.socket, process: int) -> None:
        """Watch a job for its end, and who asked for it for what is to be passed on."""
        connection.settimeout(None)
        self._processes[connection] = process
        end = os.pidfd_open(process)
        self._selector.register(end, selectors.EVENT_READ, lambda: self._reap(connection, end))
        self._selector.register(connection, selectors.EVENT_READ, lambda: self._pass_on(connection))

    def _pass_on(self, connection: socket.socket) -> None:
        """Give a job the signal that who asked for it got; where that is gone, end the job."""
        if connection not in self._processes:  # its end was told a moment ago
            return
        try:
            signals = connection.recv(1)
        except OSError:
            signals = b""
        os.kill(self._processes[connection], signals[0] if signals else signal.SIGKILL)
        if not signals:
            self._selector.unregister(connection)

    def _reap(self, connection: socket.socket, end: int) -> None:
        """Tell of a job's end."""
        _, status = os.waitpid(self._processes.pop(connection), 0)
        self._selector.unregister(end)
        os.close(end)
        with contextlib.suppress(KeyError):  # who asked is gone
            self._selector.unregister(connection)
        with contextlib.suppress(OSError):
            connection.send(STATUS.pack(os.waitstatus_to_exitcode(status)))
        connection.close()


def become(request: Request) -> None:
    """Do the work of the process that asks, in this one that was forked for it, as the command line does."""
    with contextlib.suppress(OSError):  # who asked has ended
        os.setpgid(0, os.getpgid(request.asking))
    for stream, source in enumerate(request.streams):
        os.dup2(source, stream)
        os.close(source)
    # Those of the server know what its own were: whether they are a terminal, and where in a file they stand.
    sys.stdin, sys.stdout, sys.stderr = _anew(sys.stdin, "r"), _anew(sys.stdout, "w"), _anew(sys.stderr, "w")
    os.chdir(request.folder)
    own = request.environment
    os.environ.update({name: own[name] for name in _OF_JOB & own.keys()})
    tempfile.tempdir = None
    if "numpy" in sys.modules:  # its generator was seeded when it was imported; Python's seeds itself anew after a fork
        sys.modules["numpy"].random.seed()
    sys.argv[1:] = request.arguments  # runpy sets the first
    runpy.run_module("avs", run_name="__main__", alter_sys=True)


@functools.cache
def _import_libraries() -> bool:
    """Import them as a job does; return whether that was possible."""
    prepare_environment()
    try:
        for name in LIBRARIES:
            importlib.import_module(name)
    except ImportError:  # a job will say so
        return False
    gc.collect()
    gc.freeze()  # else the first collection in each job would copy the pages of all that was imported
    return True


def _anew(stream: TextIO, mode: Literal["r", "w"]) -> TextIO:
    """Return a stream of the same descriptor and encoding."""
    lines = 1 if stream is sys.stderr else -1
    return open(stream.fileno(), mode, lines, stream.encoding, stream.errors, closefd=False)


def _told(environment: dict[str, str]) -> dict[str, str]:
    return {name: value for name, value in environment.items() if name not in _MAY_DIFFER}


def _parent(process: int) -> int:
    """Return the parent of a process; 0 where that has ended."""
    try:
        told = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return 0
    return int(told.rpartition(")")[2].split()[1])  # a program's name, which comes before, may hold anything


def _packages() -> list[int]:
    """Return what changes when a package is installed or removed: the times of the folders that hold them."""
    return [Path(sysconfig.get_path(name)).stat().st_mtime_ns for name in ("purelib", "platlib")]


def _other_modules() -> dict[str, int | None]:
    """Return the times of the files of loaded modules that are no library's: the server's own, and somebody's hooks."""
    libraries = tuple(f"{sysconfig.get_path(name)}/" for name in ("stdlib", "platstdlib", "purelib", "platlib"))
    files = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    paths = (path for path in files if isinstance(path, str) and path.startswith("/"))  # torch names some by no path
    return {path: _time(path) for path in paths if not path.startswith(libraries)}


def _time(path: str) -> int | None:
    try:
        return Path(path).stat().st_mtime_ns
    except OSError:
        return None


def main() -> None:
    """Serve the run that started this process, or be one of its jobs."""
    die_with_parent(int(sys.argv[2]))
    interrupt = signal.signal(signal.SIGINT, signal.SIG_IGN)  # what ends the run ends the server
    server = os.getpid()
    request = Server(socket.socket(fileno=int(sys.argv[1]))).serve()
    signal.signal(signal.SIGINT, interrupt)
    die_with_parent(server)
    become(request)


if __name__ == "__main__":
    main()
