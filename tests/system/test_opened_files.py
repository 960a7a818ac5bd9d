"""What a method's code has read without being listed is known at the end of its job, and a change of it is seen."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from avs.system import opened_files
from avs.system.code_inputs import ROOT, digest
from avs.system.ledger import Origin, ledger_of, origin_of, write_ledger
from avs.system.opened_files import read_beside

SCRIPT = """
import os, sys
from pathlib import Path
from avs.system.opened_files import expect_code_of_others, read_beside, watch_opened
watch_opened()
if "others" in sys.argv:
    expect_code_of_others()
place = Path(sys.argv[1])
sys.path.insert(0, str(place))
import turning_module
(place / "read.txt").read_text()
open(os.fsencode(place / "bytes.txt"), "rb").close()
os.close(os.open(place / "number.txt", os.O_RDONLY))
(place / "known.txt").read_text()
(place / "gone.txt").read_text()
(place / "gone.txt").unlink()
(place / "written.txt").write_text("")
(place / ".DS_Store").read_text()
Path("/etc/passwd").read_text()
import json.tool
print(*(path.name for path in read_beside([place / "known.txt"])))
"""


@pytest.mark.parametrize(("word", "found"), [("others", "bytes.txt number.txt read.txt turning_module.py"), ("no", "")])
def test_what_is_opened_or_loaded_is_found(tmp_path, word, found):
    for name in ("turning_module.py", "read.txt", "bytes.txt", "number.txt", "known.txt", "gone.txt", ".DS_Store"):
        (tmp_path / name).touch()
    words = [sys.executable, "-c", SCRIPT, str(tmp_path), word]
    result = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    assert result.stdout.strip() == found


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("avs/selectors/table.json", True),
        ("captures/notes.txt", True),
        ("avs/selectors/random.py", False),
        ("results/ci/scenes/orbit/orbit_0/images/0000.png", False),
        (".snakemake/digests_of_inputs.txt", False),
        ("avs/rasterizer/__pycache__/blending.nbi", False),
    ],
)
def test_of_the_project_only_what_no_list_tells_of_counts(name, counts):
    assert opened_files._told_of(str(ROOT / name)) is not counts


def test_libraries_and_the_system_are_no_part_of_a_method():
    paths = (os.__file__, pytest.__file__, "/proc/self/status", Path.home() / ".cache/fonts.json")
    assert all(opened_files._told_of(path) for path in opened_files._absolute(map(str, paths)))
    assert not opened_files._told_of(str(Path.home() / "angles.json"))


def test_a_change_of_what_was_opened_is_seen(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sign.txt").write_text("1")
    log = tmp_path / "job.log"
    origin = Origin("stamp", {}, {"sign.txt": digest("sign.txt")})
    write_ledger(log, [], origin)
    assert origin_of(log) == origin
    assert ledger_of(log).read_text().splitlines()[1] == f"# opened {digest('sign.txt')}  sign.txt"
    assert not origin.differs("stamp", [])
    for change in (lambda path: path.write_text("-1"), lambda path: path.unlink()):
        change(tmp_path / "sign.txt")
        digest.cache_clear()
        assert origin.differs("stamp", [])
    digest.cache_clear()


def test_nothing_is_looked_for_where_no_code_of_others_runs(monkeypatch):
    monkeypatch.setattr(opened_files, "_code_of_others", threading.Event())
    assert read_beside([]) == []
