"""All trials of the torque-controlled manipulator together: a joint that is not linear, and friction."""

from collections.abc import Mapping, Sequence

import numpy as np

from tepsipe.experiments.budgets import contributions_of, rows_of
from tepsipe.experiments.wristalyzer.names import PATHWAY, POOLED
from tepsipe.experiments.wristalyzer.record import timed
from tepsipe.identification.budgets.manipulator import pooled_budget
from tepsipe.identification.regression.pooled import PerturbedRecord, PooledFit, fit_pooled
from tepsipe.identification.result import quantities_of
from tepsipe.io.estimates import Contribution, Estimate, flagged, recommended
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETER_UNITS
from tepsipe.statistics.uncertainty import Source

CONDITION = "pooled"
# the delay of the torque absorbs the hold of the command and is not a property of the joint
NUISANCE = ("delay",)


def fit_wristalyzer_together(
    trials: list[Trial],
    period_s: float,
    lowpass_cutoff_hz: float,
    lowpass_order: int,
    cut_s: float,
    excited_band_hz: tuple[float, float],
) -> tuple[PooledFit, tuple[str, ...]]:
    """Constants of the joint and of the manipulator from the trials of all scale factors.

    trials: ``torque`` and ``angle``, all at one rate.
    period_s: period of the multisine.
    lowpass_cutoff_hz, lowpass_order: zero-lag Butterworth filter.
    cut_s: time cut at both ends.
    excited_band_hz: lowest and highest frequency of the perturbation (Hz), for the timing of every trial.

    Returns:
        fit: constants with their intervals.
        flags: failed checks of any trial's timing.
    """
    rate = trials[0].rate_hz
    cut = round(cut_s * rate)
    checked = [timed(trial, cut_s, period_s, excited_band_hz) for trial in trials]
    trials, flags = [trial for trial, _ in checked], {flag for _, found in checked for flag in found}
    records = [
        PerturbedRecord(t.values("torque"), t.values("angle"), slice(cut, t.time.size - cut)) for t in trials
    ]
    return fit_pooled(records, rate, period_s, lowpass_cutoff_hz, lowpass_order), tuple(sorted(flags))


def pooled_estimates(
    fit: PooledFit, sources: Mapping[str, Source], flags: Sequence[str] = ()
) -> tuple[list[Estimate], list[Contribution]]:
    """Tidy rows of the condition ``pooled``: K and B hold for small movements.

    flags: failed checks of the trials.

    Returns:
        estimates: I, B, K are recommended.
        contributions: their budgets, source by source.
    """
    budget, quantities = pooled_budget(fit, sources), list(fit.values)
    told = {name: q for name, q in quantities_of(fit.values, budget).items() if name not in NUISANCE}
    rows = rows_of(("wristalyzer", CONDITION, PATHWAY, POOLED), told)
    rows = flagged(recommended(rows, PATHWAY, POOLED), *flags)
    return rows, contributions_of(rows, budget, quantities)


def pooled_result(conditions: list[str], fit: PooledFit) -> Result:
    """Contribution of each group of terms to I, B, K in each trial, for the figure."""
    arrays: dict[str, np.ndarray] = {"rms_angle": fit.rms_angle}
    units = {"rms_angle": "rad"}
    for name, share in fit.shares.items():
        arrays[f"shares/{name}"] = share
        units[f"shares/{name}"] = PARAMETER_UNITS
    facts = {
        "conditions": conditions,
        "systematic_torque_Nm": fit.systematic_Nm,
        "without_softening_Nm": fit.without_softening_Nm,
        "delay_s": fit.values["delay"],
    }
    return Result(arrays, units, facts)
