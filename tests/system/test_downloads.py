"""Downloads are verified, gone on with, and whole or not at all: from a server of this test."""

import base64
import hashlib
import http.server
import re
from typing import ClassVar

import pytest

from avs.system.downloads import download
from avs.system.errors import UserError
from tests.system.local_server import serving

BODY = bytes(range(256)) * 5000
DIGEST = hashlib.sha256(BODY).hexdigest()


class Server(http.server.BaseHTTPRequestHandler):
    """Serves ``BODY`` at any path, as Google's storage does; ``behaviour`` says what goes wrong."""

    behaviour: ClassVar[dict] = {}
    asked: ClassVar[list] = []

    def do_GET(self):
        told = type(self).behaviour
        body, etag = told.get("body", BODY), told.get("etag", '"one"')
        wanted = self.headers.get("Range")
        type(self).asked.append(wanted)
        start = int(re.fullmatch(r"bytes=(\d+)-", wanted)[1]) if wanted else 0
        if (wanted and self.headers.get("If-Range") != etag) or told.get("no_ranges"):
            start = 0
        if told.get("status"):
            self.send_response(told["status"])
            self.send_header("Content-Length", "0")
            self.end_headers()
            return
        self.send_response(206 if start else 200)
        if etag:
            self.send_header("ETag", etag)
        if "md5" in told:
            self.send_header("x-goog-hash", f"crc32c=AAAAAA==,md5={told['md5']}")
        self.send_header("Content-Length", str(len(body) - start))
        self.end_headers()
        breaks = told.get("breaks", [])
        self.wfile.write(body[start : start + breaks.pop(0)] if breaks else body[start:])

    def log_message(self, *arguments):
        """Say nothing."""


@pytest.fixture
def server(monkeypatch):
    monkeypatch.setattr(Server, "behaviour", {})
    monkeypatch.setattr(Server, "asked", [])
    with serving(Server) as address:
        yield f"{address}/file.zip"


def left(folder):
    return sorted(path.name for path in folder.iterdir())


def test_file_comes_whole_and_alone(server, tmp_path):
    found = download(server, tmp_path / "file.zip", print, len(BODY), DIGEST)
    assert (tmp_path / "file.zip").read_bytes() == BODY
    assert (found.sha256, found.size, found.verified) == (DIGEST, len(BODY), True)
    assert left(tmp_path) == ["file.zip"]


def test_connection_that_breaks_is_gone_on_with(server, tmp_path):
    Server.behaviour = {"breaks": [700_000, 300_000]}
    download(server, tmp_path / "file.zip", print, sha256=DIGEST)
    assert (tmp_path / "file.zip").read_bytes() == BODY
    first, *later = Server.asked
    assert first is None
    assert len(later) == 2
    assert 600_000 < int(later[0][len("bytes=") : -1]) < int(later[1][len("bytes=") : -1]) < len(BODY)


def test_later_call_goes_on(server, tmp_path):
    Server.behaviour = {"breaks": [700_000, 0]}
    with pytest.raises(UserError, match="1 MB of it are kept"):
        download(server, tmp_path / "file.zip", print)
    assert left(tmp_path) == ["file.zip.part", "file.zip.part.etag"]
    download(server, tmp_path / "file.zip", print)
    assert (tmp_path / "file.zip").read_bytes() == BODY
    assert left(tmp_path) == ["file.zip"]


@pytest.mark.parametrize("change", [{"etag": '"two"'}, {"no_ranges": True}])
def test_part_of_another_file_is_not_gone_on_with(server, tmp_path, change):
    Server.behaviour = {"breaks": [700_000, 0]}
    with pytest.raises(UserError):
        download(server, tmp_path / "file.zip", print)
    other = BODY[::-1]
    Server.behaviour = change | {"body": other}
    download(server, tmp_path / "file.zip", print)
    assert (tmp_path / "file.zip").read_bytes() == other


@pytest.mark.parametrize("etag", ["", 'W/"weak"'])
def test_server_that_does_not_tell_its_versions_is_asked_for_all(server, tmp_path, etag):
    Server.behaviour = {"breaks": [700_000, 0], "etag": etag}
    with pytest.raises(UserError):
        download(server, tmp_path / "file.zip", print)
    Server.behaviour = {"etag": etag}
    download(server, tmp_path / "file.zip", print)
    assert (tmp_path / "file.zip").read_bytes() == BODY
    assert Server.asked[-1] is None


def test_hash_that_google_states_is_compared(server, tmp_path):
    right = base64.b64encode(hashlib.md5(BODY).digest()).decode()
    Server.behaviour = {"md5": right}
    assert download(server, tmp_path / "file.zip", print).verified
    Server.behaviour = {"md5": base64.b64encode(bytes(16)).decode()}
    with pytest.raises(UserError, match="MD5"):
        download(server, tmp_path / "other.zip", print)
    assert left(tmp_path) == ["file.zip"]


@pytest.mark.parametrize(
    ("behaviour", "expected", "message"),
    [
        ({}, {"size": 3}, "instead of 3"),
        ({}, {"sha256": "00" * 32}, "SHA-256"),
        ({"status": 404}, {}, "HTTP 404"),
        ({"status": 416}, {}, "cannot be downloaded"),
    ],
)
def test_what_is_wrong_is_one_line_and_leaves_nothing(server, tmp_path, behaviour, expected, message):
    Server.behaviour = behaviour
    with pytest.raises(UserError, match=message) as error:
        download(server, tmp_path / "file.zip", print, **expected)
    assert "\n" not in str(error.value)
    assert left(tmp_path) == []


def test_disk_without_room_is_told_before_anything_is_written(server, tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.disk_usage", lambda path: type("Usage", (), {"free": 10})())
    with pytest.raises(UserError, match="are free"):
        download(server, tmp_path / "file.zip", print)
    assert not (tmp_path / "file.zip").exists()
