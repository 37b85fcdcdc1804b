"""Limits of the signals of a trial, the stated contents of its rig, and frozen stretches.

A channel whose median step is hardly larger than its smallest one is quantised: identical neighbours are
common in it. In all other channels noise changes every sample. In public C3D files the longest run of
one position in all coordinates is 20 ms; the longest run of one value in a force channel, exact zeros
excluded, is 39 ms.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np
from annotated_types import Ge, Le

from tepsipe.quantities import ASCENDING, Band, Fraction, Pair, Positive, Time
from tepsipe.signals.resampling import runs_of

if TYPE_CHECKING:
    from tepsipe.io.trial import Trial

Limit = Annotated[Pair[float], ASCENDING]
# a channel is quantised if the median of its steps is at most this many times the smallest
QUANTISED_STEPS = 3.0
# smallest change of a signal while another one is held, as a fraction of its whole range
MOVING_RANGE = 0.2
# a held signal changes by less than this fraction of its whole range
HELD_RANGE = 1e-6


@dataclass(frozen=True)
class Limits:
    """Plausible range of each kind of signal: (lowest, highest)."""

    rate_hz: Band
    """Sampling rate of a trial."""
    belt_velocity_m_per_s: Limit
    """Measured and commanded velocity of a belt."""
    belt_acceleration_m_per_s2: Limit
    """Its difference from sample to sample."""
    marker_position_m: Limit
    """Every coordinate of a marker."""
    marker_speed_m_per_s: Positive
    """Highest speed of a marker from sample to sample."""
    force_N: Limit
    """Force components of a force plate, load of a treadmill."""
    moment_Nm: Limit
    """Moments of a force plate, load of a treadmill."""
    angle_rad: Limit
    """Angle of a joint in a manipulator."""
    torque_Nm: Limit
    """Torque of a joint in a manipulator."""
    joint_speed_rad_per_s: Positive
    """Angular velocity of this joint, which one sample in 1000 may exceed: a human ankle in a manipulator
    reaches 3 rad/s, an angle in degrees that is read in rad far more."""
    torque_per_angle_Nm_per_rad: Band
    """Standard deviation of this torque over that of the angle. The torque must also do positive work on the
    joint, otherwise one of the two has the wrong sign."""
    emg_uV: Limit
    """Raw electromyogram."""
    frozen_s: Time
    """Longest stretch of identical samples of a marker, or of the force plate under the foot, weight or
    person. In real recordings 0.04 s were found. Quantised channels, whose usual step is about their
    smallest, are exempt. In a trial of a standing person frozen stretches count as hidden, so that their
    perturbations are omitted."""
    belt_fixed_correlation: Fraction
    """Lowest correlation of the velocities of a belt-fixed marker and of the belt."""
    belt_fixed_scale: Annotated[Pair[Annotated[float, Ge(0), Le(10)]], ASCENDING]
    """Ratio of these velocities."""
    belt_fixed_delay_s: Time
    """Longest delay between them."""
    accelerated_fraction: Annotated[float, Ge(-10), Le(1)]
    """Lowest share of the mass on the belt that the fore-aft force accelerates with it: at least the feet."""


@dataclass(frozen=True)
class Rig:
    """Stated contents of the trial; unknown ones may be omitted."""

    belt: str | None = None
    """Belt that carries something: its force plate must be alive."""
    carried_kg: tuple[float, float] | None = None
    """Lowest and highest mass on that belt."""
    mass_key: str = "the masses in the configuration"
    """Where this mass is stated, for messages."""
    belt_fixed: tuple[str, ...] = ()
    """Belt-fixed markers."""
    segments: dict[str, tuple[str, ...]] | None = None
    """Segment -> its markers, which must move when the belt does."""
    amplitude_m_per_s: float | None = None
    """Stated amplitude of the velocity of the perturbed belt: its highest speed."""
    person: bool = False
    """Whether a person stands on the belt: a step moves the foot, and stretches in which a marker is frozen
    are marked as hidden, so that their perturbations are left out."""


def source(files: dict[str, str], *kinds: str) -> str:
    """Path of the first of these kinds of file that is present, otherwise of the first of all."""
    return next(
        (str(files[kind]) for kind in kinds if kind in files), str(next(iter(files.values()), "trial"))
    )


def used_belt(trial: "Trial", rig: Rig) -> int | None:
    """Index of the belt in use on the axis of the trial's plates, or None."""
    if rig.belt is None or "force" not in trial.signals:
        return None
    belts = trial.axes["belt"].tolist()
    return belts.index(rig.belt) if rig.belt in belts else None


def frozen_stretch(
    values: Annotated[np.ndarray, "(n, c)"],
    rate_hz: float,
    longest_s: float,
    ignored: np.ndarray | None = None,
) -> tuple[int, int] | None:
    """Longest stretch of identical samples, if it is implausible for a noisy channel.

    values: components of one channel; a sample is repeated if all of them are.
    longest_s: longest stretch that is accepted.
    ignored: samples that were not measured.
    Returns: first sample and the first after it (samples); None if there is no such stretch, or if all
    components are quantised.
    """
    steps = np.abs(np.diff(values, axis=0))
    repeated = (steps == 0.0).all(axis=1)
    if ignored is not None:
        repeated &= ~(ignored[1:] | ignored[:-1])
    runs = runs_of(repeated)
    if not runs:
        return None
    start, stop = max(runs, key=lambda run: run[1] - run[0])
    if stop + 1 - start < max(3, round(longest_s * rate_hz)) or all(map(_quantised, steps.T)):
        return None
    return start, stop + 1


def _quantised(steps: np.ndarray) -> bool:
    """Test for a component whose median step is about as small as its smallest."""
    taken = steps[steps > 0.0]
    return bool(taken.size and np.median(taken) <= QUANTISED_STEPS * taken.min())


def held_while_moving(
    values: np.ndarray, others: np.ndarray, rate_hz: float, longest_s: float
) -> tuple[int, int] | None:
    """First stretch in which one signal is held although another one moves.

    values, others: signal that may be held, and the one that moves it.
    longest_s: longest stretch that is accepted.
    Returns: first sample and the first after it (samples), or None.
    """
    size, other = float(np.ptp(values)), float(np.ptp(others))
    held = np.abs(np.diff(values)) <= HELD_RANGE * size
    for start, stop in runs_of(held):
        long_enough = stop + 1 - start >= max(3, round(longest_s * rate_hz))
        if long_enough and np.ptp(others[start : stop + 1]) > MOVING_RANGE * other:
            return start, stop + 1
    return None
