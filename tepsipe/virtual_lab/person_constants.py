"""Hidden constants of a standing person: body, feet, muscles, nerves, skin and markers.

Constants with a default belong to mechanisms that may be absent: the default switches the mechanism off.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

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
from tepsipe.virtual_lab.anthropometry import FOOT, SHANK, THIGH

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
