"""Shank, thigh and trunk on a belt-driven foot in the multi-body engine MuJoCo, where PyBullet is missing.

As `tepsipe.virtual_lab.chain_pybullet`: no equation of motion, the belt's acceleration as a gravity, and
MuJoCo's semi-implicit Euler method, which is leapfrog with rates at half steps.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import mujoco
import numpy as np

SEGMENT = """<body name="s{k}" pos="0 0 {z!r}"><inertial pos="0 0 {com!r}" mass="{mass!r}"
diaginertia="{inertia!r} {inertia!r} {inertia!r}"/><joint type="hinge" axis="-1 0 0"/>{inside}</body>"""


class MuJoCoChain:
    """Three segments with hinges, at the steps of the model (s)."""

    def __init__(self, model: mujoco.MjModel, gravity: float):
        self.model, self.gravity = model, gravity
        self.data, self.pushed = mujoco.MjData(model), np.zeros(3)

    def put(self, q: Sequence[float], rate: Sequence[float]) -> None:
        """Set joint angles (rad) and their rates half a step before (rad/s)."""
        self.data.qpos[:], self.data.qvel[:] = q, rate

    def holding_torque(self, q: Sequence[float]) -> tuple[float, ...]:
        """Joint torques (N·m) that hold joint angles (rad) against gravity."""
        self.model.opt.gravity[:] = (0.0, 0.0, -self.gravity)
        self.put(q, (0.0, 0.0, 0.0))
        mujoco.mj_forward(self.model, self.data)
        return tuple(self.data.qfrc_bias.tolist())

    def push(self, segment: int, height_m: float, force: float, q: Sequence[float]) -> None:
        """A horizontal force (N) on a segment, a height (m) above its lower end, at the next step."""
        self.data.qpos[:] = q
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        body = segment + 1
        point = self.data.xpos[body] + height_m * self.data.xmat[body].reshape(3, 3)[:, 2]
        mujoco.mj_applyFT(
            self.model, self.data, np.array([0.0, force, 0.0]), np.zeros(3), point, body, self.pushed
        )

    def step(self, torque: Sequence[float], belt: float) -> tuple[tuple, tuple]:
        """One step under joint torques (N·m) and a belt's acceleration (m/s²): angles, rates (rad, rad/s)."""
        self.model.opt.gravity[:] = (0.0, -belt, -self.gravity)
        self.data.qfrc_applied[:] = torque + self.pushed
        self.pushed[:] = 0.0
        mujoco.mj_step(self.model, self.data)
        return tuple(self.data.qpos.tolist()), tuple(self.data.qvel.tolist())


@contextmanager
def built(masses, lengths, coms, inertias, gravity: float, step_s: float) -> Iterator[MuJoCoChain]:
    """Three segments (kg, m, m, kg m²) on the foot, under g (m/s²), at steps (s)."""
    inside = ""
    for k in (2, 1, 0):
        inside = SEGMENT.format(
            k=k,
            z=float(lengths[k - 1]) if k else 0.0,
            com=float(coms[k]),
            mass=float(masses[k]),
            inertia=float(inertias[k]),
            inside=inside,
        )
    yield MuJoCoChain(
        mujoco.MjModel.from_xml_string(
            f'<mujoco><compiler angle="radian"/><option integrator="Euler" timestep="{float(step_s)!r}">'
            f'<flag constraint="disable" contact="disable"/></option><worldbody>{inside}</worldbody></mujoco>'
        ),
        gravity,
    )
