"""Effect of a low-pass on I, B, K of recorded or simulated trials, with the torque from leg or foot.

All signals of a trial pass the same filter, markers before the pose is found. The belt-induced load is
subtracted by a treadmill model behind the same filter, or left in.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.experiments.dummy.foot_pathways import FootOptions, foot_delay, foot_side, windows_from_onset
from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.planning.design import FOOT, LEG
from tepsipe.experiments.planning.filtering import delay_samples, filtered_motion, late
from tepsipe.identification.estimators import LEAST_SQUARES, LEAST_SQUARES_OWN_ZERO, Record, estimate
from tepsipe.io.trial import Trial
from tepsipe.mechanics.inverse_dynamics import leg_torque
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.compensation import compensated_loads
from tepsipe.treadmill.prepared import prepare_trial
from tepsipe.treadmill.registry import FittedModel
from tepsipe.treadmill.trial_recordings import recordings_of_loads

COMPENSATED = "foot-compensated"
# window of the torque from the foot, as in the study: the subsequent swing determines most of K (s)
FOOT_WINDOW_S = 2.0


@dataclass(frozen=True)
class FilteredEstimates:
    """I, B, K of one trial behind one filter."""

    pathway: str
    """{"leg", "foot", "foot-compensated"}: Origin of the torque, and whether the belt-induced load was
    subtracted."""
    lowpass: Lowpass
    """The filter (Hz)."""
    parameters: Annotated[np.ndarray, "(windows, 3)"]
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of every window."""
    windows_s: list[tuple[float, float]]
    """Start and end of the windows (s), before the delay of a filter that runs forwards only."""


def filter_estimates(
    trial: Trial,
    name: str,
    dummy: DummyOptions,
    options: FootOptions,
    models: Mapping[str, FittedModel],
    lowpass: Lowpass,
) -> list[FilteredEstimates]:
    """Estimate I, B, K of a trial whose signals all pass one filter.

    trial: forces, moments, markers and belt velocity.
    name: names the trial in messages.
    dummy, options: Choices; the filter of ``dummy`` finds the windows.
    models: component of the load, Fy or Mx -> treadmill model.
    Returns: estimates from the leg, the foot, and the foot with the belt-induced load subtracted.
    """
    detected = prepare_trial(trial, name, dummy.lowpass, dummy.window)
    delay_s = foot_delay(detected, options)
    prepared = detected.behind(lowpass)
    rate, time, leg = prepared.rate_hz, prepared.time, dummy.leg
    positions = trial.values("marker_position")
    motion = filtered_motion(time, positions, prepared.markers, dummy.leg_markers, leg.com_m, lowpass)
    side = foot_side(prepared, options, motion, delay_s)
    recordings = recordings_of_loads(prepared, side.measured, options.foot.mass_kg + leg.mass_kg)
    behind = {component: replace(model, lowpass=lowpass) for component, model in models.items()}
    compensated = compensated_loads(behind, recordings)
    delayed = replace(prepared, perturbations=late(prepared.perturbations, lowpass, rate))
    after_foot = windows_from_onset(delayed, FOOT_WINDOW_S)
    torque = leg_torque(leg, motion.theta, motion.theta_dd, motion.y_dd, motion.z_dd)
    fitted = [(LEG, motion, torque, delayed.perturbations, LEAST_SQUARES)]
    for pathway, loads in ((FOOT, side.measured), (COMPENSATED, compensated)):
        torque = side.torque("foot", options.foot, leg, loads)
        fitted.append((pathway, side.motion, torque, after_foot, LEAST_SQUARES_OWN_ZERO))
    # the windows before the delay of the filter
    earlier = time - delay_samples(lowpass, rate) / rate
    estimates = []
    for pathway, motion, torque, windows, estimator in fitted:
        record = Record(motion=motion, torque=torque, perturbations=windows, at_rest=prepared.at_rest)
        spans = [(float(earlier[p.start]), float(earlier[p.stop - 1])) for p in windows]
        estimates.append(FilteredEstimates(pathway, lowpass, estimate(estimator, record).parameters, spans))
    return estimates
