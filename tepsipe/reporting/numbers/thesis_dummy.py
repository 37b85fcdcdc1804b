"""Numbers of the chapter on the dummy that the printed tables describe."""

import math

from tepsipe.experiments.thesis_dummy.tables import CellRow
from tepsipe.io.result import Result
from tepsipe.mechanics.rubber_joint import RubberJoint
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.numbers.format import LABELS, _printed, number

ROWS = (
    ("stiffness_Nm_per_rad", "K", "N·m/rad"),
    ("half_softening_rad", "phi_h", "rad"),
    ("damping_Nms_per_rad", "B", "N·m·s/rad"),
    ("softened_damping_Nms_per_rad", "B_s", "N·m·s/rad"),
    ("inertia_Nms2_per_rad", "I", "N·m·s²/rad"),
)
GROUPS = (
    ("I", "I"),
    ("B", "B"),
    ("K", "K"),
    ("SEM_", "SEM of I, B and K"),
    ("VAF_perturbation", "VAF of a perturbation"),
    ("VAF_trial", "VAF of the full dataset"),
)
AMPLITUDES_RAD = (0.005, 0.01, 0.02, 0.03)


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
    counts = [
        {"label": label, **{role: _within(rows, role, name) for role in ("fitted", "predicted")}}
        for name, label in GROUPS
    ]
    joint = _joint(best["constants"])
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
        "n": str(len(best["intervals"])),
        "at_work": [
            {
                "amplitude": number(a, 1),
                "K": number(joint.linearised(a)[0]),
                "B": number(joint.linearised(a)[1]),
            }
            for a in AMPLITUDES_RAD
        ],
        "best_predicts": best["predicted_rms"]
        < min(found["predicted_rms"] for found in [*laws.values()][:-1]),
        "noise_um": number(1e6 * result.facts["marker_noise_m"], 2),
        "scatter": {q: number(v, 2) for q, v in result.facts["scatter"].items()},
        "fitted": str(len(fitted)),
        "fitted_within": str(sum(row.within for row in fitted)),
        "predicted": str(len(predicted)),
        "predicted_within": str(sum(row.within for row in predicted)),
        "outside": [
            {
                "condition": short_name(row.condition),
                "quantity": LABELS.get(row.quantity, row.quantity),
                "printed": _printed(row.printed),
                "value": number(row.value, 4 if row.quantity.startswith("VAF") else 3),
            }
            for row in rows
            if not row.within
        ],
    }


def _within(rows: list[CellRow], role: str, name: str) -> str:
    """How many numbers of one kind (no unit) lie within their tolerance; a dash where there is none."""
    alike = str.startswith if name.endswith("_") else str.__eq__
    own = [row for row in rows if row.role == role and alike(row.quantity, name)]
    return f"{sum(row.within for row in own)} of {len(own)}" if own else number(None)


def _joint(constants: dict) -> RubberJoint:
    """The joint of a law (units in the names), linear where no angle of softening was fitted."""
    half = constants["half_softening_rad"]
    return RubberJoint(**(constants | {"half_softening_rad": math.inf if half is None else half}))
