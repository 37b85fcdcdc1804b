"""Hooks of MkDocs: pages from outside docs/, tutorials with outputs, links to the repository, equations."""

import io
import os
import re
import tomllib
from contextlib import redirect_stdout, suppress
from importlib.resources import files as contents
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from nbconvert import MarkdownExporter

ROOT = Path(__file__).resolve().parents[1]
EXECUTED = ROOT / "build/tutorials"
DEMONSTRATION = ROOT / "results/passive-cameras"
ADDRESS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["urls"][
    "Repository"
]
# pages of the project that are pages of the site, too: path in the repository -> path in the site
OUTSIDE = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "config/README.md": "reference/configuration.md",
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
LINK = re.compile(r"(\]\()([^)\s#]*)(#[^)\s]*)?(\))")
FENCE = re.compile(r"(^ *```.*?^ *```|`[^`\n]+`)", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^<!-- tepsipe ?([\w-]*) -->$", re.MULTILINE)
EQUATION = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Take the address of the repository from pyproject.toml, and list all pages of the appendix."""
    config.repo_url, config.repo_name = ADDRESS, "Repository"
    config.nav = [*config.nav, {"Appendix": [{name: pages} for name, pages in APPENDIX.items()]}]
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
        notebook = (EXECUTED / f"{path.stem}.ipynb").read_bytes()
        files.append(File.generated(config, f"{folder}.ipynb", content=notebook))
        title, _, rest = body.strip().partition("\n")
        body = f"{title}\n\n[Download as a notebook]({path.stem}.ipynb)\n{rest}\n"
        files.append(File.generated(config, f"{folder}.md", content=body))
    font = "fonts/STIXTwoMath-Regular.ttf"
    content = (contents("ziamath") / font).read_bytes()
    files.append(File.generated(config, f"assets/{font}", content=content))
    for path in shown_results():
        place = f"demonstration/{path.relative_to(DEMONSTRATION).as_posix()}"
        files.append(File.generated(config, place, abs_src_path=str(path)))
    return files


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
    place = page.file.src_uri
    return generated.get(place, f"docs/{place}")


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links between files of the repository into links of the site, and write the help of commands."""
    here = PurePosixPath(repository_path(page)).parent
    places = OUTSIDE | {source: f"tutorials/{path.stem}.md" for source, path in TUTORIALS.items()}
    folder = PurePosixPath(page.file.src_uri).parent
    page.meta.setdefault("search", {})["boost"] = BOOST.get(PurePosixPath(page.file.src_uri).parts[0], 1.0)
    page.edit_url = f"{ADDRESS}/edit/main/{repository_path(page)}"

    def moved(match: re.Match) -> str:
        before, target, anchor, after = match.groups()
        if not target or "://" in target or target.startswith("mailto:"):
            return match.group()
        path = os.path.normpath(here / target)
        if (ROOT / path).is_dir() and (ROOT / path / "README.md").is_file():
            path = f"{path}/README.md"
        place = places.get(path, path.removeprefix("docs/") if path.startswith("docs/") else None)
        file = files.get_file_from_path(place) if place is not None else None
        if file and file.inclusion.is_included():
            target = os.path.relpath(place, folder)
        elif (ROOT / path).exists():
            target = f"{ADDRESS}/blob/main/{path}"
        return f"{before}{target}{anchor or ''}{after}"

    parts = FENCE.split(markdown)
    parts[::2] = [LINK.sub(moved, part) for part in parts[::2]]
    return COMMAND.sub(lambda match: help_of(match.group(1)), "".join(parts))


def help_of(command: str) -> str:
    """Help of a command of tepsipe, as a block of code."""
    from tepsipe.cli import main

    os.environ["COLUMNS"] = "90"
    printed = io.StringIO()
    with redirect_stdout(printed), suppress(SystemExit):
        main([*([command] if command else []), "--help"])
    return f"```text\n{printed.getvalue()}```"


def on_page_content(html: str, **_: object) -> str:
    """Convert equations to MathML, which browsers typeset without a script."""

    def mathml(match: re.Match) -> str:
        tag, kind, latex = match.groups()
        latex = latex.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
        return (
            f'<{tag} class="equation">{convert(latex, display="inline" if kind == "(" else "block")}</{tag}>'
        )

    return EQUATION.sub(mathml, html)
