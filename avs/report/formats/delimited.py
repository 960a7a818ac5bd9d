"""Tables as csv: for other programs."""

from __future__ import annotations

import csv
import io

from avs.report.document import Document, Listing
from avs.report.formats.plain_text import one_line


def document_csv(document: Document) -> str:
    """Return the numbers of a table."""
    return listing_csv(document.listing)


def listing_csv(listing: Listing) -> str:
    """Return a header and one line for each record, with line feeds."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(listing.fields)
    writer.writerows(
        [one_line(value) if isinstance(value, str) else value for value in each] for each in listing.records
    )
    return stream.getvalue()
