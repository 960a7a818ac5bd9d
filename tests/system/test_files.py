"""Files appear whole or not at all, also when the writer fails or the disk is full."""

import errno
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from avs.system.errors import UserError
from avs.system.files import (
    atomic_folder,
    atomic_path,
    canonical_json,
    explained,
    file_hash,
    temporary_folder,
    write_json,
    write_text,
)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def interrupted_file(target):
    with atomic_path(target) as temporary:
        temporary.write_text("half")
        raise RuntimeError


def interrupted_folder(target):
    with atomic_folder(target) as temporary:
        (temporary / "b").write_text("b")
        raise KeyboardInterrupt


def large_folder(target):
    with explained(), atomic_folder(target) as temporary:
        (temporary / "points3D.bin").write_bytes(b"x" * 100_000)


def test_a_file_appears_only_at_the_end(tmp_path):
    target = tmp_path / "new" / "table.csv"
    with atomic_path(target) as temporary:
        temporary.write_text("a")
        assert not target.exists()
        assert temporary.suffix == ".csv"
    assert target.read_text() == "a"
    assert names(target.parent) == ["table.csv"]


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path):
    target = tmp_path / "table.csv"
    write_text(target, "old")
    with pytest.raises(RuntimeError):
        interrupted_file(target)
    assert target.read_text() == "old"
    assert names(tmp_path) == ["table.csv"]


def test_a_folder_replaces_the_old_one_whole(tmp_path):
    target = tmp_path / "scene"
    with atomic_folder(target) as temporary:
        (temporary / "images").mkdir()
        (temporary / "images" / "a").write_text("a")
    with atomic_folder(target) as temporary:
        (temporary / "b").write_text("b")
    assert names(target) == ["b"]
    assert names(tmp_path) == ["scene"]


def test_a_failure_leaves_the_old_folder_and_nothing_else(tmp_path):
    target = tmp_path / "scene"
    with atomic_folder(target) as temporary:
        (temporary / "a").write_text("a")
    with pytest.raises(KeyboardInterrupt):
        interrupted_folder(target)
    assert names(target) == ["a"]
    assert names(tmp_path) == ["scene"]


def test_results_follow_the_umask(tmp_path):
    old = os.umask(0o027)
    try:
        write_text(tmp_path / "file", "a")
        with atomic_folder(tmp_path / "folder"):
            pass
    finally:
        os.umask(old)
    assert (tmp_path / "file").stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "folder").stat().st_mode & 0o777 == 0o750


def test_canonical_json_does_not_depend_on_order_and_refuses_nan():
    assert canonical_json({"b": 1, "a": [0.1, "é"]}) == canonical_json({"a": [0.1, "é"], "b": 1})
    assert canonical_json({"a": 1}).endswith("}\n")
    with pytest.raises(ValueError, match="not JSON compliant"):
        canonical_json({"a": float("nan")})


def test_file_hash_is_sha256(tmp_path):
    write_text(tmp_path / "file", "abc")
    assert file_hash(tmp_path / "file").startswith("ba7816bf8f01cfea")


@pytest.fixture
def limited_file_size():
    """Files of this process cannot grow beyond 64 KiB; it stands for a full disk where none can be mounted."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (65536, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    signal.signal(signal.SIGXFSZ, handler)


def test_a_failed_write_names_the_result_and_leaves_nothing(tmp_path, limited_file_size):
    write_json(tmp_path / "record.json", {"a": 1})
    with pytest.raises(UserError, match=r"record\.json: file too large; raise the limit"), explained():
        write_json(tmp_path / "record.json", {"a": "x" * 100_000})
    assert (tmp_path / "record.json").read_text() == canonical_json({"a": 1})
    with pytest.raises(UserError, match=r"/scene: file too large"):
        large_folder(tmp_path / "scene")
    assert names(tmp_path) == ["record.json"]


def test_a_failed_write_to_what_is_temporary_names_its_folder(limited_file_size):
    with (
        pytest.raises(UserError, match=r"/avs-test-\w+: file too large"),
        explained(),
        temporary_folder("avs-test-") as made,
    ):
        (made / "mesh.ply").write_bytes(b"x" * 100_000)
    assert not made.exists()


_WRITER = """
import sys
from avs.system.errors import UserError
from avs.system.files import explained, write_text
try:
    with explained():
        write_text(sys.argv[1], "x" * 1_000_000)
except UserError as error:
    print(error)
"""


@pytest.mark.skipif(sys.platform != "linux" or os.geteuid() != 0, reason="mounting a small disk needs root on Linux")
def test_a_full_disk_names_the_result_and_leaves_nothing(tmp_path):
    script = 'mount -t tmpfs -o size=128k none "$2" && "$0" -c "$1" "$2/a.txt" && ls -A "$2"'
    run = subprocess.run(
        ["unshare", "--mount", "sh", "-c", script, sys.executable, _WRITER, tmp_path],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parents[2],
    )
    if "unshare" in run.stderr or "mount" in run.stderr:
        pytest.skip(f"this container mounts nothing: {run.stderr.strip()}")
    assert run.stdout == f"{tmp_path}/a.txt: no space left on device; free some space, then run again\n"


def test_explained_keeps_other_errors_and_knows_a_path():
    with pytest.raises(ValueError, match="mine"), explained():
        raise ValueError("mine")
    with pytest.raises(UserError, match=r"^/x/y: permission denied; give yourself"), explained():
        raise PermissionError(errno.EACCES, "Permission denied", "/x/y")
