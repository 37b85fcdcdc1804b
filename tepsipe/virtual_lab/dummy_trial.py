"""One trial of the ankle dummy on the treadmill, from protocol and truth to raw files.

Markers that do not move with the body they sit on: a leg that bends or wobbles, and tape that gives.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy

from tepsipe.quantities import Frequency, Height, NotNegative, Time
from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.dummy import (
    MARKERS,
    DummyMarkers,
    DummyMotion,
    DummyTruth,
    FootTilt,
    dummy_marker_paths,
    move_dummy,
)
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import (
    INTEGRATION_RATE_HZ,
    MarkerPath,
    Protocol,
    plates_of,
    record_capture,
    record_log,
    schedule_trial,
)
from tepsipe.virtual_lab.truth_file import TrueMotion, write_true_motion

Shift = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Wobble:
    """Hidden constants of a mass that lags behind an accelerated leg, d'' + 2 z w d' + w² d = -a."""

    hz: Annotated[Frequency, "Hz"]  # w / 2 pi
    """Natural frequency."""
    damping: NotNegative  # z
    """Damping ratio."""
    common: float
    """Fraction of the mass's displacement by which all markers of the leg move; 0 in both is a rigid leg."""
    growing_per_m: Annotated[float, "1/m"]
    """The same per distance from the joint."""


@dataclass(frozen=True)
class Slip:
    """The tape of a marker gives in every pulse, by a random step that stays."""

    foot_m: Height
    """Standard deviation of the step of the markers on the foot; 0 is a marker that holds."""
    ankle_m: Height
    """The same of the marker on the ankle."""
    settling_s: Time
    """Time constant of a step."""


def wobbling(wobble: Wobble, time: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Lag d of a wobbling mass behind an accelerated body.

    time, acceleration: regular instants (s) and acceleration of the body (m/s²).
    Returns: d (m), 0 at first.
    """
    natural = 2.0 * np.pi * wobble.hz
    mass = ([-1.0], [1.0, 2.0 * wobble.damping * natural, natural**2])
    numerator, denominator, _ = scipy.signal.cont2discrete(mass, time[1] - time[0], method="bilinear")
    return scipy.signal.lfilter(np.ravel(numerator), denominator, acceleration)


def slipping(
    step_m: float, settling_s: float, onsets_s: Annotated[np.ndarray, "(k,)"], rng: np.random.Generator
) -> Shift:
    """Steps of one marker, a random one at each onset.

    step_m, settling_s: standard deviation of a step (m) and its time constant (s).
    onsets_s: onsets of the pulses.
    Returns: displacement, shape (n,), at instants, shape (n,).
    """
    steps = step_m * rng.standard_normal(onsets_s.size)

    def shift(instant: np.ndarray) -> np.ndarray:
        since = np.maximum(instant[:, None] - onsets_s, 0.0) / settling_s
        return (1.0 - np.exp(-since)) @ steps

    return shift


def shifted(path: MarkerPath, shift: Shift) -> MarkerPath:
    """The path, moved forwards by a displacement (m) at every instant (s)."""

    def moved_path(instant: np.ndarray) -> np.ndarray:
        positions = path(instant)
        positions[:, 1] += shift(instant)
        return positions

    return moved_path


def make_dummy_trial(truth: dict, condition: str, protocol: Protocol, files: dict[str, Path]) -> None:
    """Make one trial of the ankle dummy on the treadmill.

    truth: the laboratory's constants, as its configuration file holds them.
    condition: name of the condition: it seeds the trial's noise.
    files: files to write: ``log``, ``calibration`` and ``markers``, and ``motion``, the hidden motion of
    the joint, if it is wanted.
    """
    seed, rig = truth["seed"], truth["treadmill"]
    dummy = DummyTruth(**truth["dummy"]["subject"])
    # the rod is set upright by the motion capture
    upright = dummy.rest_angle_rad - rig["capture"]["vertical_rad"]
    dummy = replace(dummy, rest_angle_rad=upright)
    rng = generator(seed, "dummy", condition)
    of_slip = generator(seed, "dummy", condition, "slip")
    rest_after_s = rig["protocol"]["rest_after_s"]
    schedule = schedule_trial(rig, protocol, rest_after_s, rng)
    motion = move_dummy(
        dummy,
        Rubber(**truth["dummy"]["rubber"]),
        DriveTruth(**rig["drive"]),
        schedule.command,
        schedule.ends_s,
        INTEGRATION_RATE_HZ,
        FootTilt(**truth["dummy"]["foot_tilt"]),
        [(plates_of(rig)["right"], 1.0)],
    )
    record_log(rig, seed, schedule, {"right": motion}, rng, files)
    paths = _marker_paths(truth["dummy"], dummy, motion, schedule.onsets_s, of_slip)
    record_capture(rig, schedule, MARKERS, paths, rng, files["markers"])
    if "motion" in files:
        angle, rate = motion.angle - motion.tilt, motion.angle_rate - motion.tilt_rate
        # parts that belong to the joint's inertia turn with the leg
        acceleration = np.gradient(motion.angle_rate, motion.time)
        elapsed = motion.time - schedule.trigger_s
        true = TrueMotion(elapsed, angle, rate, acceleration, motion.joint_torque)
        write_true_motion(files["motion"], true)


def _marker_paths(truth: dict, dummy: DummyTruth, motion: DummyMotion, onsets_s, rng) -> list[MarkerPath]:
    """Paths of the markers, including bending between markers and body and yielding tape."""
    layout = DummyMarkers(**truth["markers"])
    paths = dummy_marker_paths(layout, dummy, motion)
    wobble, slip = Wobble(**truth["wobble"]), Slip(**truth["slip"])
    foot = len(layout.foot_m)
    if wobble.common or wobble.growing_per_m:
        lag = wobbling(wobble, motion.time, motion.acceleration)
        lags = scipy.interpolate.CubicSpline(motion.time, lag)
        for k, (_, along) in enumerate([layout.ankle_m, *layout.leg_m], start=foot):
            part = wobble.common + wobble.growing_per_m * along
            paths[k] = shifted(paths[k], lambda instant, part=part: part * lags(instant))
    for k, step in enumerate([slip.foot_m] * foot + [slip.ankle_m]):
        if step:
            paths[k] = shifted(paths[k], slipping(step, slip.settling_s, onsets_s, rng))
    return paths
