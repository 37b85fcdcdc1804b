"""A person of two segments who stands on a platform that moves forwards and backwards.

Legs and trunk are a double inverted pendulum, with the absolute angles p of the legs and q of the trunk from
the vertical, the platform's acceleration a and a push F at the hip:

    J1 p'' + h cos(p - q) q'' + h sin(p - q) q'^2 = S1 (g sin p - a cos p) - T1 + T2 + F l cos p
    J2 q'' + h cos(p - q) p'' - h sin(p - q) p'^2 = S2 (g sin q - a cos q) - T2

J1 = I1 + m1 c1^2 + m2 l^2, J2 = I2 + m2 c2^2, h = m2 l c2, S1 = m1 c1 + m2 l, S2 = m2 c2. The torques T of
ankle and hip resist their angles (p, q - p) at once and with a delay. The person's own torque is coloured
noise, which moves the body and comes back through the feedback.
"""

from dataclasses import dataclass, replace
from math import cos, sin
from typing import Annotated

import numpy as np

Matrix = tuple[tuple[float, float], tuple[float, float]]
NONE: Matrix = ((0.0, 0.0), (0.0, 0.0))
# time before the record in which the motion settles (s)
SETTLING_S = 20.0


@dataclass(frozen=True)
class PlatformPerson:
    """Hidden constants of the person; rows of matrices are torques of ankle and hip, columns their angles."""

    leg_mass_kg: float = 23.0
    trunk_mass_kg: float = 48.0
    """Masses."""
    leg_length_m: float = 0.85
    leg_com_m: float = 0.47
    trunk_com_m: float = 0.33
    """Ankle to hip, ankle to the legs' centre of mass, hip to the trunk's."""
    leg_inertia_kgm2: float = 1.7
    trunk_inertia_kgm2: float = 3.3
    """Moments of inertia about the centres of mass (kg m²)."""
    stiffness_Nm_per_rad: Matrix = ((1000.0, 180.0), (120.0, 420.0))
    damping_Nms_per_rad: Matrix = ((120.0, 30.0), (25.0, 45.0))
    """That act at once."""
    reflex_stiffness_Nm_per_rad: Matrix = NONE
    reflex_damping_Nms_per_rad: Matrix = NONE
    """That act with the delay."""
    delay_s: tuple[float, float] = (0.1, 0.1)
    """Delays of the reflexes of ankle and hip."""
    own_torque_Nm: tuple[float, float] = (8.0, 4.0)
    """Standard deviation of the torque that the person makes at will."""
    own_band_hz: tuple[float, float] = (0.05, 1.0)
    """Corner frequencies of that torque."""
    gravity_m_per_s2: float = 9.81
    """Acceleration of gravity."""

    def with_reflex(self) -> "PlatformPerson":
        """A person whose joints are less stiff (N·m/rad) and have reflexes, each of its own angle."""
        return replace(
            self,
            stiffness_Nm_per_rad=((800.0, 170.0), (110.0, 400.0)),
            damping_Nms_per_rad=((80.0, 25.0), (20.0, 40.0)),
            reflex_stiffness_Nm_per_rad=((300.0, 0.0), (0.0, 60.0)),
            reflex_damping_Nms_per_rad=((60.0, 0.0), (0.0, 15.0)),
            delay_s=(0.12, 0.1),
        )


@dataclass(frozen=True)
class PlatformProtocol:
    """Perturbations of the person, and their measurement."""

    duration_s: float = 300.0
    rate_hz: float = 50.0
    """Length of the record (s) and sampling rate (Hz)."""
    platform_m: float = 0.024
    """Standard deviation of the platform's position."""
    platform_band_hz: tuple[float, float] = (0.1, 1.2)
    """Corner frequencies of its random motion."""
    push_N: float = 0.0
    """Standard deviation of a random push at the hip, the second perturbation (N); 0 for none."""
    push_band_hz: tuple[float, float] = (0.1, 2.0)
    """Corner frequencies of the push."""
    angle_noise_rad: float = 2e-4
    torque_noise_Nm: float = 0.3
    """Standard deviation of the sensors' noise."""
    step_s: float = 0.004
    """Step of the integration."""


@dataclass(frozen=True)
class PlatformRecord:
    """Signals recorded by the instruments."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    platform: Annotated[np.ndarray, "(n,)", "m"]
    """Position of the platform."""
    push: Annotated[np.ndarray, "(n,)", "N"]
    """Push at the hip."""
    angle: Annotated[np.ndarray, "(n, 2)", "rad"]
    torque: Annotated[np.ndarray, "(n, 2)", "N·m"]
    """Angles and torques of ankle and hip; torque resists."""


def coloured_noise(
    rng: np.random.Generator, count: int, step_s: float, band_hz: tuple[float, float], order: int
) -> Annotated[np.ndarray, "(count,)"]:
    """Random signal of unit variance, flat between two corner frequencies.

    count: number of samples.
    step_s: sampling period.
    order: order of the decline above the upper one; below the lower one it is 2.
    Returns: Samples.
    """
    frequency = np.fft.rfftfreq(count, step_s)
    gain = np.zeros(frequency.size)
    above = frequency[1:]
    gain[1:] = 1.0 / np.sqrt((1.0 + (band_hz[0] / above) ** 4) * (1.0 + (above / band_hz[1]) ** (2 * order)))
    x = np.fft.irfft(np.fft.rfft(rng.standard_normal(count)) * gain, count)
    return x / x.std()


def record_platform(
    person: PlatformPerson, protocol: PlatformProtocol, rng: np.random.Generator
) -> PlatformRecord:
    """Move the platform and record the person."""
    step = protocol.step_s
    count = round((protocol.duration_s + SETTLING_S) / step)

    def drawn(deviation: float, band_hz: tuple[float, float], order: int) -> np.ndarray:
        return deviation * coloured_noise(rng, count, step, band_hz, order)

    platform = drawn(protocol.platform_m, protocol.platform_band_hz, 3)
    acceleration = np.gradient(np.gradient(platform, step), step)
    push = drawn(protocol.push_N, protocol.push_band_hz, 2)
    spontaneous = np.column_stack(
        [drawn(deviation, person.own_band_hz, 2) for deviation in person.own_torque_Nm]
    )
    angle, torque = _move(person, acceleration, push, spontaneous, step)
    every = slice(round(SETTLING_S / step), None, round(1.0 / (protocol.rate_hz * step)))
    angle, torque = angle[every], torque[every]
    angle = angle + protocol.angle_noise_rad * rng.standard_normal(angle.shape)
    torque = torque + protocol.torque_noise_Nm * rng.standard_normal(torque.shape)
    return PlatformRecord(
        np.arange(angle.shape[0]) / protocol.rate_hz, platform[every], push[every], angle, torque
    )


def _accelerations(person: PlatformPerson):
    """Function of the angles, their rates, platform, push and torques that returns p'', (q - p)''."""
    m1, m2, c2 = person.leg_mass_kg, person.trunk_mass_kg, person.trunk_com_m
    length, g = person.leg_length_m, person.gravity_m_per_s2
    j1 = person.leg_inertia_kgm2 + m1 * person.leg_com_m**2 + m2 * length**2
    j2, h = person.trunk_inertia_kgm2 + m2 * c2**2, m2 * length * c2
    s1, s2 = m1 * person.leg_com_m + m2 * length, m2 * c2

    def accelerations(p, r, p_rate, r_rate, a, push, t1, t2):
        q, q_rate = p + r, p_rate + r_rate
        coupling, slope = h * cos(r), h * sin(-r)
        first = s1 * (g * sin(p) - a * cos(p)) - t1 + t2 + push * length * cos(p) - slope * q_rate**2
        second = s2 * (g * sin(q) - a * cos(q)) - t2 + slope * p_rate**2
        determinant = j1 * j2 - coupling**2
        p_second = (j2 * first - coupling * second) / determinant
        return p_second, (j1 * second - coupling * first) / determinant - p_second

    return accelerations


def _move(
    person: PlatformPerson, acceleration, push, spontaneous, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate by the midpoint rule in plain numbers (rad, N·m), which are faster than short arrays."""
    (k11, k12), (k21, k22) = person.stiffness_Nm_per_rad
    (b11, b12), (b21, b22) = person.damping_Nms_per_rad
    (d11, d12), (d21, d22) = person.reflex_stiffness_Nm_per_rad
    (e11, e12), (e21, e22) = person.reflex_damping_Nms_per_rad
    late1, late2 = (round(delay / step) for delay in person.delay_s)
    accelerations = _accelerations(person)
    count = len(push)
    states, torques = [(0.0, 0.0, 0.0, 0.0)] * count, [(0.0, 0.0)] * count
    p = r = u = w = 0.0
    for i, (a, f, n1, n2) in enumerate(
        zip(acceleration.tolist(), push.tolist(), *spontaneous.T.tolist(), strict=True)
    ):
        states[i] = (p, r, u, w)
        if i >= late1:
            x, y, dx, dy = states[i - late1]
            n1 += d11 * x + d12 * y + e11 * dx + e12 * dy
        if i >= late2:
            x, y, dx, dy = states[i - late2]
            n2 += d21 * x + d22 * y + e21 * dx + e22 * dy
        t1, t2 = n1 + k11 * p + k12 * r + b11 * u + b12 * w, n2 + k21 * p + k22 * r + b21 * u + b22 * w
        torques[i] = (t1, t2)
        p2, r2 = accelerations(p, r, u, w, a, f, t1, t2)
        pm, rm, um, wm = p + 0.5 * step * u, r + 0.5 * step * w, u + 0.5 * step * p2, w + 0.5 * step * r2
        t1, t2 = (
            n1 + k11 * pm + k12 * rm + b11 * um + b12 * wm,
            n2 + k21 * pm + k22 * rm + b21 * um + b22 * wm,
        )
        p2, r2 = accelerations(pm, rm, um, wm, a, f, t1, t2)
        p, r, u, w = p + step * um, r + step * wm, u + step * p2, w + step * r2
        if abs(p) > 1.0 or abs(r) > 1.5:
            raise RuntimeError(f"the person falls after {i * step:.1f} s")
    return np.array(states)[:, :2], np.array(torques)
