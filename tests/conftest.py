"""Fixtures that several rooms share."""

import os
from pathlib import Path

import pytest

from avs.system.compatibility import prepare_environment

# Before numpy and torch are imported by a test module: threads and their waiting are decided then.
prepare_environment()


@pytest.fixture(scope="session")
def shared_scenes() -> Path:
    """The folder of real photographs in COLMAP layout; they are no part of the repository."""
    root = Path(os.environ.get("AVS_SHARED", Path(__file__).parent.parent / ".." / "shared"))
    scenes = root / "scenes"
    if not scenes.is_dir():
        pytest.skip(f"no real photographs: {scenes} does not exist (AVS_SHARED names the folder above it)")
    return scenes


@pytest.fixture(scope="session")
def shared_weights() -> Path:
    """The folder with the published parameters of NIQE and BRISQUE; they are no part of the repository."""
    root = Path(os.environ.get("AVS_SHARED", Path(__file__).parent.parent / ".." / "shared"))
    weights = root / "weights"
    if not weights.is_dir():
        pytest.skip(f"no published parameters: {weights} does not exist (AVS_SHARED names the folder above it)")
    return weights
