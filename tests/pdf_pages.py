"""Pages of a report's PDF for tests that read its words."""

import re
from pathlib import Path

from pypdf import PageObject, PdfReader
from pypdf.generic import ContentStream, NameObject

# what is drawn from q to Q, without text (BT, ET), images (Do), marked content (BDC, EMC) and further q
DRAWN = re.compile(rb"(?<=\s)q\s[^qQBED()<>]*Q\s+")
# steps of a path: to a point, along a line or a curve, and back to the start
STEPS = re.compile(rb"(?<=\s)(?:(?:-?[\d.]+\s){6}c|(?:-?[\d.]+\s){2}[lm]|h)\s+")


def pages_of(path: Path) -> list[PageObject]:
    """Pages of a PDF without what is drawn in its figures.

    Drawings are most of a page's operators; to parse them takes several times as long as all else.
    """
    reader = PdfReader(path)
    pages = list(reader.pages)
    for page in pages:
        content = ContentStream(page["/Contents"].get_object(), reader, "bytes")
        data, count = content.get_data(), 1
        while count:  # drawings in drawings
            data, count = DRAWN.subn(b"", data)
        content.set_data(STEPS.sub(b"", data))
        page[NameObject("/Contents")] = content
    return pages
