"""Torque of the joint by inverse dynamics of the leg, for arrays of your own."""

import numpy as np

from tepsipe.arguments import checked
from tepsipe.errors import refuse_other_kind
from tepsipe.mechanics.inverse_dynamics import Leg, leg_pathway_torque
from tepsipe.mechanics.segment_kinematics import SegmentMotion


def joint_torque(motion: SegmentMotion, leg: Leg, *, thesis: bool = False) -> np.ndarray:
    """Torque of the joint by inverse dynamics of the leg, without a force plate.

    Derived consistently (`leg_torque`), or as thesis eq (3-8) prints it (`leg_torque_as_printed`).

    Parameters
    ----------
    motion : SegmentMotion
        From `segment_motion` (s, rad, m).
    leg : Leg
        The leg (kg, m, kg·m²).
    thesis : bool
        Whether to take the equation as printed, whose stiffness is K - 2 m g r.

    Returns
    -------
    ndarray, shape (n,)
        tau (N·m), positive when it resists positive theta.

    Raises
    ------
    InputError
        If ``motion`` or ``leg`` is of another type.

    Examples
    --------
    >>> from tepsipe import joint_torque, load_example, segment_motion
    >>> dummy = load_example("dummy")
    >>> motion = segment_motion(
    ...     dummy.time, dummy.positions, dummy.markers, dummy.leg.com_m, labels=dummy.labels
    ... )
    >>> torque = joint_torque(motion, dummy.leg)
    >>> print(f"largest torque {torque.max():.2f} N·m")
    largest torque 0.35 N·m
    """
    refuse_other_kind(motion, SegmentMotion, "joint_torque", "segment_motion")
    refuse_other_kind(leg, Leg, "joint_torque", "Leg")
    (thesis,) = checked(thesis=thesis)
    return leg_pathway_torque("leg-thesis" if thesis else "leg", leg, motion)
