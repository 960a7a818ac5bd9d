"""``make photographs``: what each FROM is called, and that its name reaches Snakemake whole."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from snakemake.cli import parse_config

ROOT = Path(__file__).parents[2]
STUB = '#!/bin/bash\nprintf "%s\\n" "${0##*/}" "$@" >> "$CALLS"\n'


@pytest.fixture
def made(tmp_path):
    """Run it beside stubs of Python and Snakemake; return the status, the line on stderr, and the words of both."""
    project = tmp_path / "project"
    (project / ".venv" / "bin").mkdir(parents=True)
    for name in ("Makefile", "environment.txt"):
        shutil.copy(ROOT / name, project)
    for name in ("python", "snakemake"):
        (project / ".venv" / "bin" / name).write_text(STUB)
        (project / ".venv" / "bin" / name).chmod(0o755)
    (project / ".venv" / "installed").touch()
    calls = tmp_path / "calls"

    def run(source):
        calls.unlink(missing_ok=True)
        done = subprocess.run(
            ["make", "-s", "photographs", f"FROM={source}"],
            cwd=project,
            env=os.environ | {"CALLS": str(calls)},
            capture_output=True,
            text=True,
            check=False,
        )
        return done.returncode, done.stderr, calls.read_text().splitlines() if calls.exists() else []

    return run


def captured(words):
    """Return the capture that poses go to, the source, and the capture that Snakemake is given."""
    assert words[:5] == ["python", "-m", "avs", "data", "pose"]
    given = parse_config([words[-1]])["scenes_dir"]
    return words[words.index("--out") + 1], words[words.index("--") + 1], given


@pytest.mark.parametrize(
    ("source", "name"),
    [
        ("trip.2024", "trip.2024"),
        ("trip.2025", "trip.2025"),
        ("trip.2025//", "trip.2025"),
        ("trip.2024/.", "trip.2024"),
        ("trip.2024/../trip.2025/", "trip.2025"),
        ("link", "trip.2024"),
        ("walk.v2.mp4", "walk.v2"),
        ("it's #2: a=b, true", "it's #2: a=b, true"),
        ('say "x"', 'say "x"'),
        ("-x", "-x"),
    ],
)
def test_a_capture_is_called_after_the_folder_or_the_video_itself(source, name, made, tmp_path):
    for folder in ("trip.2024", "trip.2025", "it's #2: a=b, true", 'say "x"', "-x"):
        (tmp_path / folder).mkdir()
    (tmp_path / "walk.v2.mp4").touch()
    (tmp_path / "link").symlink_to("trip.2024")
    status, _, words = made(f"{tmp_path}/{source}")
    assert status == 0
    out, place, given = captured(words)
    assert out == given == f"captures/{name}"
    assert place == os.path.realpath(tmp_path / source.rstrip("/"))


@pytest.mark.parametrize(
    ("source", "line"),
    [
        ("", "error: FROM=: names no folder of photographs; say make photographs FROM=DIR"),
        ("nowhere", "error: FROM=nowhere: there is no such folder or video; say make photographs FROM=DIR"),
        (".", "error: FROM=.: holds this project, whose own pictures would count; say make photographs FROM=DIR"),
        ("..", "error: FROM=..: holds this project, whose own pictures would count; say make photographs FROM=DIR"),
        ("/", "error: FROM=/: holds this project, whose own pictures would count; say make photographs FROM=DIR"),
        ("../.mp4", "error: FROM=../.mp4: has no name that a capture could take; say make photographs FROM=DIR"),
    ],
)
def test_what_is_no_source_is_one_line_and_nothing_is_run(source, line, made, tmp_path):
    (tmp_path / ".mp4").touch()
    status, told, words = made(source)
    assert (status, told.splitlines()[0], words) == (2, line, [])
