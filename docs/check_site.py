"""Check the built site: every link leads to a page and a heading of it, and nothing is loaded from a network.

python docs/check_site.py [FOLDER]
"""

import re
import sys
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

SITE = Path(__file__).resolve().parents[1] / "site"
# attributes from which a browser loads something by itself, and those that a reader follows
LOADS = {("script", "src"), ("img", "src"), ("iframe", "src"), ("source", "src"), ("video", "src")}
FOLLOWS = {("a", "href"), ("link", "href")}
LOADING_LINKS = {"stylesheet", "preload", "preconnect", "icon", "modulepreload"}


class Page(HTMLParser):
    """Links and anchors of an HTML page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.targets: list[tuple[str, bool]] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect what a start tag loads, follows and names."""
        found = {name: value or "" for name, value in attrs}
        self.anchors |= {found[name] for name in ("id", "name") if name in found}
        loads = tag == "link" and bool(LOADING_LINKS & set(found.get("rel", "").split()))
        for name, value in found.items():
            if (tag, name) in LOADS or (tag, name) in FOLLOWS:
                self.targets.append((value, loads or (tag, name) in LOADS))


@cache
def page(path: Path) -> Page:
    """Parsed page, once."""
    return Page(path)


def has_anchor(path: Path, anchor: str) -> bool:
    """Return whether a page has this anchor; those of trials keep the shown part of the signals in it."""
    return anchor in page(path).anchors or anchor.startswith("__") or "demonstration" in path.parts


def faults(site: Path) -> list[str]:
    """Return one sentence per broken link and per file that would be loaded from a network."""
    found = []
    for path in sorted(site.rglob("*.html")):
        here = path.relative_to(site)
        if path.name == "404.html":  # its links are those of the root of a server
            continue
        for target, loads in page(path).targets:
            address, anchor = urldefrag(target)
            if re.match(r"(?:[a-z]+:)?//", address):
                found += [f"{here} loads {target} from a network"] if loads else []
                continue
            if re.match(r"(data|mailto|javascript):", address):
                continue
            there = (path.parent / unquote(address.partition("?")[0])).resolve() if address else path
            if there.is_dir():
                there = there / "index.html"
            if not there.is_file():
                found.append(f"{here} links {target}, which is not there")
            elif anchor and there.suffix == ".html" and not has_anchor(there, unquote(anchor)):
                found.append(f"{here} links {target}, which has no such heading")
    for path in sorted(site.rglob("*.css")):
        for target in re.findall(r"url\(['\"]?(https?:[^'\")]+)", path.read_text(encoding="utf-8")):
            found.append(f"{path.relative_to(site)} loads {target} from a network")
    return found


if __name__ == "__main__":
    site = Path(sys.argv[1]) if len(sys.argv) > 1 else SITE
    found = faults(site)
    print(*found, sep="\n", end="\n" if found else "")
    print(f"{len(list(site.rglob('*.html')))} pages, {len(found)} faults")
    sys.exit(bool(found))
