"""Specification curve: one trial by every combination of the choices of the thesis (Appendix A).

A specification is one combination of choices for the estimation of I, B, K:

    torque      equation of the torque: leg-thesis, leg, foot-thesis, foot (`inverse_dynamics`)
    filter      low-pass: as in the study, forwards only, other cutoff, order counted in each pass, none
    filtered    filtered signals: all; the torque only; the motion only, from which the regressors follow
    reference   angle and torque at rest: from the first and last rest, or from just before each perturbation
    window      the length of the command, the actual length, or longer
    estimator   windowed-least-squares-thesis, windowed-least-squares, output-error

Output error uses neither torque nor windows, always one angle at rest, and one filter for all signals.
All estimates come from the functions that the pathways of the study use.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from tepsipe.experiments.dummy.foot_pathways import (
    FOOT_TORQUES,
    FootOptions,
    foot_delay,
    foot_side,
    windows_from_onset,
)
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, belt_fixed_position, leg_motion
from tepsipe.experiments.dummy.options import Pathway, SpecificationOptions
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
from tepsipe.mechanics.inverse_dynamics import TORQUE_PATHWAYS
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import Perturbation
from tepsipe.treadmill.prepared import Filter, PreparedTrial, prepare_trial

CHOICES = ("torque", "filter", "filtered", "reference", "window", "estimator")
TORQUES = ("leg-thesis", "leg", *FOOT_TORQUES)
FILTERED = ALL_SIGNALS, TORQUE_ONLY, MOTION_ONLY = ("all signals", "torque only", "motion only")
REFERENCES = ("first and last rest", "per segment")
WINDOWS = ("command length", "actual length", "longer")
NONE, WHOLE_TRIAL = "none", "whole trial"
AS_PRINTED, RECOMMENDED, OTHER = "as printed", "recommended", ""


@dataclass(frozen=True)
class Specification:
    """Estimates by one combination of choices."""

    condition: str
    torque: str
    filter: str
    filtered: str
    reference: str
    window: str
    estimator: str
    """The choices."""
    role: str
    """as printed, recommended, or empty."""
    I_Nms2_per_rad: float
    B_Nms_per_rad: float
    K_Nm_per_rad: float
    """Means over perturbations."""
    VAF_percent: float
    """Mean VAF of the torque over perturbations."""

    @property
    def choices(self) -> tuple[str, ...]:
        """Values of `CHOICES`."""
        return tuple(getattr(self, choice) for choice in CHOICES)


SPECIFICATIONS = Table(Specification, "a specification")


def unfiltered(x: np.ndarray, rate_hz: float) -> np.ndarray:
    """``x`` unchanged, at any rate (Hz)."""
    return x


@dataclass(frozen=True)
class Forwards:
    """A forward-only low-pass, initialised in the steady state of the first sample."""

    lowpass: Lowpass

    def __call__(self, x: np.ndarray, rate_hz: float) -> np.ndarray:
        """Filter ``x`` along its first axis, sampled at ``rate_hz`` (Hz); unit of ``x``."""
        return self.lowpass(x - x[0], rate_hz) + x[0]


def filters(dummy: DummyOptions, options: SpecificationOptions) -> dict[str, Filter]:
    """Name -> filter, the study's first (cutoffs in Hz).

    "4th order bidirectional" may count both passes, as in the study, or each of them: twice the order.
    """
    cutoff, order = dummy.lowpass_cutoff_hz, dummy.lowpass_order
    return {
        f"bidirectional {cutoff:g} Hz": dummy.lowpass,
        f"unidirectional {cutoff:g} Hz": Forwards(Lowpass(cutoff, order, False)),
        f"bidirectional {options.other_cutoff_hz:g} Hz": Lowpass(options.other_cutoff_hz, order, True),
        f"bidirectional {cutoff:g} Hz, order {2 * order}": Lowpass(cutoff, 2 * order, True),
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

    trial: forces, moments, markers and belt velocity.
    as_printed, recommended: pathways of the study; their combinations get a role.
    """
    known = filters(dummy, options)
    standard = next(iter(known))
    prepared = prepare_trial(trial, f"dummy/{condition}", dummy.lowpass, dummy.window)
    delay_s = foot_delay(prepared, foot)
    signals = {
        key: _signals(prepared.behind(lowpass), dummy, foot, delay_s) for key, lowpass in known.items()
    }
    fits_by_choice = [*_by_torque(prepared, signals, options), *_by_angle(prepared, signals, dummy)]
    rows = [
        Specification(
            condition,
            *choices,
            _role(choices, standard, as_printed, recommended),
            *map(float, fits.mean),
            float(fits.vaf_per_perturbation.mean()),
        )
        for choices, fits in fits_by_choice
    ]
    return sorted(rows, key=lambda row: (row.K_Nm_per_rad, row.choices))


@dataclass(frozen=True)
class _Signals:
    """A trial behind one filter: motion (rad, m) of the leg by side, torques (N·m) by their equation.

    The sides are leg and foot, each on its own clock.
    """

    prepared: PreparedTrial
    motions: dict[str, SegmentMotion]
    torques: dict[str, np.ndarray]


def _signals(prepared: PreparedTrial, dummy: DummyOptions, foot: FootOptions, delay_s: float) -> _Signals:
    """Motion and torques with all signals filtered."""
    motion = leg_motion(prepared, dummy, "aligned")
    side = foot_side(prepared, foot, motion, delay_s)
    torques = {
        key: derive(dummy.leg, motion.theta, motion.theta_dd, motion.y_dd, motion.z_dd)
        for key, derive in TORQUE_PATHWAYS.items()
    } | {key: side.torque(key, foot.foot, dummy.leg, side.measured) for key in FOOT_TORQUES}
    return _Signals(prepared, {"leg": motion, "foot": side.motion}, torques)


def _by_torque(
    prepared: PreparedTrial, signals: dict[str, _Signals], options: SpecificationOptions
) -> Iterator[tuple[tuple[str, ...], WindowedFits]]:
    """Choices and estimates by least squares of a torque."""
    lengths_s = (options.command_s, None, options.longer_s)
    windows = {
        kind: windows_from_onset(prepared, length_s)
        for kind, length_s in zip(WINDOWS, lengths_s, strict=True)
    }
    before = round(options.before_segment_s * prepared.rate_hz)
    rests = dict(zip(REFERENCES, (prepared.at_rest, before), strict=True))
    for torque, (key, filtered) in product(TORQUES, _filtered_signals(signals)):
        motion, values = _of_filtered(signals, torque, key, filtered)
        for window, estimator, reference in product(windows, (LEAST_SQUARES_THESIS, LEAST_SQUARES), rests):
            fits = _regress(motion, values, windows[window], rests[reference], estimator)
            yield (torque, key, filtered, reference, window, estimator), fits


def _filtered_signals(signals: dict[str, _Signals]) -> Iterator[tuple[str, str]]:
    """Every filter with every choice of the signals that pass it."""
    for key in signals:
        for filtered in FILTERED if key != NONE else (NONE,):
            yield key, filtered


def _of_filtered(
    signals: dict[str, _Signals], torque: str, key: str, filtered: str
) -> tuple[SegmentMotion, np.ndarray]:
    """Motion and torque (N·m); only the signals named by ``filtered`` pass the filter."""
    only_torque, only_motion = filtered == TORQUE_ONLY, filtered == MOTION_ONLY
    motion = signals[NONE if only_torque else key].motions[torque.partition("-")[0]]
    if only_torque:
        return motion, signals[key].prepared.filtered(signals[NONE].torques[torque])
    return motion, signals[NONE if only_motion else key].torques[torque]


def _by_angle(
    prepared: PreparedTrial, signals: dict[str, _Signals], dummy: DummyOptions
) -> Iterator[tuple[tuple[str, ...], WindowedFits]]:
    """Choices and estimates by output error, which uses neither torque nor windows."""
    position = belt_fixed_position(prepared.trial, dummy.belt_fixed_labels, "aligned")
    for key, of_filter in signals.items():
        record = Record(
            motion=of_filter.motions["leg"],
            foot_position=of_filter.prepared.filtered(position),
            belt_velocity=of_filter.prepared.belt_velocity,
            leg=dummy.leg,
            perturbations=prepared.perturbations,
            at_rest=prepared.at_rest,
        )
        filtered = NONE if key == NONE else ALL_SIGNALS
        choices = (NONE, key, filtered, REFERENCES[0], WHOLE_TRIAL, OUTPUT_ERROR)
        yield choices, estimate(OUTPUT_ERROR, record)


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
        key: np.concatenate([getattr(fit, key)[rest:] for fit in alone])
        for key in ("torque", "predicted", "regressors")
    }
    stops = np.cumsum([0, *(w.stop - w.start for w in windows)])
    return WindowedFits(
        perturbations=[
            replace(w, start=int(a), stop=int(b))
            for w, a, b in zip(windows, stops[:-1], stops[1:], strict=True)
        ],
        fits=[fit.fits[0] for fit in alone],
        theta_rest_rad=float(np.mean([fit.theta_rest_rad for fit in alone])),
        torque_rest_Nm=float(np.mean([fit.torque_rest_Nm for fit in alone])),
        **joined,
    )


def _role(choices: tuple[str, ...], standard: str, as_printed: Pathway, recommended: Pathway) -> str:
    for role, pathway in ((AS_PRINTED, as_printed), (RECOMMENDED, recommended)):
        by_pathway = (pathway.torque, standard, ALL_SIGNALS, REFERENCES[0], WINDOWS[1], pathway.estimator)
        if choices == by_pathway and pathway.marker_instants == "aligned":
            return role
    return OTHER
