"""Ankle torque from the motion of the leg alone: the free body of the leg (thesis eqs 3-7 and 3-8).

Symbols: m leg mass (kg), r its centre of mass's distance from the ankle (m), I_l its moment of
inertia about the centre of mass (kg m2), g gravity (m/s2); y'', z'' acceleration of the leg's centre
of mass (m/s2); theta leg angle, positive when the leg tips towards +y (rad).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Leg:
    """Leg of the ankle dummy (thesis Table 2-2).

    Attributes
    ----------
    mass_kg : float
        m (kg).
    com_m : float
        r, from the ankle to the centre of mass (m).
    inertia_kgm2 : float
        I_l, about the centre of mass (kg m2).
    gravity_m_per_s2 : float
        g (m/s2).
    """

    mass_kg: float
    com_m: float
    inertia_kgm2: float
    gravity_m_per_s2: float


def leg_torque(
    leg: Leg, theta: np.ndarray, theta_dd: np.ndarray, y_dd: np.ndarray, z_dd: np.ndarray
) -> np.ndarray:
    """Torque of the joint, from the leg's moments about its centre of mass, derived consistently.

    The ankle pushes the leg with (m y'', m (g + z'')). Its lever about the centre of mass is
    r (sin theta, cos theta) long, and the joint returns the leg with the torque tau:

        tau = -[ m y'' r cos(theta) + I_l theta'' - m (g + z'') r sin(theta) ]

    For the dummy tau = B theta' + K (theta - theta_ref), plus I_j theta'' if the joint itself has an
    inertia I_j. It does not contain the leg's own inertia: a massless joint gives I = 0.

    Parameters
    ----------
    leg : Leg
        m, r, I_l, g (kg, m, kg m2, m/s2).
    theta, theta_dd : ndarray, shape (n,)
        Leg angle (rad) and its second derivative (rad/s2).
    y_dd, z_dd : ndarray, shape (n,)
        Acceleration of the leg's centre of mass (m/s2).

    Returns
    -------
    ndarray, shape (n,)
        tau (Nm), positive when it resists positive theta.
    """
    m, r, i_l, g = leg.mass_kg, leg.com_m, leg.inertia_kgm2, leg.gravity_m_per_s2
    return -(m * y_dd * r * np.cos(theta) + i_l * theta_dd - m * (g + z_dd) * r * np.sin(theta))


def leg_torque_as_printed(
    leg: Leg, theta: np.ndarray, theta_dd: np.ndarray, y_dd: np.ndarray, z_dd: np.ndarray
) -> np.ndarray:
    """Torque by thesis eq (3-8) as printed, with theta measured towards +y.

        F_Ay = -m y'',  F_Az = -m g + m z''
        tau = -F_Ay r cos(theta) - F_Az r sin(theta) - I_l theta''

    The equation holds for theta positive towards -y. With theta towards +y, as the arctangent of two
    markers gives it, the translational term has one sign and the other two the opposite one, and a
    fit returns I = I_j + 2 I_l, B, and K - 2 m g r. The overall sign is turned so that I is
    positive, as the thesis reports it.

    Parameters
    ----------
    leg : Leg
        m, r, I_l, g (kg, m, kg m2, m/s2).
    theta, theta_dd : ndarray, shape (n,)
        Leg angle (rad) and its second derivative (rad/s2).
    y_dd, z_dd : ndarray, shape (n,)
        Acceleration of the leg's centre of mass (m/s2).

    Returns
    -------
    ndarray, shape (n,)
        tau (Nm).
    """
    m, r, i_l, g = leg.mass_kg, leg.com_m, leg.inertia_kgm2, leg.gravity_m_per_s2
    f_ay = -m * y_dd
    f_az = -m * g + m * z_dd
    return -(-f_ay * r * np.cos(theta) - f_az * r * np.sin(theta) - i_l * theta_dd)


TORQUE_PATHWAYS = {"leg": leg_torque, "leg-printed": leg_torque_as_printed}
