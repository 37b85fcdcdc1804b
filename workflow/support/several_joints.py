"""Check of the section plan.several_joints before anything is computed."""

import math

from tepsipe.errors import InputError
from tepsipe.mechanics.engines import installed_engines


def check_several_joints(joints: dict, engine: str, name: str) -> None:
    """Unperturbed standing is long enough for all epochs and their covariance, and an engine is there."""
    protocol = joints["protocol"]
    epoch_s = protocol["before_s"] + protocol["after_s"] + 0.002
    of_windows = 20.0 * (protocol["before_s"] + max([protocol["after_s"], *joints["windows_s"]]) + 0.02)
    least = max(epoch_s * (protocol["epochs"] * len(joints["perturbations"]) + 1), of_windows)
    if protocol["unperturbed_s"] < least:
        raise InputError(
            f"{name}: expected plan.several_joints.protocol.unperturbed_s of at least {math.ceil(least)} s "
            f"for {protocol['epochs']} epochs of {len(joints['perturbations'])} perturbations, found "
            f"{protocol['unperturbed_s']:g} s: lengthen it, or take fewer epochs"
        )
    bodies = {"pybullet", "mujoco"} & set(installed_engines())
    if not (engine in bodies or (engine not in ("pybullet", "mujoco") and bodies)):
        raise InputError(
            f"{name}: expected PyBullet or MuJoCo for plan.several_joints, found "
            f"{', '.join(sorted(bodies)) or 'none'} and dummy.simulation.engine {engine}: install it, or "
            "set the engine to auto"
        )
