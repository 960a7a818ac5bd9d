"""A finished run that several files look at."""

import shutil

import pytest
from filelock import FileLock

from tests.workflow.project import checkout, run


@pytest.fixture(scope="session")
def finished(tmp_path_factory, worker_id):
    """A checkout with a finished run at -j2; copy it to change it. Processes that share the tests share the run."""
    alone = worker_id == "master"
    shared = tmp_path_factory.getbasetemp() if alone else tmp_path_factory.getbasetemp().parent
    made, mark = shared / "finished_run", shared / "finished_run.done"
    with FileLock(shared / "finished_run.lock"):
        if not mark.exists():
            shutil.rmtree(made, ignore_errors=True)
            made.mkdir()
            result = run(checkout(made), "-j2", "tables")
            assert result.returncode == 0, result.stdout + result.stderr
            mark.touch()
        return shutil.copytree(made, tmp_path_factory.mktemp("finished") / "run", symlinks=True)
