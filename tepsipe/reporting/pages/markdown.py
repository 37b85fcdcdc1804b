"""The part of Markdown that the records of decisions use, as HTML."""

import re
from collections.abc import Iterator
from pathlib import Path

from tepsipe.reporting.pages.html import table, text


def record_of(path: str | Path) -> tuple[str, str, str]:
    """Title of a record of a decision, its HTML, and the name of its file."""
    title, _, words = Path(path).read_text(encoding="utf-8").partition("\n")
    return title.lstrip("# ").partition(". ")[2], html_of(words), Path(path).name


def html_of(markdown: str) -> str:
    """Paragraphs, lists, tables, bold, italic, code, and links (as their words), as HTML; no headings."""
    return "".join(_block(lines) for lines in _blocks(markdown))


def inline(words: str) -> str:
    """Words within a paragraph as HTML."""
    words = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", words)
    parts = re.split(r"(`[^`]+`)", words)
    return "".join(
        f"<code>{text(p[1:-1])}</code>" if p.startswith("`") else _emphasis(text(p)) for p in parts
    )


def _emphasis(words: str) -> str:
    words = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", words, flags=re.DOTALL)
    return re.sub(r"(?<![\w*])\*([^*\s][^*]*?)\*(?![\w*])", r"<em>\1</em>", words)


def _blocks(markdown: str) -> Iterator[list[str]]:
    """Lines between empty lines; a list or a table below a paragraph is a block of its own."""
    for block in re.split(r"\n\s*\n", re.sub(r"(?m)^#.*\n?", "", markdown).strip()):
        lines: list[str] = []
        for line in block.splitlines():
            if lines and _kind(line) and not _kind(lines[0]):
                yield lines
                lines = []
            lines.append(line)
        if lines:
            yield lines


def _kind(line: str) -> str:
    found = re.match(r"\s*(- |\||    )", line)
    return found[1] if found else ""


def _block(lines: list[str]) -> str:
    kind = _kind(lines[0])
    if kind == "- ":
        items = re.split(r"(?m)^\s*- ", "\n".join(lines))[1:]
        return "<ul>" + "".join(f"<li>{inline(item.strip())}</li>" for item in items) + "</ul>\n"
    if kind == "|":
        rows = [[inline(cell.strip()) for cell in line.strip().strip("|").split("|")] for line in lines]
        return table(rows[0], rows[2:])
    if kind == "    ":
        return f"<pre>{text(chr(10).join(line[4:] for line in lines))}</pre>\n"
    return f"<p>{inline(' '.join(line.strip() for line in lines))}</p>\n"
