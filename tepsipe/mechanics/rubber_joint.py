"""A rubber joint that softens as it is bent and loses more energy as it softens.

    tau = K phi (1 - s) + (B + B_s s / S) phi' + I phi'',      s = S phi^2 / (phi^2 + phi_h^2)

phi is the bending, K and B hold for small bending, phi_h is the bending at which half of the softening S has
taken place, and B_s is the damping that softening adds. Filled rubber behaves like this: its storage modulus
falls with amplitude while its loss modulus rises (Payne 1962, J. Appl. Polym. Sci. 6:57-63). S and phi_h are
not separated by movements far below phi_h, where only S / phi_h^2 matters; S is therefore fixed. The joint
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
    step_s: float | np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Swing of the leg on several joints and several moving feet, by the classical Runge-Kutta method.

        (J + I) theta'' = m r G sin(theta - phi) - (tau - I theta''),   J = I_l + m r^2

    where G = hypot(g, y_f'') and phi = atan2(y_f'', g) are size and tilt of the apparent gravity.

    leg: the leg, upright and at rest at the start.
    joints: joints to try, k of them.
    foot_acceleration: y_f'' at whole and half steps.
    step_s: length of all steps, or of each step of each foot, shape (feet, n).
    Returns: theta (rad) and theta' (rad/s) at whole steps, both shape (k, feet, n + 1); positive when the
    leg tips towards +y.
    """
    constants = np.array([astuple(joint) for joint in joints]).T[:, :, None]
    lanes = (len(joints), foot_acceleration.shape[0])

    def by_lane(x: np.ndarray) -> np.ndarray:
        """Rows of a number per joint and foot, ``x`` of shape (rows, feet), as shape (rows, lanes)."""
        return np.tile(x, (1, len(joints)))

    # one lane per joint and foot, contiguous, and results in place: with this few lanes numpy's own
    # bookkeeping costs more than the arithmetic, so the loop calls as few functions as it can
    stiffness, half, damping, added, inertia = (np.broadcast_to(c, lanes).ravel() for c in constants)
    coupling = leg.mass_kg * leg.com_m
    about_ankle = leg.inertia_kgm2 + coupling * leg.com_m + inertia
    k, b, d = stiffness / about_ankle, damping / about_ankle, added / about_ankle
    c, half_squared = SOFTENING * k, half**2
    push = foot_acceleration.T
    pull = by_lane(coupling * np.hypot(leg.gravity_m_per_s2, push)) / about_ankle
    lean = by_lane(np.arctan2(push, leg.gravity_m_per_s2))
    steps = (push.shape[0] - 1) // 2
    h = np.tile(np.broadcast_to(step_s, (lanes[1], steps)).T, (1, 2 * len(joints)))
    halved, sixth = 0.5 * h, h / 6.0
    add, subtract, multiply, divide, sin = np.add, np.subtract, np.multiply, np.divide, np.sin
    share, part = np.empty((2, half.size))

    def accelerate(theta, rate, pulled, leant, out):
        """Write theta'' into ``out``; ``pulled`` is m r G / (J + I), ``leant`` is phi."""
        multiply(theta, theta, share)
        divide(share, add(share, half_squared, part), share)
        subtract(theta, leant, out)
        multiply(pulled, sin(out, out), out)
        subtract(k, multiply(c, share, part), part)
        subtract(out, multiply(theta, part, part), out)
        add(b, multiply(d, share, part), part)
        subtract(out, multiply(rate, part, part), out)

    # theta and theta' one after the other: at the step's start, at a stage, and their derivatives at stages
    size = half.size
    state, stage, change, *slopes = np.zeros((7, 2 * size))
    angle_now, rate_now, angle_then, rate_then = state[:size], state[size:], stage[:size], stage[size:]
    slopes = [(slope, slope[:size], slope[size:]) for slope in slopes]
    (first, *_), (second, *_), (third, *_), (fourth, *_) = slopes
    two = np.full(2 * size, 2.0)  # a number would be converted every time
    path = np.zeros((steps + 1, 2 * size))

    for i in range(steps):
        start, middle, end = 2 * i, 2 * i + 1, 2 * i + 2
        _, angle_slope, rate_slope = slopes[0]
        angle_slope[:] = rate_now
        accelerate(angle_now, rate_now, pull[start], lean[start], rate_slope)
        for (before, *_), (_, angle_slope, rate_slope), by, at in (
            (*slopes[0:2], halved[i], middle),
            (*slopes[1:3], halved[i], middle),
            (*slopes[2:4], h[i], end),
        ):
            add(state, multiply(by, before, stage), stage)
            angle_slope[:] = rate_then
            accelerate(angle_then, rate_then, pull[at], lean[at], rate_slope)
        multiply(two, add(second, third, change), change)
        add(add(change, first, change), fourth, change)
        add(state, multiply(sixth[i], change, change), state)
        path[i + 1] = state
    theta, rate = path.reshape(steps + 1, 2, *lanes).transpose(1, 2, 3, 0)
    return theta, rate
