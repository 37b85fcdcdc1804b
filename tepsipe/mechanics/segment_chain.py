"""Segments that stand on one another in the sagittal plane: equations of motion, linearised about a posture.

Segment i has mass m_i, length l_i, centre of mass c_i above its lower end, moment of inertia I_i about it,
and the absolute angle phi_i from the vertical, positive forwards. The lowest stands on a belt with the
acceleration a. With the mass M_i above segment i, S_i = m_i c_i + M_i l_i and J_i = I_i + m_i c_i^2 + M_i
l_i^2,

    A_ii = J_i,   A_ij = l_i S_j cos(phi_i - phi_j)  (j above i),                                     (1)
    sum_j A_ij phi_j'' + (terms in phi'^2) = g S_i sin phi_i - a S_i cos phi_i + Q_i                  (2)

for the kinetic energy phi' A phi' / 2. A horizontal force at the height d above the lower end of segment k
has Q_i = l_i cos phi_i below k and Q_k = d cos phi_k. The joint angles q_1 = phi_1, q_i = phi_i -
phi_(i-1), or phi = T q, have the conjugate torques T'Q. About a posture that the joints hold against
gravity,

    M q'' + G q + (torque that resists) = b u,   M = T'A T,   G = -T' diag(g S cos phi) T             (3)

for a force or an acceleration u. A and G, and b of the belt, are linear in the 2n constants J and S; lengths
enter as factors only, so that masses that are not known are 2n unknowns.
"""

from dataclasses import dataclass, replace
from typing import Annotated, Self

import numpy as np


@dataclass(frozen=True)
class Chain:
    """Segments from the lowest to the highest."""

    mass_kg: tuple[float, ...]
    length_m: tuple[float, ...]
    com_m: tuple[float, ...]
    """Masses (kg), lengths (m), centres of mass above the lower ends (m)."""
    inertia_kgm2: tuple[float, ...]
    """Moments of inertia about the centres of mass (kg m²)."""
    gravity_m_per_s2: float = 9.81

    @classmethod
    def from_settings(cls, person: dict) -> Self:
        """Chain of lists of masses, lengths, centres of mass and moments of inertia (kg, m, kg m²)."""
        lists = {key: tuple(person[key]) for key in ("mass_kg", "length_m", "com_m", "inertia_kgm2")}
        return cls(**lists, gravity_m_per_s2=person["gravity_m_per_s2"])

    @property
    def constants(self) -> tuple[np.ndarray, np.ndarray]:
        """J (kg m²) and S (kg m) of (1), each of shape (n,)."""
        m, length, c = (np.array(x) for x in (self.mass_kg, self.length_m, self.com_m))
        above = m.sum() - np.cumsum(m)
        return np.array(self.inertia_kgm2) + m * c**2 + above * length**2, m * c + above * length

    def relative_covariance(self, tolerance: float) -> np.ndarray:
        """Covariance of J and S over their values, shape (2 n, 2 n).

        ``tolerance`` is the relative standard uncertainty of every mass, centre of mass and moment of
        inertia, which are independent. A mass above several segments is part of the constants of each.
        """
        m, length, c = (np.array(x) for x in (self.mass_kg, self.length_m, self.com_m))
        above = np.triu(np.ones((m.size, m.size)), 1) * m
        first, second = np.diag(m * c), np.diag(m * c**2)
        of_j = np.hstack([second + length[:, None] ** 2 * above, 2.0 * second, np.diag(self.inertia_kgm2)])
        of_s = np.hstack([first + length[:, None] * above, first, np.zeros_like(first)])
        slopes = np.vstack([of_j, of_s]) / np.concatenate(self.constants)[:, None]
        return tolerance**2 * slopes @ slopes.T

    def drawn(self, rng: np.random.Generator, tolerance: float) -> "Chain":
        """A chain with random errors of masses (kg), centres of mass (m) and moments of inertia (kg m²).

        ``tolerance`` is their relative standard deviation.
        """

        def off(values: tuple[float, ...]) -> tuple[float, ...]:
            return tuple((np.array(values) * (1.0 + tolerance * rng.standard_normal(len(values)))).tolist())

        return replace(
            self, mass_kg=off(self.mass_kg), com_m=off(self.com_m), inertia_kgm2=off(self.inertia_kgm2)
        )


@dataclass(frozen=True)
class LinearChain:
    """Equations (3) about a posture; every constant of J and S multiplies one part of them."""

    inertia_parts: Annotated[np.ndarray, "(2 n, n, n)"]
    """Parts of M that J_1 ... J_n, S_1 ... S_n make (kg m²)."""
    gravity_parts: Annotated[np.ndarray, "(2 n, n, n)", "N·m/rad"]
    belt_parts: Annotated[np.ndarray, "(2 n, n)"]
    """Parts of b of the belt's acceleration (kg m)."""
    posture: Annotated[np.ndarray, "(n,)", "rad"]
    """Absolute angles of the segments."""
    length_m: tuple[float, ...]
    """Lengths of the segments."""

    @property
    def inertia(self) -> np.ndarray:
        """Inertia matrix M (kg m²), shape (n, n)."""
        return self.inertia_parts.sum(axis=0)

    @property
    def gravity(self) -> np.ndarray:
        """Gravity matrix G (N·m/rad), shape (n, n), negative where gravity makes the posture fall."""
        return self.gravity_parts.sum(axis=0)

    def push(self, segment: int, height_m: float) -> np.ndarray:
        """Vector b (m) of a horizontal force on a segment (from 0), a height (m) above its lower end."""
        levers = np.zeros(self.posture.size)
        levers[:segment] = self.length_m[:segment]
        levers[segment] = height_m
        return to_segments(levers.size).T @ (levers * np.cos(self.posture))


def to_segments(n: int) -> np.ndarray:
    """Matrix T of phi = T q for n segments, shape (n, n)."""
    return np.tril(np.ones((n, n)))


def joint_angles(segment_angles: np.ndarray) -> np.ndarray:
    """Joint angles q, shape (..., n) (rad), of absolute angles phi of the segments, shape (..., n) (rad)."""
    return np.diff(segment_angles, axis=-1, prepend=0.0)


def linearised(chain: Chain, posture: Annotated[np.ndarray, "(n,)", "rad"]) -> LinearChain:
    """Equations of motion about a posture in joint angles.

    posture: absolute angles of the segments.
    """
    posture = np.asarray(posture, float)
    n, lengths = posture.size, np.array(chain.length_m)
    j, s = chain.constants
    t, unit = to_segments(n), np.eye(n)
    cosines = np.cos(posture)
    inertia, gravity, belt = np.zeros((2 * n, n, n)), np.zeros((2 * n, n, n)), np.zeros((2 * n, n))
    for i in range(n):
        inertia[i] = j[i] * np.outer(unit[i], unit[i])
        below = np.where(np.arange(n) < i, lengths * np.cos(posture - posture[i]), 0.0)
        inertia[n + i] = s[i] * (np.outer(unit[i], below) + np.outer(below, unit[i]))
        gravity[n + i] = -chain.gravity_m_per_s2 * s[i] * cosines[i] * np.outer(unit[i], unit[i])
        belt[n + i] = -s[i] * cosines[i] * unit[i]
    return LinearChain(t.T @ inertia @ t, t.T @ gravity @ t, belt @ t, posture, chain.length_m)
