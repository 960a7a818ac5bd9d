"""A job's log, its one line for a fault, and its end with its parent."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from avs.system.job_logs import fault_of

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


def test_a_programming_error_is_one_line_and_keeps_its_traceback_in_the_log(tmp_path):
    log = tmp_path / "job.log"
    result = run("1 / 0", log)
    assert result.returncode == 1
    assert result.stderr.startswith(
        "error: <string>, line 4: ZeroDivisionError: division by zero; a fault of the program"
    )
    assert result.stderr.count("\n") == 1
    assert log.read_text().startswith("Traceback")
    assert log.read_text().endswith(result.stderr)


ENDINGS = {
    "raise MemoryError": (2, "memory: there is not enough; run fewer jobs"),
    "import numpy; numpy.empty(1 << 44)": (2, "memory: there is not enough (Unable to allocate"),
    "import torch; torch.empty(1 << 44)": (2, "memory: there is not enough"),
    "import no_such_package": (2, "no_such_package: No module named 'no_such_package'; say source .venv/bin/activate,"),
    "from avs.system import nothing": (1, "<string>, line 4: ImportError: cannot import name"),
    "import sys; sys.exit(0)": (1, "<string>, line 4: ended the program; let it raise"),
    "import sys; sys.exit('no')": (1, "<string>, line 4: ended the program (no); let it raise"),
    "def f(): f()\nf()": (1, "<string>, line 4: RecursionError"),
    "raise KeyboardInterrupt": (130, "interrupted: "),
    "try:\n    raise KeyboardInterrupt\nexcept BaseException as e:\n    raise SystemError('a result') from e": (
        130,
        "interrupted: ",
    ),
    # one over the other, as where numba and torch are called from one another
    "a, b = SystemError('a'), SystemError('b')\na.__cause__, b.__cause__ = KeyboardInterrupt(), a\nraise b": (
        130,
        "interrupted: ",
    ),
    "import os, signal, time; os.kill(os.getpid(), signal.SIGTERM); time.sleep(9)": (143, "terminated: "),
    "raise OSError(28, 'No space left on device', 'x.png')": (2, "x.png: no space left on device; free some space"),
    "raise OSError('encoder error -2')": (2, "a file: encoder error -2; check the path and the disk"),
    "raise ValueError('of\\ntwo lines')": (1, "<string>, line 4: ValueError: of two lines; a fault of the program"),
}


@pytest.mark.parametrize("body", ENDINGS)
@pytest.mark.parametrize("with_log", [True, False])
def test_whatever_a_job_meets_is_one_line_with_a_status(body, with_log, tmp_path):
    status, line = ENDINGS[body]
    result = run(body, tmp_path / "job.log" if with_log else None)
    assert result.returncode == status
    assert result.stderr.splitlines()[-1].startswith(f"error: {line}")
    if with_log:
        assert result.stderr.count("\n") == 1
        assert fault_of(tmp_path / "job.log") == result.stderr.strip().removeprefix("error: ")


def test_a_log_that_cannot_be_opened_is_one_line(tmp_path):
    (tmp_path / "logs").write_text("a file, no folder")
    result = run("print(1)", tmp_path / "logs" / "job.log")
    assert result.returncode == 2
    assert result.stderr == f"error: {tmp_path / 'logs'}: file exists; check the path and the disk, then run again\n"


def test_a_terminated_job_leaves_nothing_half_written(tmp_path):
    body = "import os, signal, time\nfrom avs.system.files import atomic_path\n"
    body += f"with atomic_path({str(tmp_path / 'result.json')!r}) as path:\n"
    body += "    path.write_text('half')\n    os.kill(os.getpid(), signal.SIGTERM)\n    time.sleep(9)"
    assert run(body).returncode == 143
    assert list(tmp_path.iterdir()) == []


def test_an_import_that_fails_before_any_command_is_one_line(tmp_path):
    (tmp_path / "typer.py").write_text("raise ImportError('broken', name='typer')")
    words = [sys.executable, "-m", "avs", "kernels"]
    where = os.environ | {"PYTHONPATH": str(tmp_path)}
    result = subprocess.run(words, cwd=ROOT, env=where, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stderr.splitlines()[-1] == (
        "error: typer: broken; say source .venv/bin/activate, or install environment.txt where there is no .venv"
    )


def test_an_error_of_the_system_names_file_and_remedy(tmp_path):
    result = run("open('nowhere/x.json')", tmp_path / "job.log")
    assert result.returncode == 2
    assert result.stderr.startswith("error: nowhere/x.json: no such file or directory; ")


def test_a_job_ends_with_its_parent(tmp_path):
    mark = tmp_path / "mark"
    child = f"""
import time
from avs.system.parent_process import die_with_parent
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


def test_a_fault_of_a_method_names_the_method(tmp_path):
    body = "error = KeyError('x')\nerror.add_note('method Mine')\nraise error"
    result = run(body, tmp_path / "job.log")
    assert result.stderr.startswith("error: method Mine: <string>, line 6: KeyError: 'x'; ")


@pytest.mark.parametrize("lines", [1, 100_000])
def test_a_reader_that_has_had_enough_is_no_fault(lines, tmp_path):
    body = (
        "import sys, time\nfrom avs.system.job_process import job\n"
        f"with job(None):\n    time.sleep(0.5)\n    [print('x' * 50) for _ in range({lines})]"
    )
    running = subprocess.Popen([sys.executable, "-c", body], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    running.stdout.close()
    assert running.stderr.read() == b""
    running.wait()


def test_a_package_that_is_not_installed_is_one_line_without_a_traceback(tmp_path):
    """As for who has not said ``source .venv/bin/activate``."""
    words = [sys.executable, "-S", "-m", "avs", "status"]
    result = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stderr.startswith("error: ")
    assert result.stderr.count("\n") == 1
    assert "say source .venv/bin/activate" in result.stderr
