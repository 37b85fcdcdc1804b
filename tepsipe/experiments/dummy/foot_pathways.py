"""TEP-SIPE with the torque from the foot: force plate, ankle marker and treadmill models."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.experiments.dummy.foot_budget import FootKnowledge, foot_budget
from tepsipe.experiments.dummy.foot_treadmill import TreadmillCheck, check_treadmill
from tepsipe.experiments.dummy.leg_pathways import DummyAnalysis, DummyOptions, leg_motion
from tepsipe.experiments.dummy.options import FootPathway
from tepsipe.identification.estimators import LEAST_SQUARES_OWN_ZERO, Record, estimate
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.identification.result import quantities_of
from tepsipe.io.trial import Trial, recorded_faults
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.inverse_dynamics import Foot, Leg, foot_torque, foot_torque_as_printed
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.perturbations import Perturbation
from tepsipe.signals.sample_faults import flags_of
from tepsipe.signals.time_alignment import advanced, marker_delay
from tepsipe.statistics.uncertainty import Budget
from tepsipe.treadmill.compensation import compensated_loads
from tepsipe.treadmill.held_out import HeldOut
from tepsipe.treadmill.plate_check import calibration_fault, calibration_of
from tepsipe.treadmill.prepared import PreparedTrial, prepare_trial
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FittedModel, pick
from tepsipe.treadmill.trial_recordings import recordings_of_loads

MEASURED = "measured"
FOOT_TORQUES = ("foot-thesis", "foot")


@dataclass(frozen=True)
class FootOptions:
    """Options of the foot pathways, in addition to the leg's."""

    foot: Foot
    """The foot (kg, m)."""
    ankle_label: str
    belt_fixed_labels: tuple[str, ...]
    """Belt-fixed markers, from which the delay of markers relative to forces is estimated."""
    belt: str
    """The belt on which the dummy stands, left or right."""
    held_out: HeldOut | None = None
    """Residuals of trials that the treadmill model has not seen."""

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

    trial: forces, moments, markers and belt velocity.
    name: names the trial in messages.
    pathways: name -> pathway.
    models: component of the load, Fy or Mx -> name -> treadmill model.
    Returns: one regression per pathway, all over the same perturbations.
    """
    prepared = prepare_trial(trial, name, dummy.lowpass, dummy.window)
    delay_s = foot_delay(prepared, options)
    side = foot_side(prepared, options, leg_motion(prepared, dummy, "aligned"), delay_s)
    mass_kg = options.foot.mass_kg + dummy.leg.mass_kg
    recordings = recordings_of_loads(prepared, side.measured, mass_kg)
    on_plate = _OnPlate(prepared, dummy, options, side, recordings, models)
    loads = {None: {component: recording.load for component, recording in recordings.items()}}
    for model in dict.fromkeys(p.treadmill_model for p in pathways.values() if p.treadmill_model):
        loads[model] = compensated_loads(on_plate.chosen(model), recordings)
    regressions, budgets, checks = {}, {}, {}
    for key, pathway in pathways.items():
        used = side.measured | loads[pathway.treadmill_model]
        torque = side.torque(pathway.torque, options.foot, dummy.leg, used)
        fit = regressions[key] = on_plate.fit(pathway, torque)
        budgets[key] = on_plate.budget(pathway, torque, fit, used)
        if pathway.treadmill_model is not None and pathway.torque == "foot":
            check = checks[key] = on_plate.check(pathway, fit)
            if dummy.sources:
                contributions = budgets[key].contributions | check.contributions
                budgets[key] = replace(budgets[key], contributions=contributions)
    return DummyAnalysis(
        time=prepared.time,
        belt_velocity=prepared.belt_velocity,
        belt_command=trial.optional("belt_command"),
        regressions=regressions,
        pathways=pathways,
        budgets=budgets,
        quantities={
            key: quantities_of(dict(zip(PARAMETERS, fit.mean, strict=True)), budgets[key])
            for key, fit in regressions.items()
        },
        damping_per_com_lag={},
        marker_residual_rms_m=side.motion.marker_residual_rms_m,
        layout_scale=side.motion.layout_scale,
        marker_noise_m=0.0,
        loads={
            f"{component}/{model or MEASURED}": load
            for model, components in loads.items()
            for component, load in components.items()
        },
        checks=checks,
        flags=_faults_on_plate(prepared, options),
    )


@dataclass(frozen=True)
class FootSide:
    """Signals of a trial for the torque from the foot, on the clock of the force plate."""

    motion: SegmentMotion
    """Motion of the leg (s, rad, m)."""
    measured: dict[str, np.ndarray]
    """Fy, Fz (N) and Mx (N·m) as measured, each of shape (n,)."""
    y_a: np.ndarray
    y_a_dd: np.ndarray
    """Position of the ankle on the plate (m) and its acceleration (m/s²)."""

    def torque(self, equation: str, foot: Foot, leg: Leg, loads: dict[str, np.ndarray]) -> np.ndarray:
        """Torque of the joint on the leg (N·m), shape (n,), by one of `FOOT_TORQUES`.

        ``loads`` are Fy (N) and Mx (N·m), as measured or compensated.
        """
        if equation == "foot":
            return foot_torque(foot, loads["Fy"], self.measured["Fz"], loads["Mx"], self.y_a, self.y_a_dd)
        if equation == "foot-thesis":
            return foot_torque_as_printed(foot, leg, loads["Fy"], self.motion.y_dd)
        raise InputError(
            f"expected a torque of {', '.join(FOOT_TORQUES)}, found {equation!r}: "
            "correct its torque in dummy.foot.pathways"
        )


def _faults_on_plate(prepared: PreparedTrial, options: FootOptions) -> tuple[str, ...]:
    """Faults of loads and ankle marker as recorded, and of the calibration of the plate.

    Names in `tepsipe.flags.FLAGS`.
    """
    weights = None if options.held_out is None else options.held_out.calibration
    differs = calibration_fault(weights, calibration_of(prepared.trial, options.belt))
    signals = prepared.as_recorded([options.belt], [options.ankle_label])
    faults = flags_of(prepared.rate_hz, prepared.at_rest, **signals) + recorded_faults(prepared.trial)
    return tuple(dict.fromkeys(faults + differs))


def foot_delay(prepared: PreparedTrial, options: FootOptions) -> float:
    """Time by which markers lag behind the treadmill's own signals (s).

    Takes the arguments of `foot_side`.
    """
    labels = prepared.markers
    for label in (options.ankle_label, *options.belt_fixed_labels):
        if label not in labels:
            raise InputError(
                f"{prepared.name}: expected a marker named {label!r} on the foot, found {listed(labels)}: "
                "correct dummy.foot.ankle_label and belt_fixed_labels"
            )
    along = _along_belt(prepared)
    riding = along[:, [labels.index(label) for label in options.belt_fixed_labels]].mean(axis=1)
    velocity = prepared.from_rest(prepared.belt_velocity)
    return marker_delay(prepared.time, riding, velocity, prepared.name)


def _along_belt(prepared: PreparedTrial) -> np.ndarray:
    """Filtered positions of all markers along the belt (m), shape (n, markers)."""
    return prepared.filtered(prepared.trial.values("marker_position")[:, :, 1].astype(float))


def foot_side(
    prepared: PreparedTrial, options: FootOptions, motion: SegmentMotion, delay_s: float
) -> FootSide:
    """Loads and motions for the torque from the foot.

    prepared: forces, moments and markers.
    motion: filtered motion of the leg on the clock of the markers.
    delay_s: time by which markers lag behind forces.
    Returns: filtered, on the force plate's clock.
    """
    time, at_rest = prepared.time, prepared.at_rest
    advanced_signals = ("theta", "theta_d", "theta_dd", "y_dd", "z_dd")
    motion = replace(
        motion, **{key: advanced(time, getattr(motion, key), delay_s) for key in advanced_signals}
    )
    ankle = _along_belt(prepared)[:, prepared.markers.index(options.ankle_label)]
    ankle = advanced(time, ankle, delay_s)
    # the belt creeps: y_A is referred to the same line through rest as Mx
    y_a = prepared.from_rest(ankle) + ankle[at_rest].mean()
    return FootSide(
        motion=motion,
        measured=prepared.load_from_rest(options.belt),
        y_a=y_a,
        y_a_dd=derivative(time, derivative(time, y_a)),
    )


@dataclass(frozen=True)
class _OnPlate:
    """Signals and settings of one trial that its pathways share."""

    prepared: PreparedTrial
    dummy: DummyOptions
    options: FootOptions
    side: FootSide
    recordings: dict[str, BeltRecording]
    models: dict[str, dict[str, FittedModel]]

    def chosen(self, model: str) -> dict[str, FittedModel]:
        """Component of the load -> treadmill model of this name."""
        return {component: pick(self.models[component], model) for component in self.recordings}

    def fit(self, pathway: FootPathway, torque: np.ndarray) -> WindowedFits:
        """Estimates of I, B, K from a torque (N·m)."""
        return self._estimates(pathway, self.side.motion, torque)

    def _estimates(self, pathway: FootPathway, motion: SegmentMotion, torque: np.ndarray) -> WindowedFits:
        windows = windows_from_onset(self.prepared, pathway.window_s)
        record = Record(motion=motion, torque=torque, perturbations=windows, at_rest=self.prepared.at_rest)
        return estimate(pathway.estimator, record)

    def budget(
        self, pathway: FootPathway, torque: np.ndarray, fit: WindowedFits, loads: dict[str, np.ndarray]
    ) -> Budget:
        """Uncertainty of the means of I, B, K from a torque (N·m) of some loads (N, N·m)."""
        # the thesis's equation is wrong, so only its Type A is stated
        sources = self.dummy.sources if pathway.torque == "foot" else {}
        known = FootKnowledge(self.options.foot, loads, self.side.y_a, self.side.y_a_dd, sources)
        return foot_budget(
            fit,
            lambda motion, torque: self._estimates(pathway, motion, torque).mean,
            self.side.motion,
            torque,
            known,
        )

    def check(self, pathway: FootPathway, fit: WindowedFits) -> TreadmillCheck:
        """Examination of the treadmill model of a pathway."""
        return check_treadmill(
            self.chosen(pathway.treadmill_model),
            self.recordings,
            fit,
            self.options.foot.height_m,
            self.options.held_out,
            pathway.estimator == LEAST_SQUARES_OWN_ZERO,
        )


def windows_from_onset(prepared: PreparedTrial, window_s: float | None) -> list[Perturbation]:
    """Windows to fit: the perturbations themselves, or windows of equal length from their onsets.

    window_s: length of the windows (s); None for the perturbations themselves.
    """
    perturbations = prepared.perturbations
    if window_s is None:
        return perturbations
    windows = [replace(p, stop=p.start + round(window_s * prepared.rate_hz)) for p in perturbations]
    starts = [*(p.start for p in perturbations[1:]), prepared.time.size]
    if any(window.stop > start for window, start in zip(windows, starts, strict=True)):
        raise InputError(
            f"{prepared.name}: expected {window_s:g} s from the onset of every perturbation to the next, "
            "found less: shorten window_s of the pathway in the configuration"
        )
    return windows
