"""The caption of a figure: a text file beside it, so that nobody has to guess what it shows."""

from __future__ import annotations

import textwrap
from pathlib import Path

from avs.system.files import write_text

_WIDTH = 100


def write_caption(out: Path, text: str) -> None:
    """Write the caption of the figure ``out``, a path without suffix, as Markdown."""
    write_text(out.with_name(f"{out.name}.md"), textwrap.fill(text, _WIDTH, break_on_hyphens=False) + "\n")


def read_caption(figure: Path) -> str | None:
    """Return the caption beside a file of a figure, on one line, or None where it has none."""
    path = figure.with_suffix(".md")
    return " ".join(path.read_text(encoding="utf-8").split()) if path.is_file() else None
