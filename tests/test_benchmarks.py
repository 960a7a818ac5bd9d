"""Benchmarks measure and are no tests; that each still finds what it measures is one."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_every_benchmark_finds_what_it_imports():
    names = sorted(path.stem for path in Path(__file__).with_name("benchmarks").glob("[a-z]*.py"))
    assert names
    lines = [f"import tests.benchmarks.{name}" for name in names]
    found = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stderr
