"""Archives are unpacked inside of their folder, whole or not at all."""

import gzip
import io
import re
import tarfile
import zipfile

import pytest

from avs.system.archives import unpack
from avs.system.errors import UserError
from avs.system.files import file_hash

CONTENT = {
    "garden/images/a.jpg": b"one" * 9000,
    "garden/sparse/0/cameras.bin": b"two",
    "room/images/b.jpg": b"three" * 9000,
}


def zipped(path, content=CONTENT, mode=0o100644):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            entry = zipfile.ZipInfo(name)
            entry.external_attr = mode << 16
            archive.writestr(entry, data)
    return path


def tarred(path, content=CONTENT, kind=tarfile.REGTYPE):
    with tarfile.open(path, "w:gz") as archive:
        for name, data in content.items():
            member = tarfile.TarInfo(name)
            member.size, member.type = (len(data) if kind == tarfile.REGTYPE else 0), kind
            member.linkname = "/etc/passwd" if kind != tarfile.REGTYPE else ""
            archive.addfile(member, io.BytesIO(data))
    return path


@pytest.mark.parametrize("make", [zipped, tarred])
def test_content_is_unpacked_beside_what_is_there(make, tmp_path):
    (tmp_path / "data" / "bicycle").mkdir(parents=True)
    archive = make(tmp_path / "archive")
    assert unpack(archive, tmp_path / "data", file_hash(archive)) == ["garden", "room"]
    assert {path.name for path in (tmp_path / "data").iterdir()} == {"bicycle", "garden", "room"}
    for name, data in CONTENT.items():
        assert (tmp_path / "data" / name).read_bytes() == data


def cut(path):
    path.write_bytes(path.read_bytes()[:60])
    return path


def changed(path):
    content = bytearray(path.read_bytes())
    content[70] ^= 255
    path.write_bytes(content)
    return path


def flagged(path, flag):
    """A ZIP whose members say ``flag`` of themselves, in their headers and in the directory."""
    return patched(path, {b"PK\x03\x04": 6, b"PK\x01\x02": 8}, flag)


def compressed(path, method):
    """A ZIP whose members say that they are compressed by ``method``."""
    return patched(path, {b"PK\x03\x04": 8, b"PK\x01\x02": 10}, method)


def patched(path, places, value):
    content = bytearray(path.read_bytes())
    for signature, offset in places.items():
        for found in re.finditer(re.escape(signature), bytes(content)):
            content[found.start() + offset] = value
    path.write_bytes(content)
    return path


def after(path):
    """Two archives in one file."""
    path.write_bytes(path.read_bytes() * 2)


def recompressed(path, mode):
    with tarfile.open(path, mode) as archive:
        for name, data in CONTENT.items():
            member = tarfile.TarInfo(name)
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))
    return path


def without_end(path, plain):
    """A tar that ends with the second of three members."""
    recompressed(path, "w:")
    with tarfile.open(path) as archive:
        end = archive.getmembers()[2].offset
    content = path.read_bytes()[:end]
    path.write_bytes(content if plain else gzip.compress(content))


def second_header(path):
    """A tar with a second header that makes no sense."""
    recompressed(path, "w:")
    with tarfile.open(path) as archive:
        start = archive.getmembers()[1].offset
    content = bytearray(path.read_bytes())
    content[start : start + 512] = b"x" * 512
    path.write_bytes(content)


def checksum(path):
    content = bytearray(path.read_bytes())
    content[-8] ^= 1
    path.write_bytes(content)


def middle(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 255
    path.write_bytes(content)


FAULTS = {
    "parent": (lambda path: zipped(path, {"../x": b"x"}), r"its member \.\./x would leave the folder; do not use it"),
    "hidden parent": (lambda path: tarred(path, {"a/../../x": b"x"}), r"would leave the folder"),
    "absolute": (lambda path: tarred(path, {"/tmp/x": b"x"}), r"its member /tmp/x would leave the folder"),
    "backslashes": (lambda path: zipped(path, {"..\\x": b"x"}), r"would leave the folder"),
    "drive": (lambda path: zipped(path, {"C:/x": b"x"}), r"would leave the folder"),
    "link in a ZIP": (
        lambda path: zipped(path, {"x": b"/etc/passwd"}, 0o120777),
        r"its member x is a link or a device",
    ),
    "link in a tar": (lambda path: tarred(path, {"x": b""}, tarfile.SYMTYPE), r"its member x is a link or a device"),
    "hard link": (lambda path: tarred(path, {"x": b""}, tarfile.LNKTYPE), r"is a link or a device"),
    "device": (lambda path: tarred(path, {"x": b""}, tarfile.CHRTYPE), r"is a link or a device"),
    "cut ZIP": (lambda path: cut(zipped(path)), r"is damaged or cut off \(.*; get the archive again"),
    "cut tar": (lambda path: cut(tarred(path)), r"is (damaged|no ZIP or tar archive)"),
    "changed ZIP": (lambda path: changed(zipped(path)), r"is damaged or cut off \("),
    "encrypted ZIP": (
        lambda path: flagged(zipped(path), 1),
        r"its member garden/images/a\.jpg is encrypted; unpack it with",
    ),
    "unknown compression": (lambda path: compressed(zipped(path), 97), r"cannot be read here \(.*compression"),
    "two ZIPs in one": (lambda path: after(zipped(path)), r"has something before its first member"),
    "tar between members": (lambda path: without_end(path, plain=True), r"is cut off: it lacks the mark of its end"),
    "tar.gz between members": (lambda path: without_end(path, plain=False), r"it lacks the mark of its end"),
    "tar with a damaged header": (second_header, r"is damaged, or two archives in one file"),
    "tar.gz with another checksum": (lambda path: checksum(tarred(path)), r"is damaged or cut off \(CRC"),
    "tar.bz2 with changed bytes": (lambda path: middle(recompressed(path, "w:bz2")), r"is (damaged|no ZIP or tar)"),
    "no archive": (lambda path: path.write_bytes(b"hello"), r"is no ZIP or tar archive"),
    "nothing": (lambda path: None, r"there is no such archive"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_one_line_and_leaves_nothing(fault, tmp_path):
    make, message = FAULTS[fault]
    make(tmp_path / "archive")
    with pytest.raises(UserError) as caught:
        unpack(tmp_path / "archive", tmp_path / "data")
    assert re.search(message, str(caught.value)), str(caught.value)
    assert not list(tmp_path.glob("data/*"))
    assert {path.name for path in tmp_path.iterdir()} <= {"archive", "data"}


def test_nothing_is_replaced(tmp_path):
    (tmp_path / "data" / "room").mkdir(parents=True)
    with pytest.raises(UserError, match=r"data/room: is there already, and archive holds it"):
        unpack(zipped(tmp_path / "archive"), tmp_path / "data")
    assert [path.name for path in (tmp_path / "data").iterdir()] == ["room"]


def test_another_archive_than_the_one_meant_is_refused(tmp_path):
    with pytest.raises(UserError, match="has another SHA-256 than the one given"):
        unpack(zipped(tmp_path / "archive"), tmp_path / "data", "0" * 64)


@pytest.mark.parametrize("mode", ["w:", "w:gz", "w:bz2", "w:xz"])
def test_a_tar_whose_last_member_is_a_zip_stays_a_tar(mode, tmp_path):
    inner = zipped(tmp_path / "inner.zip").read_bytes()
    with tarfile.open(tmp_path / "archive", mode) as archive:
        for name in ("a.zip", "b.zip"):
            member = tarfile.TarInfo(name)
            member.size = len(inner)
            archive.addfile(member, io.BytesIO(inner))
    assert unpack(tmp_path / "archive", tmp_path / "data") == ["a.zip", "b.zip"]
    assert (tmp_path / "data" / "b.zip").read_bytes() == inner
