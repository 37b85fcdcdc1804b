"""The report as a page for a browser: the HTML of Typst in a frame with contents, search, and origins.

Typst typesets all words and numbers (report/*.typ). This module gives every section, figure, table and
equation an anchor that does not change with others, and puts below every figure and table where it comes
from. Links are relative to the folder of the page, so that the results can be moved. The records of decisions
are turned into HTML here, as far as they use Markdown.
"""

import re
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import unescape
from pathlib import Path
from string import ascii_lowercase, ascii_uppercase
from urllib.parse import quote

from tepsipe.drawing.trial_page import WEB, asset, json_script, table, text

# letters of formulas stand in planes in which nobody searches: plain ones, which browsers make italic
ITALIC = {chr(0x1D434 + k): letter for k, letter in enumerate(ascii_uppercase + ascii_lowercase)}
ITALIC |= {chr(0x1D6E2 + k): chr(0x391 + k) for k in range(25) if k != 17}
ITALIC |= {chr(0x1D6FC + k): chr(0x3B1 + k) for k in range(25)}
ITALIC |= {"\u210e": "h", "\U0001d6df": "\u03d1", "\U0001d719": "\u03d5", "\U0001d711": "\u03c6"}
# dots that combine with a letter stand beside it in some browsers
ACCENTS = {"\u0307": "\u02d9", "\u0308": "\u00a8"}
SCRIPTS = ("report.js", "swing.js", "explore.js")
# questions of a reader, and the first of these places that the report has
QUESTIONS = {
    "Answer": ("answers", "abstract", "findings"),
    "Why?": ("not-physical", "discussion"),
    "How certain is this?": ("certainty", "truth", "budgets"),
    "What is missing?": ("what-is-missing-for-a-better-answer",),
    "Results of every trial": ("trials",),
    "Raw data": ("raw-data",),
    "Code": ("code",),
    "Command": ("make-again",),
    "What is simulated": ("simulated", "laboratory"),
    "What did not reproduce": ("ledger",),
    "Your own recordings": ("own-recordings",),
}
# of the table behind a question, the choice of a filter
FILTERS = {"ledger": "verdict=not reproduced"}
# titles of the figures to try
TRIED = {
    "apparent": "Try it: a wrong torque",
    "specification": "Try it: all choices",
    "forward": "Try it: the swing",
}
# number of a chapter of the supplement
SUPPLEMENTARY = re.compile(r"\s*S\d+\s")
# elements of a heading that its entry in the contents keeps
KEPT = "em|math|mi|mn|msub|mrow|code"
# a cell with a number, which may have signs, an interval and marks
NUMBER = re.compile(r"^[\s\u2060]*[(<>]?[\s<>±−+\-]*\d[\d.,  ·⁰¹²³⁴⁵⁶⁷⁸⁹⁻%*†‡∗×/()±−to–-]*$")


@dataclass(frozen=True)
class Origin:
    """Where a figure or table comes from."""

    data: Mapping[str, str]
    """Words of a link -> path of a file, relative to the page."""
    code: Sequence[tuple[str, str]]
    """What a place in the code is (rule, script, function, source), and the place: ``path``, ``path:line`` or
    ``name (path:line)``."""
    command: str
    """What makes it again."""


@dataclass(frozen=True)
class ReportPage:
    """All that the page has beside the typeset report."""

    title: str
    """Title of the study."""
    facts: Sequence[tuple[str, str]]
    """Authors, version, commit and the like, with their names."""
    files: Mapping[str, str]
    """Words of a link -> path of the same report in another form, relative to the page."""
    sizes: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Path of an image, relative to the page -> width and height (points)."""
    source: str = "report.typ"
    """Source of the report, for parts that name no other one."""
    origins: Mapping[str, Origin] = field(default_factory=dict)
    """Anchor of a figure, table or part -> where it comes from; source of a part of the report -> the same
    of the tables that have no anchor of their own."""
    rests_on: Mapping[str, Sequence[int]] = field(default_factory=dict)
    """Anchor of a figure, table or section, or source -> numbers of the decisions on which it rests."""
    decisions: Mapping[int, tuple[str, str, str]] = field(default_factory=dict)
    """Number of a decision -> its title, its HTML, and the name of its file."""
    parts: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    """Identifier of a section that follows the report -> its title and its HTML."""
    explored: Mapping[str, tuple[str, object]] = field(default_factory=dict)
    """Anchor of a figure -> what there is to try below it (a key of `TRIED`), and its data."""
    functions: Mapping[str, str] = field(default_factory=dict)
    """Place of a function, as origins name it -> its source."""
    repository: str = ""
    """Address of the sources at the commit of the run, to which a path is added; empty if it is not known."""


def render_report(typeset: str, page: ReportPage) -> str:
    """The report as one file of HTML, the same for the same content.

    typeset: the report as Typst exports it; chapters of a supplement (S1, S2, ...) are folded.
    page: what the page has beside it.
    Returns: the page; its links and images are relative to it.
    """
    math_style = re.search(r"(?s)<style>(.*?)</style>", typeset)
    body = typeset.partition("<body>")[2].rpartition("</body>")[0]
    body = _own_drawings(_plain_letters(body))
    body = _folded(_own_anchors(body))
    # what scrolls on a narrow screen is reached by keys
    body = re.sub(r' class="(equation|drawn)"', r'\g<0> tabindex="0"', body)
    body = re.sub(r"(?s)<table.*?</table>", _marked_columns, body)
    body = re.sub(r'<img src="([^"]+)"', lambda m: _image(m[1], page.sizes), body)
    body = _lead(body)
    body, used = _with_origins(body, page)
    used = sorted({*used, *(n for key in page.parts for n in page.rests_on.get(key, ()))})
    parts = {**_tried(body, page), **page.parts, **_decisions(used, page.decisions)}
    for key, (title, content) in parts.items():
        rests = page.rests_on.get(key, ())
        below = _origin(page.origins[key], rests, page) if key in page.origins else ""
        body += f'<section>\n<h2 id="{text(key)}">{text(title)}</h2>\n{content}{below}</section>\n'
    body = _headings_with_links(_links_to_sections(_functions_once(body, page)))
    subtitle = re.search(r'(?s)<p class="subtitle">.*?</p>', body)
    body = body.replace(subtitle[0], "") if subtitle else body
    first = re.search(r'(?s)(<section id="lead">\s*)(<p>.*?</p>)', body)
    body = body.replace(first[0], "<section>") if first else body
    top = (subtitle[0] if subtitle else "") + (f'<div id="lead">{first[2]}</div>\n' if first else "")
    scripts = "".join(f"<script>\n{asset(name)}</script>\n" for name in SCRIPTS)
    font = b64encode((WEB / "report-math.woff2").read_bytes()).decode("ascii")
    style = (
        f'@font-face {{ font-family: "Report Math"; src: url("data:font/woff2;base64,{font}"); }}\n'
        f"{math_style[1] if math_style else ''}{asset('report.css')}"
    )
    return (
        '<!doctype html>\n<html lang="en-GB">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{text(page.title)}</title>\n<style>\n{style}</style>\n"
        f"<script>\n{asset('theme.js')}</script>\n</head>\n<body>\n"
        '<a class="skip" href="#report">To the report</a>\n'
        f"{_side(body)}"
        f'<main id="report">\n{_head(page, top, _questions(body))}{_lines(body)}</main>\n'
        f"{json_script('page-data', dict(page.explored.values()))}\n"
        f"{scripts}</body>\n</html>\n"
    )


def about_code(citation: Mapping, code: Mapping) -> list[tuple[str, str]]:
    """Authors and version of the software (CITATION.cff), and the commit of the run, for `ReportPage`."""
    authors = ", ".join(
        person.get("name") or f"{person.get('given-names', '')} {person.get('family-names', '')}".strip()
        for person in citation["authors"]
    )
    commit = (code["commit"] or "")[:12] + (", with uncommitted changes" if code["modified"] else "")
    return [
        ("Authors of the software", authors),
        ("Version", citation["version"]),
        ("Commit", commit),
        ("Date of the commit", code["date"]),
    ]


def made_again(command: str) -> str:
    """Section on the command that repeats the run, its code, and how to begin with own recordings."""
    own = "tepsipe new-study recordings --output my-study && cd my-study && tepsipe check && tepsipe run"
    return (
        "<p>To repeat the whole run, use this command in the folder of the run, with the version named at "
        "the top. To repeat a single figure, table or trial, use the command under its <i>Data, code, "
        f"command</i> or on the page of the trial.</p>\n{_copied(command)}"
        '<h3 id="code">Code</h3>\n'
        "<p>The rule, script and function behind every figure and table are under its <i>Data, code, "
        "command</i>, with the source of the function.</p>\n"
        '<h3 id="own-recordings">Your own recordings</h3>\n'
        "<p>These commands turn a folder of your recordings into a study. The project's page "
        "<code>docs/recordings/README.md</code> lists the instruments that can be read.</p>\n"
        f"{_copied(own)}"
    )


def _copied(command: str) -> str:
    return f'<p><code>{text(command)}</code> <button type="button" class="copy">copy</button></p>\n'


def picture_size(path: str | Path) -> tuple[float, float]:
    """Width and height of a drawing of the run, an SVG (points); zeros if it names none."""
    head = Path(path).read_text(encoding="utf-8")[:2000]
    found = re.search(r'width="([\d.]+)pt" height="([\d.]+)pt"', head)
    return (float(found[1]), float(found[2])) if found else (0.0, 0.0)


def link(path: str, words: str) -> str:
    """A link to a file that is named relative to the page; ``words`` is plain text."""
    # "./" so that a colon in the first part is not read as a scheme
    return f'<a href="{text("./" + quote(path))}">{text(words)}</a>'


# ---- typeset report


def _folded(body: str) -> str:
    """A body in which the chapters of the supplement are shown on demand."""
    parts: list[str] = []
    depth, opened = 0, None
    for part in re.split(r"(?s)(<(?:div|section)\b|</(?:div|section)>|<h2\b.*?</h2>)", body):
        depth += part in ("<div", "<section")
        if opened is not None and (part.startswith("<h2") or (part.startswith("</") and opened == depth)):
            parts.append("</details>\n")
            opened = None
        depth -= part in ("</div>", "</section>")
        if part.startswith("<h2") and SUPPLEMENTARY.match(re.sub(r"<[^>]+>", "", part)):
            part, opened = f'<details class="chapter"><summary>{part}</summary>\n', depth
        parts.append(part)
    return "".join(parts) + ("</details>\n" if opened is not None else "")


def _links_to_sections(body: str) -> str:
    """Links to the sections that the page's own parts name by their titles; words where there is none."""
    headings = re.findall(r'(?s)<h[2-5] id="([^"]+)"[^>]*>(.*?)</h[2-5]>', body)
    names = {}
    for name, words in headings:
        numbered = " ".join(unescape(re.sub(r"<[^>]+>", "", words)).split())
        number, title = re.fullmatch(r"(S?\d[\d.]* )?(.*)", numbered).groups("")
        names[title] = name, number

    def linked(found: re.Match) -> str:
        name, number = names.get(unescape(found[1]), ("", ""))
        told = f"Section {number}\N{LEFT DOUBLE QUOTATION MARK}{found[2]}\N{RIGHT DOUBLE QUOTATION MARK}"
        return f'<a href="#{name}">{told}</a>' if name else told

    return re.sub(r'<a href="#section:([^"]+)">(.*?)</a>', linked, body)


def _plain_letters(body: str) -> str:
    """Formulas with letters that can be searched, spaces, and dots above the middle of a letter."""

    def letter(found: re.Match) -> str:
        if found[1] == "\N{EM SPACE}":
            return '<mspace width="1em"></mspace>'
        plain = ITALIC.get(found[1])
        return f"<mi>{plain}</mi>" if plain else found[0]

    body = re.sub(r"<mi>([^<])</mi>", letter, body)
    return re.sub(r"<mo>([\u0307\u0308])</mo>", lambda m: f"<mo>{ACCENTS[m[1]]}</mo>", body)


def _own_drawings(body: str) -> str:
    """Drawings of Typst, each with identifiers of its own for the glyphs that they share."""
    parts = re.split(r"(?s)(<svg.*?</svg>)", body)
    for k in range(1, len(parts), 2):
        parts[k] = re.sub(r"\bg(?=[0-9A-F]{20})", f"d{k}g", parts[k])
    return "".join(parts)


def _own_anchors(body: str) -> str:
    """Anchors by words and numbers in place of Typst's ``loc-…``, which count all elements before."""
    body, names = _labelled(body)
    taken = set(re.findall(r' id="((?!loc-\d)[^"]+)"', body)) | set(names.values())

    def free(wanted: str) -> str:
        name, k = wanted, 2
        while name in taken:
            name, k = f"{wanted}-{k}", k + 1
        taken.add(name)
        return name

    def heading(found: re.Match) -> str:
        level, attributes, words = found.groups()
        slug = _slug(re.sub(r"<[^>]+>", "", words))
        old = re.search(r' id="(loc-\d+)"', attributes)
        if old:
            if old[1] not in names:
                names[old[1]] = free(slug)
            return found[0]
        return (
            found[0]
            if " id=" in attributes
            else f'<h{level} id="{free(slug)}"{attributes}>{words}</h{level}>'
        )

    def figure(found: re.Match) -> str:
        attributes, content = found.groups()
        if ' id="' in attributes:
            return found[0]
        numbered = re.search(r"(Figure|Table)[\s ]+(S?\d+)", re.sub(r"<[^>]+>", "", content))
        name = free("-".join(numbered.groups()).lower() if numbered else "figure")
        return f'<figure id="{name}"{attributes}>{content}</figure>'

    def reference(found: re.Match) -> str:
        names[found[1]] = free(f"reference-{found[3]}")
        return found[0]

    def equation(found: re.Match) -> str:
        number = re.search(r'<span class="number">\((\w+)\)</span>', found[0])
        if number and " id=" not in found[1]:
            return found[0].replace("<math", f'<math id="{free(f"equation-{number[1]}")}"', 1)
        return found[0]

    body = re.sub(r'<li id="(loc-\d+)">(<span class="prefix"><a [^>]*>\[)(\d+)', reference, body)
    body = re.sub(r'(?s)<div class="equation">(<math[^>]*>).*?</div>', equation, body)
    body = re.sub(r"(?s)<h([2-5])([^>]*)>(.*?)</h\1>", heading, body)
    body = re.sub(r"(?s)<figure([^>]*)>(.*?)</figure>", figure, body)
    body = re.sub(r'(?<= id=")loc-\d+(?=")', lambda m: names.get(m[0], m[0]), body)
    return re.sub(r'(?<= href="#)loc-\d+(?=")', lambda m: names.get(m[0], m[0]), body)


def _labelled(body: str) -> tuple[str, dict[str, str]]:
    """Headings and figures with the labels that stand before them as anchors; Typst's own names for some."""
    names: dict[str, str] = {}

    def labelled(found: re.Match) -> str:
        before, label, tag, attributes = found.groups()
        own = re.search(r' id="([^"]+)"', before + attributes)
        if own and own[1] != label:
            names[own[1]] = label
        attributes = re.sub(r' id="[^"]+"', "", attributes)
        return f'<{tag} id="{label}"{attributes}>'

    marked = r'<div((?: id="[^"]+")?) data-label="([^"]+)"></div>\s*<(h[2-6]|figure)([^>]*)>'
    return re.sub(marked, labelled, body), names


def _slug(words: str) -> str:
    """Lower-case letters and digits of a heading without its number, joined by hyphens."""
    words = re.sub(r"^[\dA-Z]?[\d.]*\s+", "", unescape(words).strip())
    return re.sub(r"[^a-z0-9]+", "-", words.lower()).strip("-") or "section"


def _marked_columns(found: re.Match) -> str:
    """A table that scrolls by itself if it is wide; columns of numbers are right-aligned."""
    shown = re.sub(r"(?s)<td(?P<a>[^>]*)>(?P<c>.*?)</td>", _cell, found[0])
    shown = re.sub(r"<th([^>]*)></th>", r"<td\1></td>", shown)  # a corner without words heads nothing
    return f'<div class="wide" tabindex="0">{shown}</div>'


def _cell(found: re.Match) -> str:
    plain = re.sub(r"<[^>]+>", "", found["c"].replace("<br>", " "))
    if "<code>" in found["c"]:  # versions and checksums are no numbers
        return found[0]
    return f'<td class="n"{found["a"]}>{found["c"]}</td>' if NUMBER.match(plain) else found[0]


def _image(path: str, sizes: Mapping[str, tuple[float, float]]) -> str:
    """Opening of an image with its size, so that nothing moves when it is loaded."""
    width, height = sizes.get(path, (0.0, 0.0))
    size = f' width="{width:.0f}" height="{height:.0f}"' if width and height else ""
    return f'<img src="{text(quote(path))}"{size}'


def _lead(body: str) -> str:
    """The figure of the result below the first paragraph: the same image and words, with a link to it."""
    wanted = re.search(r'<div data-lead="([^"]+)"></div>', body)
    if not wanted:
        return body
    shown = re.search(rf'(?s)<figure[^>]*id="{re.escape(wanted[1])}".*?</figure>', body)
    if not shown:
        return body.replace(wanted[0], "")
    image = re.search(r"<img[^>]*>", shown[0])
    caption = re.search(r"(?s)<figcaption>(.*?)</figcaption>", shown[0])
    picture = image[0].replace(' loading="lazy"', "") if image else ""
    label, _, words = caption[1].partition(": ") if caption else ("", "", "")
    # the first sentence; all of a caption that describes its parts one by one
    finding = None if words.startswith("Left") else re.match(r"(?s)(.*?[.:])(\s|$)", words)
    found = re.sub(r":$", ".", finding[1]) if finding else words
    return body.replace(
        wanted[0],
        f'<div class="lead"><a href="#{wanted[1]}">{picture}</a>'
        f'<p>{found} <a href="#{wanted[1]}">{label}</a></p></div>',
    )


# ---- origins


# a figure; tables that follow each other without a caption
SHOWN = r'<figure.*?</figure>|(?:<div class="wide"[^>]*><table.*?</table></div>\s*)+'


def _with_origins(body: str, page: ReportPage) -> tuple[str, list[int]]:
    """Below every figure and table, where it comes from; and the decisions that are named there."""
    source, section, used = page.source, "", set()
    parts = re.split(rf'(?s)(<div data-source="[^"]+">|{SHOWN}|<h[2-4] id="[^"]+")', body)
    for k, part in enumerate(parts):
        if part.startswith("<div data-source"):
            source = part.split('"')[1]
        elif part.startswith("<h"):
            section = part.split('"')[1]
        elif re.match(SHOWN, part, re.DOTALL):
            name, known = _names_of(part)
            rests = next((page.rests_on[p] for p in (*known, section, source) if p in page.rests_on), ())
            used.update(rests)
            origin = next((page.origins[key] for key in (*known, source) if key in page.origins), None)
            if origin:
                below = _origin(origin, rests, page)
                figure, end, _ = part.partition("</figure>")
                parts[k] = figure + below + end
            if name in page.explored:
                parts[k] += _explorer(page.explored[name][0])
    return "".join(parts), sorted(used)


def _explorer(kind: str) -> str:
    return (
        f'<div class="explorer" id="try-{kind}" data-explore="{kind}" data-title="{text(TRIED[kind])}" '
        "hidden></div>\n"
    )


def _tried(body: str, page: ReportPage) -> dict[str, tuple[str, str]]:
    """Section with what there is to try about figures that the report does not show."""
    left = [kind for kind, _ in page.explored.values() if f'id="try-{kind}"' not in body]
    return {"try": ("Try it", "".join(map(_explorer, left)))} if left else {}


def _names_of(shown: str) -> tuple[str, list[str]]:
    """Anchor of a figure, empty for a table without one; and the names by which its origin may be known."""
    anchor = re.match(r'<figure id="([^"]+)"', shown)
    if not anchor:
        return "", []
    picture = re.search(r'<img src="[^"]*?(\w+)\.svg"', shown)  # its label may be another one
    names = [anchor[1], picture[1] if picture else "", re.sub(r"_\d$", "", anchor[1])]  # blocks of a table
    return anchor[1], list(filter(None, names))


def _origin(origin: Origin, rests: Sequence[int], page: ReportPage) -> str:
    files = " ".join(link(path, words) for words, path in origin.data.items())
    code = "".join(f"<dt>{text(what)}</dt><dd>{_place(place, page)}</dd>" for what, place in origin.code)
    named = ", ".join(
        f'<a href="#decision-{n}">decision {n}: {text(page.decisions[n][0])}</a>'
        for n in rests
        if n in page.decisions
    )
    return (
        '<details class="origin"><summary>Data, code, command</summary>\n'
        f"<dl><dt>Data</dt><dd>{files}</dd>{code}"
        f"{f'<dt>Based on</dt><dd>{named}</dd>' if named else ''}"
        f"<dt>Command</dt><dd><code>{text(origin.command)}</code> "
        '<button type="button" class="copy">copy</button></dd></dl></details>\n'
    )


def _place(place: str, page: ReportPage) -> str:
    """A place in the code; the source of a function is folded below it, where `_functions_once` puts it."""
    if place in page.functions:
        return f'<details class="code"><summary><code>{text(place)}</code></summary></details>'
    return f"<code>{text(place)}</code>{_line_of(place, page)}"


def _line_of(place: str, page: ReportPage) -> str:
    """Link to the line of a place at the commit of the run, if the address of the repository is known."""
    found = re.search(r"([\w./-]+\.\w+)(?::(\d+))?\)?$", place)
    if not page.repository or not found:
        return ""
    line = f"#L{found[2]}" if found[2] else ""
    return f' <a href="{text(page.repository)}/{quote(found[1])}{line}">in the repository</a>'


def _functions_once(body: str, page: ReportPage) -> str:
    """The source of a function at the first figure or table that it makes; at the others a link to it."""
    names: dict[str, str] = {}

    def filled(found: re.Match) -> str:
        place = unescape(found[1])
        if place in names:
            content = f'<a href="#{names[place]}">Source</a>'
            return f"{found[0].removesuffix('</details>')}{content}</details>"
        names[place] = f"code-{_slug(place)}-{len(names) + 1}"
        code = f'{_line_of(place, page)}<pre tabindex="0"><code>{text(page.functions[place])}</code></pre>'
        summary = f"<summary><code>{found[1]}</code></summary>"
        return f'<details class="code" id="{names[place]}">{summary}{code}</details>'

    return re.sub(r'<details class="code"><summary><code>(.*?)</code></summary></details>', filled, body)


def _decisions(
    used: Sequence[int], decisions: Mapping[int, tuple[str, str, str]]
) -> dict[str, tuple[str, str]]:
    """Section with the records of the decisions that figures and tables name."""
    records = "".join(
        f'<details class="decision" id="decision-{n}"><summary>{n}. {text(decisions[n][0])}</summary>\n'
        f"{decisions[n][1]}<p><code>docs/decisions/{text(decisions[n][2])}</code></p></details>\n"
        for n in used
        if n in decisions
    )
    about = (
        "<p>These are the decisions on which figures and tables of this page are based. All decisions are in "
        "the folder <code>docs/decisions</code> of the project.</p>\n"
    )
    return {"decisions": ("Decisions", about + records)} if records else {}


# ---- frame


def _headings_with_links(body: str) -> str:
    """Headings from which their address can be copied."""

    def linked(found: re.Match) -> str:
        level, name, attributes, words = found.groups()
        own = f'<a class="anchor" href="#{name}" aria-label="Link to this section">#</a>'
        return f'<h{level} id="{name}"{attributes}>{words} {own}</h{level}>'

    # a click on the heading of a folded chapter unfolds it
    return re.sub(r'(?s)(?<!<summary>)<h([2-5]) id="([^"]+)"([^>]*)>(.*?)</h\1>', linked, body)


def _side(body: str) -> str:
    """Contents, search and the choice between light and dark; of folded chapters no sections."""
    folded = set(re.findall(r'<details class="chapter"><summary><h2 id="([^"]+)"', body))
    items, chapter = [], ""
    for level, name, words in re.findall(r'(?s)<h([23]) id="([^"]+)"[^>]*>(.*?)</h\1>', body):
        chapter = name if level == "2" else chapter
        if level == "3" and chapter in folded:
            continue
        plain = re.sub(rf"(?s)<a class=.anchor.*?</a>|<(?!/?(?:{KEPT})\b)[^>]+>", "", words)
        kind = f"level-{level} folded" if chapter in folded else f"level-{level}"
        items.append(f'<li class="{kind}"><a href="#{name}">{plain.strip()}</a></li>\n')
    return (
        '<nav class="side" aria-label="Contents">\n<details open><summary>Contents</summary>\n'
        '<div class="tools"><input type="search" id="search" placeholder="Search" '
        'aria-label="Search the report">'
        '<button type="button" id="theme" aria-label="Light or dark">◐</button></div>\n'
        '<ol id="found" hidden></ol>\n'
        f'<ol id="contents">\n{"".join(items)}</ol>\n</details>\n</nav>\n'
    )


def _head(page: ReportPage, top: str, questions: str) -> str:
    """Title, subtitle and first paragraph (``top``), questions of a reader, facts and other forms."""
    facts = "".join(
        f"<div><dt>{text(name)}</dt><dd>{text(value)}</dd></div>" for name, value in page.facts if value
    )
    files = " ".join(link(path, words) for words, path in page.files.items())
    return (
        f'<header>\n<h1>{text(page.title)}</h1>\n{top}{questions}<dl class="facts">{facts}</dl>\n'
        f'<p class="forms">{files}</p>\n</header>\n'
    )


def _questions(body: str) -> str:
    """Links to what most readers look for, and to what there is to try."""
    found = set(re.findall(r'<(?:h[2-5]|figure)[^>]* id="([^"]+)"', body))
    places = {words: next((p for p in own if p in found), None) for words, own in QUESTIONS.items()}
    links = ""
    for words, place in places.items():
        chosen = f' data-filter="{FILTERS[place]}"' if place in FILTERS else ""
        links += f'<li><a href="#{place}"{chosen}>{text(words)}</a></li>' if place else ""
    for kind, title in TRIED.items():
        if f'id="try-{kind}"' in body:
            links += f'<li class="try"><a href="#try-{kind}">{text(title)}</a></li>'
    return f'<nav class="questions" aria-label="Questions"><ul>{links}</ul></nav>\n' if links else ""


def _lines(body: str) -> str:
    """Elements on lines of their own, so that differences between two runs can be read."""
    return re.sub("(</(?:p|li|tr|dd|div|summary|details|figure|section|h[2-5])>)", r"\1\n", body)


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
            if lines and _kind_of_line(line) and not _kind_of_line(lines[0]):
                yield lines
                lines = []
            lines.append(line)
        if lines:
            yield lines


def _kind_of_line(line: str) -> str:
    found = re.match(r"\s*(- |\||    )", line)
    return found[1] if found else ""


def _block(lines: list[str]) -> str:
    kind = _kind_of_line(lines[0])
    if kind == "- ":
        items = re.split(r"(?m)^\s*- ", "\n".join(lines))[1:]
        return "<ul>" + "".join(f"<li>{inline(item.strip())}</li>" for item in items) + "</ul>\n"
    if kind == "|":
        rows = [[inline(cell.strip()) for cell in line.strip().strip("|").split("|")] for line in lines]
        return table(rows[0], rows[2:])
    if kind == "    ":
        return f'<pre tabindex="0">{text(chr(10).join(line[4:] for line in lines))}</pre>\n'
    return f"<p>{inline(' '.join(line.strip() for line in lines))}</p>\n"
