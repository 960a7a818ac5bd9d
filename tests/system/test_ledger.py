"""What a job wrote is listed beside its log; whatever is changed or lacking of it later is found."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from avs.system.code_inputs import digest
from avs.system.files import write_text
from avs.system.job_process import job
from avs.system.ledger import Origin, find_damage, origin_of, write_ledger

LARGE = "x" * 1_100_000

JOB = """
import sys
from pathlib import Path
from avs.system.files import atomic_folder, write_text
from avs.system.job_process import job
with job(Path("logs/job.log")):
    write_text("out/table.md", "small")
    write_text("out/splats.ply", "x" * 1_100_000)
    write_text("out/passing", "removed before the end")
    Path("out/passing").unlink()
    with atomic_folder("out/folder") as temporary:
        write_text(temporary / "image", "picture")
    if sys.argv[1:]:
        raise OSError("broken")
"""


@pytest.fixture
def results(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _job()
    return tmp_path


def _job(*arguments):
    root = str(Path(__file__).resolve().parents[2])
    subprocess.run([sys.executable, "-c", JOB, *arguments], check=not arguments, env=os.environ | {"PYTHONPATH": root})


def test_a_finished_job_is_listed_as_sha256sum_lists_it(results):
    assert find_damage(results / "logs") == []
    lines = (results / "logs/job.log.sha256").read_text().splitlines()
    assert [line[66:] for line in lines] == ["out/folder/image", "out/splats.ply", "out/table.md"]
    subprocess.run(["sha256sum", "--check", "--quiet", "logs/job.log.sha256"], check=True)


def test_a_failed_job_lists_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _job("fail")
    assert not (tmp_path / "logs/job.log.sha256").exists()


@pytest.mark.parametrize("name", ["out/table.md", "out/splats.ply", "out/folder/image"])
def test_a_changed_file_is_found(results, name):
    path = results / name
    path.write_text("y" + path.read_text()[1:])
    (damage,) = find_damage(results / "logs")
    assert [str(path) for path in damage.changed] == [name]
    assert damage.lacking == ()
    assert len(damage.left) == 2


def test_a_changed_file_with_its_old_time_is_found(results):
    path = results / "out/splats.ply"
    status = path.stat()
    path.write_text("y" + LARGE[1:])
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert len(find_damage(results / "logs")) == 1


def test_a_lacking_file_is_found_while_others_are_left(results):
    names = ["out/table.md", "out/splats.ply", "out/folder/image"]
    for number, name in enumerate(names):
        (results / name).unlink()
        found = find_damage(results / "logs")
        assert [[str(path) for path in damage.lacking] for damage in found] == (
            [sorted(names[: number + 1])] if number < 2 else []
        )


def test_a_damaged_list_says_nothing(results):
    (results / "logs/job.log.sha256").write_bytes(b"\xff\x00 nonsense")
    assert find_damage(results / "logs") == []


def test_a_job_lists_its_own_files_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_text("before", "not of the job")
    streams = [os.dup(1), os.dup(2)]
    try:
        with job(tmp_path / "job.log"):
            write_text("own", "of the job")
    finally:
        for stream, number in zip(streams, (1, 2), strict=True):
            os.dup2(stream, number)
    assert [line[66:] for line in (tmp_path / "job.log.sha256").read_text().splitlines()] == ["own"]


def test_a_list_tells_what_its_job_was_made_of_in_lines_that_sha256sum_passes_over(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_text("out", "written")
    assert origin_of(Path("job.log")) is None
    origin = Origin("a stamp", {"settings.json": "0" * 64, "a  scene.json": "1" * 64})
    write_ledger(Path("job.log"), [Path("out")], origin)
    assert origin_of(Path("job.log")) == origin
    assert find_damage(tmp_path) == []
    subprocess.run(["sha256sum", "--check", "--strict", "--quiet", "job.log.sha256"], check=True)
    write_ledger(Path("job.log"), [Path("out")])
    assert origin_of(Path("job.log")) is None


@pytest.fixture
def fresh_digests():
    """Let each look read the files, as a process of its own would."""
    digest.cache_clear()
    yield digest.cache_clear
    digest.cache_clear()


def test_a_job_differs_with_its_stamp_its_inputs_and_what_they_hold_whatever_their_times(tmp_path, fresh_digests):
    settings = tmp_path / "settings.json"
    settings.write_text("12 steps")
    origin = Origin("code", {str(settings): digest(str(settings))})
    assert not origin.differs("code", [str(settings)])
    assert origin.differs("other code", [str(settings)])
    assert origin.differs("code", [])
    assert origin.differs("code", [str(settings), "another"])
    time = settings.stat().st_mtime_ns
    settings.write_text("16 steps")
    os.utime(settings, ns=(time, time))
    fresh_digests()
    assert origin.differs("code", [str(settings)])
    settings.unlink()
    fresh_digests()
    assert not origin.differs("code", [str(settings)]), "what is not there is made first"
