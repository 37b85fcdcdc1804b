"""Impedance against the operating point: mean angle and torque of several trials of a person.

Stiffness of the ankle rises in proportion to the torque that its muscles hold, from rest to maximal
contraction, with a nearly constant damping ratio zeta = B / (2 sqrt(I K)) of the second-order joint (Hunter &
Kearney 1982; Weiss, Hunter & Kearney 1988). The stiffness here is K_working, that of the intrinsic torque at
the recorded amplitude, to which a second-order fit corresponds. For every person and direction of torque,

    K = K_0 + s |T|

is fitted to the trials by least squares, each trial counting once: scatter between trials is larger than the
uncertainty within one. Intervals are Student's.

`LITERATURE_SLOPE` is s by the literature: in quick releases the plantar flexors of 12 people had 250 to 400
N·m/rad at an ankle moment of 100 N·m (Hof 1998); by the proportionality of Weiss et al. it is divided by the
moment.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.experiments.position_manipulator.analysis import REFLEX_ESTIMATOR
from tepsipe.io.estimates import Estimate
from tepsipe.io.tables import Table
from tepsipe.statistics.least_squares import least_squares_line

# K per torque (1/rad): 250 to 400 N·m/rad at 100 N·m
LITERATURE_SLOPE = (2.5, 4.0)
LITERATURE_TORQUE_NM = 100.0
# the stiffness against the operating point
STIFFNESS = "K_working"
QUANTITIES = (STIFFNESS, "K", "K_short_range", "B", "I", "K_growth", "reflex_gain")
LEAST_TRIALS = 3


@dataclass(frozen=True)
class Nominal:
    """What the trial sheet says of a trial."""

    participant: str = ""
    """The person, empty if the sheet names none."""
    angle_rad: float | None = None
    torque_Nm: float | None = None
    """Operating point (rad, N·m); None where the measured mean holds."""


@dataclass(frozen=True)
class OperatingPoint:
    """One quantity of one trial; the fields are the columns of ``tables/operating_points.csv``."""

    participant: str
    condition: str
    """The person, empty if the sheet names none, and the trial."""
    angle_rad: float
    torque_Nm: float
    angle_from: str
    torque_from: str
    """trial sheet, or measured mean."""
    quantity: str
    unit: str
    """For example K_working in Nm/rad; damping_ratio is B / (2 sqrt(I K_working))."""
    value: float
    standard_error: float | None = None
    ci_low: float | None = None
    ci_high: float | None = None
    """Estimate, standard error and 95 % interval (``unit``); None where there is none."""


@dataclass(frozen=True)
class Relation:
    """Stiffness against torque; the fields are the columns of ``tables/operating_relations.csv``."""

    participant: str
    torque: str
    """The person, and the direction of the torque: positive or negative."""
    trials: int
    """Number of trials."""
    slope_per_rad: float
    slope_low: float
    slope_high: float
    """s and its 95 % interval (1/rad)."""
    at_rest_Nm_per_rad: float
    at_rest_low: Annotated[float, "N·m/rad"]
    at_rest_high: Annotated[float, "N·m/rad"]
    """K_0 and its 95 % interval."""


OPERATING_POINTS = Table(OperatingPoint, "operating points")
RELATIONS = Table(Relation, "relations of stiffness and torque")


def operating_points(
    estimates: Iterable[Estimate], measured: Mapping[str, tuple[float, float]], nominal: Mapping[str, Nominal]
) -> list[OperatingPoint]:
    """Estimates of the parallel-cascade model with the operating point of their trial.

    measured: condition -> mean angle (rad) and torque (N·m) of the trial.
    nominal: condition -> what the trial sheet says.
    Returns: in the order of ``measured``: its quantities, and the damping ratio.
    """
    rows: dict[str, dict[str, Estimate]] = {}
    for row in estimates:
        if row.experiment == "position_manipulator" and row.estimator == REFLEX_ESTIMATOR:
            rows.setdefault(row.condition, {})[row.quantity] = row
    found = []
    for condition, (angle, torque) in measured.items():
        said = nominal[condition]
        place = (
            said.participant,
            condition,
            angle if said.angle_rad is None else said.angle_rad,
            torque if said.torque_Nm is None else said.torque_Nm,
            *(
                "measured mean" if value is None else "trial sheet"
                for value in (said.angle_rad, said.torque_Nm)
            ),
        )
        own = rows.get(condition, {})
        for quantity in QUANTITIES:
            if quantity in own:
                e = own[quantity]
                found.append(
                    OperatingPoint(*place, quantity, e.unit, e.value, e.standard_error, e.ci_low, e.ci_high)
                )
        if {"I", "B", STIFFNESS} <= set(own):
            inertia, damping, stiffness = (own[q].value for q in ("I", "B", STIFFNESS))
            if inertia > 0.0 and stiffness > 0.0:
                ratio = damping / (2.0 * math.sqrt(inertia * stiffness))
                found.append(OperatingPoint(*place, "damping_ratio", "1", ratio))
    return found


def relations(points: Iterable[OperatingPoint]) -> list[Relation]:
    """Line of K against torque for every person and direction of torque with at least three trials.

    Trials without participant count as one person's only if the sheet gives their operating points.
    """
    groups: dict[tuple[str, str], list[OperatingPoint]] = {}
    for point in points:
        if point.quantity != STIFFNESS:
            continue
        if not point.participant and point.torque_from != "trial sheet":
            continue
        direction = "positive" if point.torque_Nm >= 0.0 else "negative"
        groups.setdefault((point.participant, direction), []).append(point)
    found = []
    for (participant, direction), own in groups.items():
        torque = np.abs([p.torque_Nm for p in own])
        if len(own) < LEAST_TRIALS or not np.ptp(torque) > 0.0:
            continue
        value = np.array([p.value for p in own])
        line = least_squares_line(np.column_stack([torque, np.ones(len(own))]), value)
        half = scipy.special.stdtrit(len(own) - 2, 0.975) * line.standard_error
        found.append(
            Relation(
                participant,
                direction,
                len(own),
                *(float(line.parameters[k] + sign * half[k]) for k in (0, 1) for sign in (0, -1, 1)),
            )
        )
    return found
