"""The treadmill belt's drive: commanded velocity pulses and the servo that follows them.

Symbols: v belt velocity (m/s), q integral of the velocity error (m), u drive force (N).

    e = v_command(t - delay) - v,   u = clip(P e + Q q, -u_max, u_max),   q' = e while u is not clipped
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le

from tepsipe.quantities import Frequency, Mass, NotNegative, Time


@dataclass(frozen=True)
class DriveTruth:
    """Drive of the belt."""

    belt_mass_kg: Mass
    """Belt, rollers and motor, reflected to the belt."""
    bandwidth_hz: Frequency
    """Proportional gain over belt mass as a frequency."""
    integral_time_s: Time
    """Proportional over integral gain."""
    force_limit_N: Annotated[float, Gt(0), Le(100000)]
    """Largest drive force."""
    delay_s: Annotated[float, Ge(0), Le(10)]
    """From command to force."""
    viscous_Ns_per_m: NotNegative
    """Friction of the unloaded belt."""
    velocity_step_m_per_s: Annotated[float, Gt(0), Le(10)]
    """Resolution of the logged belt velocity."""
    velocity_noise_m_per_s: NotNegative
    """Noise of the logged belt velocity."""


@dataclass(frozen=True)
class BeltMotion:
    """Exact motion of belt and frame, and what the load asks of the plate."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    """Grid of the integration."""
    belt_position: Annotated[np.ndarray, "(n,)", "m"]
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"]
    belt_acceleration: Annotated[np.ndarray, "(n,)", "m/s²"]
    """Motion of the belt along y on its frame, as its encoder sees it."""
    frame_position: Annotated[np.ndarray, "(n,)", "m"]
    frame_velocity: Annotated[np.ndarray, "(n,)", "m/s"]
    frame_acceleration: Annotated[np.ndarray, "(n,)", "m/s²"]
    """Motion of the frame along y."""
    reaction: Annotated[np.ndarray, "(n, 6)"]
    """Wrench of the plate on the load about the plate's origin: Fx, Fy, Fz (N), Mx, My, Mz (N·m)."""

    @property
    def position(self) -> Annotated[np.ndarray, "(n,)", "m"]:
        """Displacement of what stands on the belt."""
        return self.belt_position + self.frame_position

    @property
    def velocity(self) -> Annotated[np.ndarray, "(n,)", "m/s"]:
        """Its velocity."""
        return self.belt_velocity + self.frame_velocity

    @property
    def acceleration(self) -> Annotated[np.ndarray, "(n,)", "m/s²"]:
        """Its acceleration."""
        return self.belt_acceleration + self.frame_acceleration

    @property
    def rate_hz(self) -> float:
        """Steps of the integration per second, a whole number (Hz)."""
        return float(round((self.time.size - 1) / self.time[-1]))


def sine_pulse(s: np.ndarray) -> np.ndarray:
    """One full sine period in normalised time ``s`` in 0..1, with peaks +1 and -1."""
    return np.sin(2.0 * np.pi * s)


def minimum_jerk_pulse(s: np.ndarray) -> np.ndarray:
    """A minimum-jerk movement out and one back in normalised time ``s`` in 0..1: peaks +1, -1."""
    half = 2.0 * s % 1.0
    return np.where(s < 0.5, 16.0, -16.0) * half**2 * (1.0 - half) ** 2


def negative_sine_pulse(s: np.ndarray) -> np.ndarray:
    """`sine_pulse` with its sign reversed, for ``s`` in 0..1."""
    return -sine_pulse(s)


PULSES = {"sine": sine_pulse, "negative-sine": negative_sine_pulse, "minjerk": minimum_jerk_pulse}

# commanded belt velocity (m/s) at instants (s), of any shape
Command = Callable[[np.ndarray], np.ndarray]


def velocity_command(profile: str, amplitude_m_per_s: float, onsets_s: np.ndarray, pulse_s: float) -> Command:
    """Commanded belt velocity as a function of time.

    profile: {"sine", "negative-sine", "minjerk"}: Shape of one pulse.
    amplitude_m_per_s: peak velocity.
    onsets_s: onsets of the pulses (s), ascending.
    pulse_s: length of a pulse.
    Returns: ``command(t)`` gives m/s at t (s).
    """
    since = np.concatenate([[-np.inf], onsets_s])

    def command(t: np.ndarray) -> np.ndarray:
        s = np.asarray((t - since[np.searchsorted(onsets_s, t, side="right")]) / pulse_s)
        moving = s < 1.0
        velocity = np.zeros(s.shape)
        velocity[moving] = amplitude_m_per_s * PULSES[profile](s[moving])
        return velocity

    return command


def stage_commands(
    command: Command, delay_s: float, duration_s: float, rate_hz: float
) -> Annotated[np.ndarray, "(n, 3)", "m/s"]:
    """Commands that the servo has received at start, middle and end of every step of a run.

    command: commanded belt velocity (m/s) at t (s).
    delay_s: delay of the drive.
    duration_s, rate_hz: length of the run (s), and steps per second (Hz).
    """
    h = 1.0 / rate_hz
    start = np.arange(math.ceil(duration_s * rate_hz)) * h
    return command(np.column_stack([start, start + 0.5 * h, start + h]) - delay_s)
