"""Hidden constants of a standing person: body, feet, muscles, nerves, skin and markers.

Constants with a default belong to mechanisms that may be absent: the default switches the mechanism off.
"""

from dataclasses import dataclass

from tepsipe.virtual_lab.anthropometry import FOOT, SHANK, THIGH

# names of the person's markers, in the strober's order
MARKERS = ("foot1", "foot2", "ankle", "shank1", "shank2", "thigh1", "thigh2", "thigh3")
MUSCLES = ("TA", "SOL", "GAS", "BF", "RF")


@dataclass(frozen=True)
class PersonTruth:
    """Hidden constants of the body."""

    mass_kg: float
    stature_m: float
    """Mass and height of the whole body."""
    ankle_height_m: float
    foot_com_m: float
    """Ankle above the belt; centre of mass of the feet in front of the ankle (m), half as high as it."""
    stance_rad: list
    """Angles of shanks, thighs and upper body in quiet standing."""
    position_x_m: float
    position_y_m: float
    """Position of the ankles on the plate."""
    gravity_m_per_s2: float
    """Acceleration of gravity."""
    foot_mass: float = FOOT[1]
    shank_mass: float = SHANK[1]
    thigh_mass: float = THIGH[1]
    """One foot, shank and thigh as fractions of the body's mass; the upper body has the rest."""
    short_range_rad: float = 0.0
    """Rotation of the ankle after which its short-range stiffness has yielded (rad): r."""
    foot_stiffness_Nm_per_rad: float = 0.0
    foot_damping_Nms_per_rad: float = 0.0
    """Heel pads and arches against tilting of both feet on the belt: K_f, B_f; a stiffness of 0 makes the
    feet rigid."""
    forefoot_share: float = 1.0
    """Tilt of the forefoot relative to the hindfoot's; the arch takes the rest."""
    marked_share: float = 0.5
    """Part of both ankles' torque that the marked leg bears."""
    marked_rotation: float = 1.0
    """Rotation of the marked shank relative to the mean of both."""
    left_share: float = 0.5
    """Part of the weight above the feet that the left leg bears, where each foot has a plate of its own."""


@dataclass(frozen=True)
class MuscleTruth:
    """Hidden constants of one muscle, of both legs."""

    latency_s: float
    """From stretch to the reflex in its drive (s): L."""
    stretch: list
    """Lengthening per angle of ankle, knee and hip: w."""
    force_Nm: list
    """Torque of full drive that resists the angles of ankle, knee and hip (N·m): F."""
    balance_per_Nm: list
    """Drive per wanted torque at the ankle, while that is positive and negative (1/N·m)."""
    medium_latency_s: float = 0.0
    """From stretch to the medium-latency reflex in its drive (s): L_2."""


@dataclass(frozen=True)
class TaskTruth:
    """Hidden constants that depend on the instruction, relax or stiff."""

    stiffness_Nm_per_rad: list
    damping_Nms_per_rad: list
    """Intrinsic K and B of ankle, knee and hip, both legs; at the ankle without the short range."""
    tone: list
    """Drive of the muscles in quiet standing."""
    reflex_s_per_rad: list
    """Drive per stretch velocity (s/rad): G."""
    medium_reflex_s_per_rad: list | tuple = (0.0,) * 5
    """The same of the medium-latency reflex (s/rad): G_2."""
    short_range_Nm_per_rad: float = 0.0
    """Additional stiffness of both ankles in small rotations: K_s."""


@dataclass(frozen=True)
class NervesTruth:
    """Hidden constants of the loops that the instruction does not change."""

    reflex_threshold_rad_per_s: float
    """Stretch velocity that reflexes need (rad/s): s_0."""
    twitch_s: float
    """Time constant with which the muscles' force rises (s): T."""
    balance_delay_s: float
    """From the centre of mass to the drive."""
    balance_Nm_per_rad: float
    balance_Nms_per_rad: float
    """Wanted torque at the ankle per lean of the centre of mass, and per its rate."""
    wander_Nm: float
    wander_s: float
    """Standard deviation and correlation time of what balance adds of itself."""
    relaxation_s: float = 0.0
    """Time constant with which the muscles' force falls (s): T_2; 0 for T."""


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
    """Positions of the markers on the right leg."""

    foot_m: list
    """On the foot: forward of the ankle and above the belt."""
    shank_m: list
    thigh_m: list
    """In front of the segment's axis, and along it from its lower joint."""
    lateral_m: float
    """Position of all markers across the belt, from the middle between the feet."""
    joint_centre_m: list | tuple = (0.0, 0.0)
    """Position of the ankle's axis relative to the ankle's marker in quiet standing."""


@dataclass(frozen=True)
class SkinTruth:
    """Motion of the skin under the markers on the bones."""

    frequency_hz: float = 12.0
    damping: float = 0.3
    """Natural frequency (Hz) and damping ratio of the soft tissue of shank and thigh."""
    shank_share: float = 0.0
    thigh_share: float = 0.0
    """Part of the soft tissue's motion that the skin under the markers takes part in."""
    slip_m_per_rad: float = 0.0
    """Forward displacement of the ankle's marker per rotation of the ankle."""
