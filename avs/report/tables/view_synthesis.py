"""Writes the view synthesis table of a data set from its episode records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avs.report.collect import read_dataset
from avs.report.formats.delimited import scenes_csv, table_csv
from avs.report.formats.latex import table_latex
from avs.report.formats.markdown import table_markdown
from avs.report.published import read_published
from avs.report.tables.summary import summarise_table
from avs.system.files import write_text
from avs.system.reasons import Reason

REFERENCE = "ours-repvit"
"""The method that all others are compared with."""


def write_nvs_table(
    episodes: Sequence[Path],
    methods: Sequence[str],
    dataset: str,
    published: Path | None,
    out: Path,
    absent: Mapping[str, Reason] | None = None,
    reference: str = REFERENCE,
) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md`` and ``.tex``, and ``_per_scene.csv``.

    Equal records give equal bytes, whatever the order of ``episodes``. How each number is computed is described in
    ``docs/tables.md``.

    Args:
        episodes: ``episode.json`` files of the data set.
        methods: identifiers of the methods, in the order of rows; each has its row, with the reason where it has no
            number.
        dataset: name of the data set.
        published: a file of ``results/published`` (``avs.report.published.published_name``), or None.
        out: path of the table without suffix.
        absent: why a method could not run, with the remedy, by identifier.
        reference: identifier of the method that the others are compared with by paired bootstrap.

    Raises:
        UserError: no episodes; a record is missing, damaged, of another data set or not comparable with the others;
            or the published values cannot be read.
    """
    collected = read_dataset(episodes, methods, dataset)
    values = None if published is None else read_published(published)
    table = summarise_table(collected, methods, values, reference, absent or {})
    write_text(with_ending(out, ".csv"), table_csv(table))
    write_text(with_ending(out, "_per_scene.csv"), scenes_csv(table))
    write_text(with_ending(out, ".md"), table_markdown(table))
    write_text(with_ending(out, ".tex"), table_latex(table))


def with_ending(path: Path, ending: str) -> Path:
    """Append ``ending``, not ``with_suffix``: a data set's name may hold a point."""
    return path.with_name(path.name + ending)
