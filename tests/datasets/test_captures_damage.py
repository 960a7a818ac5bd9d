"""Captures damaged at random, with a fixed seed: right, or one line; never a traceback and never half a scene.

What no reader could see, such as another digit of a position, is what the damage itself explains.
"""

import os
import random
import shutil
import signal
import struct

import numpy as np
import pytest
from captures_factory import OPENCV, SIMPLE_RADIAL, make_capture

from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.captures import prepare
from avs.scene.scene import read_scene
from avs.system.errors import UserError
from avs.system.files import explained

OFFERED = ("cameras", "images", "points3D")
NUMBERS = [0.0, -1.0, 5e-324, 1e-9, 1e9, 1e15, 1e308, float("inf"), float("nan")]
COUNTS = [0, 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1]
WORDS = ["nan", "-inf", "1e400", "1e308", "5e-324", "-1", "1" + "0" * 400, "1" + "0" * 5000, str(2**64 - 1), "", "\0"]
WORDS += ["\x1b[31m", "\u2028", "../x", "a" * 300, "1e15", "0"]
LINKS = ["/dev/zero", "/dev/null", "/", "loop", "gone"]


def cut(path, draw):
    content = path.read_bytes()
    path.write_bytes(content[: draw.randrange(len(content))])


def flip(path, draw):
    content = bytearray(path.read_bytes())
    for _ in range(draw.choice([1, 5, 50])):
        content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
    path.write_bytes(content)


def drop(path, draw):
    content, start = path.read_bytes(), draw.randrange(path.stat().st_size)
    path.write_bytes(content[:start] + content[start + draw.choice([1, 8, 100]) :])


def repeat(path, draw):
    path.write_bytes(path.read_bytes() * 2)


def replace(path, draw):
    """Something that is no file, or none of this form."""
    path.unlink()
    kind = draw.choice(["nothing", "pipe", "folder", "link", "noise"])
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "link":
        path.symlink_to(draw.choice(LINKS))
    elif kind == "noise":
        path.write_bytes(draw.randbytes(500))


def exchange(path, draw):
    other = draw.choice([each for each in path.parent.iterdir() if each != path])
    content = path.read_bytes()
    path.write_bytes(other.read_bytes())
    other.write_bytes(content)


def put(path, draw):
    """A number that is legal by its form."""
    if path.suffix == ".txt":
        lines = path.read_text().split("\n")
        row = draw.choice([row for row, line in enumerate(lines) if line and not line.startswith("#")])
        fields = lines[row].split(" ")
        fields[draw.randrange(min(len(fields), 14))] = draw.choice(WORDS)
        lines[row] = " ".join(fields)
        path.write_text("\n".join(lines))
        return
    content = bytearray(path.read_bytes())
    layout, values = draw.choice([("<d", NUMBERS), ("<Q", COUNTS)])
    struct.pack_into(layout, content, draw.randrange(12), draw.choice(values))
    offset = draw.randrange(8, min(len(content), 120) - 8, 4)
    struct.pack_into(layout, content, offset, draw.choice(values))
    path.write_bytes(content)


def put_in_first_record(path, draw):
    """A number at the place of one."""
    if path.suffix == ".txt":
        return put(path, draw)
    offset = {"cameras": 32, "images": 12, "points3D": 16}[path.stem] + 8 * draw.randrange(4)
    content = bytearray(path.read_bytes())
    struct.pack_into("<d", content, offset, draw.choice(NUMBERS))
    return path.write_bytes(content)


OF_ANY_FILE = [cut, flip, drop, repeat, replace, exchange]
OF_A_MODEL = [*OF_ANY_FILE, put, put_in_first_record, put_in_first_record]


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """Captures with binary and text models."""
    folder = tmp_path_factory.mktemp("sound")
    for name in ("binary", "text"):
        make_capture(folder / name, cameras=(SIMPLE_RADIAL, OPENCV), text=name == "text", count=5)
    return folder


@pytest.fixture
def in_time():
    """A test that waits for ever, as on a pipe, fails."""

    def late(*_):
        pytest.fail("still not ended")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(30)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def refusal(capture, scene):
    """The line with which the capture is refused, or None."""
    try:
        with explained():
            prepare(capture, scene, CaptureSettings(long_side=None))
    except UserError as error:
        return str(error)
    return None


@pytest.mark.usefixtures("in_time")
@pytest.mark.parametrize("seed", range(120))
def test_a_damaged_capture_is_right_or_one_line(seed, sound, tmp_path):
    draw = random.Random(seed)
    capture, scene = tmp_path / "capture", tmp_path / "scene"
    shutil.copytree(sound / draw.choice(["binary", "text"]), capture)
    model = [path for path in sorted((capture / "sparse" / "0").iterdir()) if path.stem in OFFERED]
    image = draw.random() < 0.2
    path = draw.choice(sorted((capture / "images").iterdir()) if image else model)
    draw.choice(OF_ANY_FILE if image else OF_A_MODEL)(path, draw)
    line = refusal(capture, scene)
    if line is not None:
        assert line.isprintable()
        assert line.count("; ") >= 1
        assert [path.name for path in tmp_path.iterdir()] == ["capture"]
        return
    read = read_scene(scene)
    for numbers in (read.cameras.world_to_camera, read.cameras.intrinsics, read.points.positions):
        assert np.isfinite(numbers).all()
