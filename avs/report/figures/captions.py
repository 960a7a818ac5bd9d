"""The caption of a figure: a text file beside it, so that nobody has to guess what it shows."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

from avs.report.machines import machine_notes
from avs.system.files import write_text

_WIDTH = 100


def write_caption(out: Path, text: str) -> None:
    """Write the caption of the figure ``out``, a path without suffix, as Markdown."""
    write_text(out.with_name(f"{out.name}.md"), textwrap.fill(text, _WIDTH, break_on_hyphens=False) + "\n")


def told_of_machines(records: Sequence[Path], *, timed: bool = False) -> str:
    """Return the end of a caption: of which machines and packages the episodes are, if of several; else nothing.

    Args:
        records: ``episode.json`` files; see ``avs.report.machines.machine_notes``.
        timed: as there.

    Raises:
        UserError: what lies beside one is damaged.
    """
    return sentences(machine_notes(records, timed=timed))


def sentences(notes: Sequence[str]) -> str:
    """Return notes, which have no full stop, as sentences behind others."""
    return "".join(f" {note[0].upper()}{note[1:]}." for note in notes)


def read_caption(figure: Path) -> str | None:
    """Return the caption beside a file of a figure, on one line, or None where it has none."""
    path = figure.with_suffix(".md")
    return " ".join(path.read_text(encoding="utf-8").split()) if path.is_file() else None
