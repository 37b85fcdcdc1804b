"""Numbers of the joint likelihood of the ankle dummy."""

import pandas as pd

from tepsipe.reporting.numbers.format import number, percent, span


def joint_likelihood_data(pathway: str, own: pd.DataFrame, recovery: pd.DataFrame | None) -> dict:
    """Numbers of the joint likelihood as text.

    Parameters
    ----------
    pathway : str
        Its name.
    own : DataFrame
        Estimates of the dummy (units in the column ``unit``).
    recovery : DataFrame or None
        Estimates beside the truth, where there is one.

    Returns
    -------
    dict
        Text, counts as text, and for each flag its name and conditions.
    """
    rows = own[own.pathway == pathway]
    by = dict(list(rows.groupby("quantity")))
    softened = by.get("K_softened")
    stiffness = by["K"]
    flags: dict[str, list[str]] = {}
    for condition, names in zip(stiffness.condition, stiffness["flags"].fillna("").astype(str), strict=True):
        for name in filter(None, names.split(";")):
            flags.setdefault(name, []).append(condition)
    data = {
        "pathway": pathway,
        "stiffness": span(stiffness.value),
        "damping": span(by["B"].value),
        "small_stiffness": span(by["K_small"].value, 4),
        "small_damping": span(by["B_small"].value),
        "error_stiffness": span(stiffness.u_type_a, 1),
        "softens": "0" if softened is None else str(int((softened.ci_low > 0.0).sum())),
        "total": str(len(stiffness)),
        "delay_ms": number(1e3 * float(by["delay"].value.abs().max()), 1),
        "flags": [{"name": name, "conditions": ", ".join(where)} for name, where in flags.items()],
        "recovery": None,
    }
    if recovery is not None:
        known = recovery[(recovery.experiment == "dummy") & (recovery.pathway == pathway)]
        known = known[known.quantity.isin(["I", "B", "K"])]
        if len(known):
            each = known.groupby("quantity")
            covered = known.covered.astype(str).str.lower() == "true"
            data["recovery"] = {
                "worst_stiffness": percent(100.0 * each.get_group("K").relative_error.abs().max()),
                "worst_damping": percent(100.0 * each.get_group("B").relative_error.abs().max()),
                "covered": str(int(covered.sum())),
                "total": str(len(known)),
            }
    return data
