"""A job's log, its one line for a fault, and its end with its parent."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run(body, log=None):
    code = "from pathlib import Path\nfrom avs.system.job_process import job\n"
    code += f"with job({log and f'Path({str(log)!r})'}) as console:\n"
    code += "\n".join(f"    {line}" for line in body.splitlines())
    return subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)


def test_a_users_fault_is_one_line_in_the_log_and_on_the_terminal(tmp_path):
    log = tmp_path / "logs" / "job.log"
    body = "from avs.system.errors import UserError\nprint('working')\n"
    body += "raise UserError('a.png', 'is truncated', 'copy it again')"
    result = run(body, log)
    line = "error: a.png: is truncated; copy it again\n"
    assert result.returncode == 2
    assert result.stderr == line
    assert log.read_text() == "working\n" + line


def test_output_of_libraries_goes_to_the_log(tmp_path):
    log = tmp_path / "job.log"
    result = run("import os\nos.system('echo from a library; echo an alarm >&2')\nconsole.progress('step 1')", log)
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
    assert log.read_text() == "from a library\nan alarm\nstep 1\n"


def test_a_programming_error_keeps_its_traceback(tmp_path):
    log = tmp_path / "job.log"
    result = run("1 / 0", log)
    assert result.returncode == 1
    assert "ZeroDivisionError" in log.read_text()


def test_an_error_of_the_system_names_file_and_remedy(tmp_path):
    result = run("open('nowhere/x.json')", tmp_path / "job.log")
    assert result.returncode == 2
    assert result.stderr.startswith("error: nowhere/x.json: no such file or directory; ")


def test_a_job_ends_with_its_parent(tmp_path):
    mark = tmp_path / "mark"
    child = f"""
import time
from avs.system.job_process import die_with_parent
die_with_parent()
open({str(mark)!r}, "w").write("ready")
time.sleep(60)
"""
    parent = f"import subprocess, sys\nsubprocess.run([sys.executable, '-c', {child!r}])"
    process = subprocess.Popen([sys.executable, "-c", parent], cwd=ROOT, start_new_session=True)
    try:
        assert _until(lambda: mark.exists() and mark.read_text() == "ready")
        pids = [int(pid) for pid in _children(process.pid)]
        assert pids
        process.kill()
        process.wait()
        assert _until(lambda: not any(_alive(pid) for pid in pids))
    finally:
        with_group(process.pid)


def with_group(pid):
    """End whatever the test left behind."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)


def _children(pid):
    return Path(f"/proc/{pid}/task/{pid}/children").read_text().split()


def _alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def _until(condition, seconds=20):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False
