"""The ankle dummy standing on the belt, from the Lagrangian of belt, foot and leg.

Generalised coordinates: y position of the belt in the room (m), which moves on its frame and with it, th leg
angle from the vertical, positive when the leg tips towards +y (rad). Me and P are the mass and the push of
belt, drive and frame together (`tepsipe.virtual_lab.moving_belt`). The foot is taped to the belt; where the
tape gives, see below, else:

    [ Me + mf + m   m r cos th ] [ y'' ]   [ P + m r sin th th'^2             ]
    [ m r cos th    Il + m r^2 ] [ th'']  =  [ m g r sin th - rubber(th-th0, th') ]

The reaction on the plate is the rate of the load's linear and angular momentum, differentiated
numerically: no free-body equation is used here.

The dummy's foot tilts a little on tape and belt, and takes the ankle with it.

In addition to y and th: ph, tilt of the foot about the point of the belt under
the ankle from where it rests, positive towards +y (rad). Kinematics are linear in ph, which stays below
0.01 rad. With h height of the joint, (b, c) centre of mass of the foot forward and up, If its moment of
inertia about it, a = mf c + m h, k and d stiffness and damping of the support, R moment of the rubber, which
bends by th - ph:

    (Me + mf + m) y''  + m r cos th th''   + a ph''              = P + m r sin th th'^2
    m r cos th y''     + (Il + m r^2) th'' + m h r cos th ph''   = m g r sin th - R
    a y'' + m h r cos th th'' + (If + mf (b^2 + c^2) + m h^2) ph'' = R - R_rest + a g ph - k ph - d ph'
                                                                     + h m r sin th th'^2
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Gt, Le

from tepsipe.quantities import Angle, Gravity, Inertia, Length, Mass, NotNegative, Offset, Point, Some
from tepsipe.virtual_lab.belt import BeltMotion, Command, DriveTruth, stage_commands
from tepsipe.virtual_lab.integrate import Derivative, integrate
from tepsipe.virtual_lab.moving_belt import Below, MovingBelt, motion_of_belt
from tepsipe.virtual_lab.rubber import Memory, Rubber
from tepsipe.virtual_lab.treadmill_trial import MarkerPath


@dataclass(frozen=True)
class FootTilt:
    """The foot tilts on tape and belt."""

    compliance_rad_per_Nm: NotNegative
    """Tilt per moment; 0 is a foot that does not tilt."""
    damping_ratio: NotNegative
    """Damping ratio of the tilt."""
    foot_inertia_kgm2: Annotated[float, Gt(0), Le(20)]
    """Moment of inertia of the foot about its centre of mass."""


def tilting_derivative(
    dummy, moment: Callable, belt: MovingBelt, tilt: FootTilt, neutral: float, rest: float
) -> Derivative:
    """Derivative of (y, y', servo, th, th', ph, ph', x, x').

    moment: moment of the rubber at a bending and its rate.
    tilt: the foot's support, with a compliance above 0.
    neutral, rest: angle at which the rubber is straight (rad), and its moment at rest (N·m).
    """
    m, r, h = dummy.leg_mass_kg, dummy.leg_com_m, dummy.foot_height_m + dummy.joint_offset_m[1]
    forward, up = dummy.foot_com_m
    g, mf = dummy.gravity_m_per_s2, dummy.foot_mass_kg
    moving = belt.moving_kg + mf + m
    about_joint = dummy.leg_inertia_kgm2 + dummy.joint_inertia_kgm2 + m * r * r
    carried = mf * up + m * h
    about_belt = tilt.foot_inertia_kgm2 + mf * (forward * forward + up * up) + m * h * h
    stiffness = 1.0 / tilt.compliance_rad_per_Nm
    damping = 2.0 * tilt.damping_ratio * math.sqrt(stiffness * about_belt)
    upright = stiffness - carried * g
    pushed, swaying = belt.pushed, belt.swaying
    sin, cos, mr, mgr = math.sin, math.cos, m * r, m * g * r
    # belt and foot without the leg's angle: the inverse of their 2 x 2 matrix does not change
    both = moving * about_belt - carried * carried
    i_yy, i_yp, i_pp = about_belt / both, -carried / both, moving / both
    y_by_leg, p_by_leg = i_yy + i_yp * h, i_yp + i_pp * h

    def derivative(commanded: float, state: tuple[float, ...]) -> tuple[float, ...]:
        _, v, q, th, w, ph, x, sway, sway_rate = state
        belt_push, q_rate, sway_free = pushed(commanded, v, q, sway, sway_rate)
        s, coupling = sin(th), mr * cos(th)
        bent = moment(th - ph - neutral, w - x)
        swing = mr * s * w * w
        push = belt_push + swing
        turn = mgr * s - bent
        lean = bent - rest - upright * ph - damping * x + h * swing
        e = coupling * y_by_leg
        f = coupling * p_by_leg
        w_rate = (turn - e * push - f * lean) / (about_joint - coupling * (e + f * h))
        push -= coupling * w_rate
        lean -= coupling * h * w_rate
        v_rate, x_rate = i_yy * push + i_yp * lean, i_yp * push + i_pp * lean
        return v, v_rate, q_rate, w, w_rate, x, x_rate, sway_rate, swaying * v_rate + sway_free

    return derivative


# names of the dummy's markers, in the strober's order
MARKERS = ("foot1", "foot2", "foot3", "ankle", "leg1", "leg2", "leg3", "leg4")


@dataclass(frozen=True)
class DummyTruth:
    """Brick and rod."""

    foot_mass_kg: Mass
    """The brick: mass."""
    foot_height_m: Length
    """Height of the point from which markers are placed, where the analysis takes the joint to be."""
    foot_com_m: Point
    """Its centre of mass: [forward of that point, above the belt]."""
    joint_offset_m: Point
    """Axis of the joint: [forward of that point, above it]."""
    leg_mass_kg: Mass
    """The rod: mass."""
    leg_com_m: Length
    """Its centre of mass from the joint."""
    leg_inertia_kgm2: Annotated[float, Gt(0), Le(20)]
    """Its inertia about the centre of mass."""
    joint_inertia_kgm2: Inertia
    """Inertia of the joint, which turns with the rod."""
    rest_angle_rad: Angle
    """Angle at which the leg stands still, as the motion capture sees it."""
    position_x_m: Offset
    """Position of the foot on the plate, across the belt."""
    position_y_m: Offset
    """Position of the foot on the plate, along the belt."""
    gravity_m_per_s2: Gravity
    """Gravity."""


@dataclass(frozen=True)
class DummyMarkers:
    """Markers of the dummy."""

    foot_m: Some[Point]
    """Three markers: [anterior offset from the ankle, height above the belt]."""
    ankle_m: Point
    """[anterior offset from the axis of the rod, longitudinal offset from the ankle]."""
    leg_m: Some[Point]
    """Four markers, in the same axes."""
    lateral_m: Offset
    """Position of all markers across the belt, from the foot's middle."""


@dataclass(frozen=True)
class DummyMotion(BeltMotion):
    """Exact motion of the rig."""

    angle: np.ndarray
    angle_rate: np.ndarray
    """Leg angle from the vertical (rad) and its rate (rad/s)."""
    tilt: np.ndarray
    tilt_rate: np.ndarray
    """Angle of the foot from where it rests (rad) and its rate (rad/s)."""
    joint_torque: np.ndarray
    """Torque of the joint, its inertia included (N·m), positive when it resists positive angles."""


def move_dummy(
    dummy: DummyTruth,
    rubber: Rubber,
    drive: DriveTruth,
    command: Command,
    duration_s: float,
    rate_hz: float,
    foot: FootTilt | None = None,
    below: Below = (),
) -> DummyMotion:
    """Integrate belt, frame and dummy together.

    dummy, rubber, drive: constants of subject, joint and belt drive.
    command: commanded belt velocity (m/s) at t (s).
    duration_s, rate_hz: length of the run (s) and steps per second (Hz).
    foot: compliance of the foot; without it, or with none, the foot does not tilt.
    below: plate of the belt.
    Returns: motion and reaction on the grid of the integration.
    """
    load = (dummy.foot_mass_kg + dummy.leg_mass_kg) * dummy.gravity_m_per_s2
    belt = MovingBelt(drive, load, rate_hz, below)
    commands = stage_commands(command, drive.delay_s, duration_s, rate_hz)
    time, states, resisting = _integrated(dummy, rubber, belt, commands, rate_hz, foot)
    y, v, _, th, w, tilt, tilt_rate, *frame = states.T[:9]
    reaction, w_rate = _reaction(dummy, foot, time, (y, v, th, w, tilt, tilt_rate))
    return DummyMotion(
        **motion_of_belt(time, y, v, *frame),
        angle=th,
        angle_rate=w,
        tilt=tilt,
        tilt_rate=tilt_rate,
        joint_torque=resisting + dummy.joint_inertia_kgm2 * w_rate,
        reaction=reaction,
    )


def _integrated(
    dummy, rubber, belt: MovingBelt, commands, rate_hz, foot
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Instants, states (with a tilt of 0 where the foot does not tilt), and moment of the rubber.

    The states are y, y', the servo's, th, th', ph, ph', and x and x' of the frame.
    """
    m, r = dummy.leg_mass_kg, dummy.leg_com_m
    g = dummy.gravity_m_per_s2
    moving = belt.moving_kg + dummy.foot_mass_kg + m
    about_pivot = dummy.leg_inertia_kgm2 + dummy.joint_inertia_kgm2 + m * r * r
    gravity_moment = m * g * r * math.sin(dummy.rest_angle_rad)
    bending_at_rest = scipy.optimize.brentq(
        lambda phi: rubber.moment(phi, 0.0) - gravity_moment, -1.0, 1.0, xtol=1e-14
    )
    neutral = dummy.rest_angle_rad - bending_at_rest

    pushed, swaying = belt.pushed, belt.swaying
    memory = Memory(rubber)
    moment = memory.moment if memory.states else rubber.moment
    sin, cos, mr, mgr = math.sin, math.cos, m * r, m * g * r

    def derivative(commanded: float, state: tuple[float, ...]) -> tuple[float, ...]:
        _, v, q, th, w, sway, sway_rate = state
        belt_push, q_rate, sway_free = pushed(commanded, v, q, sway, sway_rate)
        s, c = sin(th), cos(th)
        coupling = mr * c
        push = belt_push + mr * s * w * w
        turn = mgr * s - moment(th - neutral, w)
        determinant = moving * about_pivot - coupling * coupling
        v_rate = (about_pivot * push - coupling * turn) / determinant
        w_rate = (moving * turn - coupling * push) / determinant
        return v, v_rate, q_rate, w, w_rate, sway_rate, swaying * v_rate + sway_free

    start: tuple[float, ...] = (0.0, 0.0, 0.0, dummy.rest_angle_rad, 0.0)
    tilting = foot is not None and foot.compliance_rad_per_Nm > 0.0
    if tilting:
        derivative = tilting_derivative(dummy, moment, belt, foot, neutral, gravity_moment)
        start = (*start, 0.0, 0.0)
    frame_rate = len(start) + 1
    derivative, start = belt.with_pitch(derivative, (*start, 0.0, 0.0))

    def begin_step(k: int, state: tuple[float, ...]) -> None:
        belt.begin_step(k, state[1] - state[frame_rate])

    if memory.states:

        def bending(state: tuple[float, ...]) -> tuple[float, float]:
            tilt, tilt_rate = state[5:7] if tilting else (0.0, 0.0)
            return state[3] - neutral - tilt, state[4] - tilt_rate

        derivative = memory.with_states(derivative, bending)
        start = (*start, *memory.at_rest(bending_at_rest))
    time, states = integrate(derivative, start, commands, rate_hz, begin_step)
    states, remembered = np.split(states, [len(start) - memory.states], axis=1)
    if not tilting:
        states = np.column_stack([states[:, :5], np.zeros((time.size, 2)), states[:, 5:]])
    th, w, tilt, tilt_rate = states.T[3:7]
    bent, rate = th - tilt - neutral, w - tilt_rate
    resisting = rubber.moment(bent, rate)
    return time, states, resisting + memory.remembered(bent, remembered) if memory.states else resisting


def _reaction(dummy: DummyTruth, foot: FootTilt | None, time, motion: tuple) -> tuple[np.ndarray, np.ndarray]:
    """Wrench on foot and leg about the plate's origin, from the rates of their momenta, and th'' (rad/s²).

    ``motion`` is that of the foot along y (m, m/s), of the leg's angle and of the tilt (rad, rad/s).
    """
    y, v, th, w, tilt, tilt_rate = motion
    m, r = dummy.leg_mass_kg, dummy.leg_com_m
    turning = dummy.leg_inertia_kgm2 + dummy.joint_inertia_kgm2
    forward, above = dummy.joint_offset_m
    height = dummy.foot_height_m + above
    leg_y, leg_z = y + forward + height * tilt + r * np.sin(th), height + r * np.cos(th)
    leg_vy, leg_vz = v + height * tilt_rate + r * np.cos(th) * w, -r * np.sin(th) * w
    ahead, up = dummy.foot_com_m
    foot_y, foot_z = y + ahead + up * tilt, up - ahead * tilt
    foot_vy, foot_vz = v + up * tilt_rate, -ahead * tilt_rate
    momentum_y = dummy.foot_mass_kg * foot_vy + m * leg_vy
    momentum_z = m * leg_vz + dummy.foot_mass_kg * foot_vz
    # about x, right-handed (positive turns y towards z); th turns z towards y, hence its minus
    spin_x = m * (leg_y * leg_vz - leg_z * leg_vy) - dummy.foot_mass_kg * foot_z * foot_vy - turning * w
    if foot is not None and foot.compliance_rad_per_Nm > 0.0:
        spin_x += dummy.foot_mass_kg * foot_y * foot_vz - foot.foot_inertia_kgm2 * tilt_rate
    rate = scipy.interpolate.CubicSpline(time, np.column_stack([momentum_y, momentum_z, spin_x, w]))(time, 1)
    g = dummy.gravity_m_per_s2
    fy = rate[:, 0]
    fz = rate[:, 1] + (dummy.foot_mass_kg + m) * g
    mx = rate[:, 2] + g * (dummy.foot_mass_kg * foot_y + m * leg_y) + dummy.position_y_m * fz
    my = -dummy.position_x_m * fz
    mz = dummy.position_x_m * fy
    return np.column_stack([np.zeros_like(fy), fy, fz, mx, my, mz]), rate[:, 3]


def dummy_marker_paths(markers: DummyMarkers, dummy: DummyTruth, motion: DummyMotion) -> list[MarkerPath]:
    """Paths of the markers on foot, ankle and leg, in the order of `MARKERS`.

    motion: exact motion of the rig.
    Returns: each gives x, y, z, shape (n, 3), at instants, shape (n,).
    """
    belt = scipy.interpolate.CubicSpline(motion.time, motion.position)
    angle = scipy.interpolate.CubicSpline(motion.time, motion.angle)
    still = not motion.tilt.any()
    tilt = np.zeros_like if still else scipy.interpolate.CubicSpline(motion.time, motion.tilt)

    def place(instant: np.ndarray, forward, up) -> np.ndarray:
        x = np.full(instant.shape, dummy.position_x_m + markers.lateral_m)
        y = dummy.position_y_m + belt(instant)
        return np.column_stack([x, y + forward, np.broadcast_to(up, instant.shape)])

    def on_foot(along: float, up: float) -> MarkerPath:
        def path(instant: np.ndarray) -> np.ndarray:
            ph = tilt(instant)
            return place(instant, along + up * ph, up - along * ph)

        return path

    ahead, above = dummy.joint_offset_m
    pivot = dummy.foot_height_m + above

    def on_leg(across: float, along: float) -> MarkerPath:
        across, along = across - ahead, along - above  # from the axis of the joint

        def path(instant: np.ndarray) -> np.ndarray:
            th = angle(instant)
            forward = ahead + pivot * tilt(instant) + across * np.cos(th) + along * np.sin(th)
            return place(instant, forward, pivot - across * np.sin(th) + along * np.cos(th))

        return path

    foot = [on_foot(*position) for position in markers.foot_m]
    return [*foot, on_leg(*markers.ankle_m), *[on_leg(*position) for position in markers.leg_m]]
