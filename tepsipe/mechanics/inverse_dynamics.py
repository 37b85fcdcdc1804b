"""Ankle torque by inverse dynamics of the leg or of the foot (thesis eqs 3-7, 3-8, 3-13 and 3-14).

Symbols: m mass of the leg (kg), r distance of its centre of mass from the ankle (m), I_l its moment of
inertia about the centre of mass (kg·m²), g gravity (m/s²); y'', z'' acceleration of the leg's centre
of mass (m/s²); theta leg angle, positive when the leg tips towards +y (rad). m_f foot mass (kg), l_f its
height (m); y_A, y_A'' position (m) and acceleration (m/s²) of the ankle; F_y, F_z forces (N) and M_x
moment (N·m) of the plate on the foot, the moment about the x axis in the surface of the belt. For a standing
person: z_A height of the ankle (m), y_f, z_f centre of mass of the feet (m), I_f their moment of inertia
about it (kg·m²), phi_f their angle (rad).
"""

import math
from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np

from tepsipe.arguments import OPTIONS, Range, number, within
from tepsipe.errors import InputError, listed, quoted
from tepsipe.mechanics.anthropometry import Feet, StandingBody
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.quantities import Mass

# a point mass has no moment of inertia; gravity of 981 is in cm/s²
LEG_RANGES = {
    "mass_kg": within(Mass),
    "com_m": OPTIONS["com_m"],
    "inertia_kgm2": Range(0.0, 1000.0),
    "gravity_m_per_s2": Range(0.0, 30.0, low_allowed=False),
}


@dataclass(frozen=True, kw_only=True)
class Leg:
    """Leg of the ankle dummy, or any rigid body on one joint (thesis Table 2-2).

    Attributes
    ----------
    mass_kg : float
        m (kg).
    com_m : float
        r, from the ankle to the centre of mass (m).
    inertia_kgm2 : float
        I_l, about the centre of mass (kg·m²).
    gravity_m_per_s2 : float
        g (m/s²).

    Examples
    --------
    >>> from tepsipe import Leg
    >>> leg = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027)
    >>> round(leg.mass_kg * leg.gravity_m_per_s2 * leg.com_m, 2)  # critical stiffness (N·m/rad)
    1.76
    """

    mass_kg: float
    com_m: float
    inertia_kgm2: float
    gravity_m_per_s2: float = 9.81

    @classmethod
    def from_settings(cls, geometry: dict) -> Self:
        """Leg of the constants of a dummy: ``leg_mass_kg``, ``leg_com_m`` (kg, m) and so on."""
        numbers = {name: geometry[f"leg_{name}"] for name in ("mass_kg", "com_m", "inertia_kgm2")}
        return cls(**numbers, gravity_m_per_s2=geometry["gravity_m_per_s2"])

    def __post_init__(self):
        """Refuse impossible legs.

        Raises
        ------
        InputError
            If a value is no positive number, or they cannot belong to one rigid body.
        """
        for name, value in list(vars(self).items()):
            object.__setattr__(self, name, number(value, f"Leg: {name}", LEG_RANGES[name]))
        gyration = math.sqrt(self.inertia_kgm2 / self.mass_kg)
        if gyration > 3.0 * self.com_m:
            raise InputError(
                "Leg: expected a radius of gyration, sqrt(inertia_kgm2 / mass_kg), of "
                f"at most 3 times com_m, found {gyration:.3g} m and {self.com_m:.3g} m: check that com_m and "
                "inertia_kgm2 are not swapped, and are in m and kg m2"
            )


def leg_torque(
    leg: Leg,
    theta: np.ndarray,
    theta_dd: np.ndarray,
    y_dd: Annotated[np.ndarray, "(n,)", "m/s²"],
    z_dd: Annotated[np.ndarray, "(n,)", "m/s²"],
) -> np.ndarray:
    """Joint torque from the balance of moments about the leg's centre of mass.

    The ankle acts on the leg with the force (m y'', m (g + z'')), whose lever arm about the centre of
    mass is r (sin theta, cos theta). The joint acts on the leg with the restoring torque tau:

        tau = -[ m y'' r cos(theta) + I_l theta'' - m (g + z'') r sin(theta) ]

    For the dummy tau = B theta' + K (theta - theta_ref), plus I_j theta'' if the joint has an inertia I_j
    of its own. tau does not contain the inertia of the leg: a massless joint gives I = 0.

    theta, theta_dd: leg angle (rad) and its second derivative (rad/s²).
    y_dd, z_dd: acceleration of the leg's centre of mass.
    Returns: tau (N·m), positive when it resists positive theta.
    """
    m, r, i_l, g = leg.mass_kg, leg.com_m, leg.inertia_kgm2, leg.gravity_m_per_s2
    return -(m * y_dd * r * np.cos(theta) + i_l * theta_dd - m * (g + z_dd) * r * np.sin(theta))


def leg_torque_as_printed(
    leg: Leg,
    theta: np.ndarray,
    theta_dd: np.ndarray,
    y_dd: Annotated[np.ndarray, "(n,)", "m/s²"],
    z_dd: Annotated[np.ndarray, "(n,)", "m/s²"],
) -> Annotated[np.ndarray, "(n,)", "N·m"]:
    """Joint torque by thesis eq (3-8) as printed, with theta measured towards +y.

        F_Ay = -m y'',  F_Az = -m g + m z''
        tau = -F_Ay r cos(theta) - F_Az r sin(theta) - I_l theta''

    The equation holds for theta positive towards -y. With theta towards +y, as obtained from the
    arctangent of two markers, the translational term has the opposite sign to the other two, and
    a fit returns I = I_j + 2 I_l, B, and K - 2 m g r. The overall sign is inverted so that I is positive,
    as the thesis reports.

    theta, theta_dd: leg angle (rad) and its second derivative (rad/s²).
    y_dd, z_dd: acceleration of the leg's centre of mass.
    """
    m, r, i_l, g = leg.mass_kg, leg.com_m, leg.inertia_kgm2, leg.gravity_m_per_s2
    f_ay = -m * y_dd
    f_az = -m * g + m * z_dd
    return -(-f_ay * r * np.cos(theta) - f_az * r * np.sin(theta) - i_l * theta_dd)


TORQUE_PATHWAYS = {"leg": leg_torque, "leg-thesis": leg_torque_as_printed}


def leg_pathway_torque(pathway: str, leg: Leg, motion: SegmentMotion) -> np.ndarray:
    """Torque (N·m) by one of `TORQUE_PATHWAYS`, shape (n,)."""
    if pathway not in TORQUE_PATHWAYS:
        raise InputError(
            f"expected a torque of {listed(TORQUE_PATHWAYS)}, found {quoted(pathway)}: correct it"
        )
    return TORQUE_PATHWAYS[pathway](leg, motion.theta, motion.theta_dd, motion.y_dd, motion.z_dd)


@dataclass(frozen=True)
class Foot:
    """Foot of the ankle dummy: a brick that does not rotate, with the ankle on its top (thesis Table 2-2)."""

    mass_kg: float
    height_m: float
    """l_f, from the belt to the ankle (m); the centre of mass is below the ankle, at half this height."""

    @classmethod
    def from_settings(cls, geometry: dict) -> Self:
        """Foot of ``foot_mass_kg`` (kg) and ``foot_height_m`` (m)."""
        return cls(mass_kg=geometry["foot_mass_kg"], height_m=geometry["foot_height_m"])


def foot_torque(
    foot: Foot,
    f_y: Annotated[np.ndarray, "(n,)", "N"],
    f_z: Annotated[np.ndarray, "(n,)", "N"],
    m_x: Annotated[np.ndarray, "(n,)", "N·m"],
    y_a: np.ndarray,
    y_a_dd: np.ndarray,
) -> np.ndarray:
    """Joint torque from the balance of moments of the foot about the ankle.

    The wrench of the plate has the moment M_x - y_A F_z + l_f F_y about the ankle, or, with the centre of
    pressure y_CoP = M_x / F_z (eq 3-13), F_z (y_CoP - y_A) + F_y l_f. The moment that does not accelerate
    the foot is transmitted by the joint:

        tau = M_x - y_A F_z + l_f F_y - m_f y_A'' l_f / 2

    f_y, f_z: forces of the plate on the foot.
    m_x: moment of the plate on the foot about the x axis.
    y_a, y_a_dd: position of the ankle on the plate (m), and its acceleration (m/s²).
    Returns: tau (N·m), positive when it resists positive theta.
    """
    m_f, l_f = foot.mass_kg, foot.height_m
    return m_x - y_a * f_z + l_f * f_y - m_f * y_a_dd * 0.5 * l_f


def foot_torque_as_printed(
    foot: Foot, leg: Leg, f_y: Annotated[np.ndarray, "(n,)", "N"], y_dd: Annotated[np.ndarray, "(n,)", "m/s²"]
) -> Annotated[np.ndarray, "(n,)", "N·m"]:
    """Joint torque by the equation of the foot as printed (thesis eq 3-7 and section 3-1-3).

        F_Ay = -m y'',  tau = -F_y l_f / 2 + F_Ay l_f / 2

    The moment of the vertical force, F_z times its distance from the ankle, is missing.

    f_y: force of the plate on the foot.
    y_dd: acceleration of the leg's centre of mass.
    """
    f_ay = -leg.mass_kg * y_dd
    return -f_y * 0.5 * foot.height_m + f_ay * 0.5 * foot.height_m


@dataclass(frozen=True)
class PlateLoad:
    """Load of the plate on the feet."""

    f_y: Annotated[np.ndarray, "(n,)", "N"]
    f_z: Annotated[np.ndarray, "(n,)", "N"]
    """Fore-aft and vertical force."""
    m_x: Annotated[np.ndarray, "(n,)", "N·m"]
    """Moment about the x axis in the belt's surface."""


def standing_torque(
    feet: Feet,
    gravity_m_per_s2: float,
    load: PlateLoad,
    ankle: Annotated[np.ndarray, "(n, 2)"],
    foot_com: Annotated[np.ndarray, "(n, 2)"],
    foot_com_dd: Annotated[np.ndarray, "(n, 2)"],
    foot_angle_dd: Annotated[np.ndarray, "(n,)", "rad/s²"],
) -> np.ndarray:
    """Torque of both ankles of a standing person, from the balance of moments of the feet about the ankles.

    This is thesis eq (3-14) with an angular acceleration, and with the sign of a torque on the body. The
    wrench of the plate and the weight of the feet act about the ankle; the moment that does not accelerate
    the feet is transmitted by the joint:

        tau = M_x - y_A F_z + z_A F_y - (y_f - y_A) m_f (g + z_f'') + (z_f - z_A) m_f y_f'' + I_f phi_f''

    With the centre of pressure y_CoP = M_x / F_z (eq 3-13) the first two terms are (y_CoP - y_A) F_z.

    ankle, foot_com, foot_com_dd: y, z of the ankle (m), of the feet's centre of mass (m), and its
    acceleration (m/s²).
    foot_angle_dd: angular acceleration of the feet phi_f'', positive when they tip towards +y.
    Returns: tau (N·m), positive when it resists a body that tips towards +y.
    """
    m_f, g = feet.mass_kg, gravity_m_per_s2
    lever = foot_com - ankle
    plate = load.m_x - ankle[:, 0] * load.f_z + ankle[:, 1] * load.f_y
    weight = lever[:, 0] * m_f * (g + foot_com_dd[:, 1])
    return plate - weight + lever[:, 1] * m_f * foot_com_dd[:, 0] + feet.inertia_kgm2 * foot_angle_dd


def standing_torque_as_printed(
    feet: Feet,
    gravity_m_per_s2: float,
    load: PlateLoad,
    ankle: np.ndarray,
    foot_com: np.ndarray,
    foot_com_dd: np.ndarray,
    vectors: bool,
) -> np.ndarray:
    """Torque of both ankles by thesis eq (3-14) as printed, with y_CoP = M_x / F_z (eq 3-13).

        tau = (y_A - y_CoP) x F_y - (y_A - y_f) x (m_f y_f'') - (y_A - y_f) x (m_f g) - I_f + m_f r_Af

    No other equation of the thesis contains a cross. Bold letters and crosses can be read in two ways:

    - Vector products in the plane y, z: y_A, y_CoP, y_f are points, the last two and F_y, y_f'' have their
      second component, and g points up. tau is then the torque of the joints on the feet, positive about the
      x axis, as tau_A in eq (3-7). If the feet do not turn, the products add up to minus `standing_torque`.
    - Products of scalars: y_A and y_f are y-positions, as the text below the equation states. The centre of
      pressure is then a lever arm of F_y instead of F_z, and the height of the ankle is missing.

    In both readings I_f lacks an angular acceleration, and m_f r_Af lacks it and a square (parallel axes).
    These terms do not vary unless the feet deform. Takes the arguments of `standing_torque`, and whether the
    products are of ``vectors``.

    Returns: tau as printed (the numbers of N·m, kg·m² and kg m added), positive when it resists a body that
    tips towards -y.
    """
    m_f = feet.mass_kg
    pressure = load.m_x / load.f_z
    from_com, from_pressure = ankle - foot_com, ankle - np.column_stack([pressure, np.zeros_like(pressure)])
    if vectors:
        weighed = m_f * (foot_com_dd + np.array([0.0, gravity_m_per_s2]))
        products = _cross(from_pressure, np.column_stack([load.f_y, load.f_z])) - _cross(from_com, weighed)
    else:
        weighed = m_f * (foot_com_dd[:, 0] + gravity_m_per_s2)
        products = from_pressure[:, 0] * load.f_y - from_com[:, 0] * weighed
    return products - feet.inertia_kgm2 + m_f * np.hypot(*from_com.T)


def _cross(lever: Annotated[np.ndarray, "(n, 2)"], force: Annotated[np.ndarray, "(n, 2)"]) -> np.ndarray:
    """X component of the vector product of two vectors (y, z)."""
    return lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0]


def single_joint_torque(
    body: StandingBody,
    theta: np.ndarray,
    theta_dd: np.ndarray,
    ankle_dd: Annotated[np.ndarray, "(n, 2)", "m/s²"],
) -> np.ndarray:
    """Torque of both ankles for a body above them that rotates with the shank as one rigid body.

    This is `leg_torque` with the body in place of the leg, an inverted pendulum on a moving pivot:

        tau = m g h sin(theta) - (I_b + m h^2) theta'' - m h (y_A'' cos(theta) - z_A'' sin(theta))

    theta, theta_dd: angle of the shank (rad) and its second derivative (rad/s²).
    ankle_dd: acceleration of the ankle y_A'', z_A''.
    Returns: tau (N·m), positive when it resists positive theta.
    """
    m, h = body.mass_kg, body.com_m
    about_ankle = body.inertia_kgm2 + m * h**2
    carried = ankle_dd[:, 0] * np.cos(theta) - ankle_dd[:, 1] * np.sin(theta)
    return body.critical_stiffness * np.sin(theta) - about_ankle * theta_dd - m * h * carried
