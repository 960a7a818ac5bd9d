"""Tables made on a Slurm of this machine are those of a local run, also where a job is cancelled and the node dies."""

import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest

from tests.cluster.loopback import WHERE, cluster, kill_node, reason_not_to_run, slurm, start_node
from tests.workflow.project import ROOT, checkout, environment, run

REASON = reason_not_to_run() if os.environ.get("AVS_CLUSTER") == "1" else "minutes long, starts daemons: make cluster"
pytestmark = pytest.mark.skipif(REASON is not None, reason=str(REASON))
# What a job prints, when it ran, and the date in a pdf.
VARIES = (".log", ".meta.json", ".pdf", ".sha256")
WORDS = ("snakemake", "--workflow-profile", "profiles/slurm", "--slurm-status-command", "squeue", "tables")


@pytest.fixture(scope="module")
def node(tmp_path_factory):
    folder = tmp_path_factory.mktemp("slurm")
    with cluster(folder):
        yield folder


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    folder = checkout(tmp_path_factory.mktemp("local") / "project")
    result = run(folder, "-j2", "tables")
    assert result.returncode == 0, result.stderr
    return results(folder)


def results(folder):
    root = folder / "results" / "tiny"
    files = [path for path in root.rglob("*") if path.is_file() and not path.name.endswith(VARIES)]
    return {str(path.relative_to(root)): path.read_bytes() for path in files if "logs" not in path.parts}


def started(folder, node):
    told = environment() | {"SLURM_CONF": str(node / "slurm.conf")}
    told["PATH"] = f"{told['PATH']}:{WHERE}"
    with open(folder / "run.log", "w") as log:
        return subprocess.Popen([*WORDS, "--configfile", "tiny.yaml"], cwd=folder, env=told, stdout=log, stderr=log)


def laid_out(folder):
    checkout(folder)
    shutil.copytree(ROOT / "profiles" / "slurm", folder / "profiles" / "slurm", dirs_exist_ok=True)
    return folder


def running(node):
    """Return the numbers of the jobs that run."""
    return slurm("squeue", "--noheader", "--states=R", "--format=%A", folder=node).split()


def wait_until(holds, seconds=300):
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.2)


def test_tables_are_those_of_a_local_run(node, expected, tmp_path):
    folder = laid_out(tmp_path / "project")
    assert started(folder, node).wait(timeout=1800) == 0, (folder / "run.log").read_text()[-3000:]
    assert results(folder) == expected


def test_a_cancelled_job_and_a_dead_node_cost_nothing_but_time(node, expected, tmp_path):
    folder = laid_out(tmp_path / "project")
    process = started(folder, node)
    wait_until(lambda: running(node))
    slurm("scancel", running(node)[0], folder=node)
    wait_until(lambda: Path(folder / "results/tiny/kernels").exists() and running(node))
    kill_node(node)
    time.sleep(5)
    start_node(node)
    status = process.wait(timeout=1800)
    if status:  # a job was lost for good; the same line goes on
        assert started(folder, node).wait(timeout=1800) == 0, (folder / "run.log").read_text()[-3000:]
    assert results(folder) == expected
