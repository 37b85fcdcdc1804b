"""The dummy in the multi-body engine PyBullet (thesis section 2-1-3).

The bodies are modelled in PyBullet; this module holds no equation of motion. The bodies are described in the
frame of the foot, where the motion of the belt is a gravity (0, -y_f'', -g). PyBullet integrates by leapfrog,
with angles q_k at whole steps of h and rates w_k-1/2 at half steps, hence

    y_f''  = (y_f(t + h) - 2 y_f(t) + y_f(t - h)) / h^2    so that the foot stays on its recorded path,
    theta' = (3 w_k-1/2 - w_k-3/2) / 2                     for the damping, as w_k+1/2 is not known yet,
    theta' = (w_k+1/2 + w_k-1/2) / 2 - h^2 theta''' / 6    as a result.

theta'' and the forces are evaluated afterwards, with the leg set to theta, theta' of every recorded instant.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pybullet

from tepsipe.mechanics.engines.interface import FALLEN_RAD, Joint, Swing, Task, in_world_frame
from tepsipe.mechanics.inverse_dynamics import Foot, Leg

FOOT, LEG = 0, 1  # links of the body in PyBullet


def simulate(task: Task) -> Swing:
    """Simulate the leg on the moving foot.

    Returns: motion and forces at the recorded instants.
    """
    h = task.step_s
    pushed = np.diff(task.path(h * np.arange(-1, task.steps + 1)), 2) / h**2
    with _built(task.leg, task.foot, task.joint, h) as dummy:
        theta, theta_d, fell_after_s = _swing(dummy, pushed, task.start.angle_rad, task.start.rate_rad_per_s)
        theta, theta_d = theta[:: task.stride], theta_d[:: task.stride]
        elapsed = task.elapsed(theta.size)
        theta_dd, on_leg, on_foot = _reactions(dummy, task.velocity(elapsed, 1), theta, theta_d)
    f_y, f_z, m_x = on_foot.T
    on_leg_y, on_leg_z = in_world_frame(theta, *on_leg.T)
    return Swing(
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        f_y=f_y,
        f_z=f_z,
        # in PyBullet, I is part of the leg; as part of the joint, its reaction acts on the foot
        m_x=m_x + task.path(elapsed) * f_z + task.joint.inertia_Nms2_per_rad * theta_dd,
        f_ay=-on_leg_y,
        f_az=-on_leg_z,
        fell_after_s=fell_after_s,
    )


class _Dummy:
    """The dummy in a separate PyBullet instance, at steps of h (s)."""

    def __init__(self, client: int, body: int, g: float, joint: Joint, h: float):
        self.client, self.body, self.g, self.h, self.joint = client, body, g, h, joint

    def put(self, theta: float, theta_d: float) -> None:
        """Set the leg to an angle (rad) and a rate (rad/s)."""
        pybullet.resetJointState(self.body, LEG, theta, theta_d, self.client)

    def step(self, y_dd: float, theta: float, theta_d: float) -> None:
        """One step under y_f'' (m/s²) and the torque of the joint at theta, theta'."""
        tau = self.joint.resistance(theta, theta_d)
        pybullet.setGravity(0.0, -y_dd, -self.g, self.client)
        # positional arguments are faster: two targets (unused for a torque), the torque, three gains
        pybullet.setJointMotorControl2(
            self.body, LEG, pybullet.TORQUE_CONTROL, 0.0, 0.0, -tau, 0.0, 0.0, 0.0, self.client
        )
        pybullet.stepSimulation(self.client)

    def state(self) -> tuple[float, float]:
        """Angle (rad) and rate (rad/s) of the leg."""
        return pybullet.getJointState(self.body, LEG, self.client)[:2]


@contextmanager
def _built(leg: Leg, foot: Foot, joint: Joint, h: float) -> Iterator[_Dummy]:
    """Build the dummy: the foot fixed on the belt, the leg hinged on the foot."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        upright = [0.0, 0.0, 0.0, 1.0]
        body = pybullet.createMultiBody(
            baseMass=0.0,  # the belt, which stays where it is
            linkMasses=[foot.mass_kg, leg.mass_kg],
            linkCollisionShapeIndices=[-1, -1],
            linkVisualShapeIndices=[-1, -1],
            linkPositions=[[0.0, 0.0, 0.0], [0.0, 0.0, foot.height_m]],
            linkOrientations=[upright, upright],
            linkInertialFramePositions=[[0.0, 0.0, 0.5 * foot.height_m], [0.0, 0.0, leg.com_m]],
            linkInertialFrameOrientations=[upright, upright],
            linkParentIndices=[0, 1],  # belt, foot
            linkJointTypes=[pybullet.JOINT_FIXED, pybullet.JOINT_REVOLUTE],
            linkJointAxis=[[-1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],  # positive theta rotates z towards y
            physicsClientId=client,
        )
        # PyBullet has no joint inertia: it is added to the leg, in a separate call, otherwise it is ignored
        inertia = leg.inertia_kgm2 + joint.inertia_Nms2_per_rad
        pybullet.changeDynamics(body, LEG, localInertiaDiagonal=[inertia] * 3, physicsClientId=client)
        pybullet.changeDynamics(
            body, LEG, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, physicsClientId=client
        )
        # the default limit is 100 rad/s
        pybullet.changeDynamics(body, LEG, maxJointVelocity=1e6, physicsClientId=client)
        # a motor without force replaces the default motor, which holds the leg still
        pybullet.setJointMotorControl2(
            body, LEG, pybullet.VELOCITY_CONTROL, force=0.0, physicsClientId=client
        )
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=h,
            numSubSteps=0,
            jointFeedbackMode=pybullet.JOINT_FEEDBACK_IN_JOINT_FRAME,
            physicsClientId=client,
        )
        yield _Dummy(client, body, leg.gravity_m_per_s2, joint, h)
    finally:
        pybullet.disconnect(client)


def _swing(dummy: _Dummy, y_dd: np.ndarray, theta: float, theta_d: float):
    """Angle (rad) and rate (rad/s) at every step, and the time of the fall (s) or None."""
    h, y_dd = dummy.h, y_dd.tolist()
    # a first step gives theta'' at the start, and with it the rates at the preceding half steps
    dummy.put(theta, theta_d)
    dummy.step(y_dd[0], theta, theta_d)
    theta_dd = (dummy.state()[1] - theta_d) / h
    q, w, w_before = theta, theta_d - 0.5 * h * theta_dd, theta_d - 1.5 * h * theta_dd
    dummy.put(q, w)

    angles, half_rates, fell_after_s = [], [w], None
    for k, y_dd_k in enumerate(y_dd):
        if not -FALLEN_RAD <= q <= FALLEN_RAD:
            fell_after_s = k * h
            break
        angles.append(q)
        dummy.step(y_dd_k, q, 1.5 * w - 0.5 * w_before)
        w_before, (q, w) = w, dummy.state()
        half_rates.append(w)

    half = np.array(half_rates)
    jerk = np.gradient(np.diff(half)) / h**2 if half.size > 2 else np.zeros(1)
    return np.array(angles), 0.5 * (half[:-1] + half[1:]) - h**2 * jerk / 6.0, fell_after_s


def _reactions(dummy: _Dummy, y_dd: np.ndarray, theta: np.ndarray, theta_d: np.ndarray):
    """Acceleration and forces at given states, from one step from each state.

    theta'' (rad/s²), shape (n,); force on the leg, across it and along it (N), shape (n, 2); force on the
    foot in y and z (N) and moment about x (N·m), in the belt's surface under the ankle, shape (n, 3).
    """
    for link in (FOOT, LEG):
        pybullet.enableJointForceTorqueSensor(dummy.body, link, True, dummy.client)
    theta_dd, on_leg, on_foot = [], [], []
    for y_dd_k, q, w in zip(y_dd.tolist(), theta.tolist(), theta_d.tolist(), strict=True):
        dummy.put(q, w)
        dummy.step(y_dd_k, q, w)
        foot, leg = pybullet.getJointStates(dummy.body, (FOOT, LEG), dummy.client)
        theta_dd.append((leg[1] - w) / dummy.h)
        on_leg.append(leg[2][1:3])
        on_foot.append(foot[2][1:4])
    return np.array(theta_dd), np.array(on_leg), np.array(on_foot)
