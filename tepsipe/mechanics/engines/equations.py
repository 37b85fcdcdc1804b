"""The dummy's equations of motion, integrated by the classical Runge-Kutta method of fourth order.

This engine needs only numpy. The foot follows the belt and does not rotate; the leg rotates about the ankle
against the joint. With A the force of the foot on the leg and tau the torque of the joint, the Newton-Euler
equations are

    leg     m y'' = A_y,   m (z'' + g) = A_z                                 y = y_f + r sin(theta)
            I_l theta'' = r (A_z sin(theta) - A_y cos(theta)) - tau          z = l_f + r cos(theta)
    foot    F_y = m_f y_f'' + A_y,   F_z = m_f g + A_z
            M_x - y_f F_z + l_f F_y - m_f y_f'' l_f / 2 = tau
    joint   tau = I theta'' + B theta' + K (theta - theta_ref) - s

Substituting the first two equations of the leg into the third gives the equation that is integrated,

    J theta'' = m r G sin(theta - phi) - B theta' - K (theta - theta_ref) + s,   J = I_l + m r^2 + I,

where G = hypot(g, y_f'') and phi = atan2(y_f'', g) are magnitude and tilt of the apparent gravity in the
frame of the belt. s, 0 for a linear joint, is what softening takes away (`Joint`). The other equations give
the forces. Symbols: theta leg angle, positive when the leg tips
towards +y (rad); y_f position of the foot (m); F_y, F_z (N) and M_x (N·m) of the belt on the foot, the moment
in the belt's surface where the ankle starts; I, B, K, theta_ref of the joint; m, r, I_l, g of the leg and
m_f, l_f of the foot as in `inverse_dynamics`.
"""

import math

import numpy as np

from tepsipe.mechanics.engines.interface import FALLEN_RAD, Joint, Swing, Task
from tepsipe.mechanics.inverse_dynamics import Leg


def simulate(task: Task) -> list[Swing]:
    """Simulate the leg on the moving foot, with every joint.

    Returns: motion and forces at the recorded instants.
    """
    y_dd = task.velocity(
        0.5 * task.step_s * np.arange(2 * task.steps - 1), 1
    )  # at steps and half-way between
    return [_swing(task, joint, y_dd) for joint in task.joints]


def _swing(task: Task, joint: Joint, y_dd: np.ndarray) -> Swing:
    """Motion and forces with one joint, from y_f'' (m/s²) at steps and half-way between."""
    theta, theta_d, fell_after_s = _integrate(task, joint, y_dd)
    theta, theta_d = theta[:: task.stride], theta_d[:: task.stride]
    leg, foot = task.leg, task.foot
    m, r, g = leg.mass_kg, leg.com_m, leg.gravity_m_per_s2
    elapsed = task.elapsed(theta.size)
    y_f, y_f_dd = task.path(elapsed), task.velocity(elapsed, 1)
    s, c = np.sin(theta), np.cos(theta)

    bent = joint.resistance(theta, theta_d)
    theta_dd = (m * r * (g * s - y_f_dd * c) - bent) / _about_the_ankle(leg, joint)
    tau = joint.inertia_Nms2_per_rad * theta_dd + bent
    on_leg_y = m * (y_f_dd + r * (c * theta_dd - s * theta_d**2))
    on_leg_z = m * (g - r * (s * theta_dd + c * theta_d**2))
    f_y = foot.mass_kg * y_f_dd + on_leg_y
    f_z = foot.mass_kg * g + on_leg_z
    return Swing(
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        f_y=f_y,
        f_z=f_z,
        m_x=tau + y_f * f_z - foot.height_m * (f_y - 0.5 * foot.mass_kg * y_f_dd),
        f_ay=-on_leg_y,
        f_az=-on_leg_z,
        fell_after_s=fell_after_s,
    )


def _about_the_ankle(leg: Leg, joint: Joint) -> float:
    """Moment of inertia J about the ankle (kg·m²)."""
    return leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2 + joint.inertia_Nms2_per_rad


def _integrate(task: Task, joint: Joint, y_dd: np.ndarray) -> tuple[np.ndarray, np.ndarray, float | None]:
    """Angle (rad) and rate (rad/s) at every step, and the time of the fall (s) or None."""
    leg, h = task.leg, task.step_s
    about_ankle, rest = _about_the_ankle(leg, joint), joint.rest_angle_rad
    b, k = joint.damping_Nms_per_rad / about_ankle, joint.stiffness_Nm_per_rad / about_ankle
    c, d = joint.softening_Nm_per_rad / about_ankle, joint.softened_damping_Nms_per_rad / about_ankle
    half_squared = joint.half_softening_rad**2
    pull = leg.mass_kg * leg.com_m / about_ankle * np.hypot(leg.gravity_m_per_s2, y_dd)
    lean = np.arctan2(y_dd, leg.gravity_m_per_s2) - rest
    first_pull, first_lean = float(pull[0]), float(lean[0])
    between = zip(pull[1::2].tolist(), lean[1::2].tolist(), strict=True)
    at_end = zip(pull[2::2].tolist(), lean[2::2].tolist(), strict=True)

    # x = theta - theta_ref, w = theta'; for speed, the loop calls no function but the sine
    x, w = task.start.angle_rad - rest, task.start.rate_rad_per_s
    lowest, highest = -FALLEN_RAD - rest, FALLEN_RAD - rest
    sin, half, sixth = math.sin, 0.5 * h, h / 6.0
    angles, rates = [x], [w]
    p1, l1 = first_pull, first_lean
    for (p2, l2), (p3, l3) in zip(between, at_end, strict=True):
        q = x * x / (x * x + half_squared)
        a1 = p1 * sin(x - l1) - b * w - k * x + q * (c * x - d * w)
        x2, w2 = x + half * w, w + half * a1
        q = x2 * x2 / (x2 * x2 + half_squared)
        a2 = p2 * sin(x2 - l2) - b * w2 - k * x2 + q * (c * x2 - d * w2)
        x3, w3 = x + half * w2, w + half * a2
        q = x3 * x3 / (x3 * x3 + half_squared)
        a3 = p2 * sin(x3 - l2) - b * w3 - k * x3 + q * (c * x3 - d * w3)
        x4, w4 = x + h * w3, w + h * a3
        q = x4 * x4 / (x4 * x4 + half_squared)
        a4 = p3 * sin(x4 - l3) - b * w4 - k * x4 + q * (c * x4 - d * w4)
        x += sixth * (w + 2.0 * (w2 + w3) + w4)
        w += sixth * (a1 + 2.0 * (a2 + a3) + a4)
        if not lowest <= x <= highest:
            break
        angles.append(x)
        rates.append(w)
        p1, l1 = p3, l3
    fell_after_s = None if len(angles) == task.steps else len(angles) * h
    return np.array(angles) + rest, np.array(rates), fell_after_s
