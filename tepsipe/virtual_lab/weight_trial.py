"""One trial with the weight, or with the empty belt, from protocol and truth to raw files.

A rigid weight taped to the belt, or nothing at all, from Newton's law along the belt.

    (Mb + m) y'' = u - c y'

The weight moves with the belt: it neither slips nor tips. The reaction on the plate is the rate of
its linear and angular momentum, differentiated numerically: no free-body equation is used here.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy

from tepsipe.quantities import Gravity, Height, Length, Mass, Offset
from tepsipe.virtual_lab.belt import BeltMotion, Command, DriveTruth, stage_commands
from tepsipe.virtual_lab.integrate import integrate
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import (
    INTEGRATION_RATE_HZ,
    MarkerPath,
    Protocol,
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
    weight: WeightTruth | None, drive: DriveTruth, command: Command, duration_s: float, rate_hz: float
) -> BeltMotion:
    """Integrate the belt with a weight, or empty.

    weight: constants of the weight; None if nothing is on the belt.
    command: commanded belt velocity (m/s) at t (s).
    duration_s, rate_hz: length of the run (s) and steps per second (Hz).
    Returns: motion and reaction on the grid of the integration.
    """
    moving = drive.belt_mass_kg + (0.0 if weight is None else weight.mass_kg)
    force, viscous = drive.servo(), drive.viscous_Ns_per_m

    def derivative(commanded: float, state: tuple[float, ...]) -> tuple[float, ...]:
        _, v, q = state
        u, q_rate = force(commanded - v, q)
        return v, (u - viscous * v) / moving, q_rate

    commands = stage_commands(command, drive.delay_s, duration_s, rate_hz)
    time, states = integrate(derivative, (0.0, 0.0, 0.0), commands, rate_hz)
    y, v, _ = states.T
    return BeltMotion(
        time=time,
        belt_position=y,
        belt_velocity=v,
        belt_acceleration=scipy.interpolate.CubicSpline(time, v)(time, 1),
        reaction=np.zeros((time.size, 6)) if weight is None else weight_reaction(weight, time, y, v),
    )


def weight_reaction(
    weight: WeightTruth, time: np.ndarray, y: np.ndarray, v: np.ndarray
) -> Annotated[np.ndarray, "(n, 6)"]:
    """Wrench on the weight about the plate's origin, from the rates of its momenta.

    time, y, v: instants (s), belt position (m) and velocity (m/s).
    Returns: fx, Fy, Fz (N), Mx, My, Mz (N·m).
    """
    momentum_y = weight.mass_kg * v
    # about x, right-handed (positive turns y towards z)
    spin_x = -weight.com_height_m * momentum_y
    rate = scipy.interpolate.CubicSpline(time, np.column_stack([momentum_y, spin_x]))(time, 1)
    fy = rate[:, 0]
    fz = np.full_like(fy, weight.mass_kg * weight.gravity_m_per_s2)
    mx = rate[:, 1] + (weight.position_y_m + y) * fz
    my = -weight.position_x_m * fz
    mz = weight.position_x_m * fy
    return np.column_stack([np.zeros_like(fy), fy, fz, mx, my, mz])


def weight_marker_paths(weight: WeightTruth, motion: BeltMotion) -> list[MarkerPath]:
    """Paths of the markers in the upper corners, in the order of `MARKERS`.

    motion: exact motion of the belt.
    Returns: each gives x, y, z, shape (n, 3), at instants, shape (n,).
    """
    belt = scipy.interpolate.CubicSpline(motion.time, motion.belt_position)

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
    motion = move_weight(weight, drive, schedule.command, schedule.ends_s, INTEGRATION_RATE_HZ)
    load_kg = 0.0 if weight is None else weight.mass_kg
    record_log(rig, seed, schedule, {belt: (motion, load_kg)}, rng, files)
    if weight is not None:
        record_capture(rig, schedule, MARKERS, weight_marker_paths(weight, motion), rng, files["markers"])
