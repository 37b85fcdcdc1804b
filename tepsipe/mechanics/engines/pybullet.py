"""The dummy in the multi-body engine PyBullet (thesis section 2-1-3).

The bodies are modelled in PyBullet; this module holds no equation of motion. The bodies are described in the
frame of the foot, where the motion of the belt is a gravity (0, -y_f'', -g). PyBullet integrates by leapfrog,
with angles q_k at whole steps of h and rates w_k-1/2 at half steps, hence

    y_f''  = (y_f(t + h) - 2 y_f(t) + y_f(t - h)) / h^2    so that the foot stays on its recorded path,
    theta' = (3 w_k-1/2 - w_k-3/2) / 2                     for the damping, as w_k+1/2 is not known yet,
    theta' = (w_k+1/2 + w_k-1/2) / 2 - h^2 theta''' / 6    as a result.

theta'' and the forces are evaluated afterwards, with the leg set to theta, theta' of every recorded instant.

Dummies with several joints stand on one belt, each on its own foot. They do not feel each other, and every
call of PyBullet serves all of them: a step of four takes half the time of four steps of one.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import numpy as np
import pybullet

from tepsipe.mechanics.engines.interface import FALLEN_RAD, Swing, Task, in_world_frame


def simulate(task: Task) -> list[Swing]:
    """Simulate the legs on their moving feet.

    Returns: motion and forces at the recorded instants, for every joint.
    """
    h = task.step_s
    pushed = np.diff(task.path(h * np.arange(-1, task.steps + 1)), 2) / h**2
    with _built(task) as dummies:
        swings = _swings(dummies, task, pushed)
        states = [(theta[:: task.stride], theta_d[:: task.stride]) for theta, theta_d, _ in swings]
        elapsed = task.elapsed(max(theta.size for theta, _ in states))
        reactions = _reactions(dummies, task, task.velocity(elapsed, 1), states)
    found = []
    for joint, (theta, theta_d), reaction, swing in zip(task.joints, states, reactions, swings, strict=True):
        theta_dd, across, along, f_y, f_z, m_x = reaction[: theta.size].T
        on_leg_y, on_leg_z = in_world_frame(theta, across, along)
        # in PyBullet, I is part of the leg; as part of the joint, its reaction acts on the foot
        m_x = m_x + task.path(elapsed[: theta.size]) * f_z + joint.inertia_Nms2_per_rad * theta_dd
        found.append(
            Swing(theta, theta_d, theta_dd, f_y, f_z, m_x, -on_leg_y, -on_leg_z, fell_after_s=swing[2])
        )
    return found


class _Dummies:
    """Dummies in a separate PyBullet instance: one body, whose links are feet and legs in turn."""

    def __init__(self, client: int, task: Task):
        self.client, self.g = client, task.leg.gravity_m_per_s2
        self.feet, self.legs = (list(range(first, 2 * len(task.joints), 2)) for first in (0, 1))
        self.body = 0

    def put(self, theta: Iterable[float], theta_d: Iterable[float]) -> None:
        """Set the legs to angles (rad) and rates (rad/s)."""
        for leg, q, w in zip(self.legs, theta, theta_d, strict=True):
            pybullet.resetJointState(self.body, leg, q, w, self.client)

    def step(self, y_dd: float, torques: list[float]) -> None:
        """One step under y_f'' (m/s²) and the torques on the legs (N·m)."""
        pybullet.setGravity(0.0, -y_dd, -self.g, self.client)
        pybullet.setJointMotorControlArray(
            self.body, self.legs, pybullet.TORQUE_CONTROL, forces=torques, physicsClientId=self.client
        )
        pybullet.stepSimulation(self.client)

    def state(self) -> tuple[list[float], list[float]]:
        """Angles (rad) and rates (rad/s) of the legs."""
        states = pybullet.getJointStates(self.body, self.legs, self.client)
        return [state[0] for state in states], [state[1] for state in states]


@contextmanager
def _built(task: Task) -> Iterator[_Dummies]:
    """Build the dummies: the feet fixed on the belt, each leg hinged on its foot."""
    leg, foot, count = task.leg, task.foot, len(task.joints)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        dummies = _Dummies(client, task)
        upright = [0.0, 0.0, 0.0, 1.0]
        body = dummies.body = pybullet.createMultiBody(
            baseMass=0.0,  # the belt, which stays where it is
            linkMasses=[foot.mass_kg, leg.mass_kg] * count,
            linkCollisionShapeIndices=[-1, -1] * count,
            linkVisualShapeIndices=[-1, -1] * count,
            linkPositions=[[0.0, 0.0, 0.0], [0.0, 0.0, foot.height_m]] * count,
            linkOrientations=[upright, upright] * count,
            linkInertialFramePositions=[[0.0, 0.0, 0.5 * foot.height_m], [0.0, 0.0, leg.com_m]] * count,
            linkInertialFrameOrientations=[upright, upright] * count,
            # the belt is 0, and link k is k + 1
            linkParentIndices=[parent for foot in dummies.feet for parent in (0, foot + 1)],
            linkJointTypes=[pybullet.JOINT_FIXED, pybullet.JOINT_REVOLUTE] * count,
            linkJointAxis=[[-1.0, 0.0, 0.0]] * 2 * count,  # positive theta rotates z towards y
            physicsClientId=client,
        )
        for link, joint in zip(dummies.legs, task.joints, strict=True):
            # PyBullet has no joint inertia: it is added to the leg, in a separate call, otherwise it is
            # ignored
            inertia = leg.inertia_kgm2 + joint.inertia_Nms2_per_rad
            pybullet.changeDynamics(body, link, localInertiaDiagonal=[inertia] * 3, physicsClientId=client)
            pybullet.changeDynamics(
                body, link, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, physicsClientId=client
            )
            # the default limit is 100 rad/s
            pybullet.changeDynamics(body, link, maxJointVelocity=1e6, physicsClientId=client)
            # a motor without force replaces the default motor, which holds the leg still
            pybullet.setJointMotorControl2(
                body, link, pybullet.VELOCITY_CONTROL, force=0.0, physicsClientId=client
            )
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=task.step_s,
            numSubSteps=0,
            jointFeedbackMode=pybullet.JOINT_FEEDBACK_IN_JOINT_FRAME,
            physicsClientId=client,
        )
        yield dummies
    finally:
        pybullet.disconnect(client)


def _swings(dummies: _Dummies, task: Task, y_dd: np.ndarray) -> list[tuple]:
    """For every leg, angle (rad) and rate (rad/s) at every step, and the time of the fall (s) or None."""
    h, count = task.step_s, len(task.joints)
    theta, theta_d = task.start.angle_rad, task.start.rate_rad_per_s
    resistances = [joint.resistance for joint in task.joints]
    # a first step gives theta'' at the start, and with it the rates at the preceding half steps
    q = [theta] * count
    dummies.put(q, [theta_d] * count)
    dummies.step(float(y_dd[0]), [-torque(theta, theta_d) for torque in resistances])
    theta_dd = [(after - theta_d) / h for after in dummies.state()[1]]
    w, w_before = ([theta_d - steps * h * rate for rate in theta_dd] for steps in (0.5, 1.5))
    dummies.put(q, w)

    angles, half_rates, fell_at = [], [w], [None] * count
    for k, y_dd_k in enumerate(y_dd.tolist()):
        if max(q) > FALLEN_RAD or min(q) < -FALLEN_RAD:
            for leg, angle in enumerate(q):
                if fell_at[leg] is None and not -FALLEN_RAD <= angle <= FALLEN_RAD:
                    fell_at[leg] = k
                    resistances[leg] = _no_torque  # what it does from here on is left out
            if None not in fell_at:
                break
        angles.append(q)
        moving = zip(resistances, q, w, w_before, strict=True)
        dummies.step(y_dd_k, [-torque(angle, 1.5 * v - 0.5 * before) for torque, angle, v, before in moving])
        w_before, (q, w) = w, dummies.state()
        half_rates.append(w)

    swings = []
    for q, w, fell in zip(np.transpose(angles), np.transpose(half_rates), fell_at, strict=True):
        half = w[: len(q[:fell]) + 1]
        jerk = np.gradient(np.diff(half)) / h**2 if half.size > 2 else np.zeros(1)
        rate = 0.5 * (half[:-1] + half[1:]) - h**2 * jerk / 6.0
        swings.append((q[:fell], rate, None if fell is None else fell * h))
    return swings


def _no_torque(theta: float, theta_d: float) -> float:
    """Torque (N·m) of the joint of a leg that has fallen."""
    return 0.0


def _reactions(dummies: _Dummies, task: Task, y_dd: np.ndarray, states: list[tuple]) -> np.ndarray:
    """Acceleration and forces of every leg at given states, from one step from each, shape (legs, n, 6).

    theta'' (rad/s²); force on the leg, across it and along it (N); force on the foot in y and z (N) and
    moment about x (N·m), in the belt's surface under the ankle. A leg that has fallen stays as it was last.
    """
    links = [*dummies.feet, *dummies.legs]
    for link in links:
        pybullet.enableJointForceTorqueSensor(dummies.body, link, True, dummies.client)
    q, w = (
        np.transpose([np.pad(x, (0, y_dd.size - x.size), mode="edge") for x in signal])
        for signal in zip(*states, strict=True)
    )
    of_legs = zip(task.joints, q.T, w.T, strict=True)
    torques = -np.column_stack([joint.resistance(angle, rate) for joint, angle, rate in of_legs])
    read = []
    for y_dd_k, *state, torque in zip(*(x.tolist() for x in (y_dd, q, w, torques)), strict=True):
        dummies.put(*state)
        dummies.step(y_dd_k, torque)
        found = pybullet.getJointStates(dummies.body, links, dummies.client)
        feet, legs = found[: len(q[0])], found[len(q[0]) :]
        read.append([(leg[1], *leg[2][1:3], *foot[2][1:4]) for foot, leg in zip(feet, legs, strict=True)])
    reactions = np.array(read)
    reactions[..., 0] = (reactions[..., 0] - w) / task.step_s
    return reactions.swapaxes(0, 1)
