"""A rubber joint that softens as it is bent and loses more energy as it softens.

    tau = K phi (1 - s) + (B + B_s s / S) phi' + I phi'',      s = S phi^2 / (phi^2 + phi_h^2)

phi is the bending, K and B hold for small bending, phi_h is the bending at which half of the softening S has
taken place, and B_s is the damping that softening adds. Filled rubber behaves like this: its storage modulus
falls with amplitude while its loss modulus rises (Payne 1962, J. Appl. Polym. Sci. 6:57-63). S and phi_h are
not separated by movements below phi_h, where only S / phi_h^2 matters; S is therefore fixed.
"""

from dataclasses import astuple, dataclass, fields

import numpy as np

from tepsipe.mechanics.inverse_dynamics import Leg

SOFTENING = 0.5


@dataclass(frozen=True, kw_only=True)
class RubberJoint:
    """Constants of a rubber joint.

    Attributes
    ----------
    stiffness_Nm_per_rad : float
        K for small bending (N·m/rad).
    half_softening_rad : float
        phi_h, the bending at which half of the softening has taken place (rad); infinite for a linear joint.
    damping_Nms_per_rad : float
        B for small bending (N·m·s/rad).
    softened_damping_Nms_per_rad : float
        B_s, the damping that complete softening adds (N·m·s/rad).
    inertia_Nms2_per_rad : float
        I, inertia of the joint beyond that of the leg (N·m·s²/rad).
    """

    stiffness_Nm_per_rad: float
    half_softening_rad: float
    damping_Nms_per_rad: float
    softened_damping_Nms_per_rad: float
    inertia_Nms2_per_rad: float

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
    """Part of the softening that has taken place (-) at a bending (rad)."""
    return 1.0 / (1.0 + (half / np.maximum(np.abs(bending), 1e-12)) ** 2)


def swing(leg: Leg, joints: list[RubberJoint], foot_acceleration: np.ndarray, step_s: float) -> np.ndarray:
    """Angle of the leg on several joints and several moving feet, by the classical Runge-Kutta method.

        (J + I) theta'' = m g r sin(theta) - m r y_f'' cos(theta) - (tau - I theta''),   J = I_l + m r^2

    Parameters
    ----------
    leg : Leg
        The leg (kg, m, kg·m²), upright and at rest at the start.
    joints : list of RubberJoint
        Joints to try, k of them.
    foot_acceleration : ndarray, shape (feet, 2 n + 1)
        y_f'' at whole and half steps (m/s²).
    step_s : float
        Step (s).

    Returns
    -------
    ndarray, shape (k, feet, n + 1)
        theta at whole steps (rad), positive when the leg tips towards +y.
    """
    stiffness, half, damping, added, inertia = np.array([astuple(joint) for joint in joints]).T[:, :, None]
    coupling = leg.mass_kg * leg.com_m
    weight = coupling * leg.gravity_m_per_s2
    inverse = 1.0 / (leg.inertia_kgm2 + coupling * leg.com_m + inertia)
    half_squared = half**2

    def acceleration(theta, rate, pushed):
        square = theta * theta
        share = square / (square + half_squared)
        moment = stiffness * theta * (1.0 - SOFTENING * share) + (damping + added * share) * rate
        return (weight * np.sin(theta) - coupling * pushed * np.cos(theta) - moment) * inverse

    pushes = np.ascontiguousarray(foot_acceleration.T)
    steps = (pushes.shape[0] - 1) // 2
    theta = np.zeros((len(joints), pushes.shape[1]))
    rate = np.zeros_like(theta)
    path = np.empty((steps + 1, *theta.shape))
    path[0], h = theta, step_s
    for k in range(steps):
        start, middle, end = pushes[2 * k : 2 * k + 3]
        a1 = acceleration(theta, rate, start)
        r2 = rate + 0.5 * h * a1
        a2 = acceleration(theta + 0.5 * h * rate, r2, middle)
        r3 = rate + 0.5 * h * a2
        a3 = acceleration(theta + 0.5 * h * r2, r3, middle)
        r4 = rate + h * a3
        a4 = acceleration(theta + h * r3, r4, end)
        theta = theta + h / 6.0 * (rate + 2.0 * r2 + 2.0 * r3 + r4)
        rate = rate + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        path[k + 1] = theta
    return path.transpose(1, 2, 0)
