"""The metrics are pure: they touch no file, no environment variable and no terminal."""

import ast
from pathlib import Path

import pytest

FILES = sorted((Path(__file__).resolve().parents[2] / "metrics").glob("*.py"))
MODULES = {"glob", "io", "os", "pathlib", "pickle", "requests", "shutil", "socket", "subprocess", "sys", "tempfile"}
CALLS = {"exec", "input", "load", "loadtxt", "open", "print", "save", "savetxt"}


def impure(source):
    """Return the imports and calls in a program text that reach outside of the process."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names if alias.name.split(".")[0] in MODULES]
        elif isinstance(node, ast.ImportFrom):
            found += [node.module] if (node.module or "").split(".")[0] in MODULES else []
        elif isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            found += [f"{name}()"] if name in CALLS else []
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_metrics_touch_no_file_and_no_environment(path):
    assert impure(path.read_text(encoding="utf-8")) == []


def test_what_reaches_outside_is_found():
    source = "import os.path\nfrom pathlib import Path\nopen('a')\ntorch.load('b')\nprint(1)"
    assert impure(source) == ["os.path", "pathlib", "open()", "load()", "print()"]
