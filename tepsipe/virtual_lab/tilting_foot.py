"""The dummy's foot tilts a little on tape and belt, and takes the ankle with it.

In addition to y and th of `tepsipe.virtual_lab.dummy`: ph, tilt of the foot about the point of the belt under
the ankle from where it rests, positive towards +y (rad). Kinematics are linear in ph, which stays below
0.01 rad. With h height of the joint, (b, c) centre of mass of the foot forward and up, If its moment of
inertia about it, a = mf c + m h, k and d stiffness and damping of the support, R moment of the rubber, which
bends by th - ph:

    (Mb + mf + m) y''  + m r cos th th''   + a ph''              = u - c y' + m r sin th th'^2
    m r cos th y''     + (Il + m r^2) th'' + m h r cos th ph''   = m g r sin th - R
    a y'' + m h r cos th th'' + (If + mf (b^2 + c^2) + m h^2) ph'' = R - R_rest + a g ph - k ph - d ph'
                                                                     + h m r sin th th'^2
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Gt, Le

from tepsipe.quantities import NotNegative


@dataclass(frozen=True)
class FootTilt:
    """The foot tilts on tape and belt."""

    compliance_rad_per_Nm: NotNegative
    """Tilt per moment; 0 is a foot that does not tilt."""
    damping_ratio: NotNegative
    """Damping ratio of the tilt."""
    foot_inertia_kgm2: Annotated[float, Gt(0), Le(20)]
    """Moment of inertia of the foot about its centre of mass."""


def tilting_derivative(
    dummy, moment: Callable, drive, tilt: FootTilt, command, neutral: float, rest: float
) -> Callable:
    """Derivative of (y, y', servo, th, th', ph, ph').

    moment: moment of the rubber at a bending and its rate.
    tilt: the foot's support, with a compliance above 0.
    command: commanded belt velocity (m/s) at t (s).
    neutral, rest: angle at which the rubber is straight (rad), and its moment at rest (N·m).
    """
    m, r, h = dummy.leg_mass_kg, dummy.leg_com_m, dummy.foot_height_m + dummy.joint_offset_m[1]
    forward, up = dummy.foot_com_m
    g, mf = dummy.gravity_m_per_s2, dummy.foot_mass_kg
    moving = drive.belt_mass_kg + mf + m
    about_joint = dummy.leg_inertia_kgm2 + dummy.joint_inertia_kgm2 + m * r * r
    carried = mf * up + m * h
    about_belt = tilt.foot_inertia_kgm2 + mf * (forward * forward + up * up) + m * h * h
    stiffness = 1.0 / tilt.compliance_rad_per_Nm
    damping = 2.0 * tilt.damping_ratio * math.sqrt(stiffness * about_belt)
    upright = stiffness - carried * g
    force, viscous, delay = drive.servo(), drive.viscous_Ns_per_m, drive.delay_s
    sin, cos, mr, mgr = math.sin, math.cos, m * r, m * g * r
    # belt and foot without the leg's angle: the inverse of their 2 x 2 matrix does not change
    both = moving * about_belt - carried * carried
    i_yy, i_yp, i_pp = about_belt / both, -carried / both, moving / both
    y_by_leg, p_by_leg = i_yy + i_yp * h, i_yp + i_pp * h

    def derivative(t: float, state: tuple[float, ...]) -> tuple[float, ...]:
        _, v, q, th, w, ph, x = state
        u, q_rate = force(command(t - delay) - v, q)
        s, coupling = sin(th), mr * cos(th)
        bent = moment(th - ph - neutral, w - x)
        swing = mr * s * w * w
        push = u - viscous * v + swing
        turn = mgr * s - bent
        lean = bent - rest - upright * ph - damping * x + h * swing
        e = coupling * y_by_leg
        f = coupling * p_by_leg
        w_rate = (turn - e * push - f * lean) / (about_joint - coupling * (e + f * h))
        push -= coupling * w_rate
        lean -= coupling * h * w_rate
        return v, i_yy * push + i_yp * lean, q_rate, w, w_rate, x, i_yp * push + i_pp * lean

    return derivative
