"""A finished run that several files look at."""

import pytest

from tests.workflow.project import checkout, run


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """A checkout with a finished run at -j2; copy it to change it."""
    folder = checkout(tmp_path_factory.mktemp("finished"))
    result = run(folder, "-j2", "tables")
    assert result.returncode == 0, result.stdout + result.stderr
    return folder
