"""A rubber joint that softens as it is bent and loses more energy as it softens.

    tau = K phi (1 - s) + (B + B_s s / S) phi' + I phi'',      s = S phi^2 / (phi^2 + phi_h^2)

phi is the bending, K and B hold for small bending, phi_h is the bending at which half of the softening S has
taken place, and B_s is the damping that softening adds. Filled rubber behaves like this: its storage modulus
falls with amplitude while its loss modulus rises (Payne 1962, J. Appl. Polym. Sci. 6:57-63). S and phi_h are
not separated by movements below phi_h, where only S / phi_h^2 matters; S is therefore fixed. The joint
likelihood and the forward simulation (`tepsipe.mechanics.engines.interface.Joint`) use C = S K in place of S.
"""

from dataclasses import astuple, dataclass, fields
from typing import Annotated

import numpy as np

from tepsipe.mechanics.inverse_dynamics import Leg

SOFTENING = 0.5


@dataclass(frozen=True, kw_only=True)
class RubberJoint:
    """Constants of a rubber joint."""

    stiffness_Nm_per_rad: float
    """K for small bending."""
    half_softening_rad: float
    """phi_h, the bending at which half of the softening has taken place (rad); infinite for a linear
    joint."""
    damping_Nms_per_rad: float
    """B for small bending."""
    softened_damping_Nms_per_rad: float
    """B_s, the damping that complete softening adds."""
    inertia_Nms2_per_rad: float
    """I, inertia of the joint beyond the inertia of the leg."""

    def linearised(self, amplitude_rad: float) -> tuple[float, float]:
        """K (N·m/rad) and B (N·m·s/rad) of the linear joint nearest to this one in a sinusoid (rad).

        First harmonic of the moment (describing function): mean over a period of s, weighted by the squares
        of bending and rate, respectively.
        """
        phase = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
        share = _share(amplitude_rad * np.cos(phase), self.half_softening_rad)
        softer = 2.0 * float(np.mean(share * np.cos(phase) ** 2))
        lossier = 2.0 * float(np.mean(share * np.sin(phase) ** 2))
        return (
            self.stiffness_Nm_per_rad * (1.0 - SOFTENING * softer),
            self.damping_Nms_per_rad + self.softened_damping_Nms_per_rad * lossier,
        )


CONSTANTS = tuple(field.name for field in fields(RubberJoint))


def _share(bending, half):
    """Part of the softening that has taken place at a bending (rad)."""
    return 1.0 / (1.0 + (half / np.maximum(np.abs(bending), 1e-12)) ** 2)


def swing(
    leg: Leg,
    joints: list[RubberJoint],
    foot_acceleration: Annotated[np.ndarray, "(feet, 2 n + 1)", "m/s²"],
    step_s: float,
) -> Annotated[np.ndarray, "(k, feet, n + 1)"]:
    """Angle of the leg on several joints and several moving feet, by the classical Runge-Kutta method.

        (J + I) theta'' = m g r sin(theta) - m r y_f'' cos(theta) - (tau - I theta''),   J = I_l + m r^2

    leg: the leg, upright and at rest at the start.
    joints: joints to try, k of them.
    foot_acceleration: y_f'' at whole and half steps.
    Returns: theta at whole steps (rad), positive when the leg tips towards +y.
    """
    constants = np.array([astuple(joint) for joint in joints]).T[:, :, None]
    lanes = (len(joints), foot_acceleration.shape[0])
    # one lane per joint and foot, contiguous, and results in place: with this few lanes numpy's own
    # bookkeeping costs more than the arithmetic
    stiffness, half, damping, added, inertia = (np.broadcast_to(c, lanes).ravel() for c in constants)
    coupling = leg.mass_kg * leg.com_m
    weight = coupling * leg.gravity_m_per_s2
    inverse = 1.0 / (leg.inertia_kgm2 + coupling * leg.com_m + inertia)
    half_squared = half**2
    add, subtract, multiply, divide, sin, cos = np.add, np.subtract, np.multiply, np.divide, np.sin, np.cos
    share, moment, part = np.empty((3, half.size))
    # factors as arrays as well: a number would be converted every time
    one, two, softening, h, halved, sixth = (
        np.full(half.size, x) for x in (1.0, 2.0, SOFTENING, step_s, 0.5 * step_s, step_s / 6.0)
    )

    def acceleration(theta, rate, pushed, out):
        """Write theta'' into ``out``; ``pushed`` is m r y_f''."""
        multiply(theta, theta, share)
        divide(share, add(share, half_squared, part), share)
        subtract(one, multiply(softening, share, part), part)
        multiply(multiply(stiffness, theta, moment), part, moment)
        add(damping, multiply(added, share, part), part)
        add(moment, multiply(part, rate, part), moment)
        multiply(weight, sin(theta, out), out)
        subtract(out, multiply(pushed, cos(theta, part), part), out)
        return multiply(subtract(out, moment, out), inverse, out)

    pushes = coupling * np.tile(foot_acceleration.T, (1, len(joints)))
    steps = (pushes.shape[0] - 1) // 2
    theta, rate, rate_half, r2, r3, r4, a1, a2, a3, a4 = np.zeros((10, half.size))
    path = np.zeros((steps + 1, half.size))

    def onwards(x, by, slope, out):
        return add(x, multiply(by, slope, part), out)

    def whole_step(x, first, second, third, fourth):
        """Add h / 6 (first + 2 second + 2 third + fourth) to x."""
        add(first, multiply(two, second, part), rate_half)
        add(rate_half, multiply(two, third, part), rate_half)
        add(rate_half, fourth, rate_half)
        add(x, multiply(sixth, rate_half, rate_half), x)

    for k in range(steps):
        start, middle, end = pushes[2 * k : 2 * k + 3]
        acceleration(theta, rate, start, a1)
        onwards(rate, halved, a1, r2)
        acceleration(onwards(theta, halved, rate, rate_half), r2, middle, a2)
        onwards(rate, halved, a2, r3)
        acceleration(onwards(theta, halved, r2, rate_half), r3, middle, a3)
        onwards(rate, h, a3, r4)
        acceleration(onwards(theta, h, r3, rate_half), r4, end, a4)
        whole_step(theta, rate, r2, r3, r4)
        whole_step(rate, a1, a2, a3, a4)
        path[k + 1] = theta
    return path.reshape(steps + 1, *lanes).transpose(1, 2, 0)
