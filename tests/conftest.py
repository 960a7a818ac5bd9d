"""Fixtures that several rooms share."""

import os
from pathlib import Path

import pytest

from avs.system.compatibility import prepare_environment

# Before numpy and torch are imported by a test module: threads and their waiting are decided then.
prepare_environment()


def shared(name, what) -> Path:
    """Return a folder of files that are not part of the repository; skip the test where it is missing."""
    folder = Path(os.environ.get("AVS_SHARED", Path(__file__).parent.parent / ".." / "shared")) / name
    if not folder.is_dir():
        pytest.skip(f"no {what}: {folder} does not exist (AVS_SHARED names the folder above it)")
    return folder


@pytest.fixture(scope="session")
def shared_scenes() -> Path:
    """The folder of real photographs in COLMAP layout; they are not part of the repository."""
    return shared("scenes", "real photographs")


@pytest.fixture(scope="session")
def shared_weights() -> Path:
    """The folder with the published parameters of NIQE and BRISQUE; they are not part of the repository."""
    return shared("weights", "published parameters")
