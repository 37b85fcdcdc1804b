"""Hidden constants of a standing person: body, feet, muscles, nerves, skin and markers.

Constants with a default belong to mechanisms that may be absent: the default switches the mechanism off.

Segments of a woman's body: masses, centres of mass and moments of inertia.

Source: P. de Leva (1996), Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters, Journal of
Biomechanics 29(9), 1223-1230, Table 4, females: mass as a part of the body's, centre of mass and radius of
gyration about the transverse axis as parts of the segment's length, and lengths for a stature of 1.735 m.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le, Len, Lt

from tepsipe.quantities import (
    AddedStiffness,
    Angle,
    Damping,
    Fraction,
    Frequency,
    Gravity,
    Mass,
    NotNegative,
    Offset,
    Pair,
    Point,
    Positive,
    Stature,
    Stiffness,
    Three,
    Time,
)

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


# names of the person's markers, in the strober's order
MARKERS = ("foot1", "foot2", "ankle", "shank1", "shank2", "thigh1", "thigh2", "thigh3")
MUSCLES = ("TA", "SOL", "GAS", "BF", "RF")


@dataclass(frozen=True)
class PersonTruth:
    """Hidden constants of the body."""

    mass_kg: Mass
    """Mass of the whole body."""
    stature_m: Stature
    """Stature."""
    ankle_height_m: Annotated[float, Gt(0), Le(0.3)]
    """Height of the ankle above the belt."""
    foot_com_m: Annotated[float, Ge(-0.3), Le(0.3)]
    """Anterior offset of the feet's centre of mass."""
    stance_rad: Three[Angle]
    """Angles of shanks, thighs and upper body from the vertical in quiet standing."""
    position_x_m: Offset
    """Position of the ankles on the plate, across the belt."""
    position_y_m: Offset
    """Position of the ankles on the plate, along the belt."""
    gravity_m_per_s2: Gravity
    """Gravity."""
    foot_mass: Annotated[float, Gt(0), Le(0.05)] = FOOT[1]
    """Each foot, as a fraction of the body's mass."""
    shank_mass: Annotated[float, Gt(0), Le(0.1)] = SHANK[1]
    """Each shank."""
    thigh_mass: Annotated[float, Gt(0), Le(0.25)] = THIGH[1]
    """Each thigh; the upper body has the rest."""
    short_range_rad: Annotated[float, Gt(0), Le(3.2)] = 0.0  # r
    """Rotation of the ankle after which its short-range stiffness has yielded."""
    foot_stiffness_Nm_per_rad: AddedStiffness = 0.0  # K_f
    """Stiffness of heel pads and arches of both feet against tilting on the belt; 0 makes the feet rigid."""
    foot_damping_Nms_per_rad: Annotated[float, Ge(0), Le(20)] = 0.0  # B_f
    """Its damping."""
    forefoot_share: Fraction = 1.0
    """Tilt of the forefoot relative to that of the hindfoot."""
    marked_share: Annotated[float, Gt(0), Lt(1)] = 0.5
    """Part of both ankles' torque that the marked leg bears; 0.5 for equal legs."""
    marked_rotation: Annotated[float, Gt(0), Lt(2)] = 1.0
    """Rotation of the marked shank relative to the mean of both; 1 for equal legs."""
    left_share: Fraction = 0.5
    """Part of the weight above the feet on the left leg, if each foot is on a plate of its own (`both` in
    the column `belt`)."""


@dataclass(frozen=True, kw_only=True)
class MuscleTruth:
    """A muscle."""

    latency_s: Annotated[float, Ge(0.01), Le(1)]  # L
    """Time from stretch to the short-latency reflex."""
    medium_latency_s: Annotated[float, Ge(0.01), Le(1)] = 0.0  # L_2
    """Time from stretch to the medium-latency reflex."""
    stretch: Three[float]  # w
    """Lengthening per angle of ankle, knee and hip."""
    force_Nm: Three[Annotated[float, Ge(-5000), Le(5000)]]  # F
    """Torque at full drive that resists the angles of ankle, knee and hip, both legs."""
    balance_per_Nm: Annotated[Pair[float], "1/(N·m)"]
    """Drive per torque demanded by balance at the ankle: for positive and for negative torque."""


@dataclass(frozen=True, kw_only=True)
class TaskTruth:
    """An instruction; joints in the order ankle, knee, hip, muscles in the order TA, SOL, GAS, BF, RF."""

    stiffness_Nm_per_rad: Three[Stiffness]
    """Intrinsic stiffness, both legs; at the ankle that of large rotations."""
    short_range_Nm_per_rad: AddedStiffness = 0.0  # K_s
    """Stiffness that is added at the ankles in small rotations."""
    damping_Nms_per_rad: Three[Damping]
    """Intrinsic damping, both legs."""
    tone: Annotated[Sequence[NotNegative], Len(5, 5)]
    """Drive in quiet standing, as a fraction of the largest."""
    reflex_s_per_rad: Annotated[Annotated[Sequence[NotNegative], Len(5, 5)], "s/rad"]  # G
    """Drive per stretch velocity of the short-latency reflex (M1)."""
    medium_reflex_s_per_rad: Annotated[Annotated[Sequence[NotNegative], Len(5, 5)], "s/rad"] = (
        0.0,
    ) * 5  # G_2
    """Drive per stretch velocity of the medium-latency reflex (M2)."""


@dataclass(frozen=True, kw_only=True)
class NervesTruth:
    """Reflexes and balance."""

    reflex_threshold_rad_per_s: NotNegative  # s_0
    """Threshold of the stretch velocity for a reflex."""
    twitch_s: Annotated[float, Gt(0), Le(10)]  # T
    """Time constant of the twitch response: its rise."""
    relaxation_s: Annotated[float, Ge(0), Le(10)] = 0.0  # T_2
    """Its fall; 0 stands for `twitch_s` (critically damped)."""
    balance_delay_s: Annotated[float, Ge(0.01), Le(10)]
    """Delay from the centre of mass to the drive."""
    balance_Nm_per_rad: NotNegative
    """Torque demanded per lean of the centre of mass."""
    balance_Nms_per_rad: NotNegative
    """Torque demanded per rate of this lean."""
    wander_Nm: NotNegative
    """Random component of balance: standard deviation."""
    wander_s: Time
    """Its correlation time."""


@dataclass(frozen=True)
class Subject:
    """A person with a task: body, muscles of `MUSCLES` by name, and nerves."""

    person: PersonTruth
    """Constants."""
    muscles: dict[str, MuscleTruth]
    """Constants of every muscle."""
    task: TaskTruth
    nerves: NervesTruth


@dataclass(frozen=True)
class PersonMarkers:
    """Markers of the person."""

    foot_m: Pair[Point]
    """Two markers: [anterior offset from the ankle, height above the belt]."""
    shank_m: Pair[Point]
    """Two markers: [anterior offset from the axis of the segment, longitudinal offset from its lower
    joint]; one more is on the ankle."""
    thigh_m: Three[Point]
    """Three markers, in the same way."""
    lateral_m: Offset
    """Position of all markers across the belt, from the middle between the feet."""
    joint_centre_m: Point = (0.0, 0.0)
    """[forward, up] position of the ankle's axis relative to the ankle's marker."""


@dataclass(frozen=True)
class SkinTruth:
    """The skin under the markers."""

    frequency_hz: Frequency = 12.0
    """Natural frequency of the soft tissue of shank and thigh."""
    damping: Positive = 0.3
    """Its damping ratio."""
    shank_share: Fraction = 0.0
    """Part of the soft tissue's motion in which the markers of the shank take part; 0 for markers fixed to
    the bone."""
    thigh_share: Fraction = 0.0
    """The same of the thigh."""
    slip_m_per_rad: float = 0.0
    """Forward displacement of the ankle's marker per rotation of the ankle."""
