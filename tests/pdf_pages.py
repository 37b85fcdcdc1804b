"""Pages of a report's PDF for tests that read its words."""

import re
from pathlib import Path

from pypdf import PageObject, PdfReader
from pypdf.generic import ContentStream, NameObject

# steps of a path: to a point, along a line or a curve, and back to the start
STEPS = re.compile(rb"(?<=\s)(?:(?:-?[\d.]+\s){6}c|(?:-?[\d.]+\s){2}[lm]|h)\s+")


def pages_of(path: Path) -> list[PageObject]:
    """Pages of a PDF without the paths of its figures.

    Paths are nine tenths of a page's operators; to parse them takes three times as long as all else.
    """
    reader = PdfReader(path)
    pages = list(reader.pages)
    for page in pages:
        content = ContentStream(page["/Contents"].get_object(), reader, "bytes")
        content.set_data(STEPS.sub(b"", content.get_data()))
        page[NameObject("/Contents")] = content
    return pages
