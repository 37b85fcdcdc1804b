"""First page of the report: where the raw files come from, and the findings of the run, as sentences.

The PDF and the index for a browser print the same sentences. A sentence is a list of pieces [kind, text]:
text, emph, strong, math (as Typst writes it) and ref (a section of the PDF).
"""

import re

MARKUP = re.compile(
    r"\$(?P<math>[^$]+)\$|(?<!\w)_(?P<emph>[^_]+)_(?!\w)|\*(?P<strong>[^*]+)\*"
    r"|\[@(?P<ref>[\w-]+)\]"
)

Piece = list[str]
Paragraph = list[Piece]


def pieces(template: str, **values: object) -> Paragraph:
    """A sentence as pieces (units in it).

    Parameters
    ----------
    template : str
        Text with ``$math$``, ``_emphasis_``, ``*strong*``, ``[@section]`` and names of
        values in braces.
    **values : object
        Their texts, in which nothing is markup.

    Returns
    -------
    list of [str, str]
        Kind and text of every piece.
    """
    found, at = [], 0
    for match in MARKUP.finditer(template):
        if match.start() > at:
            found.append(["text", template[at : match.start()].format(**values)])
        text = match[match.lastgroup]
        found.append([match.lastgroup, text if match.lastgroup == "math" else text.format(**values)])
        at = match.end()
    if at < len(template):
        found.append(["text", template[at:].format(**values)])
    return found


def abstract_of(data: dict) -> dict[str, list[Paragraph]]:
    """Findings of the run by experiment or part (units in them), from the data of the report."""
    parts: dict[str, list[Paragraph]] = {}
    if data["claims"] is not None:
        parts["claims"] = [
            pieces(
                "Of the {total} claims of the thesis, {reproduced} are reproduced, {fitted} fitted (their "
                "numbers were used to choose constants of the virtual laboratory), {predicted} predicted by "
                "these constants, {explained} explained by a number, and {not_reproduced} not reproduced"
                "{pending} ([@claims]).",
                pending=""
                if data["claims"]["not_computed"] == "0"
                else f"; {data['claims']['not_computed']} were not computed",
                **data["claims"],
            )
        ]
    if data["cells"] is not None:
        parts["cells"] = [
            pieces(
                "Of the {total} printed cells of Tables 4-1 to 4-4, {within} lie within their tolerance or "
                "are explained by a number: {reproduced} reproduced, {fitted} fitted, {predicted} predicted, "
                "{explained} explained ([@cells]).",
                **data["cells"],
            )
        ]
    return parts


def warnings_of(data: dict) -> list[Paragraph]:
    """Recommended estimates (no unit) that failed a check: which, and what to look at.

    Parameters
    ----------
    data : dict
        Data of the report, of which ``flags`` is used.

    Returns
    -------
    list of paragraphs
        One, or none where no check failed.
    """
    quoted = data.get("flags", {}).get("recommended")
    if not quoted or not quoted["kinds"]:
        return []
    found = pieces(
        "*Look at these first.* {count} of the {total} recommended estimates failed a check.",
        count=quoted["count"],
        total=quoted["total"],
    )
    for kind in quoted["kinds"]:
        found += pieces(" _{where}_: {meaning}.", where=kind["where"], meaning=kind["meaning"])
    return [found]
