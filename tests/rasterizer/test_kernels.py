"""How kernels are compiled and kept: machine code on disk follows every file that is compiled into it."""

import shutil
from pathlib import Path

import pytest

from avs.rasterizer import kernels

FOLDER = Path(kernels.__file__).parent


@pytest.mark.parametrize("name", ["constants.py", "blending_decision.py", "simd.py"])
def test_the_stamp_follows_constants_and_functions_of_other_files(name, tmp_path, monkeypatch):
    for path in FOLDER.glob("*.py"):
        shutil.copy(path, tmp_path)
    monkeypatch.setattr(kernels, "__file__", str(tmp_path / "kernels.py"))
    stamp = kernels._stamp.__wrapped__  # without the memory of earlier calls
    before = stamp(tmp_path)
    with (tmp_path / name).open("a") as file:
        file.write("# changed\n")
    assert stamp(tmp_path) != before
