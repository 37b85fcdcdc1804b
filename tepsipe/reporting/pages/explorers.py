"""What the page of the report gives to its figures to try (explore.js): numbers of the run, in SI units."""

import math
from collections.abc import Mapping, Sequence

from tepsipe.experiments.dummy.specification_curve import CHOICES, SPECIFICATIONS
from tepsipe.io.recovery_table import Recovery
from tepsipe.reporting.figures.names import words


def leg_of(geometry: Mapping[str, float]) -> dict[str, float]:
    """Leg of the dummy by its settings: mass (kg), com (m), inertia (kg·m²), gravity (m/s²)."""
    return {
        "mass": geometry["leg_mass_kg"],
        "com": geometry["leg_com_m"],
        "inertia": geometry["leg_inertia_kgm2"],
        "gravity": geometry["gravity_m_per_s2"],
    }


def apparent(geometry: Mapping[str, float], truth: Sequence[Recovery]) -> dict | None:
    """The leg and the true joint of the dummy for small movements (I, B, K); None where no truth is known."""
    known = {r.quantity: r.truth for r in truth if r.experiment == "dummy"}
    joint = {q: known.get(f"{q}_small", known.get(q)) for q in "IBK"}
    if None in joint.values():
        return None
    return {"leg": leg_of(geometry), "joint": joint}


def specification(path: str, truth: Sequence[Recovery]) -> dict | None:
    """Combinations of the specification curve (table) sorted by K (N·m/rad), and the true K of its trial."""
    rows = [row for row in SPECIFICATIONS.read(path) if math.isfinite(row.K_Nm_per_rad)]
    if not rows:
        return None
    rows.sort(key=lambda row: row.K_Nm_per_rad)
    recommended = [row.K_Nm_per_rad for row in rows if row.role == "recommended"]
    true = [
        r.truth
        for r in truth
        if (r.experiment, r.condition, r.quantity) == ("dummy", rows[0].condition, "K") and r.recommended
    ]
    middle = recommended[0] if recommended else rows[len(rows) // 2].K_Nm_per_rad
    return {
        "steps": list(CHOICES),
        "rows": [
            {
                "K": row.K_Nm_per_rad,
                "B": _number(row.B_Nms_per_rad),
                "VAF": _number(row.VAF_percent),
                "role": row.role or "",
                "options": [words(getattr(row, step)) for step in CHOICES],
            }
            for row in rows
        ],
        "truth": true[0] if true else None,
        "limits": [middle - 12.0, middle + 12.0],
    }


def _number(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
