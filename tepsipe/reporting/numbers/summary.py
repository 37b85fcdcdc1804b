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
        "*What the thesis found.* Perturbed by short velocity pulses of a treadmill belt, the rubber joint "
        "of an ankle dummy showed $I$ = {inertia} N·m·s²/rad and $K$ = {stiffness} N·m/rad. "
        "In a conventional manipulator the same joint had a $K$ of about {start_stiffness} N·m/rad. "
        "The fits explained {vaf_trial} % of the "
        "variance (VAF), but the thesis called the parameters “not physically meaningful”.",
        **data["reported"],
    )


def _why(d: dict) -> list[Paragraph]:
    if not d["signs_explain"]:
        return []
    return [
        pieces(
            "*Why.* The equation of motion in the thesis mixes two sign conventions of the angle. This adds "
            'twice the inertia of the leg, $2 I_"leg"$ = {two_leg_inertia} N·m·s²/rad, to $I$ and subtracts '
            "twice its gravitational stiffness, $2 m g r$ = {two_mgr} N·m/rad, from $K$. The VAF cannot "
            "show it ([@not-physical], [@vaf-blind]).",
            **d,
        )
    ]


def _instead(data: dict) -> Paragraph:
    d = data["dummy"]
    text = (
        "*What to do instead.* Use the same free body with consistent signs, and markers interpolated to "
        "one instant: the mean $K${amplitudes} is then {recommended_mean_stiffness} N·m/rad. "
    )
    amplitudes = "" if d["clear_from"] == "–" else f" at {d['clear_from']} m/s and above"
    found = pieces(text, amplitudes=amplitudes, **d)
    joint = d.get("joint_likelihood")
    if joint is not None:
        found += pieces(
            "Better, fit the motion of the leg, the foot and the belt drive together ([@joint-likelihood]): "
            "$K$ = {stiffness} N·m/rad over all conditions{error}.",
            error=""
            if joint.get("recovery") is None
            else f", at most {joint['recovery']['worst_stiffness']} % from the truth",
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
            "*How sure.* The raw files are simulated, so the truth is known: the 95 % intervals of {covered} "
            "of {total} recommended estimates contain it. Checks warn of {flagged} of them, and {missed} "
            "miss the truth without a warning ([@truth]).",
            **{name: "none" if count == "0" else count for name, count in counts.items()},
        )
    ]
