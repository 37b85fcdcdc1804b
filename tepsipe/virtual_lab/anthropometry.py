"""Segments of a woman's body: masses, centres of mass and moments of inertia.

Source: P. de Leva (1996), Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters, Journal of
Biomechanics 29(9), 1223-1230, Table 4, females: mass as a part of the body's, centre of mass and radius of
gyration about the transverse axis as parts of the segment's length, and lengths for a stature of 1.735 m.
"""

from dataclasses import dataclass

import numpy as np

STATURE_M = 1.735
# segment -> length (m), mass, centre of mass from its upper end, radius of gyration
HEAD = (0.2002, 0.0668, 0.5894, 0.359)
TRUNK = (0.5293, 0.4257, 0.4151, 0.339)
UPPER_ARM = (0.2751, 0.0255, 0.5754, 0.260)
FOREARM = (0.2643, 0.0138, 0.4559, 0.257)
HAND = (0.0780, 0.0056, 0.7474, 0.454)
THIGH = (0.3685, 0.1478, 0.3612, 0.364)
SHANK = (0.4323, 0.0481, 0.4416, 0.267)
FOOT = (0.2283, 0.0129, 0.4014, 0.279)


@dataclass(frozen=True)
class Segment:
    """A rigid part of the body, both sides together."""

    mass_kg: float
    length_m: float
    """Mass (kg), and length between its joints (m)."""
    com_m: float
    """Centre of mass from the lower joint."""
    inertia_kgm2: float
    """Moment of inertia about the centre of mass, for turning in the sagittal plane."""


def _paired(row: tuple, mass_kg: float, scale: float) -> Segment:
    length, part, com, gyration = row
    length *= scale
    mass = 2.0 * part * mass_kg
    return Segment(mass, length, (1.0 - com) * length, mass * (gyration * length) ** 2)


def scaled(segment: Segment, factor: float) -> Segment:
    """The same shape (m) with ``factor`` times the mass and the moment of inertia (kg, kg·m²)."""
    return Segment(factor * segment.mass_kg, segment.length_m, segment.com_m, factor * segment.inertia_kgm2)


def shanks(mass_kg: float, stature_m: float) -> Segment:
    """Both shanks of a body of mass (kg) and stature (m)."""
    return _paired(SHANK, mass_kg, stature_m / STATURE_M)


def thighs(mass_kg: float, stature_m: float) -> Segment:
    """Both thighs of a body of mass (kg) and stature (m)."""
    return _paired(THIGH, mass_kg, stature_m / STATURE_M)


def feet(mass_kg: float, stature_m: float) -> Segment:
    """Both feet of a body of mass (kg) and stature (m); length from heel to toe, com from the toe."""
    return _paired(FOOT, mass_kg, stature_m / STATURE_M)


def upper_body(mass_kg: float, stature_m: float, ankle_height_m: float) -> Segment:
    """Trunk, head and crossed arms of a body of mass (kg) and stature (m) as one segment on the hips.

    The arms, crossed on the chest, count as a point at the height of the trunk's centre of mass.
    """
    scale = stature_m / STATURE_M
    hip = ankle_height_m + scale * (SHANK[0] + THIGH[0])
    trunk_com = (1.0 - TRUNK[2]) * TRUNK[0] * scale
    head_com = stature_m - HEAD[2] * HEAD[0] * scale - hip
    arms = 2.0 * (UPPER_ARM[1] + FOREARM[1] + HAND[1])
    mass = mass_kg * np.array([TRUNK[1], HEAD[1], arms])
    height = np.array([trunk_com, head_com, trunk_com])
    gyration = scale * np.array([TRUNK[3] * TRUNK[0], HEAD[3] * HEAD[0], 0.0])
    com = mass @ height / mass.sum()
    inertia = mass @ (gyration**2 + (height - com) ** 2)
    return Segment(float(mass.sum()), stature_m - hip, float(com), float(inertia))
