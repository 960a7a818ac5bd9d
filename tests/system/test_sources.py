"""The files that a rule depends on."""

import os
import time
from pathlib import Path

from avs.system.code_inputs import ROOT, sources, with_contents
from avs.system.files import file_hash
from avs.system.installed_files import _brought_by, installed_files


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


def test_a_distribution_of_several_modules_brings_them_all_and_a_package_its_data(tmp_path, monkeypatch):
    place = tmp_path / "lib"
    told = place / "avs_turn-1.dist-info"
    told.mkdir(parents=True)
    (told / "METADATA").write_text("Metadata-Version: 2.1\nName: avs_turn\nVersion: 1\n")
    (told / "top_level.txt").write_text("avs_turn\navs_turn_core\n")
    shared = "../share/avs_turn/sign.txt"
    names = ("avs_turn.py", "avs_turn_core.py", "avs_turn_tables/angles.json", "avs_turn_fast.abi3.so", shared)
    for name in names:
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).touch()
    (told / "RECORD").write_text(
        "".join(f"{name},,\n" for name in (names[0], *names[2:], "avs_turn-1.dist-info/RECORD"))
    )
    monkeypatch.syspath_prepend(place)
    installed_files.cache_clear()
    _brought_by.cache_clear()
    assert sources("avs_turn") == sorted(os.path.normpath(place / name) for name in names)
    _brought_by.cache_clear()


def test_data_of_a_package_count_and_what_python_compiles_does_not(tmp_path, monkeypatch):
    package = tmp_path / ".local" / "turning_data"
    (package / "__pycache__").mkdir(parents=True)
    names = (".turns", "__init__.py", "angles.json", "fast.so")
    for name in (*names, "__pycache__/a.pyc", "{{name}}.txt", ".DS_Store"):
        (package / name).touch()
    monkeypatch.syspath_prepend(tmp_path / ".local")
    assert sources("turning_data") == [str(package / name) for name in names]


def test_data_beside_a_method_count(tmp_path, monkeypatch):
    from avs.system import code_inputs

    package = tmp_path / "avs" / "selectors" / "turning"
    package.mkdir(parents=True)
    for name in ("tables/deep", "other_package", "__pycache__"):
        (package / name).mkdir(parents=True)
    counted = ("__init__.py", "angles.json", "tables/.turns", "tables/deep/turns.json")
    others = ("other_package/__init__.py", "other_package/a.json", "__pycache__/a.pyc", "tables/.DS_Store")
    for name in (*counted, *others):
        (package / name).touch()
    monkeypatch.setattr(code_inputs, "ROOT", tmp_path)
    folder = "avs/selectors/turning"
    forget_sources()
    assert sources("avs.selectors.turning") == [f"{folder}/{name}" for name in counted]
    (package / "__init__.py").write_text("from avs.selectors.turning import other_package\n")
    forget_sources()
    assert sources("avs.selectors.turning") == [
        f"{folder}/{name}" for name in (*counted[:2], "other_package/__init__.py", "other_package/a.json", *counted[2:])
    ]
    forget_sources()


def test_a_module_beside_the_snakefile_counts(tmp_path, monkeypatch):
    from avs.system import code_inputs

    (tmp_path / "avs" / "selectors").mkdir(parents=True)
    (tmp_path / "avs" / "selectors" / "rooted.py").write_text(
        "import os\nimport rooted_helper\nfrom helpers import turn\n"
    )
    (tmp_path / "rooted_helper.py").write_text("from . import os\n")
    (tmp_path / "helpers").mkdir()
    for name in ("helpers/turn.py", "helpers/turn.json", "README.md"):
        (tmp_path / name).touch()
    monkeypatch.setattr(code_inputs, "ROOT", tmp_path)
    forget_sources()
    expected = ["avs/selectors/rooted.py", "helpers/turn.json", "helpers/turn.py", "rooted_helper.py"]
    assert sources("avs.selectors.rooted") == expected
    forget_sources()


def forget_sources():
    from avs.system import code_inputs

    for each in (code_inputs._sources, code_inputs._files, code_inputs._imported, code_inputs._beside):
        each.cache_clear()


def test_data_beside_a_module_count_that_is_installed_as_a_link(tmp_path, monkeypatch):
    counted = (".turns", "turn.json", "turning_link.py")
    for name in (*counted, "setup.py", ".DS_Store"):
        (tmp_path / name).touch()
    monkeypatch.syspath_prepend(tmp_path)
    assert sources("turning_link") == [str(tmp_path / name) for name in counted]


def test_a_folder_stands_for_its_files(tmp_path):
    for name in (
        *("main.py", "lib/order.py", "lib/deep/a.bin", "lib/.parameters.json"),
        *("lib/.git/HEAD", "lib/.#order.py", "lib/order.py~", "lib/__pycache__/order.pyc"),
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    given = [str(tmp_path / name) for name in ("main.py", "lib", "absent.py")]
    expected = ("main.py", "lib/.parameters.json", "lib/deep/a.bin", "lib/order.py", "absent.py")
    assert with_contents(given) == [str(tmp_path / name) for name in expected]


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


def test_links_to_folders_are_followed_in_packages_and_beside_methods(tmp_path, monkeypatch):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "weights.bin").write_text("")
    package = tmp_path / "linking_package"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "model").symlink_to(tmp_path / "real")
    (package / "all").symlink_to(tmp_path)  # leads back to what holds it
    (package / "itself").symlink_to("itself")
    monkeypatch.syspath_prepend(tmp_path)
    inside = [str(package / "__init__.py"), str(package / "model" / "weights.bin")]
    assert sources("linking_package") == inside
    assert with_contents([str(package)]) == inside
