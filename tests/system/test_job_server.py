"""Jobs that a run's server forks: the same work with the same end as of a process of its own."""

import os
import re
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from avs.system import job_server
from avs.system.job_client import VARIABLE

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the server is for Linux")

# A project of one command, so that a job can do anything: the run starts a server and its children ask it.
COMMANDS = """
    import os, sys, time, signal, tempfile
    if sys.argv[1] == "tell":
        forked = "avs.system.job_server" in open("/proc/self/cmdline").read()
        print(forked, sys.argv[2:], os.getcwd(), os.environ.get("TMPDIR"), tempfile.gettempdir(), sys.stdin.read())
        print("told", file=sys.stderr)
    elif sys.argv[1] == "exit":
        sys.exit(int(sys.argv[2]))
    elif sys.argv[1] == "fail":
        raise OSError("a fault of the job")
    elif sys.argv[1] == "die":
        os.kill(os.getpid(), int(sys.argv[2]))
    elif sys.argv[1] == "wait":
        def end(number, frame):
            os.write(1, b"ended in order")
            sys.exit(143)
        signal.signal(signal.SIGTERM, end)
        print(os.getpid(), os.getpgid(0), flush=True)
        time.sleep(60)
"""


@pytest.fixture
def project(tmp_path):
    """A folder with the server's modules and a command line that does what a test asks."""
    system = tmp_path / "avs" / "system"
    system.mkdir(parents=True)
    for name in ("compatibility", "errors", "job_client", "job_server", "numerics", "parent_process", "stub_library"):
        text = (ROOT / "avs" / "system" / f"{name}.py").read_text()
        (system / f"{name}.py").write_text(re.sub("^LIBRARIES = .*$", "LIBRARIES = ()", text, flags=re.MULTILINE))
    (tmp_path / "avs" / "__main__.py").write_text(
        "from avs.system.job_client import run_by_server\nrun_by_server()\n" + textwrap.dedent(COMMANDS)
    )
    return tmp_path


def in_run(project, body, **variables):
    """Return what a run prints that starts a server and then does ``body``, in which ``job`` runs a command."""
    program = """
        import os, signal, subprocess, sys, time
        from avs.system import job_server
        def words(*arguments):
            return [sys.executable, "-m", "avs", *map(str, arguments)]
        def job(*arguments, **options):
            done = subprocess.run(words(*arguments), text=True, capture_output=True, input="typed", **options)
            print(done.returncode, done.stdout, done.stderr, flush=True)
        job_server.start()
    """
    text = textwrap.dedent(program) + textwrap.dedent(body)
    environment = {name: value for name, value in os.environ.items() if name != VARIABLE} | variables
    words = [sys.executable, "-c", text]
    result = subprocess.run(
        words, cwd=project, env=environment, capture_output=True, text=True, check=False, timeout=60
    )
    assert result.returncode == 0, result.stderr
    assert not result.stderr, result.stderr
    return result.stdout


def test_a_job_has_what_its_process_was_given(project):
    (project / "elsewhere").mkdir()
    told = in_run(
        project,
        """
        job("tell", "a b", "ä", cwd="elsewhere", env=os.environ | {"TMPDIR": "/var", "PYTHONPATH": os.getcwd()})
        job("tell", env=os.environ | {"TMPDIR": "/var", "OMP_NUM_THREADS": "7"})
        """,
        PYTHONPATH=str(project),
    )
    first, second, *_ = told.splitlines()
    assert first == f"0 True ['a b', 'ä'] {project}/elsewhere /var /var typed"
    assert second == " told"
    assert "0 True [] " in told


def test_a_job_ends_as_its_process_would(project):
    told = in_run(project, 'job("exit", 3)\njob("fail")\njob("die", 9)\njob("die", 11)\njob("exit", 0)')
    assert told.startswith("3 ")
    assert "1  Traceback" in told
    assert "OSError: a fault of the job" in told
    assert "\n-9 " in told
    assert "\n-11 " in told
    assert told.splitlines()[-1].startswith("0 ")


@pytest.mark.parametrize(
    ("how", "options"),
    [
        ("another environment", 'env=os.environ | {"MKL_CBWR": "AVX2"}'),
        ("another environment", 'env=os.environ | {"PYTHONPATH": "."}'),
        ("not a child of the run", ""),
        ("a module was written anew", ""),
        ("no server listens", f'env=os.environ | {{"{VARIABLE}": "avs-none"}}'),
    ],
)
def test_what_would_be_another_job_starts_by_itself(project, how, options):
    before = {
        "not a child of the run": "words = lambda *told: ['sh', '-c', f'{sys.executable} -m avs tell; true']",
        "a module was written anew": "job('tell'); os.utime('avs/system/errors.py')",
    }.get(how, "")
    told = in_run(project, f'{before}\njob("tell", {options})').splitlines()
    assert [line.startswith("0 False") for line in told if line.startswith("0")][-1]


def test_a_job_is_forked_where_nothing_differs(project):
    assert in_run(project, 'job("tell")').startswith("0 True")


WAITING = """
    asked = subprocess.Popen(words("wait"), stdout=subprocess.PIPE, text=True)
    process, group = map(int, asked.stdout.readline().split())
    assert process != asked.pid and group == os.getpgid(0)
"""


def test_a_job_gets_the_signal_of_who_asked_for_it(project):
    told = in_run(project, WAITING + "    asked.terminate()\n    print(asked.stdout.read(), asked.wait())")
    assert told == "ended in order 143\n"


def test_a_job_ends_with_who_asked_for_it(project):
    told = in_run(project, WAITING + "    asked.kill()\n    print(asked.wait(), process)")
    status, process = map(int, told.split())
    assert status == -9
    assert _is_gone(process)


def test_a_job_ends_with_the_run_and_its_server(project):
    program = WAITING + "    print(process, asked.pid, flush=True)\n    os._exit(0)"
    process, asked = map(int, in_run(project, program).split())
    assert _is_gone(process)
    assert _is_gone(asked)


def test_who_asked_ends_with_a_killed_server_and_the_next_job_starts_by_itself(project):
    told = in_run(
        project,
        WAITING
        + """
    with open(f"/proc/{process}/stat") as stream:
        os.kill(int(stream.read().rpartition(")")[2].split()[1]), signal.SIGKILL)
    print(asked.wait(), process)
    job("tell")
    """,
    )
    status, process = map(int, told.splitlines()[0].split())
    assert status == -9
    assert _is_gone(process)
    assert told.splitlines()[1].startswith("0 False")


def test_jobs_run_beside_each_other(project):
    told = in_run(
        project,
        WAITING + '    job("exit", 4)\n    os.kill(process, signal.SIGKILL)\n    print(asked.wait())',
    )
    assert [line.split()[0] for line in told.splitlines() if line.strip()] == ["4", "-9"]


def test_the_server_imports_nothing_that_a_job_is_to_read():
    """A job of other code than a run was planned with is refused, but what was imported before is not looked at."""
    program = "import sys\nfrom avs.system import job_server\nassert job_server._import_libraries()\n"
    program += "print(*sorted(name for name in sys.modules if name.split('.')[0] in ('avs', 'metrics', 'tests')))"
    words = [sys.executable, "-c", program]
    told = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    needed = {"compatibility", "errors", "job_client", "job_server", "numerics", "parent_process", "stub_library"}
    assert set(told) == {"avs", "avs.system", *(f"avs.system.{name}" for name in needed)}


def test_no_library_starts_threads_when_it_is_imported():
    program = "import os\nfrom avs.system import job_server\nassert job_server._import_libraries()\n"
    program += "print(len(os.listdir('/proc/self/task')))"
    words = [sys.executable, "-c", program]
    assert subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout == "1\n"


def _is_gone(process):
    end = time.monotonic() + 5
    while time.monotonic() < end:
        try:
            if Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                return True
        except OSError:
            return True
        time.sleep(0.02)
    os.kill(process, signal.SIGKILL)
    return False


def test_without_the_kernels_help_there_is_no_server(monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(sys, "platform", "darwin")
    job_server.start()
    assert VARIABLE not in os.environ
