"""The dummy's rubber joint, by one of several laws.

Bent by phi, at a rate phi', the rubber resists with the moment

    R = k phi (1 - S q) (1 + phi^2 / phi_h^2)^(-p/2) + (b + b_s q) phi' + k_d z + sum_i c (phi - s_i)

    q = phi^2 / (phi^2 + phi_h^2),    z' = phi' - |phi'| z / phi_d,    s_i' = (phi - s_i) / T_i

- S and b_s: filled rubber loses stiffness as it is bent further, and more energy (Payne 1962, J. Appl.
  Polym. Sci. 6, 57-63). As shipped, the other terms are off.
- p: stiffness falls with a power of the bending.
- k_d: friction within the rubber, an element of Dahl, whose losses do not depend on speed (Dahl 1968; for
  rubber Berg 1998, Vehicle System Dynamics 30, 197-212).
- c: springs in series with dashpots (Maxwell elements) relax. A chain whose times are decades apart loses
  about the same energy in a cycle at all frequencies between them.

The rubber stores the energy of its springs and loses the rest; no term gives back more than it took:

    stored = int k phi (1 - S q) (1 + phi^2 / phi_h^2)^(-p/2) dphi + k_d z^2 / 2 + sum_i c (phi - s_i)^2 / 2
    lost   = (b + b_s q) phi'^2 + k_d z^2 |phi'| / phi_d + sum_i c (phi - s_i)^2 / T_i
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from annotated_types import Gt, Le

from tepsipe.quantities import AddedStiffness, Damping, Fraction, NotNegative, Some, Stiffness, Time


@dataclass(frozen=True)
class Rubber:
    """A rubber joint that softens as it is bent further and loses more energy as it softens (Payne effect).

    Further terms add friction within the rubber, and relaxation.
    """

    stiffness_Nm_per_rad: Stiffness  # k
    """Stiffness for small bending."""
    damping_Nms_per_rad: Damping  # b
    """Damping for small bending."""
    softening: NotNegative  # S
    """Fraction of the stiffness that is lost at large bending, 0 to 1."""
    softening_angle_rad: Annotated[float, Gt(0), Le(3.2)]  # phi_h
    """Bending at which half of it is lost."""
    softened_damping_Nms_per_rad: Damping  # b_s
    """Damping that is gained at large bending, half of it at the same angle."""
    softening_power: Fraction = 0.0  # p
    """Power of the bending with which the stiffness falls beyond the same angle (0: none)."""
    bristle_Nm_per_rad: AddedStiffness = 0.0  # k_d
    """Stiffness that yields, of friction within the rubber, in addition (0: none)."""
    bristle_rad: Annotated[float, Gt(0), Le(3.2)] = 1.0  # phi_d
    """Bending at which it has yielded."""
    relaxation_share: NotNegative = 0.0
    """Moment of a quick bending beyond that, as a fraction of the stiffness for small bending (0: none)."""
    relaxation_s: Some[Time] = (1.0,)  # T_i
    """Times in which it relaxes, an equal part of it in each."""

    @cached_property
    def moment(self) -> Callable[[float, float], float]:
        """``moment(bending, rate)`` (N·m) opposes a bending (rad) that grows at a rate (rad/s)."""
        stiffness, softening, square_angle = (
            self.stiffness_Nm_per_rad,
            self.softening,
            self.softening_angle_rad**2,
        )
        small, large = self.damping_Nms_per_rad, self.softened_damping_Nms_per_rad
        half_power = -0.5 * self.softening_power

        # constants are looked up once: a trial asks half a million times
        def moment(bending: float, rate: float) -> float:
            square = bending * bending
            part = square / (square + square_angle)
            return stiffness * bending * (1.0 - softening * part) + (small + large * part) * rate

        def falling(bending: float, rate: float) -> float:
            square = bending * bending
            part = square / (square + square_angle)
            lasting = stiffness * (1.0 - softening * part) * (1.0 + square / square_angle) ** half_power
            return lasting * bending + (small + large * part) * rate

        return falling if half_power else moment


class Memory:
    """Friction and relaxation of a rubber during integration: the terms of `Rubber` with z and s_i.

    The slacks s_i (rad), and after them the deflection z (rad) if there is friction, are the last of the
    rig's states.
    """

    def __init__(self, rubber: Rubber) -> None:
        self._lasting = rubber.moment
        self._times_s = tuple(rubber.relaxation_s) if rubber.relaxation_share else ()
        self._each = rubber.relaxation_share * rubber.stiffness_Nm_per_rad / len(rubber.relaxation_s)
        self._yielding, self._yields_rad = rubber.bristle_Nm_per_rad, rubber.bristle_rad
        self.states = len(self._times_s) + bool(self._yielding)
        """Number of states; 0 of a rubber without memory."""
        self._moment = 0.0

    def at_rest(self, bending: float) -> tuple[float, ...]:
        """States of a rubber that has long been bent (rad), without friction."""
        return (bending,) * len(self._times_s) + (0.0,) * bool(self._yielding)

    def moment(self, bending: float, rate: float) -> float:
        """Moment (N·m) that opposes a ``bending`` (rad) growing at ``rate`` (rad/s), with its memory."""
        return self._lasting(bending, rate) + self._moment

    def with_states(self, derivative: Callable, bending: Callable) -> Callable:
        """Derivative of a rig's states and these (units of the states per s).

        ``derivative(u, state)`` is the rig's, with this moment; ``bending(state)`` is bending and rate (rad,
        rad/s).
        """
        of_rig, count = -self.states, len(self._times_s)
        times, each, yielding, yields = self._times_s, self._each, self._yielding, self._yields_rad

        def of_both(u: float, state: tuple[float, ...]) -> tuple[float, ...]:
            rig, own = state[:of_rig], state[of_rig:]
            bent, rate = bending(rig)
            stretches = [bent - slack for slack in own[:count]]
            rates = [stretch / time for stretch, time in zip(stretches, times, strict=True)]
            self._moment = each * sum(stretches)
            if yielding:
                self._moment += yielding * own[count]
                rates.append(rate - abs(rate) * own[count] / yields)
            return (*derivative(u, rig), *rates)

        return of_both

    def remembered(self, bending: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Moment of the memory (N·m) for a course of bending, shape (n,), and of its states, (n, m) (rad)."""
        count = len(self._times_s)
        moment = self._each * np.sum(bending[:, None] - states[:, :count], axis=1)
        return moment + self._yielding * states[:, count] if self._yielding else moment
