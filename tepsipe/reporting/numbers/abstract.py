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
    for experiment, sentences in (
        ("dummy", _dummy),
        ("standing", _standing),
        ("position_manipulator", _position_manipulator),
        ("platform", _platform),
    ):
        if experiment in data["experiments"]:
            parts[experiment] = sentences(data)
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


def _dummy(data: dict) -> list[Paragraph]:
    d, reported = data["dummy"], data["reported"]
    found = pieces(
        "On the instrumented treadmill, the printed equation of motion of the leg yields $I$ = "
        "{printed_mean_inertia} N·m·s²/rad and $K$ = {printed_mean_stiffness} N·m/rad, with a VAF of up "
        "to {vaf_printed_largest} % in the fitted windows. ",
        **d,
    )
    if reported is not None:
        found += pieces(
            "The thesis reports {inertia} N·m·s²/rad and {stiffness} N·m/rad and calls its parameters “not "
            "physically meaningful”. ",
            **reported,
        )
    if d["signs_explain"]:
        found += pieces(
            "The signs explain the difference without any effect of the treadmill: the printed signs add "
            '$2 I_"leg"$ = {two_leg_inertia} N·m·s²/rad to the inertia and subtract $2 m g r$ = {two_mgr} '
            "N·m/rad from the stiffness. ",
            **d,
        )
    found += pieces(
        "VAF cannot reveal a wrong sign, because with one degree of freedom _any_ linear combination of "
        "acceleration, velocity and angle can be fitted. The same free body with consistent signs yields $I$ "
        "= {recommended_mean_inertia} N·m·s²/rad and $K$ = {recommended_mean_stiffness} N·m/rad from the "
        "same recordings{amplitudes}.",
        amplitudes=_amplitudes(d["clear_from"]),
        **d,
    )
    if d["recovery"] is None:
        return [found]
    return [
        found,
        pieces(
            "Over the {count} conditions with belt velocities{amplitudes}, the largest error of the "
            "consistent equation relative to {truth} is {worst_stiffness} % in $K$ and {worst_damping} % "
            "in $B$.",
            amplitudes=_amplitudes(d["clear_from"], " of"),
            **(d["recovery"] | {"truth": _truth(d["recovery"])}),
        ),
        *(_thesis_dummy(data["thesis_dummy"]) if "thesis_dummy" in data else ()),
    ]


def _truth(recovery: dict) -> str:
    """What the estimates of single trials are compared with (no unit)."""
    if recovery["at_work"]:
        return "the linear joint nearest to the laboratory’s non-linear joint in the same movements"
    return "the laboratory’s constants"


def _thesis_dummy(found: dict) -> list[Paragraph]:
    return [
        pieces(
            "One rubber joint that softens, with {n} constants fitted to the sinusoidal half of the printed "
            "tables, returns {fitted_within} of the {fitted} fitted numbers and {predicted_within} of the "
            "{predicted} other numbers of Tables 4-2 and 4-3 within their tolerances ([@thesis-dummy]).",
            **found,
        )
    ]


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


def _position_manipulator(data: dict) -> list[Paragraph]:
    return [pieces(template, **values) for template, values in data["position_manipulator"]["abstract"]]


def _platform(data: dict) -> list[Paragraph]:
    a = data["platform"]
    found = []
    for trial in a["trials"]:
        static = [row for row in trial["rows"] if row["kind"] == "K_mode" and row["interval"]]
        known = "; ".join(f"{row['joints']} {row['value']} ({row['interval']}) N·m/rad" for row in static)
        found += pieces(
            "{start}Of the {quantities} quantities of the model {chosen}, the {simplest} that {accepted}, "
            "the trial {condition} of a person on a moving platform identifies {identified} "
            "([@platform]).{mode}",
            start=" " if found else "",
            simplest="freest" if trial["rejected"] else "simplest",
            accepted="leaves least torque coherent with the platform"
            if trial["rejected"]
            else "leaves no torque coherent with the platform",
            mode=f" Static stiffness along the slow mode: {known}."
            if known and not trial["rejected"]
            else "",
            **{key: trial[key] for key in ("quantities", "chosen", "condition", "identified")},
        )
    return [found]
