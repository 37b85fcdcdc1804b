"""Numbers and sentences of the report on several joints."""

import math

import pandas as pd

from tepsipe.experiments.planning.several_joints import UNKNOWN, WITHIN
from tepsipe.reporting.numbers.format import SUPERSCRIPTS, number, percent, span


def joints_data(sets: pd.DataFrame, elements: pd.DataFrame, models: pd.DataFrame, settings: dict) -> dict:
    """What the report reads on several joints.

    Parameters
    ----------
    sets, elements, models : DataFrame
        Tables of the sets of perturbations, of the elements of K and B, and of models and windows (units in
        their columns).
    settings : dict
        Section plan.several_joints of the configuration.

    Returns
    -------
    dict
        Texts and cells (units in the report).
    """
    window = settings["protocol"]["after_s"]
    return {
        "findings": [
            *_of_numbers(sets),
            *_of_persons(sets),
            *_of_belt(sets),
            *_of_models(models, window),
            *_of_windows(models, window),
            *_of_inertia(elements, settings["inertia_percent"]),
        ],
        "sets": [_set_cells(row) for row in sets.itertuples()],
        "statements": [
            [row.perturbations.replace("+", " + "), _typeset(row.statement)] for row in sets.itertuples()
        ],
        "models": _model_cells(models),
        "epochs": settings["protocol"]["epochs"],
        "window_ms": number(1e3 * window, 3),
        "persons": settings["persons"],
        "limit_k": number(settings["limits"]["stiffness_percent"], 3),
        "limit_b": number(settings["limits"]["damping_percent"], 3),
    }


def _identified(rows: pd.DataFrame) -> pd.DataFrame:
    return rows[rows.identified.astype(str).str.lower() == "true"]


def _listed(names) -> str:
    return ", ".join(name.replace("+", " + ") for name in names)


def _least(rows: pd.DataFrame) -> tuple[int | None, list[str]]:
    """Least number of perturbations that identifies the matrices, and the sets that do so."""
    good = _identified(rows)
    if not len(good):
        return None, []
    least = int(good.number.min())
    return least, list(good[good.number == least].perturbations)


def _of_numbers(sets: pd.DataFrame) -> list[str]:
    least, names = _least(sets)
    if least is None:
        return [
            "No set of perturbations identifies stiffness and damping of ankle, knee and hip: "
            "none has values."
        ]
    tried = sets[sets.number == least]
    said = (
        f"Stiffness and damping of ankle, knee and hip, {int(sets.unknowns.iloc[0])} unknowns, need {least} "
        f"independent perturbation{'s' * (least > 1)}: {len(names)} of {len(tried)} sets of {least} identify "
        f"them ({_listed(names)})."
    )
    common = set.intersection(*(set(name.split("+")) for name in names))
    if len(names) < len(tried) and common:
        said += f" All of these contain {_listed(sorted(common))}."
    return [said]


def _of_persons(sets: pd.DataFrame) -> list[str]:
    good, found = _identified(sets), []
    quoted = good[good.quoted_percent > 0.0]
    persons = int(sets.persons.iloc[0])
    if len(quoted):
        found.append(
            f"In {persons} recordings of a simulated person these sets find K with an RMS error of "
            f"{span([quoted.k_rms_percent.min(), quoted.k_rms_percent.max()], 2)} % of √(K_ii K_jj), no "
            f"element further off than {number(quoted.k_largest_error_percent.max(), 2)} %; "
            f"{percent(quoted.coverage_percent.mean())} % of the 95 % intervals hold the truth."
        )
    others = sets.drop(good.index)
    if len(others):
        refused = others[others.quoted_percent == 0.0]
        if len(refused) == len(others):
            found.append(f"The {len(others)} other sets have no values in any recording.")
        else:
            few = others[others.quoted_percent > 0.0]
            found.append(f"Of the other sets, {_listed(few.perturbations)} have values in some recordings.")
    return found


def _of_belt(sets: pd.DataFrame) -> list[str]:
    belt = sets[sets.perturbations == "belt"]
    if not len(belt):
        return []
    said = _typeset(belt.iloc[0].statement)
    if said.startswith("No values: "):
        return ["The belt alone gives no values: " + said.removeprefix("No values: ")]
    return [f"The belt alone is enough. {said}"]


def _of_models(models: pd.DataFrame, window: float) -> list[str]:
    own, found = models[models.window_s == window], []
    symmetric = own[(own.matrices == "symmetric") & (own.inertia == WITHIN)]
    least, names = _least(symmetric)
    if least is not None:
        said = f"If K and B are taken as symmetric, {least} can be enough ({_listed(names)})"
        if least < 3:
            said += ", but fewer than three do not test the symmetry, and without it their numbers are wrong"
        found.append(said + ".")
    unknown = own[(own.inertia == UNKNOWN) & (own.perturbations == "belt")]
    if len(unknown) and not len(_identified(unknown)):
        found.append(
            "Without the inertia the belt alone never shows the scale of K and B, only their proportions."
        )
    return found


def _of_windows(models: pd.DataFrame, window: float) -> list[str]:
    said = []
    for window_s, own in models[(models.matrices == "any") & (models.inertia == WITHIN)].groupby("window_s"):
        if window_s != window:
            least, _ = _least(own)
            need = "no set identifies them" if least is None else f"{least} can be enough"
            said.append(f"with {number(1e3 * window_s, 3)} ms, {need}")
    return [f"The window after the onset counts: {'; '.join(said)}."] if said else []


def _of_inertia(elements: pd.DataFrame, tolerance: float) -> list[str]:
    own = elements[elements.quantity.str.startswith("K_")].dropna(subset="neglected_inertia_u_percent")
    if not len(own):
        return []
    largest = own.groupby("perturbations").neglected_inertia_u_percent.max()
    return [
        f"The inertia is an unknown within its tolerance, {number(tolerance, 2)} % of every mass, centre of "
        "mass and moment of inertia, and the intervals hold it. If it is taken as exact, such errors move "
        f"the least certain element of K by {span([largest.min(), largest.max()], 2)} % of √(K_ii K_jj) (one "
        "standard deviation), beside narrow intervals."
    ]


def _typeset(statement: str) -> str:
    return statement.replace("sqrt(", "√(")


def _optional(value, digits: int = 2) -> str:
    return "–" if pd.isna(value) else number(value, digits)


def _set_cells(row) -> list[str]:
    return [
        row.perturbations.replace("+", " + "),
        f"{row.rank} of {row.unknowns}",
        _power(row.condition),
        f"{row.movements} of 3",
        _bounded(row.k_half_width_percent),
        _bounded(row.b_half_width_percent),
        "yes" if str(row.identified).lower() == "true" else "no",
        _optional(row.k_rms_percent),
        _optional(row.coverage_percent, 3),
    ]


def _bounded(value: float) -> str:
    return number(value, 2) if value < 1000.0 else "> 1000"


def _power(value: float) -> str:
    """Nearest power of ten (no unit)."""
    return f"10{str(round(math.log10(value))).translate(SUPERSCRIPTS)}"


def _model_cells(models: pd.DataFrame) -> list[list[str]]:
    """Least number of perturbations by window and model, and the sets."""
    rows = []
    for (window_s, matrices, inertia), own in models.groupby(["window_s", "matrices", "inertia"], sort=False):
        least, names = _least(own)
        rows.append(
            [
                number(1e3 * window_s, 3),
                matrices,
                inertia,
                str(int(own.unknowns.iloc[0])),
                "none of up to 3" if least is None else str(least),
                "–" if least is None else _listed(names),
            ]
        )
    return rows
