"""Shank, thigh and trunk on a belt-driven foot in the multi-body engine PyBullet.

This module holds no equation of motion. The bodies are described in the frame of the foot, where the belt's
acceleration a is a gravity (0, -a, -g). PyBullet integrates by leapfrog: angles at whole steps, rates at half
steps.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import cos, sin

import pybullet

JOINTS = (0, 1, 2)


class PyBulletChain:
    """Three segments with revolute joints, at steps of ``step_s`` (s)."""

    def __init__(self, client: int, body: int, gravity: float, com_m: Sequence[float]):
        self.client, self.body, self.gravity, self.com_m = client, body, gravity, com_m

    def put(self, q: Sequence[float], rate: Sequence[float]) -> None:
        """Set joint angles (rad) and their rates half a step before (rad/s)."""
        for joint in JOINTS:
            pybullet.resetJointState(self.body, joint, q[joint], rate[joint], self.client)

    def holding_torque(self, q: Sequence[float]) -> tuple[float, ...]:
        """Joint torques (N·m) that hold joint angles (rad) against gravity."""
        still = (0.0, 0.0, 0.0)
        pybullet.setGravity(0.0, 0.0, -self.gravity, self.client)
        return tuple(pybullet.calculateInverseDynamics(self.body, list(q), still, still, self.client))

    def push(self, segment: int, height_m: float, force: float, q: Sequence[float]) -> None:
        """A horizontal force (N) on a segment, a height (m) above its lower end, at the next step."""
        angle = sum(q[: segment + 1])
        pybullet.applyExternalForce(
            self.body,
            segment,
            (0.0, force * cos(angle), force * sin(angle)),
            (0.0, 0.0, height_m - self.com_m[segment]),
            pybullet.LINK_FRAME,
            self.client,
        )

    def step(self, torque: Sequence[float], belt: float) -> tuple[tuple, tuple]:
        """One step under joint torques (N·m) and a belt's acceleration (m/s²): angles, rates (rad, rad/s)."""
        pybullet.setGravity(0.0, -belt, -self.gravity, self.client)
        pybullet.setJointMotorControlArray(
            self.body, JOINTS, pybullet.TORQUE_CONTROL, forces=torque, physicsClientId=self.client
        )
        pybullet.stepSimulation(self.client)
        first, second, third = pybullet.getJointStates(self.body, JOINTS, self.client)
        return (first[0], second[0], third[0]), (first[1], second[1], third[1])


@contextmanager
def built(masses, lengths, coms, inertias, gravity: float, step_s: float) -> Iterator[PyBulletChain]:
    """Three segments (kg, m, m, kg m²) on the foot, under g (m/s²), at steps (s)."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        upright = [0.0, 0.0, 0.0, 1.0]
        body = pybullet.createMultiBody(
            baseMass=0.0,  # the foot on the belt, which stays where it is
            linkMasses=list(masses),
            linkCollisionShapeIndices=[-1] * 3,
            linkVisualShapeIndices=[-1] * 3,
            linkPositions=[[0.0, 0.0, 0.0], [0.0, 0.0, lengths[0]], [0.0, 0.0, lengths[1]]],
            linkOrientations=[upright] * 3,
            linkInertialFramePositions=[[0.0, 0.0, com] for com in coms],
            linkInertialFrameOrientations=[upright] * 3,
            linkParentIndices=[0, 1, 2],
            linkJointTypes=[pybullet.JOINT_REVOLUTE] * 3,
            linkJointAxis=[[-1.0, 0.0, 0.0]] * 3,  # a positive angle rotates z towards y, forwards
            physicsClientId=client,
        )
        for joint, inertia in zip(JOINTS, inertias, strict=True):
            # in a call of its own, otherwise the inertia is ignored
            pybullet.changeDynamics(body, joint, localInertiaDiagonal=[inertia] * 3, physicsClientId=client)
            pybullet.changeDynamics(
                body, joint, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, physicsClientId=client
            )
            pybullet.changeDynamics(body, joint, maxJointVelocity=1e6, physicsClientId=client)
            # a motor without force replaces the default motor, which holds the joint still
            pybullet.setJointMotorControl2(
                body, joint, pybullet.VELOCITY_CONTROL, force=0.0, physicsClientId=client
            )
        pybullet.setPhysicsEngineParameter(fixedTimeStep=step_s, numSubSteps=0, physicsClientId=client)
        yield PyBulletChain(client, body, gravity, coms)
    finally:
        pybullet.disconnect(client)
