"""Belt, drive and frame below a load, integrated together with it.

The frame sways fore and aft on its transducers, in modes (`tepsipe.virtual_lab.force_plate`). The load stands
on the belt, and moves with the belt and the first mode. With x the displacement of the frame, v the velocity
of the belt on it, and the moving mass m of the first mode over its share of fore-aft forces:

    m (x'' + c x' + k x) = -(F + f_r + m_b v')
    M_b v' = u - d v - F

F is the force of the belt on the load, f_r the belt's friction, m_b the mass of the belt that the transducers
feel, u the force of the servo with the friction d of the drive, which turns the rollers against the frame,
and M_b the mass of belt and drive. F follows from the load's own equations of motion, which contain its
acceleration y'' = v' + x''. Together they are those of a load on a belt of the mass M_e, pushed by P:

    M_e y'' = P - F,    1 / M_e = (1 - m_b / m) / M_b + 1 / m
    P = M_e [(1 - m_b / m) (u - d v) / M_b - f_r / m - c x' - k x]

Rigid ground is a frame of infinite mass. A load on two belts ties their frames together, side by side. Tremor
of the floor does not move the load. The friction that moves the frame is that under the load at rest.

The pitch of the frame, its second mode, moves the belt's surface by p if it has a moving mass m_p over its
share of fore-aft forces. With x the sum of both motions,

    1 / M_e = (1 - m_b k_m) / M_b + k_m,     k_m = 1 / m + 1 / m_p
    P = M_e [(1 - m_b k_m) (u - d v) / M_b - k_m f_r - r - r_p],     r = c (x' - p') + k (x - p)
    p'' = (x'' + r + r_p) / (k_m m_p) - r_p,                         r_p = c_p p' + k_p p

The fore-aft force rocks the frame at the height of the belt. The moment M_x of the load reaches the
transducers through both modes, but its part in the motion below the load is left out, as is the tilt of the
belt.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy

from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.force_plate import Mode, PlateTruth
from tepsipe.virtual_lab.integrate import Derivative

# plates of the belts below a load, and the part of its weight on each; without any the ground is rigid
Below = Sequence[tuple[PlateTruth, float]]

# largest phase of a mode in one step of the integration (rad): a faster one is rigid
FASTEST = 1.0


class MovingBelt:
    """Equations of belt, drive and frame, to be completed by those of a load.

    load: vertical force of the load at rest (N).
    rate_hz: steps of the integration per second.
    below: plates of the belts that carry the load.
    """

    def __init__(self, drive: DriveTruth, load: float, rate_hz: float, below: Below = ()):
        moving = [
            (plate, part) for plate, part in below if _moves(plate.resonance_mass_kg, plate.modes[0], rate_hz)
        ]
        own = _tied([(plate.resonance_mass_kg, plate.modes[0]) for plate, _ in moving])
        pitching = [
            (plate.second_mass_kg, plate.modes[1])
            for plate, _ in moving
            if _moves(plate.second_mass_kg, plate.modes[1], rate_hz)
        ]
        pitch = _tied(pitching)
        self._per_kg, self._damping, self._stiffness = own
        self._pitch = None
        """Pitch of the frame, if it moves the load: k_p - k, c_p - c, k_p, c_p, and 1 / (k_m m_p)."""
        if pitching:
            self._per_kg += pitch[0]
            (_, c, k), (of_pitch, c_p, k_p) = own, pitch
            self._pitch = k_p - k, c_p - c, k_p, c_p, of_pitch / self._per_kg
        self._now = [0.0, 0.0]
        """Displacement (m) and velocity (m/s) of the pitch."""
        self._frictions = [_friction(plate, part * load, rate_hz) for plate, part in moving]
        self._friction = [0.0, 0.0]
        """At the start of a step, and in its middle (N)."""
        not_felt = 1.0 - self._per_kg * sum(plate.felt_belt_mass_kg for plate, _ in moving)
        self.moving_kg = drive.belt_mass_kg / (not_felt + drive.belt_mass_kg * self._per_kg)
        """Mass M_e."""
        self.swaying = 1.0 - self.moving_kg / drive.belt_mass_kg
        """Acceleration x'' of the frame per y''."""
        self.pushed = self._equations(drive, not_felt * self.moving_kg / drive.belt_mass_kg)

    def _equations(self, drive: DriveTruth, of_pull: float) -> Callable[..., tuple[float, float, float]]:
        """Function of numbers, which the integration calls some thousand times for each second of a trial.

        ``pushed(command, y', q, x, x')`` (m/s, m) gives P (N), the servo's rate, and the acceleration of the
        frame (m/s²) without y''.
        """
        gain = 2.0 * math.pi * drive.bandwidth_hz * drive.belt_mass_kg
        period, most, least = drive.integral_time_s, drive.force_limit_N, -drive.force_limit_N
        viscous, friction = drive.viscous_Ns_per_m, self._friction
        by_friction, damping, stiffness = (
            self.moving_kg * a for a in (self._per_kg, self._damping, self._stiffness)
        )
        by_kg = 1.0 / drive.belt_mass_kg
        pitch = self._now if self._pitch else None
        more_k, more_c = (self.moving_kg * a for a in self._pitch[:2]) if self._pitch else (0.0, 0.0)

        def pushed(commanded: float, rate: float, q: float, x: float, x_rate: float) -> tuple:
            v = rate - x_rate
            q_rate = commanded - v
            u = gain * (q_rate + q / period)
            if u > most:
                u, q_rate = most, 0.0
            elif u < least:
                u, q_rate = least, 0.0
            pull = u - viscous * v
            push = of_pull * pull - by_friction * friction[1] - damping * x_rate - stiffness * x
            if pitch:
                push -= more_k * pitch[0] + more_c * pitch[1]
            return push, q_rate, by_kg * (push - pull)

        return pushed

    def with_pitch(
        self, derivative: Derivative, start: tuple[float, ...]
    ) -> tuple[Derivative, tuple[float, ...]]:
        """Equations of motion and initial state of a load, with those of the pitch if it moves the load.

        derivative, start: of a load; the last two states are x and x'. The pitch adds p and p' after them.
        """
        if self._pitch is None:
            return derivative, start
        more_k, more_c, k_p, c_p, share = self._pitch
        k, c, now = k_p - more_k, c_p - more_c, self._now

        def with_it(inputs: Any, state: tuple[float, ...]) -> tuple[float, ...]:
            *of_load, p, p_rate = state
            now[0], now[1] = p, p_rate
            rates = derivative(inputs, tuple(of_load))
            x, x_rate = of_load[-2:]
            own = c_p * p_rate + k_p * p
            together = rates[-1] + c * (x_rate - p_rate) + k * (x - p) + own
            return (*rates, p_rate, share * together - own)

        return with_it, (*start, 0.0, 0.0)

    def begin_step(self, k: int, v: float) -> None:
        """Take the friction at the start of step k from the belt's velocity on its frame (m/s)."""
        before, now = self._friction[0], 0.0
        for friction in self._frictions:
            now += friction(k, v)
        self._friction[:] = now, now + 0.5 * (now - before)


def _moves(mass_kg: float, mode: Mode, rate_hz: float) -> bool:
    """Test for a mode that moves the load, and is slow enough for the steps of the integration."""
    return mass_kg * mode.shares[0] > 0.0 and math.sqrt(mode.stiffness_per_s2) < FASTEST * rate_hz


def _tied(modes: list[tuple[float, Mode]]) -> tuple[float, float, float]:
    """1 / m (1/kg), c (1/s) and k (1/s²) of the same mode of several frames side by side."""
    masses = [(kg / mode.shares[0], mode.damping_per_s, mode.stiffness_per_s2) for kg, mode in modes]
    kg = sum(mass for mass, *_ in masses)
    per_kg = 1.0 / kg if masses else 0.0
    damping = per_kg * sum(mass * damping for mass, damping, _ in masses)
    return per_kg, damping, per_kg * sum(mass * stiffness for mass, _, stiffness in masses)


def _friction(plate: PlateTruth, load: float, rate_hz: float) -> Callable[[int, float], float]:
    """``friction(k, v)``: friction (N) at point k of the grid, as `belt_wrench` with the mean lag."""
    speed, viscous, share = plate.friction_speed_m_per_s, plate.friction_Ns_per_m, plate.bristle_share
    rubbing = plate.friction_N + plate.friction_coefficient * load
    lag, tanh, exp = plate.belt_lag_s * rate_hz, math.tanh, math.exp
    z, before, faster, at = 0.0, 0.0, 0.0, -1

    def friction(k: int, v: float) -> float:
        nonlocal z, before, faster, at
        since = k - at
        # change of the velocity in a step, taken on from the middle of the last one
        slower, faster = faster, (v - before) / since
        rollers = v + lag * (1.5 * faster - 0.5 * slower)
        before, at = v, k
        sliding = tanh(rollers / speed)
        if share and rollers:
            sign = 1.0 if rollers > 0.0 else -1.0
            z = sign + (z - sign) * exp(-abs(rollers) * since / rate_hz / plate.bristle_m)
        return rubbing * (sliding + share * (z - sliding)) + viscous * rollers

    return friction


def motion_of_belt(
    time: np.ndarray, y: np.ndarray, v: np.ndarray, x: np.ndarray, x_rate: np.ndarray
) -> dict[str, np.ndarray]:
    """Fields of `BeltMotion` but the reaction.

    time: grid of the integration (s).
    y, v, x, x_rate: motion of the load and of the frame below it (m, m/s).
    """
    rates = np.column_stack([v - x_rate, x_rate])
    belt, frame = scipy.interpolate.CubicSpline(time, rates)(time, 1).T
    return {
        "time": time,
        "belt_position": y - x,
        "belt_velocity": rates[:, 0],
        "belt_acceleration": belt,
        "frame_position": x,
        "frame_velocity": x_rate,
        "frame_acceleration": frame,
    }
