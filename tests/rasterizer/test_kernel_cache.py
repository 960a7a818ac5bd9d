"""Compiled code on disk that is damaged is compiled anew, and no process dies of it."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CODE = """
import sys
sys.path.insert(0, {folder!r})
from toy import twice
print(twice(21.0))
"""


def run(folder):
    words = [sys.executable, "-c", CODE.format(folder=str(folder))]
    return subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize(
    "damage", [lambda content: content[: len(content) // 2], lambda content: b"", lambda _: b"x" * 99]
)
def test_a_damaged_cache_is_made_anew(suffix, damage, tmp_path):
    text = (
        "from avs.rasterizer.kernels import kernel\n\n\ndef double(x):\n    return 2 * x\n\n\ntwice = kernel(double)\n"
    )
    (tmp_path / "toy.py").write_text(text)
    assert run(tmp_path) == "42.0\n"
    (cached,) = (tmp_path / "__pycache__").glob(f"*.{suffix}")
    cached.write_bytes(damage(cached.read_bytes()))
    first, second = run(tmp_path), run(tmp_path)
    assert first.endswith("42.0\n")
    assert "it is compiled anew" in first
    assert second == "42.0\n"
