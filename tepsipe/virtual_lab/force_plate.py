"""The dual-belt treadmill's 14 force transducers, and the dynamics between them and the load.

Per belt: 4 vertical transducers in the corners, 2 medio-lateral ones at the belt's ends, 1 fore-aft
one in its middle. A wrench w = (Fx, Fy, Fz, Mx, My, Mz) spreads over the 7 transducers as the
least-norm forces f with E f = w, where E holds the transducers' lines of action. Voltages are
sensitivity times cross-talk times f. The calibration matrix is the result of a careful static
calibration of such a plate.

The transducers do not measure the reaction on the load alone. In the order of the force path:

1. Belt. The drive pulls the belt at its rear end, and belt and splices give in a viscous way: the
   load follows the rollers through a first-order lag, T on average, which changes by a factor phi(t)
   from push to push as belt and splices settle, so that the rollers move at

       v_r = v + phi T v'

   Belt and rollers rub on deck and bearings with a friction that is full only at some speed, because a
   film has to form (v_0), that grows with the load N on the deck, and that has a viscous part:

       F_friction = (F_0 + mu N) ((1 - b) tanh(v_r / v_0) + b z) + c v_r

   A share b of it comes from bristles z with a memory (below). The friction acts on deck and
   bearings, a lever arm below the surface of the belt, and so causes a moment M_x. At the load this
   friction leads the velocity and so resembles a mass, more so for a slower belt: the apparent mass
   c_eff T falls with amplitude as the friction saturates. The excess mass of the upper run of the belt
   over the lower run, which moves the other way, acts as a mass; the rollers, accelerated against the
   frame, act as a pitch moment -(I / r) v'.
2. Floor. The building vibrates near its natural frequency and shakes the frame, whose mass lies about at
   the height of the belt: a fore-aft force that is independent of the perturbations.
3. Frame. It sways fore and aft on the transducers, and tips on them, in two modes: each takes a share of Fy
   and another of Mx, has a mass on a spring and a damper, and the transducers show the forces of both. The
   load stands on belt plus frame (`tepsipe.virtual_lab.moving_belt`), so its force holds its own inertia in
   that motion, and passes through the empty frame. A weight thus lowers the resonance, a body on springy
   legs hardly does. The second mode, a pitch of the frame, moves the load only if it has a mass.
4. Mounts. Rubber seals bridge the gap between the deck and the floor around it, at the height of the
   belt. They are stiff under a quick force and pass a share s of it to the floor; within T_m the rubber
   relaxes (a Maxwell element), so a static calibration does not detect it:

       F_transducer = F - s (T_m d/dt) / (1 + T_m d/dt) F

5. Amplifier. Forces and moments are logged a time after the belt velocity of the same instant.

Bristles bend before they slide (Dahl's model; LuGre without Stribeck effect). A displacement x of the belt
over deck and bearings first bends bristles, which slide once they are bent by d:

    z' = (x' - |x'| z) / d,    force = F z,    -1 <= z <= 1

The force depends on where the belt has been, not on how fast: small movements are elastic, large ones meet
full friction, and after a pulse a force stays behind. P. R. Dahl (1968), A solid friction model, Aerospace
Corporation TOR-0158(3107-18)-1; C. Canudas de Wit et al. (1995), IEEE Transactions on Automatic Control 40,
419-425.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import scipy
from annotated_types import Ge, Gt, Le, Len, Lt

from tepsipe.quantities import (
    Delay,
    Fraction,
    Frequency,
    Height,
    Length,
    NotNegative,
    Offset,
    Pair,
    Positive,
    Rate,
    Time,
)
from tepsipe.virtual_lab.belt import BeltMotion


def bristle_deflection(displacement: np.ndarray, breakaway_m: float) -> np.ndarray:
    """Deflection z of the bristles, from z = 0.

    displacement: path of the belt over its support (m), monotonic between samples.
    breakaway_m: displacement d that the bristles take.
    Returns: z, exact for the path that joins the samples by straight lines.
    """
    steps = np.diff(displacement)
    kept = np.exp(-np.abs(steps) / breakaway_m).tolist()
    z, deflection = 0.0, [0.0]
    for sign, part in zip(np.sign(steps).tolist(), kept, strict=True):
        z = sign + (z - sign) * part
        deflection.append(z)
    return np.array(deflection)


BELTS = ("left", "right")
TRANSDUCERS = ("z_front_left", "z_front_right", "z_rear_left", "z_rear_right", "x_front", "x_rear", "y")
COMPONENTS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


class Mode(NamedTuple):
    """One mode of the frame."""

    shares: Pair[float]
    """Fractions of [F_y, M_x] that it takes."""
    damping_per_s: float
    stiffness_per_s2: float
    """Damping and stiffness over its mass."""


@dataclass(frozen=True)
class PlateTruth:
    """Force plate and frame."""

    belt_length_m: Annotated[float, Gt(0), Le(10)]
    """Distance between the transducers along the belt."""
    belt_width_m: Annotated[float, Gt(0), Le(10)]
    """Distance between them across the belt."""
    transducer_depth_m: Height
    """Their depth."""
    sensitivity_V_per_N: Positive
    """Volts per newton."""
    sensitivity_spread: NotNegative
    """Its relative spread."""
    cross_talk: NotNegative
    """Relative leak between channels."""
    calibration_error: NotNegative
    """Relative error of the calibration."""
    force_scale: Pair[Annotated[float, Gt(0), Le(10)]]
    """Gain since the calibration, [fore-aft, vertical]."""
    vertical_leak: Annotated[float, Ge(-1), Le(1)]
    """Fraction of the vertical force that the fore-aft transducer shows."""
    origin_height_m: Offset
    """Height of the calibration's origin above the belt."""
    origin_forward_m: Offset
    """Position of that origin, forward of the motion capture's origin."""
    moment_scale: Annotated[float, Ge(-10), Le(10)]
    """Gain of M_x since the calibration."""
    transducer_gain: Annotated[Sequence[NotNegative], Len(4, 4)]
    """Gain of the vertical transducers since the calibration, [front left, front right, rear left, rear
    right]."""
    noise_V: NotNegative
    """White noise of a channel."""
    drift_V_per_s: NotNegative
    """Standard deviation of its linear drift."""
    felt_belt_mass_kg: Annotated[float, Ge(0), Le(500)]
    """Mass of the belt's upper run minus that of its lower run, which acts on the fore-aft transducer."""
    felt_roller_inertia_kgm: NotNegative
    """Moment of inertia of the rollers over their radius: pitch moment per belt acceleration."""
    belt_lag_s: Annotated[float, Ge(0), Le(10)]  # T
    """Mean delay of the load relative to the rollers, because the belt stretches."""
    belt_lag_wander: NotNegative
    """Its variation between perturbations (standard deviation of the logarithm)."""
    belt_lag_wander_s: Time
    """Correlation time of this variation."""
    friction_N: NotNegative
    """Friction of the moving belt: unloaded."""
    friction_coefficient: NotNegative
    """Additional friction per newton of load."""
    friction_speed_m_per_s: Annotated[float, Gt(0), Le(10)]
    """Speed of saturation."""
    friction_Ns_per_m: NotNegative
    """Viscous part of the friction."""
    bristle_share: Fraction  # b
    """Fraction of the friction, without its viscous part, that has a memory (0: none)."""
    bristle_m: Length  # d
    """Displacement before it slides."""
    friction_lever_m: Offset
    """Depth under the belt's surface at which friction acts: its moment about the lateral axis."""
    floor_m_per_s2: NotNegative
    """Vibration of the floor: root mean square."""
    floor_hz: Frequency
    """Its frequency."""
    floor_damping: Positive
    """Its damping ratio."""
    resonance_hz: Frequency
    """Fore-aft resonance of the unloaded frame."""
    resonance_damping: Positive
    """Its damping ratio."""
    resonance_mass_kg: Annotated[float, Gt(0), Le(10000)]
    """Its moving mass."""
    second_share: Pair[Fraction]
    """Second mode of the frame: its fraction of [F_y, M_x] (0: none)."""
    second_hz: Frequency
    """Its frequency."""
    second_damping: Positive
    """Its damping ratio."""
    mount_share: Annotated[float, Ge(0), Lt(1)]  # s
    """Fraction of a fast fore-aft force that rubber mounts at the height of the belt take."""
    mount_relaxation_s: Time  # T_m
    """Their relaxation time."""
    rate_hz: Rate
    """Rate of the log."""
    second_mass_kg: Annotated[float, Ge(0), Le(10000)] = 0.0
    """Moving mass of the second mode at the belt's surface (0: it moves no load)."""
    force_delay_s: Delay = 0.0
    """Time by which the logged forces and moments are later than the logged belt velocity."""

    @property
    def modes(self) -> tuple[Mode, Mode]:
        """Modes of the empty frame."""
        force, moment = self.second_share
        first, second = 2.0 * np.pi * self.resonance_hz, 2.0 * np.pi * self.second_hz
        return (
            Mode((1.0 - force, 1.0 - moment), 2.0 * self.resonance_damping * first, first**2),
            Mode((force, moment), 2.0 * self.second_damping * second, second**2),
        )


def lines_of_action(truth: PlateTruth) -> np.ndarray:
    """Wrench about the belt's centre of a unit force in every transducer, shape (6, 7) (N/N, N·m/N)."""
    half_l, half_w, depth = (0.5 * truth.belt_length_m, 0.5 * truth.belt_width_m, truth.transducer_depth_m)
    places = [(-half_w, half_l), (half_w, half_l), (-half_w, -half_l), (half_w, -half_l)]
    points = [(x, y, -depth) for x, y in places]
    points += [(0.0, half_l, -depth), (0.0, -half_l, -depth), (0.0, 0.0, -depth)]
    directions = [(0, 0, 1)] * 4 + [(1, 0, 0)] * 2 + [(0, 1, 0)]
    columns = [
        np.concatenate([direction, np.cross(point, direction)])
        for point, direction in zip(points, directions, strict=True)
    ]
    return np.column_stack(columns).astype(float)


def plate_electronics(truth: PlateTruth, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Matrix from transducer forces to voltages, and the calibration matrix found for the plate.

    Returns:
        volts_per_newton: voltages of all channels per transducer force (V/N). Shape (14, 14).
        calibration: force and moment components of both belts per voltage (N/V, N·m/V). Shape (12, 14).
    """
    n = len(TRANSDUCERS) * len(BELTS)
    gains = 1.0 + truth.sensitivity_spread * rng.standard_normal(n)
    leak = truth.cross_talk * rng.standard_normal((n, n))
    np.fill_diagonal(leak, 0.0)
    volts_per_newton = truth.sensitivity_V_per_N * (np.diag(gains) + leak)
    both = np.kron(np.eye(len(BELTS)), lines_of_action(truth))
    calibration = both @ np.linalg.inv(volts_per_newton)
    calibration *= 1.0 + truth.calibration_error * rng.standard_normal(calibration.shape)
    return volts_per_newton, calibration


def wandering_lag(truth: PlateTruth, n: int, rate_hz: float, rng: np.random.Generator) -> np.ndarray:
    """Time by which the load follows the rollers: its logarithm is a stationary Ornstein-Uhlenbeck process.

    n: number of samples.
    rate_hz: samples per second.
    Returns: phi T (s), with mean T.
    """
    kept = np.exp(-1.0 / (truth.belt_lag_wander_s * rate_hz))
    steps = rng.standard_normal(n)
    steps[1:] *= np.sqrt(1.0 - kept**2)
    wander = scipy.signal.lfilter([1.0], [1.0, -kept], steps)
    return truth.belt_lag_s * np.exp(truth.belt_lag_wander * (wander - 0.5 * truth.belt_lag_wander))


def floor_tremor(
    truth: PlateTruth, n: int, rate_hz: float, rng: np.random.Generator
) -> Annotated[np.ndarray, "(n,)", "m/s²"]:
    """Acceleration of the floor: white noise through the floor's resonance.

    n: number of samples.
    rate_hz: samples per second.
    """
    natural = 2.0 * np.pi * truth.floor_hz
    width = 2.0 * truth.floor_damping * natural
    before = round(10.0 * rate_hz / width)  # until the floor has forgotten that it started at rest
    swing = _filtered(([width, 0.0], [1.0, width, natural**2]), rng.standard_normal(before + n), rate_hz)[
        before:
    ]
    # power of white noise that passes the band: width / 4 of half the sampling rate, in Hz
    return truth.floor_m_per_s2 * np.sqrt(2.0 * rate_hz / width) * swing


def belt_wrench(
    truth: PlateTruth,
    load: Annotated[np.ndarray, "(n,)", "N"],
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"],
    belt_acceleration: Annotated[np.ndarray, "(n,)", "m/s²"],
    belt_lag: Annotated[np.ndarray, "(n,)", "s"],
    rate_hz: float,
) -> Annotated[np.ndarray, "(n, 6)"]:
    """Reaction that the moving belt adds to the load's.

    load: vertical force of the load on the belt.
    belt_velocity, belt_acceleration: motion of the belt under the load.
    belt_lag: time by which the load follows the rollers.
    rate_hz: samples per second.
    Returns: fx, Fy, Fz (N), Mx, My, Mz (N·m): friction and inertia of the belt, pitch moment of the
    rollers.
    """
    at_rollers = belt_velocity + belt_lag * belt_acceleration
    rubbing = truth.friction_N + truth.friction_coefficient * load
    friction = rubbing * np.tanh(at_rollers / truth.friction_speed_m_per_s)
    if truth.bristle_share:
        path = np.cumsum(at_rollers) / rate_hz
        remembered = rubbing * bristle_deflection(path, truth.bristle_m)
        friction += truth.bristle_share * (remembered - friction)
    friction += truth.friction_Ns_per_m * at_rollers
    wrench = np.zeros((belt_velocity.size, 6))
    wrench[:, 1] = friction + truth.felt_belt_mass_kg * belt_acceleration
    # the rollers' upper side moves towards +y: they spin up the other way round x
    wrench[:, 3] = -truth.felt_roller_inertia_kgm * belt_acceleration + truth.friction_lever_m * friction
    return wrench


@dataclass(frozen=True)
class Loaded:
    """What one belt carries."""

    plate: PlateTruth
    """Constants of the force plate below it."""
    motion: BeltMotion
    """Motion of the belt (m/s, m/s²), and wrench of the plate on the load about the belt's centre (N,
    N·m)."""


def voltages_of_belts(
    loaded: dict[str, Loaded],
    volts_per_newton: Annotated[np.ndarray, "(14, 14)", "V/N"],
    sample: Annotated[np.ndarray, "(k,)"],
    rng: np.random.Generator,
) -> Annotated[np.ndarray, "(k, 14)"]:
    """Voltages of the 14 channels.

    loaded: belt of `BELTS` -> its load; a belt without one stands still.
    volts_per_newton: from `plate_electronics`.
    sample: grid points at which the log samples.
    Returns: voltages (V), left belt first.
    """
    parts = [
        _transducer_forces(loaded[belt], sample, rng) if belt in loaded else np.zeros((sample.size, 7))
        for belt in BELTS
    ]
    forces, truth = np.concatenate(parts, axis=1), next(iter(loaded.values())).plate
    drift = truth.drift_V_per_s * rng.standard_normal(forces.shape[1])
    elapsed = np.arange(sample.size)[:, None] / truth.rate_hz
    noise = truth.noise_V * rng.standard_normal(forces.shape)
    return forces @ volts_per_newton.T + drift * elapsed + noise


def _transducer_forces(loaded: Loaded, sample: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Forces of the 7 transducers of one belt (N), shape (k, 7)."""
    truth, motion = loaded.plate, loaded.motion
    of_lag, of_floor = rng.spawn(2)  # leaves what `rng` itself draws as it is
    n, grid_rate_hz = motion.time.size, motion.rate_hz
    lag, load = wandering_lag(truth, n, grid_rate_hz, of_lag), motion.reaction[:, 2]
    wrench = motion.reaction + belt_wrench(
        truth, load, motion.belt_velocity, motion.belt_acceleration, lag, grid_rate_hz
    )
    wrench[:, 1] += truth.resonance_mass_kg * floor_tremor(truth, n, grid_rate_hz, of_floor)
    wrench[:, [1, 3]] = _through_frame(truth, wrench[:, [1, 3]], grid_rate_hz)
    relaxing = ([truth.mount_relaxation_s, 0.0], [truth.mount_relaxation_s, 1.0])
    taken = truth.mount_share * _filtered(relaxing, wrench[:, 1] - wrench[0, 1], grid_rate_hz)
    wrench[:, 1] -= taken
    wrench[:, 3] += truth.origin_height_m * wrench[:, 1] - truth.origin_forward_m * wrench[:, 2]
    wrench[:, 3] *= truth.moment_scale
    logged = wrench[sample]
    if truth.force_delay_s:
        instants = np.maximum(motion.time[sample] - truth.force_delay_s, motion.time[0])
        logged = scipy.interpolate.CubicSpline(motion.time, wrench)(instants)
    found = logged @ np.linalg.pinv(lines_of_action(truth)).T
    vertical = found[:, :4].sum(axis=1)
    found[:, 6] = truth.force_scale[0] * found[:, 6] + truth.vertical_leak * vertical
    found[:, :4] *= truth.force_scale[1] * np.asarray(truth.transducer_gain)
    return found


def _through_frame(truth: PlateTruth, load: np.ndarray, rate_hz: float) -> np.ndarray:
    """Forces of springs and dampers (N, N·m), shape (n, 2), under F_y and M_x that begin at rest.

    p_i'' + c_i p_i' + k_i p_i = load,    sum_i s_i (c_i p_i' + k_i p_i)
    """
    change, felt = load - load[0], np.tile(load[0], (len(load), 1))
    for shares, damping, stiffness in truth.modes:
        transfer = [damping, stiffness], [1.0, damping, stiffness]
        # exact for a load that changes linearly between two points of the grid
        numerator, denominator, _ = scipy.signal.cont2discrete(transfer, 1.0 / rate_hz, method="foh")
        felt += scipy.signal.lfilter(numerator[0], denominator, change, axis=0) * shares
    return felt


def _filtered(transfer: tuple[list, list], x: np.ndarray, rate_hz: float) -> np.ndarray:
    """Output of a linear system (numerator, denominator in s) that starts at rest, by Tustin's rule."""
    return scipy.signal.lfilter(*scipy.signal.bilinear(*transfer, rate_hz), x)
