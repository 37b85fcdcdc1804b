"""Ten lines for the reader in a hurry: what the thesis found, why, what to do instead, how sure."""

import pandas as pd

from tepsipe.reporting.numbers.abstract import Paragraph, pieces


def covered_of_recommended(estimates: pd.DataFrame, recovery: pd.DataFrame | None) -> dict | None:
    """How many recommended estimates (values in their units) hold the truth in their 95 % interval.

    Returns
    -------
    dict or None
        ``total``, ``covered``, ``flagged`` and ``missed`` (neither), as text; None without a truth.
    """
    if recovery is None:
        return None
    keys = ["experiment", "condition", "pathway", "estimator", "quantity"]
    quoted = estimates[estimates.recommended.astype(str).str.lower() == "true"]
    both = quoted.merge(recovery[[*keys, "covered"]], on=keys, how="inner")
    if not len(both):
        return None
    covered = both.covered.astype(str).str.lower() == "true"
    flagged = both["flags"].fillna("") != ""
    counts = {
        "total": len(both),
        "covered": covered.sum(),
        "flagged": flagged.sum(),
        "missed": (~covered & ~flagged).sum(),
    }
    return {name: str(int(count)) for name, count in counts.items()}


def summary_of(data: dict) -> list[Paragraph]:
    """The summary of a reproduction of the thesis (units in it); empty for other studies.

    Parameters
    ----------
    data : dict
        Data of the report: ``dummy``, ``reported``, ``standing``, ``recommended_coverage``, texts.

    Returns
    -------
    list of paragraphs
        Pieces of text, see `tepsipe.reporting.numbers.abstract`.
    """
    if data["reported"] is None or "dummy" not in data["experiments"]:
        return []
    return [_found(data), *_why(data["dummy"]), _instead(data), *_person(data), *_how_sure(data)]


def _found(data: dict) -> Paragraph:
    return pieces(
        "*What the thesis found.* Short jerks of a treadmill belt gave $I$ = {inertia} N·m·s²/rad and $K$ "
        "= {stiffness} N·m/rad for a rubber joint with a $K$ of {start_stiffness} N·m/rad in a conventional "
        "manipulator. The fits explained {vaf_trial} % of the variance, but the parameters were not "
        "physical.",
        **data["reported"],
    )


def _why(d: dict) -> list[Paragraph]:
    if not d["signs_explain"]:
        return []
    return [
        pieces(
            "*Why.* Two terms of its equation of motion belong to different directions of the angle. This "
            'adds $2 I_"leg"$ = {two_leg_inertia} N·m·s²/rad to $I$ and takes $2 m g r$ = {two_mgr} N·m/rad '
            "from $K$, and the VAF cannot show it ([@not-physical]).",
            **d,
        )
    ]


def _instead(data: dict) -> Paragraph:
    d = data["dummy"]
    text = (
        "*What to do instead.* Use the same free body with consistent signs and markers at one instant: "
        "$K$ = {recommended_mean_stiffness} N·m/rad{amplitudes}. "
    )
    amplitudes = "" if d["clear_from"] == "–" else f" at {d['clear_from']} m/s and above"
    found = pieces(text, amplitudes=amplitudes, **d)
    joint = d.get("joint_likelihood")
    if joint is not None:
        found += pieces(
            "Better, fit the leg, the foot and the drive together ([@joint-likelihood]): $K$ = {stiffness} "
            "N·m/rad over all conditions.",
            **joint,
        )
    return found


def _person(data: dict) -> list[Paragraph]:
    p = data.get("standing")
    if p is None or p.get("participants") is not None:
        return []
    wanted = p["recommended"]["estimator"]
    rows = [row for row in p["estimators"] if row["name"] == wanted]
    if not rows:
        return []
    values = ", ".join(f"{row['stiffness']} N·m/rad ({row['task']})" for row in rows)
    return [
        pieces(
            "*On a person* the method needs the force plate and a model of the treadmill; the intrinsic "
            "stiffness of both ankles is then {values} ([@standing]).",
            values=values,
        )
    ]


def _how_sure(data: dict) -> list[Paragraph]:
    counts = data.get("recommended_coverage")
    if counts is None:
        return []
    return [
        pieces(
            "*How sure.* The raw files are simulated, so the truth is known: {covered} of {total} "
            "recommended estimates hold it in their 95 % interval; {flagged} carry a warning, and {missed} "
            "miss it without one ([@truth]).",
            **counts,
        )
    ]
