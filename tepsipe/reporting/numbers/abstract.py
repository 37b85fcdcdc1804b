"""First page of the report: where the raw files come from, and the findings of the run, as sentences.

The PDF and the index for a browser print the same sentences. A sentence is a list of pieces [kind, text]:
text, emph, strong, math (as Typst writes it) and ref (a section of the PDF).
"""

import re

from tepsipe.reporting.numbers.format import number

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
    for experiment, sentences in (("standing", _standing),):
        if experiment in data["experiments"]:
            parts[experiment] = sentences(data)
    return parts


def _amplitudes(clear_from: str, word: str = " at") -> str:
    """The belt velocities (m/s) of which a sentence tells; nothing where the sheet has no amplitudes."""
    return "" if clear_from == number(None) else f"{word} {clear_from} m/s and above"


def _standing(data: dict) -> list[Paragraph]:
    p = data["standing"]
    found = pieces(
        "{which} with a person standing on the treadmill were usable.",
        which=f"All {p['trials']} trials"
        if p["stood"] == p["trials"] != "1"
        else f"{p['stood']} of {p['trials']} trials",
    )
    wanted = p["recommended"]["estimator"]
    # of several people the means tell more
    for task in p["tasks"] if p.get("participants") is None else ():
        rows = [r for r in p["estimators"] if r["task"] == task and r["name"] == wanted]
        if rows:
            found += pieces(
                " With the instruction _{task}_ the intrinsic stiffness of both ankles is {stiffness} "
                "N·m/rad, {over_mgh} times the critical (gravitational) stiffness $m g h$.",
                **{**rows[0], "task": task},
            )
    if p["recovery"] is not None:
        found += pieces(
            " Compared with the truth, the largest error is {stiffness} % in stiffness{of_latency}.",
            stiffness=p["recovery"]["stiffness"],
            of_latency=""
            if p["recovery"]["latency"] == number(None)
            else f" and {p['recovery']['latency']} ms in the latency of a muscle",
        )
    return [found]
