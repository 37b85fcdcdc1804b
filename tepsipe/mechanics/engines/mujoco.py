"""The dummy in the multi-body engine MuJoCo, stepped by its own Runge-Kutta integrator of fourth order.

The bodies and the joint are modelled in MuJoCo; this module holds no equation of motion. The joint is
MuJoCo's hinge with its damping, stiffness and armature, each of which may be negative; what softening takes
away is added to its passive forces at every stage of a step. The bodies are described in the frame of the
foot, where the motion of the belt is a force -m y_f'' at the leg's centre of mass. An actuator with an
integrator exerts it, linear in time within a step from t to t + h:

    y_f''(t + s) = a + b s    with    a h + b h^2 / 2 = y_f'(t + h) - y_f'(t)
                                      a h^2 / 2 + b h^3 / 6 = y_f(t + h) - y_f(t) - h y_f'(t)

so that the foot has its recorded position and velocity after every step. theta'' and the forces are evaluated
afterwards: the leg is set to theta, theta' of every recorded instant, and the motion of the belt acts as a
gravity (0, -y_f'', -g) on both bodies.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from tepsipe.mechanics.engines.interface import FALLEN_RAD, Joint, Swing, Task, in_world_frame

LEG = 2  # bodies: the world, the foot, the leg
SENSORS_OFF = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
# the default inertia of 1 is replaced by the leg's, which may be zero in a compiled model
BODIES = """
<mujoco>
  <compiler angle="radian"/>
  <option integrator="RK4" timestep="{step!r}">
    <flag constraint="disable" contact="disable"/>
  </option>
  <worldbody>
    <body name="foot">
      <inertial pos="0 0 {half_height!r}" mass="{foot_mass!r}" diaginertia="1 1 1"/>
      <site name="under the ankle"/>
      <body name="leg" pos="0 0 {height!r}">
        <inertial pos="0 0 {com!r}" mass="{leg_mass!r}" diaginertia="1 1 1"/>
        <joint type="hinge" axis="-1 0 0"/>
        <site name="ankle"/>
        <site name="centre of mass" pos="0 0 {com!r}"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <general site="centre of mass" refsite="under the ankle" gear="0 -1 0 0 0 0" gainprm="{leg_mass!r}"
      dyntype="integrator"/>
  </actuator>
  <sensor>
    <force site="under the ankle"/>
    <torque site="under the ankle"/>
    <force site="ankle"/>
  </sensor>
</mujoco>
"""


def simulate(task: Task) -> list[Swing]:
    """Simulate the leg on the moving foot, with every joint.

    Returns: motion and forces at the recorded instants.
    """
    return [_moved(task, joint) for joint in task.joints]


def _moved(task: Task, joint: Joint) -> Swing:
    """Motion and forces with one joint."""
    model = _built(task, joint)
    data = mujoco.MjData(model)
    with _softening(joint):
        theta, theta_d, fell_after_s = _swing(task, model, data)
        theta, theta_d = theta[:: task.stride], theta_d[:: task.stride]
        elapsed = task.elapsed(theta.size)
        theta_dd, read = _reactions(model, data, task.velocity(elapsed, 1), theta, theta_d)
    _, f_y, f_z, m_x, _, _, _, across, along = read.T
    on_leg_y, on_leg_z = in_world_frame(theta, across, along)
    return Swing(
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        f_y=f_y,
        f_z=f_z,
        m_x=m_x + task.path(elapsed) * f_z,
        f_ay=-on_leg_y,
        f_az=-on_leg_z,
        fell_after_s=fell_after_s,
    )


@contextmanager
def _softening(joint: Joint) -> Iterator[None]:
    """Let MuJoCo call for the torque of softening within the block, if the joint softens."""
    rest = joint.rest_angle_rad

    def add(_, data):
        data.qfrc_passive[0] += joint.softened(data.qpos.item() - rest, data.qvel.item())

    if joint.softens:
        mujoco.set_mjcb_passive(add)
    try:
        yield
    finally:
        mujoco.set_mjcb_passive(None)


def _built(task: Task, joint: Joint) -> mujoco.MjModel:
    """The foot fixed on the belt, the leg hinged on the foot."""
    leg, foot = task.leg, task.foot
    model = mujoco.MjModel.from_xml_string(
        BODIES.format(
            step=float(task.step_s),
            half_height=0.5 * float(foot.height_m),
            foot_mass=float(foot.mass_kg),
            height=float(foot.height_m),
            com=float(leg.com_m),
            leg_mass=float(leg.mass_kg),
        )
    )
    # the compiler refuses negative values, the compiled model accepts them
    model.body_inertia[LEG] = leg.inertia_kgm2
    model.dof_armature[0] = joint.inertia_Nms2_per_rad
    model.dof_damping[0] = joint.damping_Nms_per_rad
    model.jnt_stiffness[0] = joint.stiffness_Nm_per_rad
    model.qpos_spring[0] = joint.rest_angle_rad
    model.opt.gravity[:] = (0.0, 0.0, -leg.gravity_m_per_s2)
    return model


def _swing(
    task: Task, model: mujoco.MjModel, data: mujoco.MjData
) -> tuple[np.ndarray, np.ndarray, float | None]:
    """Angle (rad) and rate (rad/s) at every step, and the time of the fall (s) or None."""
    h, step = task.step_s, mujoco.mj_step
    instants = h * np.arange(task.steps)
    v, gone = task.velocity(instants), np.diff(task.path(instants))
    slope = 12.0 / h**3 * (0.5 * h * (v[:-1] + v[1:]) - gone)
    first = np.diff(v) / h - 0.5 * h * slope
    angle, rate, y_dd, y_ddd = data.qpos, data.qvel, data.act, data.ctrl
    angle[0], rate[0] = task.start.angle_rad, task.start.rate_rad_per_s
    model.opt.disableflags |= SENSORS_OFF
    angles, rates = [angle.item()], [rate.item()]
    for a, b in zip(first.tolist(), slope.tolist(), strict=True):
        y_dd[0], y_ddd[0] = a, b
        step(model, data)
        q = angle.item()
        if not -FALLEN_RAD <= q <= FALLEN_RAD:
            break
        angles.append(q)
        rates.append(rate.item())
    fell_after_s = None if len(angles) == task.steps else len(angles) * h
    return np.array(angles), np.array(rates), fell_after_s


def _reactions(
    model: mujoco.MjModel, data: mujoco.MjData, y_dd: np.ndarray, theta: np.ndarray, theta_d: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration theta'' (rad/s²), shape (n,), and outputs of the sensors, shape (n, 9), at given states.

    The sensors give x, y, z each of the force of the belt on the foot (N), its moment about the point under
    the ankle (N·m), and the force of the foot on the leg in the leg's own frame (N).
    """
    model.opt.disableflags &= ~SENSORS_OFF
    data.act[0] = 0.0
    gravity = model.opt.gravity
    theta_dd, read = [], []
    for y_dd_k, q, w in zip(y_dd.tolist(), theta.tolist(), theta_d.tolist(), strict=True):
        gravity[1], data.qpos[0], data.qvel[0] = -y_dd_k, q, w
        mujoco.mj_forward(model, data)
        theta_dd.append(data.qacc.item())
        read.append(data.sensordata.copy())
    return np.array(theta_dd), np.array(read)
