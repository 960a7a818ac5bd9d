"""The files that a rule depends on."""

import os
from pathlib import Path

from avs.system.code_inputs import ROOT, sources


def test_imports_are_followed_also_inside_functions():
    files = sources("avs.commands.main")
    assert "avs/commands/main.py" in files
    assert "avs/system/job_process.py" in files
    assert "avs/nvs/loop.py" in files  # through a function of main.py and through avs/nvs/experiment.py
    assert "metrics/image.py" in files
    assert "avs/__init__.py" in files


def test_a_method_is_no_part_of_the_loop():
    files = sources("avs.nvs.experiment")
    assert not [path for path in files if path.startswith(("avs/selectors/", "avs/report/", "avs/iqa/"))]


def test_a_method_depends_on_its_own_file():
    assert "avs/selectors/fisherrf.py" in sources("avs.selectors.fisherrf")
    assert "avs/selectors/farthest.py" not in sources("avs.selectors.fisherrf")


def test_tables_depend_on_records_not_on_reconstruction():
    files = sources("avs.report.tables.view_synthesis")
    assert "avs/nvs/record.py" in files
    assert not [path for path in files if "gaussians" in path]
    # The printed names of methods come from the registry, which finds the methods' own files by name.
    assert not [path for path in files if path.startswith("avs/selectors/")]


def test_foreign_modules_have_no_files_here():
    assert sources("numpy", "some.plugin") == []


def test_every_file_exists():
    assert all((ROOT / path).is_file() for path in sources("avs.commands.main"))


def test_a_stamp_sees_content_whatever_the_time(tmp_path, monkeypatch):
    from avs.system import code_inputs

    monkeypatch.chdir(tmp_path)
    Path("a.py").write_text("1")

    def stamp():
        code_inputs._stamp.cache_clear()
        return code_inputs.stamp(["a.py", "gone"])

    first = stamp()
    os.utime("a.py", (1, 1))
    assert stamp() == first
    Path("a.py").write_text("2")
    os.utime("a.py", (1, 1))
    assert stamp() != first


def test_relative_imports_are_followed(tmp_path, monkeypatch):
    from avs.system import code_inputs

    package = tmp_path / "avs" / "selectors"
    package.mkdir(parents=True)
    for name, text in {"rel.py": "from .helper import SIGN\nfrom ..other import x", "helper.py": "SIGN = 1"}.items():
        (package / name).write_text(text)
    (tmp_path / "avs" / "other.py").write_text("x = 1")
    monkeypatch.setattr(code_inputs, "ROOT", tmp_path)
    assert sources("avs.selectors.rel") == ["avs/other.py", "avs/selectors/helper.py", "avs/selectors/rel.py"]
