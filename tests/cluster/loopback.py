"""A Slurm of one node on this machine, of Debian's packages slurmctld, slurmd, slurm-client and munge."""

import contextlib
import os
import shutil
import socket
import subprocess
import time
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel")
WHERE = f"{os.environ['PATH']}:/usr/sbin"

# Where a job's own srun looks for the configuration, because the executor takes all variables of Slurm from a job. To
# write there one must be root.
FOUND = Path("/run/slurm/conf")
OTHERS = (FOUND, Path("/etc/slurm/slurm.conf"))
CONFIGURATION = """
ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmctldPort={controller}
SlurmdPort={node}
SlurmdTimeout=20
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
MpiDefault=none
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory={memory} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def reason_not_to_run():
    """Return why no Slurm can be started here, or None."""
    missing = [name for name in PROGRAMS if shutil.which(name, path=WHERE) is None]
    if missing:
        return f"{', '.join(missing)} not installed: Debian's packages slurmctld, slurmd, slurm-client, munge"
    there = [str(path) for path in OTHERS if path.exists()]
    return f"there is a Slurm already: {there[0]}" if there else None if os.getuid() == 0 else "needs to be root"


def slurm(*words, folder):
    """Call a program of Slurm and return what it prints."""
    environment = os.environ | {"SLURM_CONF": str(folder / "slurm.conf"), "PATH": WHERE}
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}: {done.stdout}{done.stderr}"
    return done.stdout


def start_node(folder):
    """Start the daemon of the node, or start it again, and wait until it takes jobs."""
    slurm("slurmd", "-N", _host(), folder=folder)
    end = time.monotonic() + 60
    while slurm("sinfo", "--noheader", "--format=%t", folder=folder).strip() not in ("idle", "mix", "alloc"):
        assert time.monotonic() < end, slurm("sinfo", folder=folder)
        time.sleep(0.5)


def kill_node(folder):
    """Kill the daemon of the node as a failing machine would; its jobs' own processes are killed with it."""
    number = int((folder / "slurmd.pid").read_text())
    with contextlib.suppress(ProcessLookupError):
        os.kill(number, 9)
    subprocess.run(["pkill", "-9", "slurmstepd"], check=False)


@contextlib.contextmanager
def cluster(folder):
    """Yield while a Slurm runs that keeps all its files in ``folder``."""
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    ports = [_free_port() for _ in range(2)]
    told = {"folder": folder, "host": _host(), "user": _user(), "controller": ports[0], "node": ports[1]}
    (folder / "slurm.conf").write_text(CONFIGURATION.format(cores=os.cpu_count(), memory=_MEMORY, **told))
    (folder / "munge.key").write_bytes(os.urandom(1024))
    (folder / "munge.key").chmod(0o400)
    places = [f"--{name}={folder}/munge.{ending}" for name, ending in _MUNGE.items()]
    FOUND.parent.mkdir(exist_ok=True)
    FOUND.symlink_to(folder)
    slurm("munged", "--force", *places, folder=folder)
    try:
        slurm("slurmctld", folder=folder)
        start_node(folder)
        yield
    finally:
        FOUND.unlink()
        for name in ("slurmd.pid", "slurmctld.pid", "munge.pid"):
            with contextlib.suppress(OSError, ValueError):
                os.kill(int((folder / name).read_text()), 15)


_MUNGE = {"key-file": "key", "socket": "socket", "log-file": "log", "pid-file": "pid", "seed-file": "seed"}


_MEMORY = 64_000
"""Megabytes: more than any job asks for; nothing is held to it."""


def _host():
    return socket.gethostname().partition(".")[0]


def _user():
    import pwd

    return pwd.getpwuid(os.getuid()).pw_name


def _free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]
