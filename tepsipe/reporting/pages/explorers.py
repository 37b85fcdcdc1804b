"""What the page of the report gives to its figures to try (explore.js): numbers of the run, in SI units."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict

from tepsipe.experiments.dummy.specification_curve import CHOICES, SPECIFICATIONS
from tepsipe.io.estimates import Recovery
from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import PARAMETER_SETS, short_name, words
from tepsipe.reporting.pages.decimation import pack


def explored(
    geometry: Mapping[str, float],
    specifications: str,
    truth: Sequence[Recovery],
    simulated: Mapping[str, Result],
) -> dict[str, tuple[str, object]]:
    """Return what there is to try below the figures of the dummy.

    specifications: table of the specification curve.
    truth: known constants, empty for recordings.
    simulated: condition -> fit of `simulation_result`, of one trial or none.
    Returns: anchor of a figure -> function of explore.js, and its data.
    """
    found = {
        "figure_torque": ("apparent", apparent(geometry, truth)),
        "figure_specification": ("specification", specification(specifications, truth)),
    }
    for condition, fit in simulated.items():
        found["figure_4_7"] = ("forward", forward(fit, condition, geometry, truth))
    return {figure: content for figure, content in found.items() if content[1]}


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
    joint = _true_joint(truth)
    return {"leg": leg_of(geometry), "joint": joint} if joint else None


def _true_joint(truth: Sequence[Recovery]) -> dict[str, float] | None:
    """True I, B, K of the dummy for small movements (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
    known = {r.quantity: r.truth for r in truth if r.experiment == "dummy"}
    joint = {q: known.get(f"{q}_small", known.get(q)) for q in "IBK"}
    return None if None in joint.values() else joint


def forward(
    simulated: Result, condition: str, geometry: Mapping[str, float], truth: Sequence[Recovery]
) -> dict:
    """A trial of the dummy for the forward simulation in the browser.

    simulated: fit of `simulation_result`: recorded foot and leg, and the joints that were simulated.
    geometry: the leg by its settings (kg, m, kg·m²).
    truth: known constants, empty for recordings.
    Returns: leg, clock (Hz), packed signals, windows (samples), joints (recommended first), true joint or
    None.
    """
    arrays, facts = simulated.arrays, simulated.facts
    time = arrays["time"]
    names = sorted(facts["joints"], key=lambda name: name not in facts["softens"])
    return {
        "leg": leg_of(geometry),
        "rate": (time.size - 1) / float(time[-1] - time[0]),
        "standing": facts["standing_rad"],
        "velocity": asdict(pack(arrays["foot_velocity"])),
        "angle": asdict(pack(arrays["theta"])),
        "windows": arrays["windows"].astype(int).tolist(),
        "sets": [_joint(PARAMETER_SETS.get(name, name), facts["joints"][name]) for name in names],
        "truth": _true_joint(truth),
        "condition": short_name(condition),
    }


def _joint(name: str, constants: Mapping[str, float]) -> dict:
    """A joint by the symbols of swing.js."""
    symbols = {
        "inertia_Nms2_per_rad": "I",
        "damping_Nms_per_rad": "B",
        "stiffness_Nm_per_rad": "K",
        "softening_Nm_per_rad": "C",
        "softened_damping_Nms_per_rad": "D",
        "half_softening_rad": "half",
    }
    return {"name": name} | {symbols[key]: value for key, value in constants.items() if key in symbols}


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
