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
    """End of the summary of a reproduction of the thesis (units in it); empty for other studies.

    Parameters
    ----------
    data : dict
        Data of the report: ``reported``, ``recommended_coverage``, texts.

    Returns
    -------
    list of paragraphs
        Pieces of text, see `tepsipe.reporting.numbers.abstract`.
    """
    if data["reported"] is None or "dummy" not in data["experiments"]:
        return []
    return _how_sure(data)


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
