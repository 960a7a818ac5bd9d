"""A call to complete a run that is killed itself leaves nothing behind."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from avs.system.resume import runs_in

ROOT = Path(__file__).parents[2]


def wait_until(holds, seconds=30):
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for the end with the parent")
def test_what_it_starts_goes_on_when_its_shell_ends(tmp_path):
    program = tmp_path / "bin" / "snakemake"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\ncase $* in *--unlock*) exit 0;; esac\ntouch begun; sleep 1; touch ended\n")
    program.chmod(0o755)
    environment = os.environ | {"PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    line = f"{sys.executable} -m avs resume tables > /dev/null 2>&1 & while [ ! -e begun ]; do sleep 0.05; done"
    subprocess.run(["sh", "-c", line], cwd=tmp_path, env=environment, check=True, timeout=60)
    wait_until((tmp_path / "ended").exists)


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for the end with the parent")
def test_killed_while_it_unlocks_it_leaves_no_run(tmp_path):
    program = tmp_path / "bin" / "snakemake"
    program.parent.mkdir()
    program.write_text(f"#!{sys.executable}\nimport time\ntime.sleep(600)\n")
    program.chmod(0o755)
    environment = os.environ | {"PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    words = [sys.executable, "-m", "avs", "resume", "tables"]
    process = subprocess.Popen(words, cwd=tmp_path, env=environment)
    try:
        wait_until(lambda: list(runs_in(tmp_path)))
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    wait_until(lambda: not list(runs_in(tmp_path)))
