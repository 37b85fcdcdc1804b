"""Check the built site: links, files loaded from a network, addresses, and the search.

Every link leads to a page and a heading of it. Nothing is loaded from a network. No address is a placeholder,
and the map of the site lists pages of it. The search finds the right page for words that readers use.

python docs/check_site.py [FOLDER]
"""

import json
import re
import sys
from collections.abc import Callable
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

from lunr.builder import Builder
from lunr.stop_word_filter import stop_word_filter

SITE = Path(__file__).resolve().parents[1] / "site"
# attributes from which a browser loads something by itself, and those that a reader follows
LOADS = {("script", "src"), ("img", "src"), ("iframe", "src"), ("source", "src"), ("video", "src")}
FOLLOWS = {("a", "href"), ("link", "href")}
PLACEHOLDER = re.compile(r"(?:[a-z]+:)?//(?:[^/]*\.)?(?:invalid|example|test|example\.\w+)(?:/|$)")
LOADING_LINKS = {"stylesheet", "preload", "preconnect", "icon", "modulepreload"}
# words of readers, and a page that must be among the first results
SEARCHED = {
    "C3D": "recordings/c3d.html",
    "Vicon": "recordings/c3d.html",
    "Qualisys": "recordings/c3d.html",
    "D-Flow": "recordings/dflow.html",
    "MATLAB": "exports.html",
    "EMG": "recordings/emg.html",
    "conda": "elsewhere.html",
    "install": "elsewhere.html",
    "Windows": "elsewhere.html",
    "cluster": "cluster.html",
    "degrees": "when-it-stops.html",
    "sign of torque": "when-it-stops.html",
    "late torque": "checks.html",
    "filter": "planning.html",
    "gaps": "when-it-stops.html",
    "stiffness of a person": "recordings/standing.html",
    "damping": "reference/functions/fit_impedance.html",
    "interval": "uncertainty.html",
    "uncertainty": "uncertainty.html",
    "recommended": "uncertainty.html",
    "flag": "files.html",
    "treadmill force": "recordings/weight-and-empty.html",
    "how to cite": "citing.html",
    "benchmark": "benchmark.html",
    "guideline": "guideline.html",
}
FIRST = 3  # results that a reader sees at once


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
                found += [f"{here} links the placeholder {target}"] if PLACEHOLDER.match(address) else []
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
    return found + unlisted(site) + not_found(site)


def unlisted(site: Path) -> list[str]:
    """One sentence per address in the map of the site that is none of its pages; of an empty map another."""
    file = site / "sitemap.xml"
    if not file.is_file():  # of a site without an address
        return []
    places = re.findall(r"<loc>(?:https?:)?//[^/]+/([^<]*)</loc>", file.read_text(encoding="utf-8"))
    pages = {path.relative_to(site).as_posix() for path in site.rglob("*.html")}
    wrong = [place for place in places if not any(f"/{place}".endswith(f"/{page}") for page in pages)]
    found = [f"sitemap.xml lists {place}, which is not there" for place in wrong if not place.endswith("/")]
    return found if places else ["sitemap.xml lists no page"]


def not_found(site: Path) -> list[str]:
    """One sentence per word for which the search does not find the right page among its first results."""
    search = Search(json.loads((site / "search/search_index.json").read_text(encoding="utf-8")))
    found = []
    for words, page in SEARCHED.items():
        pages = search.pages(words)[:FIRST]
        if page not in pages:
            found.append(f"search for {words!r} finds {', '.join(pages) or 'nothing'}, not {page}")
    return found


class Search:
    """The search of the theme, as its script makes it from the same index with lunr."""

    def __init__(self, content: dict) -> None:
        self.separator = re.compile(content["config"]["separator"])
        builder = Builder()
        builder.b(0)  # long pages count as much as short ones
        builder.pipeline.add(stop_word_filter)
        builder.ref("location")
        for name, options in content["config"]["fields"].items():
            builder.field(name, boost=options["boost"], extractor=self._text_of(name))
        for document in content["docs"]:
            builder.add(document, {"boost": document.get("boost", 1.0)})
        self.index = builder.build()

    def _text_of(self, name: str) -> Callable[[dict], str]:
        def text(document: dict) -> str:
            field = document.get(name, "")
            field = re.sub("<[^>]*>", " ", " ".join(field) if isinstance(field, list) else field)
            return self.separator.sub(" ", field)

        return text

    def pages(self, words: str) -> list[str]:
        """Pages in the order in which the search lists them."""
        terms = self.separator.split(words.lower())
        scored = []
        for result in self.index.search(" ".join(f"{term}*" for term in terms)):
            known = {term: any(w.startswith(term) for w in result["match_data"].metadata) for term in terms}
            known = {term: is_met for term, is_met in known.items() if is_met or stop_word_filter(term)}
            page, _, heading = result["ref"].partition("#")
            whole = (not heading) + sum(known.values()) / len(known)
            scored.append((result["score"] * (1.0 + whole**2), page))
        return list(dict.fromkeys(page for _, page in sorted(scored, key=lambda found: -found[0])))


if __name__ == "__main__":
    site = Path(sys.argv[1]) if len(sys.argv) > 1 else SITE
    found = faults(site)
    print(*found, sep="\n", end="\n" if found else "")
    print(f"{len(list(site.rglob('*.html')))} pages, {len(found)} faults")
    sys.exit(bool(found))
