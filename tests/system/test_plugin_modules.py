"""A module that does not work is named, and the others are used."""

import importlib.metadata
import os
import subprocess
import sys
from pathlib import Path

import pytest
import torch

from avs.selection import registry
from avs.system.errors import UserError
from avs.system.plugin_modules import import_each

ROOT = Path(__file__).resolve().parents[2]
BROKEN = {
    "raises": "1 / 0",
    "ends": "import sys; sys.exit(3)",
    "needs": "import no_such_package",
    "misspells": "def",
    "is_deep": "def f(): f()\nf()",
    "is_careless": "import torch\ntorch.set_grad_enabled(False)",
}
FAULTS = {
    "raises": "raises.py, line 1: ZeroDivisionError",
    "ends": "ends.py, line 1: ended the program (3)",
    "needs": "no_such_package: No module named",
    "misspells": "SyntaxError",
    "is_deep": "RecursionError",
    "is_careless": "is_careless: changes settings of torch when it is imported: the gradient mode from True to False",
    "is_nowhere": "is_nowhere: No module named",
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name, text in BROKEN.items():
        (tmp_path / f"{name}.py").write_text(text)
    (tmp_path / "lists.py").write_text("METHODS = []")
    (tmp_path / "holds.py").write_text("METHODS = {'mine': 3}")
    (tmp_path / "works.py").write_text(
        "from avs.selectors.random import METHODS as OWN\nMETHODS = {'w': OWN['random']}"
    )
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def test_each_is_told_with_its_fault_and_the_others_are_imported(folder):
    working, broken = import_each([*FAULTS, "works"])
    assert list(working) == ["works"]
    assert broken.keys() == FAULTS.keys()
    assert all(FAULTS[name] in broken[name] and "\n" not in broken[name] for name in FAULTS)
    assert torch.is_grad_enabled()


def test_a_change_is_found_where_torch_was_not_imported_before(folder):
    program = "import sys\nfrom avs.system.plugin_modules import import_each\nassert 'torch' not in sys.modules\n"
    program += "print(import_each(['is_careless'])[1], sys.modules['torch'].is_grad_enabled())"
    environment = os.environ | {"PYTHONPATH": str(folder)}
    words = [sys.executable, "-c", program]
    told = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=True).stdout
    assert FAULTS["is_careless"] in told
    assert told.endswith("True\n")


def test_a_plug_in_that_nobody_lists_stops_nothing_and_is_named(folder, monkeypatch):
    points = [
        importlib.metadata.EntryPoint(name, name, registry.PACKAGE) for name in (*FAULTS, "lists", "holds", "works")
    ]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda group: points)
    found, broken = registry._found.__wrapped__()
    assert found["w"].module == "works"
    assert "random" in found
    assert broken.keys() == {*FAULTS, "lists", "holds"}
    assert broken["lists"] == "lists: METHODS is list; make it a dictionary of methods by identifier"
    assert broken["holds"].startswith("holds: METHODS['mine'] is int; make it a Method")


def test_a_method_that_is_not_found_names_what_does_not_work(monkeypatch):
    monkeypatch.setattr(registry, "broken", lambda: {"theirs": "theirs.py, line 1: ZeroDivisionError"})
    with pytest.raises(UserError, match=r"'mine': unknown; .*or mend theirs, which is left out \(theirs.py, line 1"):
        registry.find("mine")
