"""Forward simulation of the ankle dummy in PyBullet (thesis sections 2-1-3 and 3-1-3).

The foot follows the recorded belt and does not rotate; the leg turns about the ankle against the joint:

    tau = I theta'' + B theta' + K (theta - theta_ref)                                             (2-1)
    J theta'' = m g r sin(theta) - m r y_f'' cos(theta) - B theta' - K (theta - theta_ref),
    J = I_l + m r^2 + I

Symbols: theta leg angle, positive when the leg tips towards +y (rad); y_f position of the foot (m); I, B, K,
theta_ref of the joint; m, r, I_l, g of the leg and m_f, l_f of the foot as in `inverse_dynamics`.

The second equation is nowhere below: PyBullet has the bodies instead. They live in the foot's frame, where
the motion of the belt is a gravity (0, -y_f'', -g). PyBullet steps by leapfrog, with angles q_k at whole
steps of h and rates w_k-1/2 at half steps, hence

    y_f''  = (y_f(t + h) - 2 y_f(t) + y_f(t - h)) / h^2    so that the foot stays on its recorded path,
    theta' = (3 w_k-1/2 - w_k-3/2) / 2                     for the damping, as w_k+1/2 is not known yet,
    theta' = (w_k+1/2 + w_k-1/2) / 2 - h^2 theta''' / 6    as a result.

theta'' and the forces are read afterwards, with the leg put back to theta, theta' of every recorded instant.
"""

import cmath
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import pybullet
from scipy.interpolate import CubicSpline

from tepsipe.errors import InputError
from tepsipe.mechanics.impedance_model import impedance_torque
from tepsipe.mechanics.inverse_dynamics import Foot, Leg

FOOT, LEG = 0, 1  # links of the body in PyBullet
FALLEN_RAD = 0.5 * math.pi
LARGEST_PHASE_RAD = 0.1  # natural frequency times step: 63 steps per period


@dataclass(frozen=True)
class Joint:
    """Joint between foot and leg, thesis eq (2-1).

    Attributes
    ----------
    inertia_Nms2_per_rad : float
        I (Nms2/rad), without the leg's own; may be negative as long as J is not.
    damping_Nms_per_rad : float
        B (Nms/rad); may be negative.
    stiffness_Nm_per_rad : float
        K (Nm/rad); may be negative.
    rest_angle_rad : float
        theta_ref (rad), at which the joint is not bent.
    """

    inertia_Nms2_per_rad: float
    damping_Nms_per_rad: float
    stiffness_Nm_per_rad: float
    rest_angle_rad: float = 0.0


@dataclass(frozen=True)
class ForwardSimulation:
    """Simulated motion, torque and forces at the recorded instants, up to the fall if the leg falls.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Recorded instants (s), fewer than given if the leg falls.
    theta, theta_d, theta_dd : ndarray, shape (n,)
        Leg angle (rad), its rate (rad/s) and acceleration (rad/s2).
    torque : ndarray, shape (n,)
        tau of eq (2-1) (Nm), positive when it resists positive theta.
    foot_y, foot_y_d, foot_y_dd : ndarray, shape (n,)
        Position of foot and ankle from where they start (m), velocity (m/s) and acceleration (m/s2).
    y_dd, z_dd : ndarray, shape (n,)
        Acceleration of the leg's centre of mass (m/s2).
    f_y, f_z : ndarray, shape (n,)
        Ground reaction, force of the belt on the foot (N), as F_y and F_z in eq (3-7).
    m_x : ndarray, shape (n,)
        Moment of the belt on the foot about the x axis (Nm), in the belt's surface where the ankle starts.
    f_ay, f_az : ndarray, shape (n,)
        Joint reaction, force of the leg on the foot (N), as F_Ay and F_Az in eq (3-7): -m y'', -m (g + z'').
    state : {"settles", "grows", "falls"}
        Whether theta passes a quarter turn (falls); if not, whether small swings about upright grow, by
        negative damping or K < m g r, or settle (-).
    growth_per_s : float
        Rate at which small swings about upright grow once the belt rests (1/s), negative where they die out:
        -B / (2 J) of a leg that swings.
    fell_at_s : float or None
        When theta passed a quarter turn (s), on the clock of ``time``; None unless the leg falls.
    """

    time: np.ndarray
    theta: np.ndarray
    theta_d: np.ndarray
    theta_dd: np.ndarray
    torque: np.ndarray
    foot_y: np.ndarray
    foot_y_d: np.ndarray
    foot_y_dd: np.ndarray
    y_dd: np.ndarray
    z_dd: np.ndarray
    f_y: np.ndarray
    f_z: np.ndarray
    m_x: np.ndarray
    f_ay: np.ndarray
    f_az: np.ndarray
    state: str
    growth_per_s: float
    fell_at_s: float | None


def rest_angle_of_standing(leg: Leg, stiffness: float, standing_angle: float) -> float:
    """theta_ref (rad) of a joint of ``stiffness`` K (Nm/rad) on which the leg stands at an angle (rad).

    K (theta - theta_ref) = m g r sin(theta).
    """
    gravity_moment = leg.mass_kg * leg.gravity_m_per_s2 * leg.com_m * math.sin(standing_angle)
    return standing_angle - gravity_moment / stiffness


def simulate_dummy(
    time: np.ndarray,
    belt_velocity: np.ndarray,
    leg: Leg,
    foot: Foot,
    joint: Joint,
    step_s: float = 0.001,
    start_angle_rad: float = 0.0,
    start_rate_rad_per_s: float = 0.0,
    must_stand: bool = False,
) -> ForwardSimulation:
    """Move the dummy's foot as the belt was recorded and let the leg swing.

    Between its samples the belt's velocity is a cubic spline. A leg beyond a quarter turn has fallen: the
    simulation stops, and the result ends with the last recorded instant before.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Recorded instants (s), on a regular clock.
    belt_velocity : ndarray, shape (n,)
        Recorded velocity of the belt (m/s).
    leg, foot : Leg, Foot
        The dummy's segments (kg, m, kg m2).
    joint : Joint
        I, B, K and theta_ref (Nms2/rad, Nms/rad, Nm/rad, rad).
    step_s : float
        Step of the simulation (s), a whole part of the sampling interval.
    start_angle_rad, start_rate_rad_per_s : float
        theta (rad) and theta' (rad/s) at the first instant.
    must_stand : bool
        Refuse a joint that cannot hold the leg upright, K <= m g r (-).

    Returns
    -------
    ForwardSimulation
        Motion, torque and forces (s, rad, Nm, m, N).

    Raises
    ------
    InputError
        If the recording holds a NaN or its clock is not regular, the dummy cannot be built, the leg starts
        fallen, or the step is no whole part of the sampling interval or too long: more than a tenth of
        1 / w_n, w_n = sqrt(|K - m g r| / J), or of J / |B|.
    """
    time, belt_velocity = np.asarray(time, dtype=float), np.asarray(belt_velocity, dtype=float)
    interval = _sampling_interval(time, belt_velocity)
    _check_dummy(leg, foot, joint, start_angle_rad, start_rate_rad_per_s, must_stand)
    stride = _check_step(step_s, interval, leg, joint)
    h = interval / stride

    velocity = CubicSpline(interval * np.arange(time.size), belt_velocity)
    path = velocity.antiderivative()
    steps = (time.size - 1) * stride + 1
    pushed = np.diff(path(h * np.arange(-1, steps + 1)), 2) / h**2
    with _built(leg, foot, joint, h) as dummy:
        theta, theta_d, fell_after_s = _swing(dummy, pushed, start_angle_rad, start_rate_rad_per_s)
        theta, theta_d = theta[::stride], theta_d[::stride]
        elapsed = interval * np.arange(theta.size)
        foot_y, foot_y_dd = path(elapsed), velocity(elapsed, 1)
        theta_dd, on_leg, on_foot = _reactions(dummy, foot_y_dd, theta, theta_d)

    i, b, k = joint.inertia_Nms2_per_rad, joint.damping_Nms_per_rad, joint.stiffness_Nm_per_rad
    s, c, r = np.sin(theta), np.cos(theta), leg.com_m
    across, along = on_leg.T  # the leg's frame is turned by theta
    f_y, f_z, m_x = on_foot.T
    samples = theta.size
    growth = _growth(leg, joint)
    return ForwardSimulation(
        time=time[:samples],
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        torque=impedance_torque((i, b, k), theta - joint.rest_angle_rad, theta_d, theta_dd),
        foot_y=foot_y,
        foot_y_d=belt_velocity[:samples].copy(),
        foot_y_dd=foot_y_dd,
        y_dd=foot_y_dd + r * (c * theta_dd - s * theta_d**2),
        z_dd=-r * (s * theta_dd + c * theta_d**2),
        f_y=f_y,
        f_z=f_z,
        # PyBullet has I in the leg; as a part of the joint it turns the foot as much as the leg
        m_x=m_x + foot_y * f_z + i * theta_dd,
        f_ay=-(c * across + s * along),
        f_az=-(c * along - s * across),
        state="falls" if fell_after_s is not None else "grows" if growth > 0.0 else "settles",
        growth_per_s=growth,
        fell_at_s=None if fell_after_s is None else float(time[0]) + fell_after_s,
    )


# ---- PyBullet ----------------------------------------------------------------------------------


class _Dummy:
    """The dummy in a PyBullet of its own, at steps of h (s)."""

    def __init__(self, client: int, body: int, g: float, joint: Joint, h: float):
        self.client, self.body, self.g, self.h = client, body, g, h
        self.b, self.k = joint.damping_Nms_per_rad, joint.stiffness_Nm_per_rad
        self.theta_ref = joint.rest_angle_rad

    def put(self, theta: float, theta_d: float) -> None:
        """Put the leg to an angle (rad) and a rate (rad/s)."""
        pybullet.resetJointState(self.body, LEG, theta, theta_d, self.client)

    def step(self, y_dd: float, theta: float, theta_d: float) -> None:
        """One step under y_f'' (m/s2) and the torque of the joint at theta, theta'."""
        tau = self.b * theta_d + self.k * (theta - self.theta_ref)
        pybullet.setGravity(0.0, -y_dd, -self.g, self.client)
        # by position, which is faster: two targets that a torque has not, the torque, three gains
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
            linkJointAxis=[[-1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],  # theta turns z towards y
            physicsClientId=client,
        )
        # PyBullet has no inertia of joints: the leg carries it; given with other properties it is ignored
        inertia = leg.inertia_kgm2 + joint.inertia_Nms2_per_rad
        pybullet.changeDynamics(body, LEG, localInertiaDiagonal=[inertia] * 3, physicsClientId=client)
        pybullet.changeDynamics(
            body, LEG, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, physicsClientId=client
        )
        # at most 100 rad/s unless told
        pybullet.changeDynamics(body, LEG, maxJointVelocity=1e6, physicsClientId=client)
        # a motor without force: the default one holds the leg still
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
    """Angle (rad) and rate (rad/s) at every step, and when the leg fell (s) or None."""
    h, y_dd = dummy.h, y_dd.tolist()
    # a first step tells theta'' at the start, and with it the rates half a step and more before
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
    """What acts while the leg passes through given states, from one step out of each.

    theta'' (rad/s2), shape (n,); force on the leg, across it and along it (N), shape (n, 2); force on the
    foot in y and z (N) and moment about x (Nm), in the belt's surface under the ankle, shape (n, 3).
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


# ---- small swings -------------------------------------------------------------------------------


def _about_the_ankle(leg: Leg, joint: Joint) -> tuple[float, float]:
    """J (kg m2) and K - m g r (Nm/rad)."""
    about_ankle = leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2 + joint.inertia_Nms2_per_rad
    upright = joint.stiffness_Nm_per_rad - leg.mass_kg * leg.gravity_m_per_s2 * leg.com_m
    return about_ankle, upright


def _growth(leg: Leg, joint: Joint) -> float:
    """Larger real part (1/s) of the roots of J s^2 + B s + K - m g r = 0."""
    about_ankle, upright = _about_the_ankle(leg, joint)
    b = joint.damping_Nms_per_rad
    return ((cmath.sqrt(b * b - 4.0 * about_ankle * upright) - b) / (2.0 * about_ankle)).real


# ---- what cannot be simulated ------------------------------------------------------------------


def _sampling_interval(time: np.ndarray, belt_velocity: np.ndarray) -> float:
    if time.ndim != 1 or time.shape != belt_velocity.shape or time.size < 4:
        raise InputError(
            "motion of the belt: expected one velocity for each of at least 4 instants, found shapes "
            f"{belt_velocity.shape} and {time.shape}: give both as recorded"
        )
    for name, values in (("time", time), ("belt velocity", belt_velocity)):
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputError(
                f"{name}: expected finite samples, found {bad.size} that are not, the first at sample "
                f"{bad[0] + 1}: fill or cut them first"
            )
    steps = np.diff(time)
    interval = float((time[-1] - time[0]) / steps.size)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0))
        raise InputError(
            f"time: expected increasing instants, found {time[k]:.6g} s followed by {time[k + 1]:.6g} s at "
            f"sample {k + 2}: repair the time stamps first"
        )
    if np.abs(steps - interval).max() > 1e-4 * interval:
        raise InputError(
            f"time: expected a regular clock, found steps from {steps.min():.6g} s to {steps.max():.6g} s: "
            "resample the recording first"
        )
    return interval


def _check_dummy(leg: Leg, foot: Foot, joint: Joint, angle: float, rate: float, must_stand: bool) -> None:
    for body in (leg, foot, joint):
        for name, value in vars(body).items():
            if not math.isfinite(value):
                raise InputError(f"{name}: expected a finite number, found {value}: correct it")
    for name, value in (("leg", leg.mass_kg), ("foot", foot.mass_kg)):
        if value <= 0.0:
            raise InputError(f"mass of the {name}: expected more than 0 kg, found {value:g} kg: correct it")
    about_ankle, upright = _about_the_ankle(leg, joint)
    if about_ankle <= 0.0:
        least = joint.inertia_Nms2_per_rad - about_ankle
        raise InputError(
            f"inertia of the joint: expected more than {least:.4g} Nms2/rad, so that leg and joint together "
            f"have inertia, found {joint.inertia_Nms2_per_rad:.4g} Nms2/rad: simulate with other parameters"
        )
    if must_stand and upright <= 0.0:
        stiffness = joint.stiffness_Nm_per_rad
        raise InputError(
            f"stiffness of the joint: expected more than m g r = {stiffness - upright:.4g} Nm/rad, so that "
            f"the leg can stand, found {stiffness:.4g} Nm/rad: simulate with other parameters"
        )
    if not (abs(angle) < FALLEN_RAD and math.isfinite(rate)):
        raise InputError(
            f"start: expected a leg within a quarter turn of upright and a finite rate, found {angle:g} rad "
            f"and {rate:g} rad/s: start it upright"
        )


def _check_step(step_s: float, interval: float, leg: Leg, joint: Joint) -> int:
    """Steps per sample."""
    stride = round(interval / step_s) if step_s > 0.0 and math.isfinite(step_s) else 0
    if stride < 1 or abs(stride * step_s - interval) > 1e-4 * interval:
        raise InputError(
            f"step of the simulation: expected a whole part of the sampling interval of {interval:.6g} s, "
            f"found {step_s:.6g} s: divide the interval by a whole number"
        )
    about_ankle, upright = _about_the_ankle(leg, joint)
    fastest = max(math.sqrt(abs(upright) / about_ankle), abs(joint.damping_Nms_per_rad) / about_ankle)
    if step_s * fastest > LARGEST_PHASE_RAD:
        raise InputError(
            f"step of the simulation: expected at most {LARGEST_PHASE_RAD / fastest:.3g} s, a tenth of the "
            "joint's shorter time constant (1 / natural frequency, or J / B), "
            f"found {step_s:.6g} s: shorten the step"
        )
    return stride
