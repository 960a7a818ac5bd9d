"""The caption of a figure: a text file beside it, so that nobody has to guess what it shows."""

from __future__ import annotations

import textwrap
from pathlib import Path

from avs.system.files import write_text

_WIDTH = 100


def write_caption(out: Path, text: str) -> None:
    """Write the caption of the figure ``out``, a path without suffix, as Markdown."""
    write_text(out.with_name(f"{out.name}.md"), textwrap.fill(text, _WIDTH, break_on_hyphens=False) + "\n")
