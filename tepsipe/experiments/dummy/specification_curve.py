"""Specification curve: one trial by every combination of the choices of the thesis (Appendix A).

A specification is one combination of choices for the estimation of I, B, K:

    torque      equation of the torque: leg-thesis, leg, foot-thesis, foot (`inverse_dynamics`)
    filter      low-pass: that of the study, forwards only, with another cutoff, none
    filtered    filtered signals: all; the torque only; the motion only, from which the regressors follow
    reference   angle and torque at rest: from the first and last rest, or from just before each perturbation
    window      the length of the command, the actual length, or longer
    estimator   windowed-least-squares-thesis, windowed-least-squares, output-error

Output error uses neither torque nor windows, always one angle at rest, and one filter for all signals.
All estimates come from the functions that the pathways of the study use.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tepsipe.experiments.dummy.foot_pathways import FootOptions, foot_delay, foot_side, windows_from_onset
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, Pathway, belt_fixed_position
from tepsipe.identification.estimators import (
    LEAST_SQUARES,
    LEAST_SQUARES_THESIS,
    OUTPUT_ERROR,
    Record,
    estimate,
)
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.io.tables import Table
from tepsipe.io.trial import Trial
from tepsipe.mechanics.inverse_dynamics import TORQUE_PATHWAYS, foot_torque, foot_torque_as_printed
from tepsipe.mechanics.segment_kinematics import SegmentMotion, marker_positions, motion_of_markers
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import Perturbation, perturbations_of, rest_samples

CHOICES = ("torque", "filter", "filtered", "reference", "window", "estimator")
TORQUES = ("leg-thesis", "leg", "foot-thesis", "foot")
FILTERED = ("all signals", "torque only", "motion only")
REFERENCES = ("first and last rest", "per segment")
WINDOWS = ("command length", "actual length", "longer")
NONE, WHOLE_TRIAL = "none", "whole trial"
AS_PRINTED, RECOMMENDED, OTHER = "as printed", "recommended", ""


@dataclass(frozen=True)
class SpecificationOptions:
    """Options of the combinations, in addition to those of the study.

    Attributes
    ----------
    other_cutoff_hz : float
        Cutoff of the alternative filter (Hz).
    command_s, longer_s : float
        Lengths of the windows from the onset: that of the command, and longer than the perturbation (s).
    before_segment_s : float
        Time before the onset that counts as rest of a perturbation (s).
    """

    other_cutoff_hz: float
    command_s: float
    longer_s: float
    before_segment_s: float


@dataclass(frozen=True)
class Specification:
    """Estimates by one combination of choices.

    Attributes
    ----------
    condition : str
        Name of the condition.
    torque, filter, filtered, reference, window, estimator : str
        The choices.
    role : str
        as printed, recommended, or empty.
    I_Nms2_per_rad, B_Nms_per_rad, K_Nm_per_rad : float
        Means over perturbations (units in the names).
    VAF_percent : float
        Mean VAF of the torque over perturbations (%).
    """

    condition: str
    torque: str
    filter: str
    filtered: str
    reference: str
    window: str
    estimator: str
    role: str
    I_Nms2_per_rad: float
    B_Nms_per_rad: float
    K_Nm_per_rad: float
    VAF_percent: float

    @property
    def choices(self) -> tuple[str, ...]:
        """Values of `CHOICES` (no unit)."""
        return tuple(getattr(self, choice) for choice in CHOICES)


SPECIFICATIONS = Table(Specification, "a specification")


@dataclass(frozen=True)
class _Signals:
    """Motion (rad, m) and torques (N·m) with one filter, for leg and foot, each on its own clock."""

    motions: dict[str, SegmentMotion]
    torques: dict[str, np.ndarray]


def unfiltered(x: np.ndarray, rate_hz: float) -> np.ndarray:
    """``x`` unchanged (any unit), at any rate (Hz)."""
    return x


@dataclass(frozen=True)
class Forwards:
    """A forward-only low-pass, initialised in the steady state of the first sample."""

    lowpass: Lowpass

    def __call__(self, x: np.ndarray, rate_hz: float) -> np.ndarray:
        """Filter ``x`` along its first axis, sampled at ``rate_hz`` (Hz); unit of ``x``."""
        return self.lowpass(x - x[0], rate_hz) + x[0]


def filters(dummy: DummyOptions, options: SpecificationOptions) -> dict[str, Callable]:
    """Name -> filter, the study's first (cutoffs in Hz)."""
    cutoff, order = dummy.lowpass_cutoff_hz, dummy.lowpass_order
    return {
        f"bidirectional {cutoff:g} Hz": Lowpass(cutoff, order, True),
        f"unidirectional {cutoff:g} Hz": Forwards(Lowpass(cutoff, order, False)),
        f"bidirectional {options.other_cutoff_hz:g} Hz": Lowpass(options.other_cutoff_hz, order, True),
        NONE: unfiltered,
    }


def specify_dummy(
    trial: Trial,
    condition: str,
    dummy: DummyOptions,
    foot: FootOptions,
    options: SpecificationOptions,
    as_printed: Pathway,
    recommended: Pathway,
) -> list[Specification]:
    """Estimate I, B, K of one trial by every combination of choices.

    Parameters
    ----------
    trial : Trial
        Forces (N), moments (N·m), markers (m) and belt velocity (m/s).
    condition : str
        Name of the condition.
    dummy, foot, options : DummyOptions, FootOptions, SpecificationOptions
        Choices (units in their names).
    as_printed, recommended : Pathway
        Pathways of the study; their combinations get a role.

    Returns
    -------
    list of Specification
        Sorted by K (N·m/rad).

    Raises
    ------
    InputError
        If no perturbation or no rest is found, a marker is missing, a window reaches into the next
        perturbation, or a combination does not determine the parameters.
    """
    rate, name = trial.rate_hz, f"dummy/{condition}"
    known = filters(dummy, options)
    standard = next(iter(known))
    velocity = known[standard](trial.values("belt_velocity"), rate)
    perturbations = perturbations_of(velocity, rate, dummy.window, "belt velocity")
    at_rest = rest_samples(trial.time, dummy.window)
    delay = foot_delay(trial, name, foot, known[standard], at_rest)
    signals = {key: _signals(trial, name, dummy, foot, x, at_rest, delay) for key, x in known.items()}
    windows = {
        kind: windows_from_onset(perturbations, length, rate, trial.time.size, name)
        for kind, length in zip(WINDOWS, (options.command_s, None, options.longer_s), strict=True)
    }
    before = round(options.before_segment_s * rate)
    rows = []

    def add(choices: tuple[str, ...], regression: WindowedFits) -> None:
        rows.append(
            Specification(
                condition,
                *choices,
                _role(choices, standard, as_printed, recommended),
                *map(float, regression.mean),
                float(regression.vaf_per_perturbation.mean()),
            )
        )

    for torque in TORQUES:
        side = torque.partition("-")[0]
        for key, lowpass in known.items():
            for filtered in FILTERED if key != NONE else (NONE,):
                of_motion = signals[NONE if filtered == "torque only" else key]
                of_torque = signals[key if filtered in (FILTERED[0], NONE) else NONE]
                motion, values = of_motion.motions[side], of_torque.torques[torque]
                if filtered == "torque only":
                    values = lowpass(values, rate)
                for window, chosen in windows.items():
                    for estimator in (LEAST_SQUARES_THESIS, LEAST_SQUARES):
                        for reference in REFERENCES:
                            rest = at_rest if reference == REFERENCES[0] else before
                            regression = _regress(motion, values, chosen, rest, estimator)
                            add((torque, key, filtered, reference, window, estimator), regression)
    position = belt_fixed_position(trial, dummy.belt_fixed_labels, "aligned")
    for key, lowpass in known.items():
        record = Record(
            motion=signals[key].motions["leg"],
            foot_position=lowpass(position, rate),
            belt_velocity=lowpass(trial.values("belt_velocity"), rate),
            leg=dummy.leg,
            perturbations=perturbations,
            at_rest=at_rest,
        )
        filtered = NONE if key == NONE else FILTERED[0]
        add((NONE, key, filtered, REFERENCES[0], WHOLE_TRIAL, OUTPUT_ERROR), estimate(OUTPUT_ERROR, record))
    return sorted(rows, key=lambda row: (row.K_Nm_per_rad, row.choices))


def _signals(
    trial: Trial,
    name: str,
    dummy: DummyOptions,
    foot: FootOptions,
    lowpass: Callable,
    at_rest: np.ndarray,
    delay_s: float,
) -> _Signals:
    """Motion and torques with all signals filtered."""
    leg, labels = dummy.leg, trial.axes["marker"].tolist()
    on_leg = marker_positions(trial.values("marker_position"), labels, dummy.leg_markers)
    motion = motion_of_markers(trial.time, lowpass(on_leg, trial.rate_hz), dummy.leg_markers, leg.com_m)
    torques = {
        key: derive(leg, motion.theta, motion.theta_dd, motion.y_dd, motion.z_dd)
        for key, derive in TORQUE_PATHWAYS.items()
    }
    side = foot_side(trial, name, foot, lowpass, at_rest, motion, delay_s)
    load = side.measured
    torques["foot"] = foot_torque(foot.foot, load["Fy"], load["Fz"], load["Mx"], side.y_a, side.y_a_dd)
    torques["foot-thesis"] = foot_torque_as_printed(foot.foot, leg, load["Fy"], side.motion.y_dd)
    return _Signals({"leg": motion, "foot": side.motion}, torques)


def _regress(
    motion: SegmentMotion,
    torque: np.ndarray,
    windows: list[Perturbation],
    rest: np.ndarray | int,
    estimator: str,
) -> WindowedFits:
    """Windowed least squares with one rest (samples at rest), or one per perturbation (samples before it)."""
    if not isinstance(rest, int):
        return estimate(estimator, Record(motion=motion, torque=torque, perturbations=windows, at_rest=rest))
    alone = []
    for window in windows:
        # only the part of the trial that one perturbation needs
        part = slice(window.start - rest, window.stop)
        cut = replace(
            motion,
            **{
                key: getattr(motion, key)[part]
                for key in ("time", "theta", "theta_d", "theta_dd", "y_dd", "z_dd")
            },
        )
        placed = replace(window, start=rest, stop=rest + window.stop - window.start)
        before = np.arange(cut.time.size) < rest
        one = Record(motion=cut, torque=torque[part], perturbations=[placed], at_rest=before)
        alone.append(estimate(estimator, one))
    joined = {
        key: np.concatenate([getattr(found, key)[rest:] for found in alone])
        for key in ("torque", "predicted", "regressors")
    }
    stops = np.cumsum([0, *(w.stop - w.start for w in windows)])
    return WindowedFits(
        perturbations=[
            replace(w, start=int(a), stop=int(b))
            for w, a, b in zip(windows, stops[:-1], stops[1:], strict=True)
        ],
        fits=[found.fits[0] for found in alone],
        theta_rest_rad=float(np.mean([found.theta_rest_rad for found in alone])),
        torque_rest_Nm=float(np.mean([found.torque_rest_Nm for found in alone])),
        **joined,
    )


def _role(choices: tuple[str, ...], standard: str, as_printed: Pathway, recommended: Pathway) -> str:
    for role, pathway in ((AS_PRINTED, as_printed), (RECOMMENDED, recommended)):
        own = (pathway.torque, standard, FILTERED[0], REFERENCES[0], WINDOWS[1], pathway.estimator)
        if choices == own and pathway.marker_instants == "aligned":
            return role
    return OTHER
