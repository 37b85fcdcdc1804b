"""Numbers of the chapter on the dummy that the printed tables describe."""

from tepsipe.experiments.thesis_dummy.tables import CellRow
from tepsipe.io.result import Result
from tepsipe.reporting.numbers.format import number

ROWS = (
    ("stiffness_Nm_per_rad", "K", "N·m/rad"),
    ("half_softening_rad", "phi_h", "rad"),
    ("damping_Nms_per_rad", "B", "N·m·s/rad"),
    ("softened_damping_Nms_per_rad", "B_s", "N·m·s/rad"),
    ("inertia_Nms2_per_rad", "I", "N·m·s²/rad"),
)
GROUPS = (("I", "I"), ("B", "B"), ("K", "K"), ("VAF", "VAF"), ("SEM", "SEM"))


def thesis_dummy_data(result: Result, rows: list[CellRow]) -> dict:
    """Constants with intervals, and how many printed numbers they return (units as N·m, rad, s).

    Parameters
    ----------
    result : Result
        Of `tepsipe.experiments.thesis_dummy.tables.fit_result` (units in the names).
    rows : list of CellRow
        Printed numbers (units in the rows).

    Returns
    -------
    dict
        Text.
    """
    laws = result.facts["laws"]
    *_, best = laws.values()
    constants = [
        {
            "symbol": symbol,
            "unit": unit,
            "value": number(best["constants"][name]),
            "low": number(best["intervals"][name][0]),
            "high": number(best["intervals"][name][1]),
        }
        for name, symbol, unit in ROWS
    ]
    counts = []
    for role in ("fitted", "predicted"):
        for start, label in GROUPS:
            own = [row for row in rows if row.role == role and row.quantity.startswith(start)]
            if own:
                within = sum(row.within for row in own)
                counts.append({"role": role, "label": label, "n": str(len(own)), "within": str(within)})
    predicted = [row for row in rows if row.role == "predicted"]
    fitted = [row for row in rows if row.role == "fitted"]
    return {
        "constants": constants,
        "laws": [
            {
                "law": law,
                "n": str(len(found["intervals"])),
                "fitted": number(found["fitted_rms"]),
                "predicted": number(found["predicted_rms"]),
            }
            for law, found in laws.items()
        ],
        "counts": counts,
        "noise_um": number(1e6 * result.facts["marker_noise_m"], 2),
        "scatter": {q: number(v, 2) for q, v in result.facts["scatter"].items()},
        "fitted": str(len(fitted)),
        "fitted_within": str(sum(row.within for row in fitted)),
        "predicted": str(len(predicted)),
        "predicted_within": str(sum(row.within for row in predicted)),
        "outside": [
            {
                "condition": row.condition,
                "quantity": row.quantity.replace("_", " "),
                "printed": number(row.printed, 4),
                "value": number(row.value, 4),
            }
            for row in rows
            if not row.within
        ],
    }
