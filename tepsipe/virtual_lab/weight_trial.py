"""One trial with the weight, or with the empty belt, from protocol and truth to raw files.

A rigid weight taped to the belt, or nothing at all, from Newton's law along the belt.

    F = m (v' + x'')

with v velocity of the belt on its frame and x displacement of the frame
(`tepsipe.virtual_lab.moving_belt`). The weight moves with the belt: it neither slips nor tips. The reaction
on the plate is the rate of its linear and angular momentum.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy

from tepsipe.quantities import Gravity, Height, Length, Mass, Offset
from tepsipe.virtual_lab.belt import BeltMotion, Command, DriveTruth, stage_commands
from tepsipe.virtual_lab.integrate import integrate
from tepsipe.virtual_lab.moving_belt import Below, MovingBelt, motion_of_belt
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

# names of the weight's markers, in the strober's order: round its upper face, from the front left corner
MARKERS = ("weight1", "weight2", "weight3", "weight4")


@dataclass(frozen=True)
class WeightTruth:
    """Rigid cuboid, taped to the belt, with a marker in every upper corner.

    The heavy one lies on the belt in trials whose row names a mass.
    """

    mass_kg: Mass
    """Mass."""
    width_m: Length
    """Dimension across the belt."""
    length_m: Length
    """Dimension along the belt."""
    height_m: Length
    """Dimension above the belt."""
    com_height_m: Height
    """Height of the centre of mass above the belt."""
    position_x_m: Offset
    """Position on the plate, across the belt."""
    position_y_m: Offset
    """Position on the plate, along the belt."""
    gravity_m_per_s2: Gravity
    """Gravity."""


def move_weight(
    weight: WeightTruth | None,
    drive: DriveTruth,
    command: Command,
    duration_s: float,
    rate_hz: float,
    below: Below = (),
) -> BeltMotion:
    """Integrate the belt with a weight, or empty.

    weight: constants of the weight; None if nothing is on the belt.
    command: commanded belt velocity (m/s) at t (s).
    duration_s, rate_hz: length of the run (s) and steps per second (Hz).
    below: plate of the belt.
    Returns: motion and reaction on the grid of the integration.
    """
    mass_kg = 0.0 if weight is None else weight.mass_kg
    load = 0.0 if weight is None else mass_kg * weight.gravity_m_per_s2
    belt = MovingBelt(drive, load, rate_hz, below)
    pushed, swaying = belt.pushed, belt.swaying
    moving = belt.moving_kg + mass_kg

    def derivative(commanded: float, state: tuple[float, ...]) -> tuple[float, ...]:
        _, v, q, x, x_rate = state
        push, q_rate, sway = pushed(commanded, v, q, x, x_rate)
        acceleration = push / moving
        return v, acceleration, q_rate, x_rate, swaying * acceleration + sway

    def begin_step(k: int, state: tuple[float, ...]) -> None:
        belt.begin_step(k, state[1] - state[4])

    commands = stage_commands(command, drive.delay_s, duration_s, rate_hz)
    time, states = integrate(*belt.with_pitch(derivative, (0.0,) * 5), commands, rate_hz, begin_step)
    y, v, _, x, x_rate = states.T[:5]
    motion = BeltMotion(**motion_of_belt(time, y, v, x, x_rate), reaction=np.zeros((time.size, 6)))
    if weight is None:
        return motion
    return replace(motion, reaction=weight_reaction(weight, y, motion.acceleration))


def weight_reaction(
    weight: WeightTruth, y: np.ndarray, acceleration: np.ndarray
) -> Annotated[np.ndarray, "(n, 6)"]:
    """Wrench on the weight about the plate's origin, from the rates of its momenta.

    y, acceleration: displacement (m) and acceleration (m/s²) of the weight.
    Returns: fx, Fy, Fz (N), Mx, My, Mz (N·m).
    """
    fy = weight.mass_kg * acceleration
    fz = np.full_like(fy, weight.mass_kg * weight.gravity_m_per_s2)
    # about x, right-handed (positive turns y towards z)
    mx = -weight.com_height_m * fy + (weight.position_y_m + y) * fz
    my = -weight.position_x_m * fz
    mz = weight.position_x_m * fy
    return np.column_stack([np.zeros_like(fy), fy, fz, mx, my, mz])


def weight_marker_paths(weight: WeightTruth, motion: BeltMotion) -> list[MarkerPath]:
    """Paths of the markers in the upper corners, in the order of `MARKERS`.

    motion: exact motion of the belt.
    Returns: each gives x, y, z, shape (n, 3), at instants, shape (n,).
    """
    belt = scipy.interpolate.CubicSpline(motion.time, motion.position)

    def corner(right: float, forward: float) -> MarkerPath:
        x = weight.position_x_m + 0.5 * right * weight.width_m
        y = weight.position_y_m + 0.5 * forward * weight.length_m

        def path(instant: np.ndarray) -> np.ndarray:
            fixed = np.ones_like(instant)
            return np.column_stack([x * fixed, y + belt(instant), weight.height_m * fixed])

        return path

    return [corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)]


def make_weight_trial(
    truth: dict, condition: str, protocol: Protocol, files: dict[str, Path], belt: str = "right"
) -> None:
    """Make one trial with the weight on the belt, or with the empty belt.

    truth: the laboratory's constants, as its configuration file holds them, with the section ``weight`` or
    ``heavy_weight``.
    condition: name of the condition: it seeds the trial's noise.
    files: files to write: ``log`` and ``calibration``, and ``markers`` of the weight, without which the
    belt is empty.
    belt: {"left", "right"}: The belt that moves.
    """
    seed, rig = truth["seed"], truth["treadmill"]
    weight = None
    if "markers" in files:
        weight = WeightTruth(**truth.get("weight", truth.get("heavy_weight")))
    rng = generator(seed, "empty" if weight is None else "weight", condition)
    rest_after_s = rig["protocol"]["rest_after_weight_s"]
    schedule = schedule_trial(rig, protocol, rest_after_s, rng)
    drive = DriveTruth(**rig["drive"])
    below = [(plates_of(rig)[belt], 1.0)]
    motion = move_weight(weight, drive, schedule.command, schedule.ends_s, INTEGRATION_RATE_HZ, below)
    record_log(rig, seed, schedule, {belt: motion}, rng, files)
    if weight is not None:
        record_capture(rig, schedule, MARKERS, weight_marker_paths(weight, motion), rng, files["markers"])
