"""All trials of the torque-controlled manipulator together: a joint that is not linear, and friction."""

from collections.abc import Mapping

from tepsipe.experiments.budgets import contributions_of, rows_of
from tepsipe.experiments.fitted import Fitted
from tepsipe.experiments.wristalyzer.names import PATHWAY, POOLED
from tepsipe.experiments.wristalyzer.record import timed
from tepsipe.identification.budgets.manipulator import pooled_budget
from tepsipe.identification.regression.pooled import PerturbedRecord, fit_pooled
from tepsipe.identification.result import quantities_of
from tepsipe.io.estimates import flagged, recommended
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.mechanics.impedance_model import PARAMETER_UNITS
from tepsipe.statistics.uncertainty import Source

NAMES = ("wristalyzer", "pooled", PATHWAY, POOLED)


def fit_together(
    trials: Mapping[str, Trial],
    sources: Mapping[str, Source],
    *,
    period_s: float,
    lowpass_cutoff_hz: float,
    lowpass_order: int,
    cut_s: float,
    excited_band_hz: tuple[float, float],
) -> Fitted:
    """Constants of the joint and of the manipulator from the trials of all scale factors.

    trials: condition -> ``torque`` and ``angle``, all at one rate.
    sources: torque_scale and angle_scale, as far as they are known.
    period_s: period of the multisine.
    lowpass_cutoff_hz, lowpass_order: zero-lag Butterworth filter.
    cut_s: time cut at both ends.
    excited_band_hz: lowest and highest frequency of the perturbation (Hz), for the timing of every trial.
    Returns: rows of the condition ``pooled``, of which I, B, K of small movements are recommended; for the
    figure, contribution of each group of terms to I, B, K in each trial.
    """
    rate = next(iter(trials.values())).rate_hz
    cut = round(cut_s * rate)
    records, flags = [], set()
    for trial in trials.values():
        on_time, found = timed(trial, cut_s, period_s, excited_band_hz)
        kept = slice(cut, on_time.time.size - cut)
        records.append(PerturbedRecord(on_time.values("torque"), on_time.values("angle"), kept))
        flags.update(found)
    fit = fit_pooled(records, rate, period_s, lowpass_cutoff_hz, lowpass_order)
    quantities = quantities_of(fit.values, pooled_budget(fit, sources))
    # the delay of the torque absorbs the hold of the command and is not a property of the joint
    delay = quantities.pop("delay")
    signals = {"rms_angle": (fit.rms_angle, "rad")}
    signals |= {f"shares/{name}": (share, PARAMETER_UNITS) for name, share in fit.shares.items()}
    facts = {
        "conditions": list(trials),
        "systematic_torque_Nm": fit.systematic_Nm,
        "without_softening_Nm": fit.without_softening_Nm,
        "delay_s": delay.value,
    }
    rows = flagged(recommended(rows_of(NAMES, quantities), PATHWAY, POOLED), *sorted(flags))
    return Fitted(Result.of(signals, facts), rows, contributions_of(NAMES, quantities))
