"""Low-passes of planned and recorded trials: the same for all signals, and the bias if they differ.

A filter is linear: with h its impulse response, tau = I theta'' + B theta' + K theta implies
h * tau = I h * theta'' + B h * theta' + K h * theta. Filtered alike, on the same clock, signals without noise
give I, B, K without bias, whatever the filter. If only one side is filtered, the other side is regressed on
its smoothed copy (`mismatch_bias`).

For the same reason no filter removes a belt-induced torque e y'' + c y' that is in the band of the joint. The
leg obeys -p y'' = J theta'' + B theta' + (K - k_g) theta, so e y'' is itself a combination of the regressors,
and it changes the estimates by

    -(e / p) (J, B, K - k_g)   from e,    -(c / p) (0, J, B) and a remainder (K - k_g) int theta   from c

before and behind any filter. Only what lies outside the band, such as a resonance of the frame, is removed.

`filter_estimates` applies a filter to all signals of a recorded or simulated trial, to markers before the
pose is found. The belt-induced load is subtracted by a treadmill model behind the same filter, or left in.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.experiments.dummy.foot_pathways import FootOptions, foot_delay, foot_side, windows_from_onset
from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.planning.design import FOOT, LEG, Design, ExpectedMotion, exact_markers
from tepsipe.experiments.planning.window_noise import lowpass_gain
from tepsipe.identification.estimators import LEAST_SQUARES, LEAST_SQUARES_OWN_ZERO, Record, estimate
from tepsipe.identification.regression.windows import regress_torque
from tepsipe.io.trial import Trial
from tepsipe.mechanics.inverse_dynamics import leg_torque
from tepsipe.mechanics.segment_kinematics import (
    SegmentMarkers,
    SegmentMotion,
    marker_positions,
    motion_of_markers,
)
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import Perturbation
from tepsipe.treadmill.compensation import compensated_loads
from tepsipe.treadmill.prepared import prepare_trial
from tepsipe.treadmill.registry import FittedModel
from tepsipe.treadmill.trial_recordings import recordings_of_loads

COMPENSATED = "foot-compensated"
# window of the torque from the foot, as in the study: the subsequent swing determines most of K (s)
FOOT_WINDOW_S = 2.0


def filtered(x: np.ndarray, lowpass: Lowpass, rate_hz: float) -> np.ndarray:
    """A signal, shape (n, ...), behind a filter at rest at its first sample (unit of ``x``)."""
    start = x[:1]
    flat = (x - start).reshape(len(x), -1)
    return lowpass(flat, rate_hz).reshape(x.shape) + start


def filtered_motion(
    time: Annotated[np.ndarray, "(n,)", "s"],
    positions: Annotated[np.ndarray, "(n, all markers, 2 or 3)", "m"],
    labels: list[str],
    markers: SegmentMarkers,
    com_m: float,
    lowpass: Lowpass,
) -> SegmentMotion:
    """Motion of the leg from filtered markers.

    com_m: distance of the centre of mass from the joint.
    Returns: angle and accelerations, late by the delay of the filter.
    """
    rate = (time.size - 1) / (time[-1] - time[0])
    raw = marker_positions(np.asarray(positions, dtype=float), labels, markers)
    return motion_of_markers(time, filtered(raw, lowpass, rate), markers, com_m)


def delay_samples(lowpass: Lowpass, rate_hz: float) -> int:
    """Delay of slow signals behind a filter that runs forwards only (samples); 0 of a zero-lag one."""
    if lowpass.zero_lag:
        return 0
    slow = 1e-3 * lowpass.cutoff_hz
    gain = lowpass_gain(np.array([slow]), rate_hz, lowpass)[0]
    return round(float(-np.angle(gain)) / (2.0 * np.pi * slow) * rate_hz)


def late(windows: list[Perturbation], lowpass: Lowpass, rate_hz: float) -> list[Perturbation]:
    """Windows (samples) delayed like the signals behind a filter that runs forwards only."""
    samples = delay_samples(lowpass, rate_hz)
    return [replace(p, start=p.start + samples, stop=p.stop + samples) for p in windows]


def mismatch_bias(
    design: Design, motion: ExpectedMotion, of_torque: Lowpass | None, of_motion: Lowpass | None
) -> Annotated[np.ndarray, "(3,)"]:
    """Bias of I, B, K due to different filters of torque and motion, without noise.

    of_torque, of_motion: Filters; None for a signal that is not filtered.
    Returns: bias of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
    """
    rate = design.rig.camera_rate_hz
    positions, labels, _ = exact_markers(design, motion)
    # an exact signal has no power above this cutoff
    whole = Lowpass(0.45 * rate, 2, True)
    of_leg = filtered_motion(
        motion.time, positions, labels, design.rig.leg_markers, design.leg.com_m, of_motion or whole
    )
    torque = filtered(motion.simulated.torque, of_torque or whole, rate)
    windows = late(motion.perturbations, of_motion or whole, rate)
    return regress_torque(of_leg, torque, windows, motion.at_rest).mean - design.parameters


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


def lowpasses(
    cutoffs_hz: Sequence[float], zero_lag_orders: Sequence[int], one_sided_orders: Sequence[int]
) -> list[Lowpass]:
    """Every filter of some cutoffs (Hz) and orders: zero-lag ones, then those that run forwards only."""
    kinds = [(order, True) for order in zero_lag_orders] + [(order, False) for order in one_sided_orders]
    return [Lowpass(cutoff, order, zero_lag) for order, zero_lag in kinds for cutoff in cutoffs_hz]
