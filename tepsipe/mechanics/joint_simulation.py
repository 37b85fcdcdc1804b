"""Simulate a joint of known impedance under a leg on a moving belt, to test estimators."""

from typing import TYPE_CHECKING

import numpy as np

from tepsipe.arguments import checked, one_of, regular_rate, same_length, samples
from tepsipe.errors import InputError, refuse_other_kind
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.signals.array_types import Samples

if TYPE_CHECKING:
    from tepsipe.mechanics.forward_dynamics import ForwardSimulation


MOST_STEPS = 10**8
THESIS_FOOT = Foot(mass_kg=2.1, height_m=0.055)  # Table 2-2


def simulate_joint(
    time: "Samples",
    belt_velocity: "Samples",
    leg: Leg,
    *,
    I: float = 0.0,  # noqa: E741, N803  the symbols of the thesis
    B: float,  # noqa: N803
    K: float,  # noqa: N803
    rest_angle_rad: float = 0.0,
    softening: tuple[float, float, float] | None = None,
    foot: Foot = THESIS_FOOT,
    engine: str = "auto",
    step_s: float | None = None,
) -> "ForwardSimulation":
    """Motion, torque and forces of a leg on a joint of known impedance, driven by the belt.

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s), on a regular clock.
    belt_velocity : array_like or Signal, shape (n,)
        Velocity of the belt (m/s).
    leg : Leg
        The leg (kg, m, kg·m²).
    I, B, K : float
        Inertia (N·m·s²/rad, without the leg's own), damping (N·m·s/rad), stiffness (N·m/rad) of the joint.
    rest_angle_rad : float
        Angle at which the joint is not bent (rad).
    softening : tuple of float, optional
        C (N·m/rad), B_s (N·m·s/rad) and phi_h (rad) of a joint that softens, such as the ``softening`` of a
        joint likelihood (`tepsipe.mechanics.rubber_joint`); I, B, K are then those of small bending.
    foot : Foot
        The foot (kg, m); by default the foot of the thesis.
    engine : {"auto", "pybullet", "mujoco", "equations"}
        Engine of the simulation; ``auto`` takes the first of the others that is installed.
    step_s : float, optional
        Longest step of the simulation (s); by default 1 ms.

    Returns
    -------
    ForwardSimulation
        Angle (rad), torque (N·m), forces (N) and accelerations (m/s²) at the instants.

    Raises
    ------
    InputError
        If the signals cannot be used, the joint cannot be simulated, or the engine is not installed.

    Examples
    --------
    >>> from tepsipe import load_example, simulate_joint
    >>> dummy = load_example("dummy")
    >>> moved = simulate_joint(
    ...     dummy.time[:2500],
    ...     dummy.belt_velocity[:2500],
    ...     dummy.leg,
    ...     I=0.02,
    ...     B=0.15,
    ...     K=10.0,
    ...     engine="equations",
    ... )
    >>> print(f"largest angle {moved.theta.max():.3f} rad")
    largest angle 0.005 rad
    """
    from tepsipe.mechanics.engines import ENGINES
    from tepsipe.mechanics.forward_dynamics import Joint, simulate_dummy

    refuse_other_kind(leg, Leg, "simulate_joint", "Leg")
    refuse_other_kind(foot, Foot, "simulate_joint", "mechanics.inverse_dynamics.Foot")
    I, B, K, rest_angle_rad, step_s = checked(  # noqa: E741
        ("step_s",), I=I, B=B, K=K, rest_angle_rad=rest_angle_rad, step_s=step_s
    )
    engine = one_of(engine, "engine", ("auto", *ENGINES))
    softened = () if softening is None else samples(softening, "", "softening", shape=(3,)).tolist()
    time, rate_hz = regular_rate(time)
    velocity = samples(belt_velocity, "m/s", "belt_velocity")
    same_length(time, belt_velocity=velocity)
    stride = max(1, int(np.ceil(1.0 / (rate_hz * (0.001 if step_s is None else step_s)) - 1e-9)))
    if stride * time.size > MOST_STEPS:
        raise InputError(
            f"step_s: expected at most {MOST_STEPS:g} steps, found {stride * time.size:.3g}: lengthen "
            "step_s or shorten the record"
        )
    # instants of single precision
    time = time[0] + np.arange(time.size) / rate_hz
    joint = Joint(I, B, K, rest_angle_rad, *softened)
    return simulate_dummy(time, velocity, leg, foot, joint, 1.0 / (rate_hz * stride), engine)
