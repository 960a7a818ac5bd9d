"""Processor time of a run's jobs that its server forks against the same jobs started by themselves.

Run from the root of the repository, after ``snakemake -j2 tables``: ``python -m tests.benchmarks.bench_job_server``.
Two jobs, in turn each way: an episode, and one that does next to nothing, so that its time is what a start costs.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from avs.system import job_server
from avs.system.job_client import VARIABLE


def of_children():
    """Return the processor time of this process's children that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def of_server(process):
    """Return the processor time of a server that runs, with that of the jobs that have ended."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def server():
    """Start a server and return its process and the name of its socket."""
    before = set(Path(f"/proc/self/task/{os.getpid()}/children").read_text().split())
    job_server.start()
    (process,) = set(Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()) - before
    return int(process), os.environ.pop(VARIABLE)


def main():
    """Print a line for each job."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, default=Path("results/ci"))
    parser.add_argument("--scene", default="orbit/orbit_0")
    parser.add_argument("--repetitions", type=int, default=5)
    told = parser.parse_args()
    settings = told.results / "settings" / "episode" / "random.json"
    episode = ["episode", told.results / "scenes" / told.scene, 0, "--settings", settings]
    process, name = server()

    def seconds(words, variables):
        before = of_children() + of_server(process)
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-m", "avs", *map(str, words)]
            command += ["--out", f"{folder}/episode"] if words[0] == "episode" else []
            subprocess.run(command, env=os.environ | variables, check=True, capture_output=True)
        return of_children() + of_server(process) - before

    for words in (["kernels", "gaussians"], episode):
        seconds(words, {VARIABLE: name})  # the libraries are imported, and kernels compiled
        found = {"by itself": [], "forked": []}
        for _ in range(told.repetitions):
            found["by itself"].append(seconds(words, {}))
            found["forked"].append(seconds(words, {VARIABLE: name}))
        alone, forked = (statistics.median(times) for times in found.values())
        ends = ", ".join(f"{way} {min(times):.1f} to {max(times):.1f}" for way, times in found.items())
        told_of = f"{alone:.1f} s by itself, {forked:.1f} s forked, {alone / forked:.2f} x"
        print(f"{words[0]}: {told_of} ({ends})", flush=True)


if __name__ == "__main__":
    main()
