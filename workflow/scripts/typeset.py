"""Typesetting of a report by Typst."""

import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

import typst


def typeset(files: Mapping[str, str | Path], main: str, pdf: str | Path) -> None:
    """Typeset the source ``main`` to a PDF, the same bytes from the same files.

    Typst reads below one root only: ``files`` maps paths below it, that of ``main`` among them, to files.
    """
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, path in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, root / name)
        typst.compile(
            str(root / main),
            output=pdf,
            root=str(root),
            ignore_system_fonts=True,
            timestamp=0,
            pdf_standards="a-2b",
        )
