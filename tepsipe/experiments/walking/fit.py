"""Fit of one walking trial: impedance at every perturbed phase of stance, and the strides that it would need.

A walk without pulses is fitted with pulses of no size at random strides, so that its intervals tell what is
known without perturbations.
"""

from dataclasses import replace

import numpy as np

from tepsipe.experiments.fitted import Fitted
from tepsipe.experiments.walking.analysis import analyse_walking, place_pulses, without_pulses
from tepsipe.experiments.walking.needed_strides import needed_strides
from tepsipe.experiments.walking.options import ExpectedPulse, WalkingOptions
from tepsipe.experiments.walking.results import walking_estimates, walking_rows
from tepsipe.experiments.walking.strides import (
    Strides,
    WalkingRecording,
    agreement,
    ankle_moment,
    bandwidth_hz,
)
from tepsipe.io.result import Result
from tepsipe.signals.resampling import refuse_short
from tepsipe.statistics.uncertainty import sources_of

# recording, strides, and instants of events (s), from `tepsipe.experiments.walking.trial.read_trial`
Walk = tuple[WalkingRecording, Strides, dict]


def begin(
    walk: Walk, section: dict, seed: int, lasts_s: float | None = None
) -> tuple[np.ndarray, WalkingOptions]:
    """Onsets of the pulses (s), which have a place in the strides, and options for them.

    lasts_s: duration of a recorded trial in the trial sheet; None for a simulated one.
    """
    recording, strides, events = walk
    if lasts_s is not None:
        refuse_short(float(np.ptp(recording.time)), lasts_s, recording.name)
    onsets, options = events["pulse"], WalkingOptions(**section["analysis"])
    if not onsets.size:
        onsets, options = without_pulses(strides, options, np.random.default_rng(seed))
    place_pulses(recording, strides, onsets, options)
    return onsets, options


def fit(walk: Walk, section: dict, condition: str, seed: int, lasts_s: float | None = None) -> Fitted:
    """Impedance at each phase; ``rows`` of it and ``needed`` strides are further results.

    lasts_s: as for `begin`.
    """
    recording, strides, events = walk
    onsets, options = begin(walk, section, seed, lasts_s)
    found = analyse_walking(recording, strides, onsets, options, sources_of(section["uncertainty"]))
    pulsed = events["pulse"].size > 0
    estimates, contributions = walking_estimates(condition, found)
    if not pulsed:
        estimates = [e if e.n_perturbations is None else replace(e, n_perturbations=0) for e in estimates]
    quiet = strides.taken(found.quiet) if pulsed else strides
    planned, choices = ExpectedPulse(**section["planned"]), WalkingOptions(**section["analysis"])
    supplied = recording.supplied_moment
    facts = {
        "condition": condition,
        "source": "virtual_lab" if lasts_s is None else "recorded",
        "strides": len(strides),
        "pulses": len(onsets) if pulsed else 0,
        "stance_s": found.stance_s,
        "bandwidth_hz": None
        if supplied is None
        else bandwidth_hz(supplied, ankle_moment(recording), recording.rate_hz),
        "agreement_Nm": None if supplied is None else agreement(recording, strides.in_stance(recording.time)),
        "dropped": list(found.dropped),
    }
    further = {
        "rows": walking_rows(condition, "recorded" if pulsed else "none", found),
        "needed": needed_strides(condition, recording, quiet, planned, choices),
    }
    return Fitted(Result({}, {}, facts), estimates, contributions, further)
