"""Registry of the estimators of a perturbed trial: each takes a record and returns windowed fits.

The study's pathways, the specification curve and the public functions select an estimator here. To add one,
write its module with a function that returns `WindowedFits`, and enter it in `ESTIMATORS`.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.identification.one_thread import one_thread

if TYPE_CHECKING:
    from tepsipe.identification.likelihood.channels import DummyMarkers
    from tepsipe.identification.regression.windows import WindowedFits
    from tepsipe.mechanics.inverse_dynamics import Leg
    from tepsipe.mechanics.segment_kinematics import JointMotion
    from tepsipe.signals.perturbations import Perturbation


@dataclass(frozen=True, kw_only=True)
class Record:
    """Signals of one trial for an estimator; signals that it does not need may be None."""

    motion: "JointMotion | None" = None
    """Angle of the joint with its derivatives (s, rad), filtered; a `SegmentMotion` for output error."""
    torque: np.ndarray | None = None
    """Torque of the joint (N·m), filtered as the motion is."""
    perturbations: "list[Perturbation] | None" = None
    """Windows (samples)."""
    at_rest: np.ndarray | None = None
    """Samples at rest."""
    leg: "Leg | None" = None
    """The leg (kg, m, kg·m²)."""
    foot_position: np.ndarray | None = None
    belt_velocity: np.ndarray | None = None
    """Position of the foot along the belt (m), and logged velocity of the belt (m/s), filtered as the
    motion is."""
    markers: "DummyMarkers | None" = None
    """Markers of foot and leg, not filtered (m)."""
    belt_log: np.ndarray | None = None
    """Logged velocity of the belt, not filtered (m/s); None also where it was derived from markers."""


@dataclass(frozen=True)
class Estimator:
    """An estimator of I, B, K from a record."""

    meaning: str
    """Description in a few words."""
    needs: tuple[str, ...]
    """Parts of a `Record` that it uses."""
    function: Callable
    """From the record to `WindowedFits`."""
    true_in_windows: bool = False
    """Whether the truth of its estimates is the linear joint nearest to the true one in the windows of the
    perturbations; otherwise it is the joint for small movements."""

    @property
    def fits_torque(self) -> bool:
        """True if it fits a torque in the windows of perturbations."""
        return self.needs == NEEDS_TORQUE


# modules are imported when their estimator runs, to keep the start of other jobs short
def _windowed(thesis: bool, own_zero: bool = False) -> Callable:
    def function(record: Record):
        from tepsipe.identification.regression.windows import regress_torque

        return regress_torque(
            record.motion,
            record.torque,
            record.perturbations,
            record.at_rest,
            thesis=thesis,
            own_zero=own_zero,
        )

    return function


def _output_error(record: Record):
    from tepsipe.identification.regression.output_error import match_angle

    return match_angle(
        record.motion,
        record.foot_position,
        record.belt_velocity,
        record.leg,
        record.perturbations,
        record.at_rest,
    )


def _likelihood(softening: bool) -> Callable:
    def function(record: Record):
        from tepsipe.identification.likelihood.likelihood import maximise_likelihood
        from tepsipe.identification.likelihood.result import estimates_in_windows

        fit = maximise_likelihood(
            record.motion.time,
            record.markers,
            record.belt_log,
            record.leg,
            record.at_rest,
            softening=softening,
        )
        return estimates_in_windows(fit, record.motion, record.perturbations, record.at_rest)

    return function


LEAST_SQUARES_THESIS = "windowed-least-squares-thesis"
LEAST_SQUARES = "windowed-least-squares"
LEAST_SQUARES_OWN_ZERO = "windowed-least-squares-own-zero"
OUTPUT_ERROR = "output-error"
JOINT_LIKELIHOOD = "joint-likelihood"
JOINT_LIKELIHOOD_LINEAR = "joint-likelihood-linear"
NEEDS_TORQUE = ("motion", "torque", "perturbations", "at_rest")
NEEDS_ANGLE = ("motion", "foot_position", "belt_velocity", "leg", "perturbations", "at_rest")
NEEDS_MARKERS = ("motion", "markers", "leg", "perturbations", "at_rest")
ESTIMATORS = {
    LEAST_SQUARES_THESIS: Estimator(
        "windowed (per-perturbation) least squares, torque at rest not subtracted",
        NEEDS_TORQUE,
        _windowed(thesis=True),
        true_in_windows=True,
    ),
    LEAST_SQUARES: Estimator(
        "the same with the torque at rest subtracted; where the perturbations repeat each other, products of "
        "different ones only, which noise does not bias",
        NEEDS_TORQUE,
        _windowed(thesis=False),
        true_in_windows=True,
    ),
    LEAST_SQUARES_OWN_ZERO: Estimator(
        "the same with a free constant torque in every window, because the zero of a force plate drifts and "
        "friction leaves a force behind",
        NEEDS_TORQUE,
        _windowed(thesis=False, own_zero=True),
        true_in_windows=True,
    ),
    OUTPUT_ERROR: Estimator(
        "angle simulated over the whole trial from the motion of the foot and the logged belt velocity",
        NEEDS_ANGLE,
        _output_error,
    ),
    JOINT_LIKELIHOOD: Estimator(
        "maximum likelihood of leg markers, foot markers and logged belt velocity over the whole trial, of a "
        "joint that may soften with bending",
        NEEDS_MARKERS,
        _likelihood(softening=True),
        true_in_windows=True,
    ),
    JOINT_LIKELIHOOD_LINEAR: Estimator(
        "the same for a linear joint: efficient, but its intervals do not hold the truth if the joint "
        "softens",
        NEEDS_MARKERS,
        _likelihood(softening=False),
        true_in_windows=True,
    ),
}


def find_estimator(name: str) -> Estimator:
    """Estimator with a given name."""
    if name not in ESTIMATORS:
        raise InputError(f"expected an estimator of {listed(ESTIMATORS)}, found {quoted(name)}: correct it")
    return ESTIMATORS[name]


@one_thread()
def estimate(name: str, record: Record) -> "WindowedFits":
    """Estimate I, B, K of a record by the named estimator.

    name: one of `ESTIMATORS`.
    Returns: estimates of every window (N·m·s²/rad, N·m·s/rad, N·m/rad).
    """
    estimator = find_estimator(name)
    missing = [
        f.name for f in fields(Record) if f.name in estimator.needs and getattr(record, f.name) is None
    ]
    if missing:
        raise InputError(
            f"estimator {name}: expected a record with {listed(estimator.needs)}, found none of "
            f"{listed(missing)}: give it, or choose another estimator"
        )
    return estimator.function(record)
