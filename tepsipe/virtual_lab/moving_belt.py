"""Belt, drive and frame below a load, integrated together with it.

The frame sways fore and aft on its transducers, in modes. Mode i has a mass m_i on a spring and a damper, and
takes the share s_i of all fore-aft forces; the transducers show the forces of springs and dampers:

    m_i p_i'' + c_i p_i' + k_i p_i = F + f,    x = -sum_i s_i p_i
    F_transducers = sum_i s_i (c_i p_i' + k_i p_i)

F is the force of the belt on the load, f the force that the belt itself needs (`belt_wrench`) and that of the
trembling floor, x the displacement of the frame. The load stands on the belt, and so moves at v + x'. The
drive turns the rollers against the frame, with the mass M_b of belt and drive:

    M_b v' = u - c v - F

F follows from the load's own equations of motion, which contain v' + x''. Together they are those of a load
on a belt of the mass M_e that is pushed by P:

    M_e (v' + x'') = P - F,    1 / M_e = 1 / M_b + sum_i s_i / m_i
    P = M_e [(u - c v) / M_b - sum_i s_i (f - c_i p_i' - k_i p_i) / m_i]

A load on two belts rests on both frames by its parts, and moves with them by the same parts. A moment M_x
tips the frame on its transducers in modes of the same kind, but the frame is so long that its rotation does
not move the load. The friction that moves the frame is that under the load at rest.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.force_plate import Frame, belt_friction


# largest phase of a mode in one step of the integration (rad)
FASTEST = 1.0


@dataclass(frozen=True)
class _Mode:
    """Coefficients of a mode's equation of motion."""

    belt: int
    """Number of its frame."""
    share: float
    """s_i times the frame's part of the load."""
    by_load: float
    by_belt: float
    """p_i'' of F and of f (1/kg)."""
    damping: float
    stiffness: float
    """c_i / m_i (1/s) and k_i / m_i (1/s²)."""


def _modes(frames: Sequence[Frame], rate_hz: float) -> list[_Mode]:
    """Modes that move the load; those that a step of the integration cannot follow are stiff enough not to."""
    modes = []
    for belt, frame in enumerate(frames):
        for mode in frame.plate.modes:
            share = mode.shares[0]
            if share and math.sqrt(mode.stiffness_per_s2) < FASTEST * rate_hz:
                own = frame.part * share, frame.part / mode.mass_kg, 1.0 / mode.mass_kg
                modes.append(_Mode(belt, *own, mode.damping_per_s, mode.stiffness_per_s2))
    return modes


class MovingBelt:
    """Equations of belt, drive and frame, to be completed by those of a load.

    Its states are v (m/s), the servo's (m), and p_i (m), p_i' (m/s) of every mode of the frames.

    load: vertical force of the load at rest (N).
    command: commanded belt velocity (m/s) at t (s).
    frames: of the belts below the load; without any the ground is rigid.
    """

    def __init__(
        self,
        drive: DriveTruth,
        command: Callable[[float], float],
        load: float,
        rate_hz: float,
        frames: Sequence[Frame] = (),
    ):
        modes = self._modes = _modes(frames, rate_hz)
        by_load = sum(mode.share * mode.by_load for mode in modes)
        self.moving_kg = drive.belt_mass_kg / (1.0 + drive.belt_mass_kg * by_load)
        """Mass M_e."""
        self.start = (0.0, 0.0) * len(modes)
        """States of the frame at rest."""
        # of every frame: the force f at the start of a step, and its rate
        self._own = [[0.0, 0.0] for _ in frames]
        self._began, self._acceleration = 0.0, 0.0
        self._own_force = [_own_force(frame, frame.part * load, rate_hz) for frame in frames]
        self._rate_hz = rate_hz
        self.pushed, self.rates = self._equations(drive, command, by_load)

    def _equations(self, drive: DriveTruth, command, by_load: float) -> tuple[Callable, Callable]:
        """Functions of numbers, which the integration calls some thousand times for each second of a trial.

        pushed: ``pushed(t, v, q, frame)`` gives P (N) and what `rates` needs; ``frame`` are its states.
        rates: ``rates(pushed, b)`` gives v', the servo's rate and those of the frame's states, from what
        `pushed` gave and v' + x'' (m/s²).
        """
        force, viscous, delay = drive.servo(), drive.viscous_Ns_per_m, drive.delay_s
        moving_kg, own_forces = self.moving_kg, self._own
        of_pull = moving_kg / drive.belt_mass_kg
        modes = [
            (mode.belt, mode.share, mode.by_load, mode.by_belt, mode.damping, mode.stiffness)
            for mode in self._modes
        ]

        def pushed(t: float, v: float, q: float, frame: Sequence[float]) -> tuple:
            u, q_rate = force(command(t - delay) - v, q)
            late, swaying, free = t - self._began, 0.0, []
            for k, (belt, share, _, by_belt, damping, stiffness) in enumerate(modes):
                now, rate = own_forces[belt]
                p, p_rate = frame[2 * k], frame[2 * k + 1]
                p_rate_rate = by_belt * (now + late * rate) - damping * p_rate - stiffness * p
                swaying -= share * p_rate_rate
                free.append((p_rate, p_rate_rate))
            return of_pull * (u - viscous * v) + moving_kg * swaying, q_rate, swaying, free

        def rates(pushed: tuple, b: float) -> tuple[float, ...]:
            push, q_rate, swaying, free = pushed
            load = push - moving_kg * b
            v_rate = self._acceleration = b - swaying + by_load * load
            found = [v_rate, q_rate]
            for (_, _, by_load_i, _, _, _), (p_rate, p_rate_rate) in zip(modes, free, strict=True):
                found += (p_rate, p_rate_rate + by_load_i * load)
            return tuple(found)

        return pushed, rates

    def begin(self, k: int, v: float) -> None:
        """Take the belt's own forces (N) from the velocity (m/s) at the start of step k.

        Within the step they change as in the step before.
        """
        for own, force in zip(self._own, self._own_force, strict=True):
            before, now = own[0], force(k, v, self._acceleration)
            own[:] = now, (now - before) * self._rate_hz if k else 0.0
        self._began = k / self._rate_hz

    def motion(
        self,
        time: np.ndarray,
        position: np.ndarray,
        velocity: np.ndarray,
        frame: Annotated[np.ndarray, "(n, 2 modes)"],
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
        """Fields of `BeltMotion` but the reaction, and displacement (m) and velocity (m/s) of the load.

        position, velocity: of the belt on its frame (m, m/s).
        frame: states of the frame.
        """
        shares = np.array([mode.share for mode in self._modes])
        x, x_rate = -frame[:, ::2] @ shares, -frame[:, 1::2] @ shares
        fields = {
            "time": time,
            "belt_position": position,
            "belt_velocity": velocity,
            "belt_acceleration": scipy.interpolate.CubicSpline(time, velocity)(time, 1),
            "frame_position": x,
            "frame_velocity": x_rate,
            "frame_acceleration": scipy.interpolate.CubicSpline(time, x_rate)(time, 1),
        }
        return fields, position + x, velocity + x_rate


def _own_force(frame: Frame, load: float, rate_hz: float) -> Callable[[int, float, float], float]:
    """``force(k, v, a)``: f (N) at point k of the grid, from velocity and acceleration of the belt."""
    plate, lag, tremor = frame.plate, frame.lag.tolist(), frame.tremor.tolist()
    z = 0.0

    def force(k: int, velocity: float, acceleration: float) -> float:
        nonlocal z
        at_rollers = velocity + lag[k] * acceleration
        if plate.bristle_share and at_rollers:
            sign = math.copysign(1.0, at_rollers)
            z = sign + (z - sign) * math.exp(-abs(at_rollers) / rate_hz / plate.bristle_m)
        friction = belt_friction(plate, load, at_rollers, z)
        return float(friction) + plate.felt_belt_mass_kg * acceleration + plate.resonance_mass_kg * tremor[k]

    return force
