"""The dummy's rubber joint."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from annotated_types import Gt, Le

from tepsipe.quantities import Damping, NotNegative, Stiffness, Time


@dataclass(frozen=True)
class Rubber:
    """A rubber joint that softens as it is bent further and loses more energy as it softens (Payne effect).

    With the part q = phi^2 / (phi^2 + softening_angle^2) of the softening that has taken place, the moment is
    ``stiffness * phi * (1 - softening * q) + (damping + softened_damping * q) * phi'``.
    """

    stiffness_Nm_per_rad: Stiffness
    """Stiffness for small bending."""
    damping_Nms_per_rad: Damping
    """Damping for small bending."""
    softening: NotNegative
    """Fraction of the stiffness that is lost at large bending, 0 to 1."""
    softening_angle_rad: Annotated[float, Gt(0), Le(3.2)]
    """Bending at which half of it is lost."""
    softened_damping_Nms_per_rad: Damping
    """Damping that is gained at large bending, half of it at the same angle."""
    relaxation_share: NotNegative = 0.0
    """Moment of a quick bending beyond that, as a fraction of the stiffness for small bending (0: none)."""
    relaxation_s: Time = 1.0
    """Time in which it relaxes."""

    @cached_property
    def moment(self) -> Callable[[float, float], float]:
        """``moment(bending, rate)`` (N·m) opposes a bending (rad) that grows at a rate (rad/s)."""
        stiffness, softening, square_angle = (
            self.stiffness_Nm_per_rad,
            self.softening,
            self.softening_angle_rad**2,
        )
        small, large = self.damping_Nms_per_rad, self.softened_damping_Nms_per_rad

        # constants are looked up once: a trial asks half a million times
        def moment(bending: float, rate: float) -> float:
            square = bending * bending
            part = square / (square + square_angle)
            return stiffness * bending * (1.0 - softening * part) + (small + large * part) * rate

        return moment


class Relaxation:
    """Relaxing part of a rubber during integration: spring k and dashpot in series (Maxwell element).

    In addition to `Rubber.moment` it exerts the moment ``k (phi - s)``, where the slack s (rad) follows the
    bending, ``s' = (phi - s) / T``. The slack is the last of the rig's states.
    """

    def __init__(self, rubber: Rubber) -> None:
        self._lasting, self._slack = rubber.moment, 0.0
        self._stiffness = rubber.relaxation_share * rubber.stiffness_Nm_per_rad
        self._time_s = rubber.relaxation_s

    def moment(self, bending: float, rate: float) -> float:
        """Moment (N·m) that opposes a ``bending`` (rad) growing at ``rate`` (rad/s), with its slack."""
        return self._lasting(bending, rate) + self._stiffness * (bending - self._slack)

    def with_slack(self, derivative: Callable, bending: Callable) -> Callable:
        """Derivative of a rig's states and the slack (units of the states per s).

        ``derivative(u, state)`` is the rig's, with this moment; ``bending(state)`` is in rad.
        """

        def of_both(u: float, state: tuple[float, ...]) -> tuple[float, ...]:
            rig, self._slack = state[:-1], state[-1]
            return (*derivative(u, rig), (bending(rig) - state[-1]) / self._time_s)

        return of_both

    def relaxing(self, bending: np.ndarray, slack: np.ndarray) -> np.ndarray:
        """Moment of the spring (N·m) for a course of bending and slack (rad), shape (n,)."""
        return self._stiffness * (bending - slack)
