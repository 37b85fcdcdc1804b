"""What a low-pass does to I, B, K of recorded or simulated trials, with the torque from leg or foot.

All signals of a trial pass the same filter, markers before the pose is found. The belt-induced load is
subtracted by a treadmill model behind the same filter, or left in.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tepsipe.experiments.dummy.foot_pathways import FootOptions, foot_delay, foot_side, windows_from_onset
from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.planning.filtering import delay_samples, filtered_motion, late
from tepsipe.identification.estimators import LEAST_SQUARES, LEAST_SQUARES_OWN_ZERO, Record, estimate
from tepsipe.io.trial import Trial
from tepsipe.mechanics.inverse_dynamics import foot_torque, leg_torque
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import Perturbation, perturbations_of, rest_samples
from tepsipe.treadmill.compensation import compensated_loads
from tepsipe.treadmill.registry import FittedModel
from tepsipe.treadmill.trial_recordings import COMPONENTS, recordings_of_loads

LEG, FOOT, COMPENSATED = "leg", "foot", "foot-compensated"
# window of the torque from the foot, as in the study: most of K is in the swing that follows (s)
FOOT_WINDOW_S = 2.0


@dataclass(frozen=True)
class FilteredEstimates:
    """I, B, K of one trial behind one filter.

    Attributes
    ----------
    pathway : {"leg", "foot", "foot-compensated"}
        Origin of the torque, and whether the belt-induced load was subtracted (-).
    lowpass : Lowpass
        The filter (Hz).
    parameters : ndarray, shape (windows, 3)
        I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of every window.
    windows_s : list of (float, float)
        Start and end of the windows (s), before the delay of a filter that runs forwards only.
    """

    pathway: str
    lowpass: Lowpass
    parameters: np.ndarray
    windows_s: list[tuple[float, float]]


def filter_estimates(
    trial: Trial,
    name: str,
    dummy: DummyOptions,
    options: FootOptions,
    models: Mapping[str, FittedModel],
    lowpass: Lowpass,
) -> list[FilteredEstimates]:
    """Estimate I, B, K of a trial whose signals all pass one filter.

    Parameters
    ----------
    trial : Trial
        Forces (N), moments (N·m), markers (m) and belt velocity (m/s).
    name : str
        Names the trial in messages.
    dummy, options : DummyOptions, FootOptions
        Choices (units in their names); the filter of ``dummy`` finds the windows.
    models : mapping of str to FittedModel
        Component of the load, Fy or Mx -> treadmill model.
    lowpass : Lowpass
        The filter (Hz).

    Returns
    -------
    list of FilteredEstimates
        Of leg, foot, and foot with the belt-induced load subtracted.

    Raises
    ------
    InputError
        If no perturbation or no rest is found, or a marker or model is missing.
    """
    rate, time = trial.rate_hz, trial.time
    detection = Lowpass(dummy.lowpass_cutoff_hz, dummy.lowpass_order, True)
    windows = perturbations_of(
        detection(trial.values("belt_velocity"), rate), rate, dummy.window, "belt velocity"
    )
    at_rest = rest_samples(time, dummy.window)
    labels = trial.axes["marker"].tolist()
    positions = trial.values("marker_position")
    motion = filtered_motion(time, positions, labels, dummy.leg_markers, dummy.leg.com_m, lowpass)
    own, behind_s = late(windows, lowpass, rate), delay_samples(lowpass, rate) / rate
    torque = leg_torque(dummy.leg, motion.theta, motion.theta_dd, motion.y_dd, motion.z_dd)
    found = [_estimates(LEG, motion, torque, own, at_rest, LEAST_SQUARES, time - behind_s, lowpass)]
    long = windows_from_onset(own, FOOT_WINDOW_S, rate, time.size, name)
    delay = foot_delay(trial, name, options, detection, at_rest)
    side = foot_side(trial, name, options, lowpass, at_rest, motion, delay)
    recordings = recordings_of_loads(
        trial,
        name,
        name,
        lowpass,
        at_rest,
        side.measured,
        dict.fromkeys(COMPONENTS, np.zeros(time.size)),
        options.foot.mass_kg + dummy.leg.mass_kg,
        np.ones(time.size, dtype=bool),
        tuple(p.start for p in windows),
    )
    as_measured = {component: recording.load for component, recording in recordings.items()}
    behind = {component: replace(model, lowpass=lowpass) for component, model in models.items()}
    for pathway, loads in (
        (FOOT, as_measured),
        (COMPENSATED, compensated_loads(behind, recordings)),
    ):
        torque = foot_torque(
            options.foot, loads["Fy"], side.measured["Fz"], loads["Mx"], side.y_a, side.y_a_dd
        )
        found.append(
            _estimates(
                pathway, side.motion, torque, long, at_rest, LEAST_SQUARES_OWN_ZERO, time - behind_s, lowpass
            )
        )
    return found


def _estimates(
    pathway: str,
    motion: SegmentMotion,
    torque: np.ndarray,
    windows: list[Perturbation],
    at_rest: np.ndarray,
    estimator: str,
    time: np.ndarray,
    lowpass: Lowpass,
) -> FilteredEstimates:
    record = Record(motion=motion, torque=torque, perturbations=windows, at_rest=at_rest)
    spans = [(float(time[p.start]), float(time[p.stop - 1])) for p in windows]
    return FilteredEstimates(pathway, lowpass, estimate(estimator, record).parameters, spans)


def lowpasses(
    cutoffs_hz: Sequence[float], zero_lag_orders: Sequence[int], one_sided_orders: Sequence[int]
) -> list[Lowpass]:
    """Every filter of some cutoffs (Hz) and orders (-): zero-lag ones, then those that run forwards only."""
    kinds = [(order, True) for order in zero_lag_orders] + [(order, False) for order in one_sided_orders]
    return [Lowpass(cutoff, order, zero_lag) for order, zero_lag in kinds for cutoff in cutoffs_hz]
