"""Impedance that changes within a trial of the position-controlled manipulator.

The method follows from the channels of the trial: realisations of a movement with a trigger, bins with a
schedule, else sliding windows (`tepsipe.identification.time_varying`). Angle, torque and
reflex torque come from the fit of the whole trial, filtered and cut.
"""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.position_manipulator.options import TimeVaryingOptions
from tepsipe.identification.time_varying import (
    MovedJoint,
    VaryingImpedance,
    impedance_by_schedule,
    impedance_in_windows,
    impedance_of_ensemble,
)
from tepsipe.io.result import Result
from tepsipe.io.tables import Table
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import UNITS


@dataclass(frozen=True)
class VaryingRow:
    """One quantity at one place; the fields are the columns of ``tables/time_varying.csv``."""

    experiment: str
    condition: str
    over: str
    """time, time after the trigger, or schedule."""
    at: float
    """Centre of the segment (``at_unit``)."""
    at_unit: str
    """s, or unit of the recording for a schedule."""
    angle_rad: float
    torque_Nm: float
    """Operating point: mean angle (rad) and torque (N·m)."""
    pieces: int
    """Realisations or pieces of the record behind the value."""
    quantity: str
    unit: str
    """For example K in Nm/rad; reflex_gain_ratio is relative to the gain of the whole trial."""
    value: float
    standard_error: float
    ci_low: float
    ci_high: float
    """Value, standard error and ends of the 95 % interval (``unit``)."""
    vaf_percent: float
    """VAF of the torque of the segments."""


VARYING_ROWS = Table(VaryingRow, "rows of impedance that changes")


def analyse_time_varying(
    trial: Trial, fit: Result, options: TimeVaryingOptions, rng: np.random.Generator
) -> VaryingImpedance | None:
    """Impedance over time, after the trigger, or with the schedule of a trial.

    trial: ``schedule`` and ``trigger`` (1 at the first sample of a realisation) if recorded.
    fit: fit of the whole trial: ``time``, ``angle``, ``torque`` and ``reflex/reflex_torque``.
    Returns: impedance, over the time of the trial for windows; None if there is neither trigger nor
    schedule and the trial is too short for windows.
    """
    rate, time = trial.rate_hz, fit.arrays["time"]
    arrays = fit.arrays
    joint = MovedJoint(arrays["angle"], arrays["torque"], rate, arrays.get("reflex/reflex_torque"))
    draws = options.bootstrap_draws
    first = round((time[0] - trial.time[0]) * rate)
    if "trigger" in trial.signals:
        starts = np.flatnonzero(trial.values("trigger")) - first
        return impedance_of_ensemble(
            joint,
            starts,
            length_s=_realisation_s(starts, rate, options),
            segment_s=options.segment_s,
            step_s=options.segment_step_s,
            draws=draws,
            rng=rng,
        )
    if "schedule" in trial.signals:
        schedule = trial.values("schedule")[first : first + time.size]
        return impedance_by_schedule(
            joint, schedule, bins=options.bins, piece_s=options.piece_s, draws=draws, rng=rng
        )
    lasts = time.size / rate
    if lasts < max(options.window_s + options.window_step_s, 4.0 * options.block_s):
        return None
    impedance = impedance_in_windows(
        joint,
        window_s=options.window_s,
        step_s=options.window_step_s,
        block_s=options.block_s,
        draws=draws,
        rng=rng,
    )
    return VaryingImpedance(**(vars(impedance) | {"at": impedance.at + time[0]}))


def _realisation_s(starts: np.ndarray, rate_hz: float, options: TimeVaryingOptions) -> float:
    """Length of a realisation (s): as chosen, else the shortest time between triggers."""
    if options.realisation_s is not None:
        return options.realisation_s
    if starts.size < 2:
        raise InputError(
            f"expected a trigger at the start of every realisation, found {starts.size} in the trial: record "
            "more realisations, or name no trigger"
        )
    return float(np.diff(starts).min()) / rate_hz


def varying_rows(experiment: str, condition: str, impedance: VaryingImpedance | None) -> list[VaryingRow]:
    """Tidy rows of one trial, none if there is no result."""
    if impedance is None:
        return []
    rows = []
    for k, at in enumerate(impedance.at):
        for i, quantity in enumerate(impedance.names):
            rows.append(
                VaryingRow(
                    experiment,
                    condition,
                    impedance.over,
                    float(at),
                    "unit of the recording" if impedance.over == "schedule" else "s",
                    float(impedance.angle[k]),
                    float(impedance.torque[k]),
                    int(impedance.pieces[k]),
                    quantity,
                    UNITS.get(quantity, "1"),
                    float(impedance.values[k, i]),
                    float(impedance.standard_error[k, i]),
                    float(impedance.low[k, i]),
                    float(impedance.high[k, i]),
                    float(impedance.vaf[k]),
                )
            )
    return rows
