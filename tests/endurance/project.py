"""A project with every kind of job, for a run of a minute, and what of its results must be the same bytes."""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time

import yaml
from factories import small_scene

from tests.workflow.project import ROOT, checkout, environment, tiny

PROGRAM = """import argparse, json
from pathlib import Path
parser = argparse.ArgumentParser()
parser.add_argument("scene", type=Path)
parser.add_argument("seed", type=int)
parser.add_argument("--settings", type=Path)
parser.add_argument("--out", type=Path)
told = parser.parse_args()
names = sorted(path.name for path in (told.scene / "images").iterdir())
test = json.loads((told.scene / "scene.json").read_text())["test"]
views = [name for name in names if name not in test]
told.out.write_text(json.dumps({"label": "Backwards", "views": views[::-1]}))
"""
RULE = """use rule views from program as backwards with:
    input: **inputs_of("backwards.py")
    output: views_of("backwards")
"""
NOT_COMPARED = ("logs", "runtime", "set_aside", "compiled")


def lay_out(folder):
    """Lay out the project in ``folder``: a capture, embedded scenes for a scorer, the scorer, a program."""
    checkout(folder)
    small_scene(folder / "captures" / "desk", count=16, name="desk", size=(48, 32))
    (folder / "captures" / "desk" / "scene.json").unlink()
    (folder / "backwards.py").write_text(PROGRAM)
    (folder / "workflows" / "baselines" / "backwards.smk").write_text(RULE)
    (folder / "tiny.yaml").write_text(yaml.safe_dump(configuration()))
    return folder


def configuration():
    """Return the settings of the run."""
    values = tiny()
    values["methods"] = ["random", "backwards", "ours-repvit"]
    check = yaml.safe_load((ROOT / "workflows" / "config" / "check.yaml").read_text())
    values["scorers"] = {"repvit": check["scorers"]["repvit"]}
    values["coverage"] = check["coverage"]
    values["distortions"]["renders"] = {"cameras": 4, "views": [4, 6], "iterations": [4, 8]}
    for name in ("handheld_training", "handheld_held_out"):
        values["datasets"][name] = check["datasets"][name]
    del values["datasets"]["orbit"]  # scenes of its kind are among those for scorers
    values["datasets"]["desk"] = {"source": "captures", "folder": "captures"}
    return values


def copy(finished, folder):
    """Copy a finished project with the times of its files, as if it had been left for a while."""
    subprocess.run(["cp", "-a", str(finished), str(folder)], check=True)
    shutil.rmtree(folder / ".snakemake" / "log", ignore_errors=True)
    return folder


def words(resume=False):
    """Return the command of a run."""
    command = [sys.executable, "-m", "avs", "resume"] if resume else ["snakemake"]
    return [*command, "-j2", "tables", "--configfile", "tiny.yaml"]


def finish(folder):
    """Complete the run as a user does, and return the finished process."""
    result = subprocess.run(words(True), cwd=folder, env=environment(), capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-3000:]
    return result


def killed_run(folder, seconds, whom, choose):
    """Start a run and kill -9 something of it after some seconds: the main process, all of it, or one job."""
    with open(folder / "killed.log", "w") as log:
        process = subprocess.Popen(
            words(True), cwd=folder, env=environment(), stdout=log, stderr=log, start_new_session=True
        )
    end = time.monotonic() + seconds
    while time.monotonic() < end and process.poll() is None:
        time.sleep(0.02)
    if process.poll() is None and whom == "main":
        process.kill()
    elif process.poll() is None and whom == "all":
        os.killpg(process.pid, signal.SIGKILL)
    elif process.poll() is None:
        jobs = _jobs(process.pid)
        if jobs:
            os.kill(choose(jobs), signal.SIGKILL)
    process.wait()
    time.sleep(0.5)  # orphans end by themselves


def results(folder):
    """Return the hash of every result that is the same in every run, by path."""
    root = folder / "results" / "tiny"
    paths = [path for path in sorted(root.rglob("*")) if path.is_file() and not path.name.endswith(".meta.json")]
    told = {str(path.relative_to(root)): path for path in paths if path.relative_to(root).parts[0] not in NOT_COMPARED}
    return {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in told.items()}


def difference(found, expected):
    """Return the names that differ: of all that is expected, and whatever else stands among tables and figures."""
    shown = {name for name in found if name.startswith(("tables", "figures"))}
    return sorted(name for name in {*expected, *shown} if found.get(name) != expected.get(name))


def _jobs(parent):
    """Return the processes of jobs below ``parent``, ascending."""
    listed = subprocess.run(["ps", "-eo", "pid,sid,args"], capture_output=True, text=True, check=True).stdout
    rows = [line.split(None, 2) for line in listed.splitlines()[1:]]
    return sorted(
        int(pid) for pid, session, args in rows if int(session) == parent and "-m avs" in args and "resume" not in args
    )
