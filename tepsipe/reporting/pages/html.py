"""HTML as text: everything that a user may have named is escaped."""

import json
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

# nothing is loaded from anywhere: a page that tried it would be stopped by the browser
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"


def text(value: object) -> str:
    """Any value as text of a page or of an attribute (no unit)."""
    return escape(str(value), quote=True)


def json_script(identifier: str, content: object) -> str:
    """Data for the page's script (any unit), which no text in it can end."""
    plain = json.dumps(content, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    plain = plain.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
    return f'<script type="application/json" id="{text(identifier)}">{plain}</script>'


def asset(name: str) -> str:
    """Text of a file of this package (no unit), for example plot.js."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def table(header: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "", kind: str = "") -> str:
    """A table (units in its header) of cells that are HTML already; the first of every row is its heading."""
    head = "".join(f'<th scope="col">{cell}</th>' if cell else "<td></td>" for cell in header)
    body = "".join(
        f'<tr><th scope="row">{row[0]}</th>' + "".join(f"<td>{cell}</td>" for cell in row[1:]) + "</tr>\n"
        for row in rows
    )
    about = f"<caption><span>{caption}</span></caption>" if caption else ""
    return (
        f'<div class="wide"><table class="{text(kind)}">{about}<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}</tbody></table></div>\n"
    )


def document(title: str, body: str, policy: str | None = POLICY) -> str:
    """A whole page (no unit) with the style of all pages; ``title`` is plain text, ``body`` is HTML."""
    guard = f'<meta http-equiv="Content-Security-Policy" content="{text(policy)}">\n' if policy else ""
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"{guard}"
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{text(title)}</title>\n<style>\n{asset('page.css')}</style>\n"
        f"<script>\n{asset('theme.js')}</script>\n</head>\n"
        f"<body>\n{body}</body>\n</html>\n"
    )
