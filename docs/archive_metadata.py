"""Write codemeta.json, .zenodo.json and the entries of docs/citing.md from CITATION.cff and pyproject.toml.

python docs/archive_metadata.py
"""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[1]


def citation() -> dict[str, Any]:
    """Contents of CITATION.cff."""
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def project() -> dict[str, Any]:
    """Section project of pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def codemeta() -> dict[str, Any]:
    """CodeMeta 3.0 description of the software."""
    cited, built = citation(), project()
    urls = built.get("urls", {})
    return {
        "@context": "https://w3id.org/codemeta/3.0",
        "@type": "SoftwareSourceCode",
        "name": built["name"],
        "description": " ".join(cited["abstract"].split()),
        "version": cited["version"],
        "license": f"https://spdx.org/licenses/{cited['license']}",
        "author": [_person(author) for author in cited["authors"]],
        "keywords": cited["keywords"],
        "programmingLanguage": "Python",
        "runtimePlatform": f"Python {built['requires-python']}",
        "softwareRequirements": built["dependencies"],
        "readme": "README.md",
    } | {
        name: urls[url]
        for name, url in (("codeRepository", "Repository"), ("issueTracker", "Issues"))
        if url in urls
    }


def zenodo() -> dict[str, Any]:
    """Metadata of the deposit on Zenodo."""
    cited = citation()
    return {
        "title": cited["title"],
        "upload_type": "software",
        "description": " ".join(cited["abstract"].split()),
        "version": cited["version"],
        "license": cited["license"],
        "creators": [_creator(author) for author in cited["authors"]],
        "keywords": cited["keywords"],
    }


def _person(author: dict[str, str]) -> dict[str, str]:
    if "name" in author:  # an entity, as the anonymous authors are
        return {"@type": "Organization", "name": author["name"]}
    person = {"@type": "Person", "givenName": author["given-names"], "familyName": author["family-names"]}
    return person | ({"@id": author["orcid"]} if "orcid" in author else {})


def _creator(author: dict[str, str]) -> dict[str, str]:
    if "name" in author:
        return {"name": author["name"]}
    creator = {"name": f"{author['family-names']}, {author['given-names']}"}
    return creator | ({"orcid": author["orcid"].rpartition("/")[2]} if "orcid" in author else {})


def bibtex() -> str:
    """Entries of the software and of the thesis for BibTeX."""
    cited = citation()
    (thesis,) = cited["references"]
    software = {"author": _authors(cited["authors"]), "title": f"{{{cited['title']}}}"}
    software |= {"version": cited["version"], "license": cited["license"]}
    software |= {key: str(cited[name]) for key, name in (("doi", "doi"), ("url", "url")) if name in cited}
    if "date-released" in cited:
        software["year"] = str(cited["date-released"])[:4]
    title = {"author": _authors(thesis["authors"]), "title": f"{{{thesis['title']}}}"}
    title |= {"type": thesis["thesis-type"], "note": thesis["notes"]}
    return "\n".join((_entry("software", "tepsipe", software), _entry("thesis", "tepsipe-thesis", title)))


def _authors(authors: list[dict[str, str]]) -> str:
    # braces keep a name of several words from being taken apart
    names = [
        f"{{{a['name']}}}" if "name" in a else f"{a['family-names']}, {a['given-names']}" for a in authors
    ]
    return " and ".join(names)


def _entry(kind: str, key: str, fields: dict[str, str]) -> str:
    lines = "".join(f"  {name} = {{{value}}},\n" for name, value in fields.items())
    return f"@{kind}{{{key},\n{lines}}}\n"


def texts() -> dict[str, str]:
    """Name of each file and its content."""
    made = {"codemeta.json": codemeta(), ".zenodo.json": zenodo()}
    found = {name: json.dumps(content, indent=2, ensure_ascii=False) + "\n" for name, content in made.items()}
    page = (ROOT / "docs/citing.md").read_text(encoding="utf-8")
    block = f"```bibtex\n{bibtex()}```"
    return found | {"docs/citing.md": re.sub(r"```bibtex\n.*?```", lambda _: block, page, flags=re.DOTALL)}


if __name__ == "__main__":
    for name, text in texts().items():
        (ROOT / name).write_text(text, encoding="utf-8")
