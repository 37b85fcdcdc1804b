"""Pulses of the belt: commanded velocity, response of the drive, and peaks.

The drive is a proportional-integral servo of the belt's velocity, whose force is limited,

    e = v_command - v,    v' = clip(2 pi f (e + q / T), -a_max, a_max),    q' = e while v' is not clipped

with f its bandwidth, T its integral time and a_max the force over the moved mass.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.arguments import check_options
from tepsipe.errors import InputError, listed, quoted
from tepsipe.quantities import Acceleration, Frequency, Length, Positive, Time, Velocity

# step of all motions of the belt (s)
STEP_S = 0.001
# part of the peak velocity below which the belt rests
_SETTLED = 1e-6
# longest time allowed for a drive to settle (s)
_LONGEST_S = 4.0


def _sine(s: np.ndarray) -> np.ndarray:
    return np.sin(2.0 * np.pi * s)


def _bump(s: np.ndarray) -> np.ndarray:
    """Velocity of a minimum-jerk movement with the peak 1."""
    return 16.0 * s**2 * (1.0 - s) ** 2


def _minjerk(s: np.ndarray) -> np.ndarray:
    return np.where(s < 0.5, _bump(2.0 * s), -_bump(2.0 * s - 1.0))


def _half_sine(s: np.ndarray) -> np.ndarray:
    return np.sin(np.pi * s)


# velocity over the elapsed part of the pulse, and whether the belt stays displaced
PROFILES: dict[str, tuple[Callable[[np.ndarray], np.ndarray], bool]] = {
    "sine": (_sine, False),
    "minjerk": (_minjerk, False),
    "half-sine": (_half_sine, True),
    "ramp": (_bump, True),
}


@dataclass(frozen=True)
class Pulse:
    """A commanded pulse of the belt."""

    profile: str
    """Its name."""
    velocity_m_per_s: np.ndarray
    """Commanded velocity every `STEP_S`, 0 at both ends."""
    one_way: bool
    """Whether the belt stays where it was moved to; the next pulse then goes back."""

    @property
    def duration_s(self) -> float:
        """Length of the command (s)."""
        return (self.velocity_m_per_s.size - 1) * STEP_S


def pulse_of(profile: str, amplitude_m_per_s: float, duration_s: float) -> Pulse:
    """A pulse of a known profile.

    profile: {"sine", "minjerk", "half-sine", "ramp"}: A period of a sine, or a minimum-jerk movement out
    and one back, as in the thesis; half a sine, or one minimum-jerk movement, after which the belt stays
    where it is.
    amplitude_m_per_s: peak velocity of the command.
    duration_s: its length.
    """
    if profile not in PROFILES:
        raise InputError(
            f"pulse: expected a profile of {listed(PROFILES)}, found {quoted(profile)}: correct it"
        )
    for name, value, least in (
        ("amplitude_m_per_s", amplitude_m_per_s, math.ulp(0.0)),
        ("duration_s", duration_s, 10.0 * STEP_S),
    ):
        if not (math.isfinite(value) and value >= least):
            what = "a positive number" if least < STEP_S else f"at least {least:g} s"
            raise InputError(f"pulse: expected {what} for {name}, found {value:g}: correct it")
    shape, one_way = PROFILES[profile]
    passed = np.linspace(0.0, 1.0, round(duration_s / STEP_S) + 1)
    return Pulse(profile, amplitude_m_per_s * shape(passed), one_way)


@dataclass(frozen=True, kw_only=True)
class Drive:
    """The belt's drive."""

    bandwidth_hz: Frequency | None = 14.0
    """Bandwidth; null: the belt follows every command."""
    integral_s: Time = 0.25
    """Proportional over integral gain."""
    acceleration_m_per_s2: Acceleration = 24.0
    """Largest force over the moved mass."""

    def __post_init__(self):
        """Refuse impossible drives."""
        check_options(Drive, self, "drive")

    def follow(self, command_m_per_s: np.ndarray, limited: bool = True) -> np.ndarray:
        """Velocity of the belt (m/s) every `STEP_S` after a command (m/s), until it rests; both start at 0.

        Without ``limited`` the force has no limit, and the velocity is linear in the command.
        """
        if self.bandwidth_hz is None:
            return np.asarray(command_m_per_s, dtype=float)
        gain, most = 2.0 * math.pi * self.bandwidth_hz, self.acceleration_m_per_s2 if limited else math.inf
        peak = float(np.abs(command_m_per_s).max())
        v, q, velocity = 0.0, 0.0, [0.0]
        command = np.asarray(command_m_per_s, dtype=float).tolist()
        # a step of the servo is solved with the command half-way through it
        halfway = [0.5 * (a + b) for a, b in itertools.pairwise(command)]
        parts, h = 4, STEP_S / 4
        for k in range(len(halfway) + round(_LONGEST_S / STEP_S)):
            wanted = halfway[k] if k < len(halfway) else 0.0
            for _ in range(parts):
                error = wanted - v
                force = gain * (error + q / self.integral_s)
                held = min(max(force, -most), most)
                if held == force:
                    q += h * error
                v += h * held
            velocity.append(v)
            if k > len(halfway) and max(abs(v), abs(q) / self.integral_s) < _SETTLED * peak:
                break
        return np.array(velocity)


@dataclass(frozen=True)
class Limits:
    """Largest motion that a subject or a drive allows; a limit that is not set is infinite."""

    velocity_m_per_s: Velocity = math.inf
    """Largest velocity."""
    displacement_m: Length = math.inf
    """Largest displacement."""
    acceleration_m_per_s2: Acceleration = math.inf
    """Largest acceleration."""
    jerk_m_per_s3: Annotated[Positive, "m/s³"] = math.inf
    """Largest jerk."""

    def __post_init__(self):
        """Refuse limits that no pulse can meet."""
        for name, value in vars(self).items():
            if not value > 0.0:
                raise InputError(
                    f"limits: expected a positive number for {name}, found {value:g}, which no pulse meets: "
                    "raise it"
                )

    def hold(self, other: "Limits") -> bool:
        """Test for peaks of a motion (m/s, m, m/s², m/s³) within these limits."""
        pairs = zip(vars(other).values(), vars(self).values(), strict=True)
        return all(peak <= limit * (1.0 + 1e-6) for peak, limit in pairs)


def peaks_of(velocity_m_per_s: np.ndarray) -> Limits:
    """Peak velocity, displacement, acceleration and jerk (over `STEP_S`) of a motion of the belt (m/s)."""
    velocity = np.concatenate([[0.0], velocity_m_per_s, [0.0]])
    displacement = STEP_S * np.cumsum(0.5 * (velocity[1:] + velocity[:-1]))
    acceleration = np.diff(velocity) / STEP_S
    jerk = np.diff(acceleration, prepend=0.0, append=0.0) / STEP_S
    return Limits(*(float(np.abs(x).max()) for x in (velocity, displacement, acceleration, jerk)))
