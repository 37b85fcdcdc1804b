"""TEP-SIPE with the torque from the foot: force plate, ankle marker and treadmill models."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Self

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.experiments.dummy.foot_budget import FootKnowledge, foot_budget
from tepsipe.experiments.dummy.foot_treadmill import check_treadmill
from tepsipe.experiments.dummy.leg_pathways import DummyAnalysis, DummyOptions
from tepsipe.identification.estimators import LEAST_SQUARES_OWN_ZERO, Record, estimate
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.io.trial import Trial
from tepsipe.mechanics.inverse_dynamics import Foot, foot_torque, foot_torque_as_printed
from tepsipe.mechanics.segment_kinematics import SegmentMotion, segment_motion
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import Perturbation, perturbations_of, rest_samples
from tepsipe.signals.time_alignment import advanced, marker_delay
from tepsipe.treadmill.compensation import compensated_loads
from tepsipe.treadmill.held_out import HeldOut
from tepsipe.treadmill.registry import FittedModel, pick
from tepsipe.treadmill.trial_recordings import COMPONENTS, measured_load, recordings_of_loads, zero_line

MEASURED = "measured"
FOOT_TORQUES = ("foot-thesis", "foot")


@dataclass(frozen=True)
class FootPathway:
    """One way from force plate and markers to parameters (names, no units).

    Attributes
    ----------
    torque : {"foot-thesis", "foot"}
        Equation of the torque (`tepsipe.mechanics.inverse_dynamics`).
    treadmill_model : str or None
        Model of the belt-induced load that is subtracted from Fy and Mx; None for the loads as measured.
    window_s : float or None
        Length of the fitted windows from the onset of a perturbation (s); None for the perturbation
        itself. A longer window includes the swing of the leg on the resting belt, without belt-induced load.
    estimator : str
        Estimator of the parameters from a torque in windows (`tepsipe.identification.estimators`).
    """

    torque: str
    treadmill_model: str | None
    window_s: float | None
    estimator: str


@dataclass(frozen=True)
class FootOptions:
    """Options of the foot pathways, in addition to those of the leg.

    Attributes
    ----------
    foot : Foot
        The foot (kg, m).
    ankle_label : str
        Marker on the ankle.
    belt_fixed_labels : tuple of str
        Belt-fixed markers, from which the delay of markers relative to forces is estimated.
    belt : str
        The belt on which the dummy stands, left or right.
    held_out : HeldOut or None
        Residuals of trials that the treadmill model has not seen (units there).
    """

    foot: Foot
    ankle_label: str
    belt_fixed_labels: tuple[str, ...]
    belt: str
    held_out: HeldOut | None = None

    @classmethod
    def from_settings(cls, geometry: dict, foot: dict, belt: str, held_out: HeldOut | None = None) -> Self:
        """Options of the constants of the foot (kg, m), ``ankle_label`` and ``belt_fixed_labels``."""
        labels = tuple(foot["belt_fixed_labels"])
        return cls(Foot.from_settings(geometry), foot["ankle_label"], labels, belt, held_out)


def analyse_foot(
    trial: Trial,
    name: str,
    dummy: DummyOptions,
    options: FootOptions,
    pathways: dict[str, FootPathway],
    models: dict[str, dict[str, FittedModel]],
) -> DummyAnalysis:
    """Estimate I, B, K of the ankle dummy from the torque by the foot and the force plate.

    Parameters
    ----------
    trial : Trial
        Forces (N), moments (N·m), markers (m) and belt velocity (m/s).
    name : str
        Names the trial in messages.
    dummy, options : DummyOptions, FootOptions
        Choices (units in their names).
    pathways : dict of str to FootPathway
        Name -> pathway.
    models : dict of str to dict of str to FittedModel
        Component of the load, Fy or Mx -> name -> treadmill model.

    Returns
    -------
    DummyAnalysis
        One regression per pathway, all over the same perturbations.

    Raises
    ------
    InputError
        If no perturbation or no rest is found, a marker or a model is missing, or a pathway is unknown.
    """
    rate, time = trial.rate_hz, trial.time
    lowpass = Lowpass(dummy.lowpass_cutoff_hz, dummy.lowpass_order, True)
    belt_velocity = lowpass(trial.values("belt_velocity"), rate)
    perturbations = perturbations_of(belt_velocity, rate, dummy.window, "belt velocity")
    at_rest = rest_samples(time, dummy.window)
    motion = segment_motion(
        time,
        trial.values("marker_position"),
        dummy.leg_markers,
        dummy.leg.com_m,
        labels=trial.axes["marker"].tolist(),
        cutoff_hz=dummy.lowpass_cutoff_hz,
        order=dummy.lowpass_order,
    )
    delay = foot_delay(trial, name, options, lowpass, at_rest)
    side = foot_side(trial, name, options, lowpass, at_rest, motion, delay)
    motion, measured, y_a, y_a_dd = side.motion, side.measured, side.y_a, side.y_a_dd
    recordings = recordings_of_loads(
        trial,
        name,
        name,
        lowpass,
        at_rest,
        measured,
        dict.fromkeys(COMPONENTS, np.zeros(time.size)),
        options.foot.mass_kg + dummy.leg.mass_kg,
        np.ones(time.size, dtype=bool),
        tuple(p.start for p in perturbations),
    )
    compensated = {}
    for model in dict.fromkeys([None, *(pathway.treadmill_model for pathway in pathways.values())]):
        loads = {component: recording.load for component, recording in recordings.items()}
        if model is not None:
            loads = compensated_loads({c: pick(models[c], model) for c in recordings}, recordings)
        compensated |= {f"{component}/{model or MEASURED}": load for component, load in loads.items()}
    regressions, budgets, checks = {}, {}, {}
    for key, pathway in pathways.items():
        used = pathway.treadmill_model or MEASURED
        loads = {"Fz": measured["Fz"]} | {c: compensated[f"{c}/{used}"] for c in recordings}
        if pathway.torque == "foot":
            torque = foot_torque(options.foot, loads["Fy"], measured["Fz"], loads["Mx"], y_a, y_a_dd)
        elif pathway.torque == "foot-thesis":
            torque = foot_torque_as_printed(options.foot, dummy.leg, loads["Fy"], motion.y_dd)
        else:
            raise InputError(
                f"expected a torque of {', '.join(FOOT_TORQUES)}, found {pathway.torque!r}: "
                "correct its torque in dummy.foot.pathways"
            )
        windows = windows_from_onset(perturbations, pathway.window_s, rate, time.size, name)
        by = partial(_by, pathway.estimator, windows, at_rest)
        regressions[key] = by(motion, torque)
        # of the thesis's equation no uncertainty of its inputs is to be stated
        sources = dummy.sources if pathway.torque == "foot" else {}
        budgets[key] = foot_budget(
            regressions[key],
            lambda motion, torque, by=by: by(motion, torque).mean,
            motion,
            torque,
            FootKnowledge(options.foot, loads, y_a, y_a_dd, sources),
        )
        if pathway.treadmill_model is not None and pathway.torque == "foot":
            checks[key] = check_treadmill(
                {c: pick(models[c], pathway.treadmill_model) for c in recordings},
                recordings,
                regressions[key],
                options.foot.height_m,
                options.held_out,
                pathway.estimator == LEAST_SQUARES_OWN_ZERO,
            )
            budgets[key] = replace(
                budgets[key],
                contributions=budgets[key].contributions | (checks[key].contributions if sources else {}),
            )
    return DummyAnalysis(
        time=time,
        belt_velocity=belt_velocity,
        belt_command=trial.optional("belt_command"),
        regressions=regressions,
        pathways=pathways,
        budgets=budgets,
        small_budgets={},
        damping_per_skew={},
        marker_residual_rms_m=motion.marker_residual_rms_m,
        marker_noise_m=0.0,
        loads=compensated,
        checks=checks,
    )


def _by(
    estimator: str,
    windows: list[Perturbation],
    at_rest: np.ndarray,
    motion: SegmentMotion,
    torque: np.ndarray,
) -> WindowedFits:
    """Estimates from a motion (s, rad) and a torque (N·m) in windows (samples)."""
    return estimate(estimator, Record(motion=motion, torque=torque, perturbations=windows, at_rest=at_rest))


@dataclass(frozen=True)
class FootSide:
    """Signals of a trial for the torque from the foot, on the clock of the force plate.

    Attributes
    ----------
    motion : SegmentMotion
        Motion of the leg (s, rad, m).
    measured : dict of str to ndarray
        Fy, Fz (N) and Mx (N·m) as measured, each of shape (n,).
    y_a, y_a_dd : ndarray, shape (n,)
        Position of the ankle on the plate (m) and its acceleration (m/s²).
    """

    motion: SegmentMotion
    measured: dict[str, np.ndarray]
    y_a: np.ndarray
    y_a_dd: np.ndarray


def foot_delay(
    trial: Trial, name: str, options: FootOptions, lowpass: Callable, at_rest: np.ndarray
) -> float:
    """Time by which markers lag behind the treadmill's own signals (s).

    Arguments are those of `foot_side`.

    Raises
    ------
    InputError
        If a marker is missing, or the belt-fixed markers do not follow the belt.
    """
    rate, time = trial.rate_hz, trial.time
    labels = trial.axes["marker"].tolist()
    for label in (options.ankle_label, *options.belt_fixed_labels):
        if label not in labels:
            raise InputError(
                f"{name}: expected a marker named {label!r} on the foot, found {listed(labels)}: "
                "correct dummy.foot.ankle_label and belt_fixed_labels"
            )
    velocity = zero_line(lowpass(trial.values("belt_velocity"), rate), time, at_rest)
    along = lowpass(trial.values("marker_position")[:, :, 1].astype(float), rate)
    riding = along[:, [labels.index(label) for label in options.belt_fixed_labels]].mean(axis=1)
    return marker_delay(time, riding, velocity, name)


def foot_side(
    trial: Trial,
    name: str,
    options: FootOptions,
    lowpass: Callable,
    at_rest: np.ndarray,
    motion: SegmentMotion,
    delay_s: float,
) -> FootSide:
    """Loads and motions for the torque from the foot.

    Parameters
    ----------
    trial : Trial
        Forces (N), moments (N·m) and markers (m).
    name : str
        Names the trial in messages.
    options : FootOptions
        Choices (units in their names).
    lowpass : callable
        Filters a signal, given with its rate (Hz).
    at_rest : ndarray of bool, shape (n,)
        Samples at rest (-).
    motion : SegmentMotion
        Filtered motion of the leg on the clock of the markers (s, rad, m).
    delay_s : float
        Time by which markers lag behind forces (s).

    Returns
    -------
    FootSide
        Filtered, on the force plate's clock.

    Raises
    ------
    InputError
        If the belt is not in the trial.
    """
    time, labels = trial.time, trial.axes["marker"].tolist()
    motion = replace(
        motion,
        **{
            key: advanced(time, getattr(motion, key), delay_s)
            for key in ("theta", "theta_d", "theta_dd", "y_dd", "z_dd")
        },
    )
    along = lowpass(trial.values("marker_position")[:, :, 1].astype(float), trial.rate_hz)
    ankle = advanced(time, along[:, labels.index(options.ankle_label)], delay_s)
    # the belt creeps: a line through rest that is subtracted from Mx must be subtracted from y_A, too
    y_a = zero_line(ankle, time, at_rest) + ankle[at_rest].mean()
    return FootSide(
        motion=motion,
        measured=measured_load(trial, name, options.belt, lowpass, at_rest),
        y_a=y_a,
        y_a_dd=derivative(time, derivative(time, y_a)),
    )


def windows_from_onset(
    perturbations: list[Perturbation], window_s: float | None, rate_hz: float, samples: int, name: str
) -> list[Perturbation]:
    """Windows to fit: the perturbations themselves, or windows of equal length from their onsets.

    Parameters
    ----------
    perturbations : list of Perturbation
        Their positions (samples).
    window_s : float or None
        Length of the windows (s); None for the perturbations themselves.
    rate_hz : float
        Sampling rate (Hz).
    samples : int
        Length of the trial (samples).
    name : str
        Names the trial in messages.

    Returns
    -------
    list of Perturbation
        The windows (samples).

    Raises
    ------
    InputError
        If a window reaches into the next perturbation or beyond the end.
    """
    if window_s is None:
        return perturbations
    windows = [replace(p, stop=p.start + round(window_s * rate_hz)) for p in perturbations]
    starts = [*(p.start for p in perturbations[1:]), samples]
    if any(window.stop > start for window, start in zip(windows, starts, strict=True)):
        raise InputError(
            f"{name}: expected {window_s:g} s from the onset of every perturbation to the next, found less: "
            "shorten window_s of the pathway in the configuration"
        )
    return windows
