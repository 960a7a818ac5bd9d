"""The files that a rule depends on."""

import os
import time
from pathlib import Path

from avs.system.code_inputs import ROOT, sources
from avs.system.files import file_hash


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


def test_a_module_that_is_not_installed_has_no_files():
    assert sources("some.plugin") == []


def test_every_file_exists():
    assert all((ROOT / path).is_file() for path in sources("avs.commands.main"))


def test_a_stamp_sees_content_whatever_the_time(tmp_path, monkeypatch):
    from avs.system import code_inputs

    monkeypatch.chdir(tmp_path)
    Path("a.py").write_text("1")

    def stamp():
        code_inputs.digest.cache_clear()
        return code_inputs.stamp(["a.py", "gone"])

    first = stamp()
    os.utime("a.py", (1, 1))
    assert stamp() == first
    Path("a.py").write_text("2")
    os.utime("a.py", (1, 1))
    assert stamp() != first


def test_a_module_of_another_package_brings_the_files_of_that_package(tmp_path, monkeypatch):
    package = tmp_path / "turning"
    (package / "parts").mkdir(parents=True)
    for name in ("__init__.py", "method.py", "parts/angles.py"):
        (package / name).touch()
    monkeypatch.syspath_prepend(tmp_path)
    assert [path for path in sources("turning.method") if path.startswith("/")] == [
        str(package / name) for name in ("__init__.py", "method.py", "parts/angles.py")
    ]
    assert sources("no_such_package.method") == []


def test_a_large_file_is_read_once_and_again_after_an_edit_that_keeps_size_and_time(tmp_path, monkeypatch):
    from avs.system import known_digests

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(known_digests, "_SETTLED", 0)
    Path(".snakemake").mkdir()
    Path("a.jpg").write_bytes(b"1" * 1_100_000)
    os.utime("a.jpg", (1, 1))
    read = []
    monkeypatch.setattr(known_digests, "file_hash", lambda path: read.append(path) or file_hash(path))

    def digest():
        known_digests._kept.cache_clear()
        return known_digests.known_digest("a.jpg")

    first = digest()
    assert digest() == first
    assert read == ["a.jpg"]
    time.sleep(0.05)  # longer than the steps of the file system's clock
    Path("a.jpg").write_bytes(b"2" * 1_100_000)
    os.utime("a.jpg", (1, 1))
    assert digest() == file_hash("a.jpg") != first
    # A line that was cut off, or is none, is passed over.
    known_digests.KEPT.write_text(known_digests.KEPT.read_text()[:-9] + "x\n")
    assert digest() == file_hash("a.jpg")
    known_digests.KEPT.unlink()
    known_digests.KEPT.parent.rmdir()
    assert digest() == file_hash("a.jpg")
    assert not known_digests.KEPT.exists()


def test_relative_imports_are_followed(tmp_path, monkeypatch):
    from avs.system import code_inputs

    package = tmp_path / "avs" / "selectors"
    package.mkdir(parents=True)
    for name, text in {"rel.py": "from .helper import SIGN\nfrom ..other import x", "helper.py": "SIGN = 1"}.items():
        (package / name).write_text(text)
    (tmp_path / "avs" / "other.py").write_text("x = 1")
    monkeypatch.setattr(code_inputs, "ROOT", tmp_path)
    assert sources("avs.selectors.rel") == ["avs/other.py", "avs/selectors/helper.py", "avs/selectors/rel.py"]
