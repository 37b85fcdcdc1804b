"""Hooks of MkDocs: pages from outside docs/, tutorials with outputs, links to the repository, equations."""

import ast
import inspect
import io
import os
import re
import tomllib
from contextlib import redirect_stdout, suppress
from functools import cache
from importlib.resources import files as contents
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from nbconvert import MarkdownExporter
from PIL import Image

import tepsipe

ROOT = Path(__file__).resolve().parents[1]
EXECUTED = ROOT / "build/tutorials"
DEMONSTRATION = ROOT / "results/passive-cameras"
# addresses of the project, as long as it has any
ADDRESSES = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"].get("urls", {})
ADDRESS = ADDRESSES.get("Repository")
# pages of the project that are pages of the site, too: path in the repository -> path in the site
OUTSIDE = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    **{
        path.relative_to(ROOT).as_posix(): path.relative_to(ROOT).as_posix()
        for path in sorted((ROOT / "benchmarks").rglob("*.md"))
    },
}
# folders of which every page is listed, the index first
APPENDIX = {
    "Decisions": [
        "decisions/README.md",
        *(f"decisions/{path.name}" for path in sorted((ROOT / "docs/decisions").glob("0*.md"))),
    ],
    "Measurements": sorted(
        (place for place in OUTSIDE if place.startswith("benchmarks/")),
        key=lambda place: place != "benchmarks/README.md",
    ),
}
TUTORIALS = {
    f"docs/tutorials/{path.stem}.py": path for path in sorted((ROOT / "docs/tutorials").glob("*.py"))
}
# weight of pages in the search by the first part of their path: answers before reasons
BOOST = {"glossary.md": 4.0, "versions.md": 2.0, "files.md": 2.0, "uncertainty.md": 2.0, "decisions": 0.3}
BOOST |= {"benchmarks": 0.2, "changelog.md": 0.3}
# words by which readers search for a page that names its subject otherwise
WORDS = {
    "recordings/c3d.md": ["C3D", "Vicon", "Qualisys"],
    "recordings/dflow.md": ["D-Flow", "Motek"],
    "recordings/emg.md": ["EMG"],
    "recordings/standing.md": ["stiffness of a person"],
    "recordings/weight-and-empty.md": ["treadmill force", "belt-induced force"],
    "exports.md": ["MATLAB", "OpenSim"],
    "elsewhere.md": ["install", "conda", "Windows", "container"],
    "cluster.md": ["cluster", "SLURM"],
    "when-it-stops.md": ["degrees", "sign of torque", "late torque", "gaps"],
    "uncertainty.md": ["uncertainty", "interval", "recommended"],
    "files.md": ["flag", "recommended"],
    "checks.md": ["flag", "late torque"],
    "planning.md": ["filter"],
    "citing.md": ["how to cite", "BibTeX"],
    "guideline.md": ["guideline", "protocol"],
    "benchmark.md": ["benchmark"],
    "reference/functions/fit_impedance.md": ["inertia", "damping", "stiffness"],
}
# the page of the configuration, its sections that are parts of the page of another one, and titles of pages
CONFIGURATION = "config/README.md"
JOINED = {"pathvars": "study", "noise": "dummy", "empty": "weight", "models-of-a-treadmill": "weight"}
TITLES = {
    "study": "Study and folders",
    "coverage": "Coverage study",
    "plan": "Plan study",
    "walking": "Walking",
    "plausible": "Plausible signals",
    "wristalyzer": "Torque-controlled manipulator",
    "plate_treadmill": "Treadmill and its force plates",
    "dummy": "Dummy",
    "position_manipulator": "Position-controlled manipulator",
    "platform": "Moving platform",
    "weight": "Weight, empty belt and treadmill models",
    "standing": "Standing person",
    "belt": "Unloaded treadmill",
    "uncertainty": "Type B uncertainties",
    "the-trial-sheet": "Trial sheet",
    "virtual_labyaml": "Virtual laboratory",
    "reportedyaml": "Values of the thesis",
}
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
LINK = re.compile(r"(\]\()([^)\s#]*)(#[^)\s]*)?(\))")
FUNCTION = re.compile(r"^::: tepsipe\.(\w+)$", re.MULTILINE)
NOWHERE = "nowhere"  # target of a folder, which a site without a repository does not show
CODE_NAME = re.compile(r"<code>(\w+)</code>")
# in which no name is linked
UNLINKED = re.compile(r"(<a\b.*?</a>|<h[1-6]\b.*?</h[1-6]>|<pre\b.*?</pre>|<svg\b.*?</svg>)", re.DOTALL)
FENCE = re.compile(r"(^ *```.*?^ *```|`[^`\n]+`)", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^<!-- tepsipe ?([\w-]*) -->$", re.MULTILINE)
EQUATION = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Take version and addresses, and list the pages that are written here."""
    config.site_name = f"tepsipe {tepsipe.__version__}"
    config.site_url = ADDRESSES.get("Documentation", "")
    if ADDRESS:
        config.repo_url, config.repo_name = ADDRESS, "Repository"
    else:
        config.theme["features"].remove("content.action.edit")
    made = {
        "api.md": [{"All functions": "api.md"}, *(f"reference/functions/{name}.md" for name in functions())],
        "config/README.md": [
            "reference/configuration/index.md",
            *({title: f"reference/configuration/{file_of(key)}"} for key, title in titles().items()),
        ],
    }

    def listed(entry: dict | str) -> dict | str:
        if isinstance(entry, str):
            return entry
        ((name, target),) = entry.items()
        return {name: [*map(listed, target)] if isinstance(target, list) else made.get(target, target)}

    config.nav = [*map(listed, config.nav), {"Appendix": [{name: pages} for name, pages in APPENDIX.items()]}]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages from outside docs/, the executed tutorials and the demonstration."""
    for source, place in OUTSIDE.items():
        files.append(File.generated(config, place, abs_src_path=str(ROOT / source)))
    for path in TUTORIALS.values():
        body, resources = MarkdownExporter().from_filename(str(EXECUTED / f"{path.stem}.ipynb"))
        folder = f"tutorials/{path.stem}"
        for name, data in resources["outputs"].items():
            body = body.replace(f"({name})", f"({path.stem}/{name})")
            files.append(File.generated(config, f"{folder}/{name}", content=data))
        pictures = [data for name, data in resources["outputs"].items() if name.endswith(".png")]
        files.append(File.generated(config, f"{folder}/thumbnail.png", content=thumbnail(pictures[0])))
        notebook = (EXECUTED / f"{path.stem}.ipynb").read_bytes()
        files.append(File.generated(config, f"{folder}.ipynb", content=notebook))
        title, _, rest = body.strip().partition("\n")
        body = f"{title}\n\n[Download as a notebook with outputs]({path.stem}.ipynb)\n{rest}\n"
        files.append(File.generated(config, f"{folder}.md", content=body))
    generated = {"tutorials/examples.md": examples(), **configuration()}
    generated |= {f"reference/functions/{name}.md": page_of_function(name) for name in functions()}
    for place, content in generated.items():
        files.append(File.generated(config, place, content=content))
    if not ADDRESS:
        for path in linked_files():
            place = f"files/{path.relative_to(ROOT).as_posix()}.txt"
            files.append(File.generated(config, place, abs_src_path=str(path)))
    font = "fonts/STIXTwoMath-Regular.ttf"
    content = (contents("ziamath") / font).read_bytes()
    files.append(File.generated(config, f"assets/{font}", content=content))
    for path in shown_results():
        place = f"demonstration/{path.relative_to(DEMONSTRATION).as_posix()}"
        files.append(File.generated(config, place, abs_src_path=str(path)))
    return files


def thumbnail(picture: bytes) -> bytes:
    """A picture in a width of 320 pixels."""
    made = io.BytesIO()
    with Image.open(io.BytesIO(picture)) as image:
        image.thumbnail((320, 240))
        image.save(made, "png", optimize=True)
    return made.getvalue()


@cache
def functions() -> list[str]:
    """Public names in the order of the page of functions."""
    return FUNCTION.findall((ROOT / "docs/api.md").read_text(encoding="utf-8"))


def first_line(name: str) -> str:
    """First line of the documentation of a public name."""
    return inspect.getdoc(getattr(tepsipe, name)).partition("\n")[0]


def page_of_function(name: str) -> str:
    """Page of a public name: its documentation, its source, and the pages that use it."""
    used = []
    for path in (*TUTORIALS.values(), *EXAMPLES):
        text = path.read_text(encoding="utf-8")
        title = re.search(r"^# # (.+)$", text, re.MULTILINE)
        place = f"{path.stem}.md" if title else f"examples.md#{path.stem}"
        if re.search(rf"\b{name}\b", text):
            used.append(f"- [{title[1] if title else path.name}](../../tutorials/{place})\n")
    head = f"---\ntitle: {name}\n---\n\n::: tepsipe.{name}\n    options: {{heading_level: 1}}\n"
    return head + ("\n## Used in\n\n" + "".join(used) if used else "")


def examples() -> str:
    """Page with all example scripts."""
    parts = ["# Examples as scripts\n"]
    for path in EXAMPLES:
        text = path.read_text(encoding="utf-8")
        said = ast.get_docstring(ast.parse(text)).partition("\n\n")[0]
        parts.append(f"## {path.name} {{#{path.stem}}}\n\n{said}\n\n```python\n{text}```\n")
    return "\n".join(parts)


def slug(heading: str) -> str:
    """Anchor of a heading, as a forge makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


@cache
def sections() -> list[tuple[str, str, str]]:
    """Page, heading and text of the sections of the configuration; the introduction has no heading."""
    text = (ROOT / CONFIGURATION).read_text(encoding="utf-8")
    found, page, file = [], "index", ""
    for part in re.split(r"^(?=#{1,3} )", text, flags=re.MULTILINE)[1:]:
        heading, _, body = part.partition("\n")
        key = slug(heading.lstrip("# "))
        if not heading.startswith("###"):
            page, file = key if key in TITLES else "index", key
        elif file == "configyaml":
            page = JOINED.get(key, key)
        found.append((page, heading, body))
    return found


def titles() -> dict[str, str]:
    """Titles of the pages of the configuration, in the order of its sections."""
    pages = dict.fromkeys(page for page, _, _ in sections() if page != "index")
    return {page: TITLES.get(page, page) for page in pages}


@cache
def configuration() -> dict[str, str]:
    """Pages of the configuration: place in the site -> text."""
    pages = {"index": ""}
    for page, heading, body in sections():
        name = heading.lstrip("# ")
        if heading == "## config.yaml":
            links = "".join(f"- [{title}]({file_of(key)})\n" for key, title in titles().items())
            heading, body = "## Sections and files", f"\n{links}"
        elif page not in pages:
            heading = f"# Settings: {titles()[page]} {{#{slug(name)}}}"
        elif page != "index":
            heading = f"## {name}"
        pages[page] = pages.get(page, "") + f"{heading}\n{body}"
    return {f"reference/configuration/{file_of(page)}": text for page, text in pages.items()}


def file_of(section: str) -> str:
    """Page of a section of the configuration."""
    return f"{section.removesuffix('yaml').replace('_', '-')}.md"


@cache
def place_of_setting(anchor: str) -> str:
    """Page of the site with a heading of the configuration."""
    pages = {slug(heading.lstrip("# ")): page for page, heading, _ in sections()}
    return f"reference/configuration/{file_of(pages.get(anchor, 'index'))}"


def shown_results() -> list[Path]:
    """Return the index of the demonstration's results and all files that it leads to."""
    found, waiting = set(), [DEMONSTRATION / "report/index.html"]
    while waiting:
        path = waiting.pop()
        if path in found or not path.is_file():
            continue
        found.add(path)
        if path.suffix == ".html":
            targets = re.findall(r'(?:href|src)="([^"#:]+)(?:#[^"]*)?"', path.read_text(encoding="utf-8"))
            waiting += [Path(os.path.normpath(path.parent / unquote(target))) for target in targets]
    return sorted(found)


def repository_path(page: Page) -> str:
    """Path of a page's source in the repository."""
    generated = {place: source for source, place in OUTSIDE.items()}
    generated |= {f"tutorials/{path.stem}.md": source for source, path in TUTORIALS.items()}
    generated |= dict.fromkeys(configuration(), CONFIGURATION)
    generated |= {f"reference/functions/{name}.md": "docs/api.md" for name in functions()}
    generated |= {"tutorials/examples.md": "examples/own_arrays.py"}
    place = page.file.src_uri
    return generated.get(place, f"docs/{place}")


def place_of(path: str, anchor: str) -> str | None:
    """Place in the site of a file of the repository, or of a heading of it."""
    if path == CONFIGURATION:
        return place_of_setting(anchor)
    if path == "docs/api.md" and anchor.removeprefix("tepsipe.") in functions():
        return f"reference/functions/{anchor.removeprefix('tepsipe.')}.md"
    places = OUTSIDE | {source: f"tutorials/{path.stem}.md" for source, path in TUTORIALS.items()}
    return places.get(path, path.removeprefix("docs/") if path.startswith("docs/") else None)


def target_of(target: str, here: PurePosixPath) -> str:
    """File of the repository that a link on a page leads to; the page of a folder that has one."""
    path = os.path.normpath(here.parent / target) if target else str(here)
    return f"{path}/README.md" if (ROOT / path / "README.md").is_file() else path


def linked_files() -> list[Path]:
    """Files that pages link and that are no pages, which a site without a repository contains itself."""
    pages = [
        *OUTSIDE,
        CONFIGURATION,
        *(f"docs/{p.relative_to(ROOT / 'docs')}" for p in (ROOT / "docs").rglob("*.md")),
    ]
    found = set()
    for page in pages:
        for _, target, _, _ in LINK.findall(FENCE.sub("", (ROOT / page).read_text(encoding="utf-8"))):
            path = target_of(target, PurePosixPath(page))
            shown = path.startswith("docs/") and not path.endswith(".py")
            if "://" not in target and not shown and (ROOT / path).is_file():
                found.add(ROOT / path)
    return sorted(found - {ROOT / page for page in (*pages, *TUTORIALS)})


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links between files of the repository into links of the site, and fill in what is made here."""
    here = PurePosixPath(repository_path(page))
    folder = PurePosixPath(page.file.src_uri).parent
    page.meta.setdefault("search", {})["boost"] = BOOST.get(PurePosixPath(page.file.src_uri).parts[0], 1.0)
    page.meta["tags"] = WORDS.get(page.file.src_uri, [])
    page.edit_url = f"{ADDRESS}/edit/main/{here}" if ADDRESS else None

    def moved(match: re.Match) -> str:
        before, target, anchor, after = match.groups()
        if "://" in target or target.startswith("mailto:"):
            return match.group()
        path = target_of(target, here)
        place = place_of(path, (anchor or "").removeprefix("#"))
        if not target and place == page.file.src_uri:
            return match.group()
        file = files.get_file_from_path(place) if place is not None else None
        if file and file.inclusion.is_included():
            target = os.path.relpath(place, folder)
        elif ADDRESS and (ROOT / path).exists():
            target = f"{ADDRESS}/blob/main/{path}"
        elif (ROOT / path).is_file():
            target = os.path.relpath(f"files/{path}.txt", folder)
        elif (ROOT / path).is_dir():
            target = NOWHERE
        return f"{before}{target}{anchor or ''}{after}"

    parts = FENCE.split(markdown)
    if not page.file.src_uri.startswith(("reference/functions/", "tutorials/examples")):
        parts[::2] = [LINK.sub(moved, part) for part in parts[::2]]
    markdown = re.sub(rf"\[([^][]*)\]\({NOWHERE}\)", r"\1", "".join(parts))
    if page.file.src_uri == "api.md":
        line = "- [`{0}`](reference/functions/{0}.md): {1}"
        markdown = FUNCTION.sub(lambda found: line.format(found[1], first_line(found[1])), markdown)
    markdown = markdown.replace("<!-- thumbnails -->", thumbnails())
    return COMMAND.sub(lambda match: help_of(match.group(1)), markdown)


def thumbnails() -> str:
    """The first figure of every tutorial, as a link to it."""
    text, cards = (ROOT / "docs/tutorials/index.md").read_text(encoding="utf-8"), []
    for path in sorted(TUTORIALS.values(), key=lambda path: text.index(f"({path.name})")):
        title = re.search(r"^# # (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)[1]
        picture = f"![]({path.stem}/thumbnail.png)"
        cards.append(f"[{picture}{title}]({path.stem}.md)")
    return '<div class="thumbnails" markdown>\n\n' + "\n".join(cards) + "\n\n</div>"


def help_of(command: str) -> str:
    """Help of a command of tepsipe, as a block of code."""
    from tepsipe.cli import main

    os.environ["COLUMNS"] = "90"
    printed = io.StringIO()
    with redirect_stdout(printed), suppress(SystemExit):
        main([*([command] if command else []), "--help"])
    return f"```text\n{printed.getvalue()}```"


def on_page_content(html: str, page: Page, config: MkDocsConfig, **_: object) -> str:
    """Link public names, and convert equations to MathML, which browsers typeset without a script."""

    def mathml(match: re.Match) -> str:
        tag, kind, latex = match.groups()
        latex = latex.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
        return (
            f'<{tag} class="equation">{convert(latex, display="inline" if kind == "(" else "block")}</{tag}>'
        )

    def linked(match: re.Match) -> str:
        place = f"reference/functions/{match[1]}.html"
        if match[1] not in functions() or place == page.url:
            return match[0]
        return f'<a href="{os.path.relpath(place, PurePosixPath(page.url).parent)}">{match[0]}</a>'

    if page.file.src_uri in configuration():  # keys break between their words
        html = re.sub(r"(?<=<td><code>)[\w.*]+", lambda key: re.sub(r"([._])", r"\1<wbr>", key[0]), html)
    parts = UNLINKED.split(EQUATION.sub(mathml, html))
    parts[::2] = [CODE_NAME.sub(linked, part) for part in parts[::2]]
    return "".join(parts)


def on_post_build(config: MkDocsConfig) -> None:
    """Without an address of the site there is nothing to list for search engines."""
    if not config.site_url:
        for name in ("sitemap.xml", "sitemap.xml.gz"):
            Path(config.site_dir, name).unlink(missing_ok=True)
