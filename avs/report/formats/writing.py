"""A table written in every form."""

from __future__ import annotations

from pathlib import Path

from avs.report.document import Document
from avs.report.formats.delimited import document_csv, listing_csv
from avs.report.formats.latex import document_latex
from avs.report.formats.markdown import document_markdown
from avs.report.formats.table_record import write_table_record
from avs.system.files import write_text


def write_document(document: Document, out: Path) -> None:
    """Write ``out`` with the suffixes ``.csv``, ``.md``, ``.tex`` and ``.json``, and a csv file for each appendix."""
    write_text(with_ending(out, ".csv"), document_csv(document))
    write_text(with_ending(out, ".md"), document_markdown(document))
    write_text(with_ending(out, ".tex"), document_latex(document))
    write_table_record(with_ending(out, ".json"), document)
    for name, listing in document.appendices.items():
        write_text(with_ending(out, f"{name}.csv"), listing_csv(listing))


def with_ending(path: Path, ending: str) -> Path:
    """Append ``ending``, not ``with_suffix``: a data set's name may hold a point."""
    return path.with_name(path.name + ending)
