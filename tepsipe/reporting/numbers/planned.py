"""Numbers of the chapter on planning and walking."""

from collections.abc import Sequence

from tepsipe.experiments.planning.design import FOOT, JOINT_LIKELIHOOD, LEG
from tepsipe.reporting.numbers.format import MINUS, number
from tepsipe.reporting.planned import (
    BOUND,
    CHANGE,
    DESIGNS,
    FILTERS,
    LEAST,
    NUMBER,
    RATIO,
    TYPE_A,
    TYPE_B,
    PlannedRow,
    planned_value,
)

CALLED = {LEG: "leg", FOOT: "foot, compensated", JOINT_LIKELIHOOD: "joint likelihood"}
PROFILES = {"sine": "sine", "minjerk": "minimum jerk"}


def planned_data(rows: Sequence[PlannedRow], joint: dict) -> dict:
    """Numbers of the chapter as text.

    Parameters
    ----------
    rows : sequence of PlannedRow
        Table of the run (units in it).
    joint : dict
        Joint that was expected: inertia_Nms2_per_rad, damping_Nms_per_rad, stiffness_Nm_per_rad (the first).

    Returns
    -------
    dict
        Text (units in the chapter).
    """

    def value(design: str, measure: str, pathway: str = LEG, quantity: str = "K") -> float:
        return planned_value(rows, design, measure, quantity, pathway)

    best = {
        name: [value(f"best, {belt}", measure, JOINT_LIKELIHOOD) for measure in (RATIO, LEAST)]
        for name, belt in (("returning", "belt returns"), ("one_way", "one way"))
    }
    return {
        "joint": {
            "I": f"{joint['inertia_Nms2_per_rad']:g}",
            "B": f"{joint['damping_Nms_per_rad']:g}",
            "K": f"{joint['stiffness_Nm_per_rad'][0]:g}",
        },
        "designs": [_design(rows, *design) for design in DESIGNS],
        "foot_over_leg": number(value("sine-0.3", TYPE_A, FOOT) / value("sine-0.3", TYPE_A), 2),
        "minjerk_over_sine": number(value("minjerk-0.3", TYPE_A) / value("sine-0.3", TYPE_A)),
        "best": {name: [number(x) for x in found] for name, found in best.items()},
        "halved": {name: found[0] <= 0.5 for name, found in best.items()},
        "filters": [
            [name, *(_change(value(name, CHANGE, quantity=quantity)) for quantity in ("I", "B", "K"))]
            for name in FILTERS
        ],
    }


def _change(percent: float) -> str:
    """A change in per cent, with one decimal."""
    text = f"{percent:+.1f}"
    return "0.0" if float(text) == 0.0 else text.replace("-", MINUS)


def _design(rows: Sequence[PlannedRow], profile: str, amplitude: float, pathway: str) -> list[str]:
    """Cells of a design: what K will have."""
    name = f"{profile}-{amplitude:g}"
    type_a, type_b, needed = (
        planned_value(rows, name, measure, "K", pathway) for measure in (TYPE_A, TYPE_B, NUMBER)
    )
    bound = planned_value(rows, name, BOUND, "K", pathway) if pathway == JOINT_LIKELIHOOD else None
    return [
        PROFILES[profile],
        f"{amplitude:g}",
        CALLED[pathway],
        number(type_a),
        number(bound) if bound is not None else "–",
        number(type_b),
        "none" if needed is None else str(int(needed)),
    ]
