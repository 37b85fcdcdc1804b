"""Torque of the joint by inverse dynamics of the leg, for a pathway given by name."""

import numpy as np

from tepsipe.errors import InputError, listed, quoted, refuse_other_kind
from tepsipe.mechanics.inverse_dynamics import TORQUE_PATHWAYS, Leg
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
    """
    refuse_other_kind(motion, SegmentMotion, "joint_torque", "segment_motion")
    refuse_other_kind(leg, Leg, "joint_torque", "Leg")
    return leg_pathway_torque("leg-thesis" if thesis else "leg", leg, motion)


def leg_pathway_torque(pathway: str, leg: Leg, motion: SegmentMotion) -> np.ndarray:
    """Torque (N·m) by one of `TORQUE_PATHWAYS`, shape (n,).

    Raises
    ------
    InputError
        If there is no such pathway.
    """
    if pathway not in TORQUE_PATHWAYS:
        raise InputError(
            f"expected a torque of {listed(TORQUE_PATHWAYS)}, found {quoted(pathway)}: correct it"
        )
    return TORQUE_PATHWAYS[pathway](leg, motion.theta, motion.theta_dd, motion.y_dd, motion.z_dd)
