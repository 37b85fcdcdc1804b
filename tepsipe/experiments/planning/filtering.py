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
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np

from tepsipe.experiments.planning.design import Design, ExpectedMotion, exact_markers
from tepsipe.experiments.planning.window_noise import lowpass_gain
from tepsipe.identification.regression.windows import regress_torque
from tepsipe.mechanics.segment_kinematics import (
    SegmentMarkers,
    SegmentMotion,
    marker_positions,
    motion_of_markers,
)
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import Perturbation


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


def lowpasses(
    cutoffs_hz: Sequence[float], zero_lag_orders: Sequence[int], one_sided_orders: Sequence[int]
) -> list[Lowpass]:
    """Every filter of some cutoffs (Hz) and orders: zero-lag ones, then those that run forwards only."""
    kinds = [(order, True) for order in zero_lag_orders] + [(order, False) for order in one_sided_orders]
    return [Lowpass(cutoff, order, zero_lag) for order, zero_lag in kinds for cutoff in cutoffs_hz]
