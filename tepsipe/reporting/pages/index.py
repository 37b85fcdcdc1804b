"""The index of a run for a browser: findings, figures, tables, pages of the trials, provenance.

Its sentences are those of the PDF's first page. All links are relative, so that the folder can be moved.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from urllib.parse import quote

from tepsipe.reporting.pages.header import TITLES
from tepsipe.reporting.pages.html import document, table, text


@dataclass(frozen=True)
class Listing:
    """Files of a run (names, no unit), as seen from the folder of the index.

    Attributes
    ----------
    pdf : str
        Name of the report's PDF.
    figures : mapping
        Category -> name of a figure -> its caption.
    tables : mapping
        Name of a table -> its caption.
    trials : mapping
        Experiment -> its conditions.
    activity : sequence of str
        Conditions of the standing person with figures of their own.
    """

    pdf: str
    figures: Mapping[str, Mapping[str, str]]
    tables: Mapping[str, str]
    trials: Mapping[str, Sequence[str]]
    activity: Sequence[str] = field(default_factory=tuple)


def render_index(title: str, parts: Mapping[str, str], listing: Listing) -> str:
    """The index as one file of HTML.

    Parameters
    ----------
    title : str
        Title of the study.
    parts : mapping of str to str
        HTML of ``source``, ``findings`` and ``provenance``, typeset with the report.
    listing : Listing
        Files of the run.

    Returns
    -------
    str
        The page; its links are relative.
    """
    sections = {
        "findings": ("Findings", parts["findings"]),
        "trials": ("Trials", _trials(listing)),
        "figures": ("Figures", _figures(listing.figures)),
        "tables": ("Tables", _tables(listing.tables)),
        "provenance": ("Provenance", parts["provenance"]),
    }
    contents = " ".join(f'<a href="#{key}">{name}</a>' for key, (name, _) in sections.items())
    body = "".join(
        f'<section id="{key}">\n<h2>{name}</h2>\n{content.strip()}\n</section>\n'
        for key, (name, content) in sections.items()
    )
    pdf = _link(listing.pdf, "Report as PDF")
    return document(
        title,
        f"<header>\n<h1>{text(title)}</h1>\n"
        f'<nav class="contents" aria-label="Contents"><b>{pdf}</b> {contents}</nav>\n</header>\n'
        f'<main>\n<div class="source">{parts["source"]}</div>\n{body}</main>\n',
        policy=None,
    )


def _link(path: str, words: str) -> str:
    """A link to a file that is named relative to the index; ``words`` is plain text."""
    # "./" so that a colon in the first part is not read as a scheme
    return f'<a href="{text("./" + quote(path))}">{text(words)}</a>'


def _trials(listing: Listing) -> str:
    """Links to the page of every trial, experiment by experiment."""
    parts = ["<p>Each page shows the signals of one trial, to zoom into, with its estimates.</p>\n"]
    for experiment, conditions in listing.trials.items():
        items = []
        for condition in conditions:
            item = _link(f"trials/{experiment}/{condition}.html", condition)
            if experiment == "standing" and condition in listing.activity:
                own = (
                    _link(f"../figures/standing/{condition}_{number}.png", number.replace("_", "-"))
                    for number in ("4_13", "4_14")
                )
                item += f' <span class="small">{", ".join(own)}</span>'
            items.append(f"<li>{item}</li>\n")
        title = TITLES.get(experiment, experiment)
        parts.append(f'<h3>{text(title)}</h3>\n<ul class="columns">\n{"".join(items)}</ul>\n')
    return "".join(parts)


def _figures(figures: Mapping[str, Mapping[str, str]]) -> str:
    parts = []
    for category, named in figures.items():
        parts.append(f'<h3>{text(category)}</h3>\n<div class="gallery">\n')
        for name, caption in named.items():
            label = name.removeprefix("figure_").replace("_", "-")
            source = text("./" + quote(f"../figures/{name}.svg"))
            alternative = text(caption.replace("``", ""))
            image = f'<img src="{source}" alt="{alternative}" loading="lazy">'
            parts.append(
                f'<figure id="{text(name)}"><a href="{source}">{image}</a>\n'
                f"<figcaption><b>Figure {text(label)}.</b> {_caption(caption)} "
                f"({_link(f'../figures/{name}.png', 'PNG')})</figcaption></figure>\n"
            )
        parts.append("</div>\n")
    return "".join(parts)


def _caption(caption: str) -> str:
    """A caption, plain text with literals in double backquotes, as HTML."""
    return re.sub("``([^`]+)``", r"<code>\1</code>", text(caption))


def _tables(tables: Mapping[str, str]) -> str:
    rows = [
        [_link(f"../tables/{name}.csv", f"{name}.csv"), _caption(caption)] for name, caption in tables.items()
    ]
    return table(("Table", "Content"), rows)
