"""Anthropometry: segment parameters as fractions of body mass and stature.

Source: D. A. Winter (2009), Biomechanics and Motor Control of Human Movement, 4th edition, Table 4.1 and
Figure 4.1. A foot is 0.0145 of the body's mass; its centre of mass lies half-way between ankle and second
metatarsal, its radius of gyration is 0.475 of that length, and the length of a foot is 0.152 of the stature.
The centre of mass of the whole body is at 0.55 of the stature above the floor for women and 0.56 for men. The
moment of inertia of a standing body about the ankles equals a uniform rod's, J = 4/3 m h^2 (Morasso &
Schieppati 1999: 1.32).
"""

from dataclasses import dataclass

FOOT_MASS = 0.0145
FOOT_LENGTH = 0.152
FOOT_GYRATION = 0.475
ROD = 4.0 / 3.0


@dataclass(frozen=True)
class Feet:
    """Both feet as one rigid body."""

    mass_kg: float
    inertia_kgm2: float
    """I_f about their centre of mass, for turning in the sagittal plane."""


@dataclass(frozen=True)
class StandingBody:
    """The body above the ankles as one rigid body: the single-joint model of standing."""

    mass_kg: float
    """m, without the feet."""
    com_m: float
    """h, centre of mass above the ankles."""
    inertia_kgm2: float
    """I_b, about the centre of mass."""
    gravity_m_per_s2: float

    @property
    def critical_stiffness(self) -> float:
        """Critical (gravitational) stiffness m g h (N·m/rad): the least stiffness for stable standing."""
        return self.mass_kg * self.gravity_m_per_s2 * self.com_m


def both_feet(mass_kg: float, stature_m: float) -> Feet:
    """Feet of a body of mass (kg) and stature (m)."""
    mass = 2.0 * FOOT_MASS * mass_kg
    return Feet(mass, mass * (FOOT_GYRATION * FOOT_LENGTH * stature_m) ** 2)


def standing_body(
    mass_kg: float, stature_m: float, com_height: float, ankle_height_m: float, gravity_m_per_s2: float
) -> StandingBody:
    """Body above the ankles as one rigid body.

    mass_kg, stature_m: mass and height of the whole body.
    com_height: height of its centre of mass above the floor, as a fraction of the stature.
    ankle_height_m: height of the ankles above the floor (m); the centre of mass of the feet is at half of
    it.
    Returns: mass, centre of mass and moment of inertia.
    """
    feet = both_feet(mass_kg, stature_m).mass_kg
    carried = mass_kg - feet
    height = (mass_kg * com_height * stature_m - feet * 0.5 * ankle_height_m) / carried
    com = height - ankle_height_m
    return StandingBody(carried, com, (ROD - 1.0) * carried * com**2, gravity_m_per_s2)
