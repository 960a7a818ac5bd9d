"""Processor time of episodes with portable numerics against native ones: what the same bits on every machine cost.

Run from the root of the repository, after ``snakemake -j2 tables``: ``python -m tests.benchmarks.bench_numerics``. Each
episode runs anew, in a temporary folder, in turn with both numerics; kernels are compiled before.
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


def seconds(numerics, words):
    """Return the processor time of one command of the suite."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = os.environ | {"AVS_NUMERICS": numerics}
    subprocess.run([sys.executable, "-m", "avs", *map(str, words)], env=environment, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    """Print a line for each method."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, default=Path("results/ci"))
    parser.add_argument("--scene", default="orbit/orbit_0")
    parser.add_argument("--methods", nargs="+", default=["random", "fisherrf", "ours-lite0"])
    parser.add_argument("--repetitions", type=int, default=3)
    told = parser.parse_args()
    for numerics in ("portable", "native"):
        seconds(numerics, ["kernels", "gaussians"])
    for method in told.methods:
        weights = told.results / "scorer" / method.removeprefix("ours-") / "weights.safetensors"
        settings = told.results / "settings" / "episode" / f"{method}.json"
        words = ["episode", told.results / "scenes" / told.scene, 0, "--settings", settings]
        words += ["--weights", weights] if weights.exists() else []
        found = {"portable": [], "native": []}
        for _ in range(told.repetitions):
            for numerics, times in found.items():
                with tempfile.TemporaryDirectory() as folder:
                    times.append(seconds(numerics, [*words, "--out", Path(folder) / "episode"]))
        portable, native = (statistics.median(times) for times in found.values())
        ends = ", ".join(f"{name} {min(times):.1f} to {max(times):.1f}" for name, times in found.items())
        print(f"{method}: {portable:.1f} s against {native:.1f} s, {portable / native - 1:+.0%} ({ends})", flush=True)


if __name__ == "__main__":
    main()
