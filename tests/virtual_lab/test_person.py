"""The person on the belt: segments, statics, motion by other equations, reflexes, files of a trial."""

import copy
import math
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter, lsim

from tepsipe.io.formats import read_markers
from tepsipe.io.readers.edf import read_emg
from tepsipe.io.readers.treadmill_log import read_calibration_matrix, read_treadmill_log
from tepsipe.virtual_lab import person_constants
from tepsipe.virtual_lab.belt import DriveTruth, velocity_command
from tepsipe.virtual_lab.person import PersonMotion, critical_stiffness, move_person, segments, wander
from tepsipe.virtual_lab.person_constants import (
    MARKERS,
    MUSCLES,
    MuscleTruth,
    NervesTruth,
    PersonMarkers,
    PersonTruth,
    SkinTruth,
    Subject,
    TaskTruth,
    feet,
    shanks,
    thighs,
    upper_body,
)
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.standing_trial import INTEGRATION_RATE_HZ, make_standing_trial, person_marker_paths
from tepsipe.virtual_lab.treadmill_trial import Protocol, schedule_at_random

RATE_HZ = 1000.0
G = 9.81
FY, FZ, MX, MY = 1, 2, 3, 4
TASKS = ("relax", "stiff")
PUSH_N, PUSH_S = 60.0, 0.1
# de Leva (1996), Table 4, females: length (mm), mass, centre of mass, radius of gyration about the
# mediolateral axis (%), and about the one from back to front (%)
TABLE_4 = {
    "HEAD": (200.2, 6.68, 58.94, 35.9, 33.0),
    "TRUNK": (529.3, 42.57, 41.51, 33.9, 35.7),
    "UPPER_ARM": (275.1, 2.55, 57.54, 26.0, 27.8),
    "FOREARM": (264.3, 1.38, 45.59, 25.7, 26.1),
    "HAND": (78.0, 0.56, 74.74, 45.4, 53.1),
    "THIGH": (368.5, 14.78, 36.12, 36.4, 36.9),
    "SHANK": (432.3, 4.81, 44.16, 26.7, 27.1),
    "FOOT": (228.3, 1.29, 40.14, 27.9, 29.9),
}
PERSON = PersonTruth(
    mass_kg=64.0,
    stature_m=1.75,
    ankle_height_m=0.08,
    foot_com_m=0.05,
    stance_rad=[0.06, 0.03, 0.05],
    position_x_m=0.25,
    position_y_m=0.05,
    gravity_m_per_s2=G,
)
# latency, stretch per angle, torque of full drive, balance while its torque is positive and negative
CONTROLLED = {
    "TA": MuscleTruth(
        latency_s=0.044,
        stretch=[-1.0, 0.0, 0.0],
        force_Nm=[-80.0, 0.0, 0.0],
        balance_per_Nm=[-0.0005, -0.004],
    ),
    "SOL": MuscleTruth(
        latency_s=0.042, stretch=[1.0, 0.0, 0.0], force_Nm=[150.0, 0.0, 0.0], balance_per_Nm=[0.004, 0.0025]
    ),
    "GAS": MuscleTruth(
        latency_s=0.041, stretch=[1.0, 0.25, 0.0], force_Nm=[100.0, 40.0, 0.0], balance_per_Nm=[0.004, 0.0025]
    ),
    "BF": MuscleTruth(
        latency_s=0.040, stretch=[0.0, 0.5, 0.8], force_Nm=[0.0, 70.0, 100.0], balance_per_Nm=[0.0004, 0.0002]
    ),
    "RF": MuscleTruth(
        latency_s=0.043,
        stretch=[0.0, -0.6, -0.5],
        force_Nm=[0.0, -100.0, -80.0],
        balance_per_Nm=[-0.0002, -0.0004],
    ),
}
SLACK = {name: replace(muscle, force_Nm=[0.0] * 3) for name, muscle in CONTROLLED.items()}
# torque of full drive that resists the angles of ankle, knee and hip (Nm), by muscle
FORCE = np.array([muscle.force_Nm for muscle in CONTROLLED.values()])
# stiff enough to stand without nerves: the ankles must resist with more than m g h = 567 Nm/rad
STIFFNESS, DAMPING = [1100.0, 1400.0, 900.0], [10.0, 20.0, 15.0]
TONE, GAIN = [0.05, 0.1, 0.08, 0.02, 0.03], [0.3, 0.35, 0.25, 0.4, 0.2]
PASSIVE = TaskTruth(
    stiffness_Nm_per_rad=STIFFNESS, damping_Nms_per_rad=DAMPING, tone=TONE, reflex_s_per_rad=[0.0] * 5
)
REFLEXIVE = replace(PASSIVE, reflex_s_per_rad=GAIN)
UNDAMPED = replace(PASSIVE, damping_Nms_per_rad=[0.0] * 3)
NO_NERVES = NervesTruth(
    reflex_threshold_rad_per_s=0.02,
    twitch_s=0.04,
    balance_delay_s=0.11,
    balance_Nm_per_rad=0.0,
    balance_Nms_per_rad=0.0,
    wander_Nm=0.0,
    wander_s=0.6,
)
# a linear drive, and one that pushes with a known force and then lets go
LINEAR = DriveTruth(
    belt_mass_kg=45.0,
    bandwidth_hz=14.0,
    integral_time_s=0.25,
    force_limit_N=1e9,
    delay_s=0.012,
    viscous_Ns_per_m=60.0,
    velocity_step_m_per_s=0.0,
    velocity_noise_m_per_s=0.0,
)
LOOSE = replace(
    LINEAR,
    bandwidth_hz=1e-12,
    integral_time_s=1e12,
    force_limit_N=PUSH_N,
    delay_s=0.0,
    viscous_Ns_per_m=0.0,
)
# angles of ankle, knee and hip from those of shanks, thighs and upper body
TO_JOINTS = np.array([[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])


def push(t):
    """A command that a weak drive can never reach, then none."""
    return np.where(t < PUSH_S, 1e30, 0.0)


def moved(
    muscles=CONTROLLED,
    task=PASSIVE,
    nerves=NO_NERVES,
    drive=LINEAR,
    command=np.zeros_like,
    seconds=1.0,
    rate_hz=RATE_HZ,
):
    rng = generator(1, "person")
    return move_person(Subject(PERSON, muscles, task, nerves), drive, command, seconds, rate_hz, rng)


def one_pulse(amplitude, profile="sine"):
    """Command of one pulse from 0.1 to 0.2 s."""
    return velocity_command(profile, amplitude, np.array([0.1]), 0.1)


def bodies():
    """Masses (kg) of feet, shanks, thighs and upper body."""
    return np.array([feet(64.0, 1.75).mass_kg, *[segment.mass_kg for segment in segments(PERSON)]])


def joint_angles(motion):
    """Change of the angles of ankle, knee and hip since the start (rad), and their rates (rad/s)."""
    return (motion.angles - PERSON.stance_rad) @ TO_JOINTS.T, motion.rates @ TO_JOINTS.T


def rates_of(time, values):
    """Derivative of what was sampled on a grid."""
    return CubicSpline(time, values)(time, 1)


def centres(q):
    """Centres of mass y, z (m) of feet, shanks, thighs and upper body, and the joints below each.

    ``q`` holds the belt's position (m) and the angles of shanks, thighs and upper body (rad), shape (4, ...).
    """
    place = np.array([q[0], 0.08 + 0.0 * q[0]])
    found, below = [np.array([q[0] + 0.05, 0.04 + 0.0 * q[0]])], [place]
    for segment, angle in zip(segments(PERSON), q[1:], strict=True):
        towards = np.array([np.sin(angle), np.cos(angle)])
        found.append(place + segment.com_m * towards)
        below.append(place)
        place = place + segment.length_m * towards
    return np.array(found), np.array(below)


def configuration(motion):
    """Positions and angles q, and their first and second derivatives (m, rad, s), each of shape (4, n)."""
    acceleration = rates_of(motion.time, motion.rates)
    return (
        np.vstack([motion.belt_position, motion.angles.T]),
        np.vstack([motion.belt_velocity, motion.rates.T]),
        np.vstack([motion.belt_acceleration, acceleration.T]),
    )


def accelerations(motion):
    """Accelerations y, z (m/s2), shape (4, 2, n), of the bodies' centres of mass.

    Second differences of where a point would be a little earlier and later on its path.
    """
    q, v, a = configuration(motion)
    step = 1e-4
    before, after = (centres(q + s * v + 0.5 * s**2 * a)[0] for s in (-step, step))
    return (before - 2.0 * centres(q)[0] + after) / step**2


def joint_torques(motion):
    """Torque (Nm) of ankle, knee and hip, shape (n, 3): free body of all that is above the joint.

    A torque that resists an angle turns the body above backwards. There it meets the moments, forwards, of
    weight and of masses times accelerations, and moments of inertia times angular accelerations.
    """
    q, _, angular = configuration(motion)
    (centre, joint), acceleration = centres(q), accelerations(motion)
    inertia = np.array([segment.inertia_kgm2 for segment in segments(PERSON)])
    torques = []
    for first in (1, 2, 3):
        y, z = (centre[first:] - joint[first]).transpose(1, 0, 2)
        force_y = bodies()[first:, None] * acceleration[first:, 0]
        force_z = bodies()[first:, None] * (acceleration[first:, 1] + G)
        turning = inertia[first - 1 :, None] * angular[first:]
        torques.append((y * force_z - z * force_y - turning).sum(axis=0))
    return np.column_stack(torques)


def active_torques(motion, task):
    """What of the joints' torque (Nm) is neither the weight above nor stiffness and damping."""
    angle, rate = joint_angles(motion)
    intrinsic = np.array(task.stiffness_Nm_per_rad) * angle + np.array(task.damping_Nms_per_rad) * rate
    return joint_torques(motion) - joint_torques(motion)[0] - intrinsic


def stretch_rates(motion):
    """How fast the muscles lengthen (rad/s), shape (n, 5).

    TA is in front of the ankle, SOL behind it, GAS also behind the knee, BF behind knee and hip, RF in
    front of both; an angle that grows opens the joint behind.
    """
    ankle, knee, hip = joint_angles(motion)[1].T
    gas, bf, rf = ankle + 0.25 * knee, 0.5 * knee + 0.8 * hip, -0.6 * knee - 0.5 * hip
    return np.column_stack([-ankle, ankle, gas, bf, rf])


def energy(motion, stiffness=STIFFNESS):
    """Kinetic and potential energy (J) of belt, body and springs."""
    q, v, _ = configuration(motion)
    step = 1e-5
    velocity = (centres(q + step * v)[0] - centres(q - step * v)[0]) / (2.0 * step)
    kinetic = 0.5 * 45.0 * v[0] ** 2 + 0.5 * bodies() @ (velocity**2).sum(axis=1)
    kinetic += 0.5 * np.array([segment.inertia_kgm2 for segment in segments(PERSON)]) @ v[1:] ** 2
    angle, _ = joint_angles(motion)
    bent = angle @ joint_torques(motion)[0] + 0.5 * angle**2 @ np.array(stiffness)
    return kinetic + G * bodies() @ centres(q)[0][:, 1] + bent


@pytest.fixture(scope="module")
def released():
    return moved(SLACK, UNDAMPED, drive=LOOSE, command=push, seconds=2.0, rate_hz=2000.0)


@pytest.fixture(scope="module")
def still():
    return moved()


@pytest.fixture(scope="module")
def perturbed():
    """After one pulse of 0.5 m/s, with reflexes, without balance and wander."""
    return moved(task=REFLEXIVE, command=one_pulse(0.5), seconds=0.6)


# ---- segments of the body ----------------------------------------------------------------------


@pytest.mark.parametrize("name", list(TABLE_4))
def test_segments_are_those_of_the_published_table(name):
    """Length, mass, centre of mass and radius of gyration are table 4's, females."""
    length, mass, com, gyration, _ = TABLE_4[name]
    row = getattr(person_constants, name)
    assert row == pytest.approx((length / 1e3, mass / 100.0, com / 100.0, gyration / 100.0), rel=1e-12)
    assert person_constants.STATURE_M == 1.735


def test_table_gives_the_axis_across_the_body():
    """Trunk and hands are wider than deep, hence easier to nod than to tilt sideways; not so the head."""
    for name, (*_, fore_aft) in TABLE_4.items():
        assert (100.0 * getattr(person_constants, name)[3] < fore_aft) == (name != "HEAD")


@pytest.mark.parametrize(("mass_kg", "stature_m"), [(64.0, 1.75), (90.0, 1.6)])
def test_segments_add_up_to_the_body(mass_kg, stature_m):
    """The table's parts add up to 99.99 % of the body."""
    size = mass_kg, stature_m
    parts = [feet(*size), shanks(*size), thighs(*size), upper_body(*size, 0.08)]
    assert sum(part.mass_kg for part in parts) == pytest.approx(0.9999 * mass_kg, rel=1e-12)
    legs_and_head = sum(part.length_m for part in parts[1:])
    assert legs_and_head + 0.08 == pytest.approx(stature_m, rel=1e-12)


def test_legs_by_hand():
    """Both legs of a body of 50 kg as long as the table's."""
    shank, thigh = shanks(50.0, 1.735), thighs(50.0, 1.735)
    # 2 x 0.0481 x 50 kg; 55.84 % of 0.4323 m; 4.81 kg x (0.267 x 0.4323 m)^2
    assert (shank.mass_kg, shank.com_m) == pytest.approx((4.81, 0.24139632), rel=1e-8)
    assert shank.inertia_kgm2 == pytest.approx(0.0640817, rel=1e-5)
    # 2 x 0.1478 x 50 kg; 63.88 % of 0.3685 m; 14.78 kg x (0.364 x 0.3685 m)^2
    assert (thigh.mass_kg, thigh.com_m) == pytest.approx((14.78, 0.2353978), rel=1e-8)
    assert thigh.inertia_kgm2 == pytest.approx(0.265921, rel=1e-5)
    assert feet(50.0, 1.735).mass_kg == pytest.approx(1.29)


def test_segments_scale_with_mass_and_stature():
    """Masses go with the mass, lengths with the stature, inertias with mass times stature squared."""
    for part in (shanks, thighs, feet):
        small, large = part(50.0, 1.5), part(100.0, 1.8)
        assert large.mass_kg / small.mass_kg == pytest.approx(2.0)
        assert large.length_m / small.length_m == pytest.approx(1.2)
        assert large.com_m / small.com_m == pytest.approx(1.2)
        assert large.inertia_kgm2 / small.inertia_kgm2 == pytest.approx(2.0 * 1.44)
    # the ankle scales along with the rest
    small, large = upper_body(50.0, 1.5, 0.075), upper_body(100.0, 1.8, 0.09)
    assert large.com_m / small.com_m == pytest.approx(1.2)
    assert large.inertia_kgm2 / small.inertia_kgm2 == pytest.approx(2.0 * 1.44)


def test_inertia_of_the_upper_body_by_parallel_axes():
    """Trunk, head and arms of 100 kg and 1.735 m, first about the hips and from there to their centre."""
    body = upper_body(100.0, 1.735, 0.08)
    # above the hips, which are 0.08 + 0.4323 + 0.3685 m above the floor
    trunk, head = (1.0 - 0.4151) * 0.5293, 1.735 - 0.5894 * 0.2002 - 0.8808
    trunk_kg, head_kg, arms_kg = 42.57, 6.68, 2.0 * (2.55 + 1.38 + 0.56)
    mass = trunk_kg + head_kg + arms_kg
    com = ((trunk_kg + arms_kg) * trunk + head_kg * head) / mass
    about_hips = trunk_kg * ((0.339 * 0.5293) ** 2 + trunk**2) + arms_kg * trunk**2
    about_hips += head_kg * ((0.359 * 0.2002) ** 2 + head**2)
    assert (body.mass_kg, body.com_m) == pytest.approx((58.23, com), rel=1e-12)
    assert body.com_m == pytest.approx(0.35853, abs=1e-5)
    assert body.inertia_kgm2 == pytest.approx(about_hips - mass * com**2, rel=1e-10)


def test_critical_stiffness_is_weight_times_height_above_the_ankles():
    """About 560 Nm/rad: 62 kg at 0.93 m, that is 0.55 to 0.57 of the stature for the whole body."""
    upright = centres(np.zeros(4))[0]
    above = G * bodies()[1:] @ (upright[1:, 1] - 0.08)
    assert critical_stiffness(PERSON) == pytest.approx(above, rel=1e-12)
    assert 500.0 < critical_stiffness(PERSON) < 600.0
    height = bodies() @ upright[:, 1] / bodies().sum()
    assert 0.55 < height / 1.75 < 0.57


def test_inertia_of_the_standing_body_is_that_of_people():
    """Measured of three men standing: radius of gyration, for nodding, of 0.214 to 0.225 of the stature."""
    # 81.9 to 129 lb in s2, 147 to 203 lb, 67.4 to 73.3 in
    upright = centres(np.zeros(4))[0][:, 1]
    own = sum(segment.inertia_kgm2 for segment in segments(PERSON)) + feet(64.0, 1.75).inertia_kgm2
    com = bodies() @ upright / bodies().sum()
    gyration = math.sqrt((own + bodies() @ (upright - com) ** 2) / bodies().sum())
    assert 0.21 < gyration / 1.75 < 0.23


# ---- standing still ----------------------------------------------------------------------------


def test_quiet_standing_is_an_equilibrium(still):
    """Nothing moves without perturbation, wander and balance, and the muscles keep their tone."""
    assert np.abs(still.angles - PERSON.stance_rad).max() < 1e-10
    assert np.abs(still.belt_position).max() < 1e-10
    assert still.drive == pytest.approx(np.tile(TONE, (still.time.size, 1)), abs=1e-12)


def test_plate_carries_the_weight(still):
    """Upwards the weight of 99.99 % of 64 kg, and nothing else."""
    reaction = still.reaction[500]
    assert reaction[:3] == pytest.approx([0.0, 0.0, 0.9999 * 64.0 * G], abs=1e-6)


def test_centre_of_pressure_is_under_the_centre_of_mass(still):
    """Statics: all moments of the weight are carried where the weight acts."""
    reaction = still.reaction[500]
    # segments of 1.75 m: lengths and centres of mass above the lower joints, as parts of the table's
    scale = 1.75 / 1.735
    knee = 0.4323 * scale * math.sin(0.06)
    hip = knee + 0.3685 * scale * math.sin(0.03)
    shank = 0.5584 * 0.4323 * scale * math.sin(0.06)
    thigh = knee + 0.6388 * 0.3685 * scale * math.sin(0.03)
    upper = hip + upper_body(64.0, 1.75, 0.08).com_m * math.sin(0.05)
    forward = 0.0258 * 0.05 + 0.0962 * shank + 0.2956 * thigh + 0.5823 * upper
    assert reaction[MX] / reaction[FZ] == pytest.approx(0.05 + forward / 0.9999, abs=1e-9)
    assert -reaction[MY] / reaction[FZ] == pytest.approx(0.25, abs=1e-12)
    # under the feet, in front of the ankles
    assert 0.02 < forward < 0.08


def test_ankles_bear_the_weight_in_front_of_them(still):
    """The free bodies above the joints ask for the torques that the weight above them makes."""
    scale, torques = 1.75 / 1.735, joint_torques(still)[500]
    upper = 0.5823 * upper_body(64.0, 1.75, 0.08).com_m * math.sin(0.05)
    thigh = scale * 0.3685 * math.sin(0.03) * (0.2956 * 0.6388 + 0.5823)
    shank = scale * 0.4323 * math.sin(0.06) * (0.0962 * 0.5584 + 0.2956 + 0.5823)
    expected = 64.0 * G * np.array([shank + thigh + upper, thigh + upper, upper])
    assert torques == pytest.approx(expected, rel=1e-6)


# ---- motion, by equations of another origin ----------------------------------------------------


def jacobian(q):
    """How the centres of mass move with q, shape (4 bodies, 2, 4): derivative by a complex step."""
    columns = [centres(q + 1e-30j * unit)[0].imag / 1e-30 for unit in np.eye(4)]
    return np.stack(columns, axis=-1)


def lagrange(task, command, breaks, instants):
    """Positions and angles q at instants, from virtual work and an adaptive rule of eighth order.

    Masses times accelerations and weights, projected on how q moves them, balance the drive's force and the
    joints' torques. The torques at rest are those that make the stance an equilibrium.
    """
    mass = bodies()
    inertia = np.diag([45.0, *[segment.inertia_kgm2 for segment in segments(PERSON)]])
    stance = np.array([0.0, *PERSON.stance_rad])
    weight = np.array([0.0, G])
    gravity = np.einsum("b,bck,c->k", mass, jacobian(stance), weight)[1:]
    at_rest = np.linalg.solve(TO_JOINTS.T, -gravity)
    gain = 2.0 * math.pi * 14.0 * 45.0
    step = 1e-5

    def derivative(t, state):
        q, v, integral = state[:4], state[4:8], state[8]
        moves = jacobian(q)
        curved = (jacobian(q + step * v) - jacobian(q - step * v)) @ v / (2.0 * step)
        matrix = inertia + np.einsum("b,bcj,bck->jk", mass, moves, moves)
        angle, rate = TO_JOINTS @ (q - stance)[1:], TO_JOINTS @ v[1:]
        torque = at_rest + np.array(task.stiffness_Nm_per_rad) * angle
        torque += np.array(task.damping_Nms_per_rad) * rate
        error = command(t - 0.012) - v[0]
        force = np.array([gain * (error + integral / 0.25) - 60.0 * v[0], *(-TO_JOINTS.T @ torque)])
        force -= np.einsum("b,bck,bc->k", mass, moves, curved + weight)
        return np.concatenate([v, np.linalg.solve(matrix, force), [error]])

    state, found = np.concatenate([stance, np.zeros(5)]), []
    for start, end in pairwise(breaks):
        inside = instants[(instants > start) & (instants <= end)]
        rules = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-11}
        solution = solve_ivp(derivative, (start, end), state, t_eval=inside, **rules)
        found.append(solution.y[:4])
        state = solution.y[:, -1]
    return np.hstack(found)


@pytest.mark.slow
def test_motion_obeys_the_equations_of_lagrange():
    """Belt and segments move as a derivation by virtual work says, which shares no line with the other."""
    command = one_pulse(0.4)
    motion = moved(SLACK, command=command, seconds=0.6, rate_hz=2000.0)
    # the command has corners at its start and end
    expected = lagrange(PASSIVE, command, [0.0, 0.112, 0.212, 0.6], motion.time[1:])
    found = np.vstack([motion.belt_position, motion.angles.T])[:, 1:]
    for one, other in zip(found, expected, strict=True):
        assert np.ptp(other) > 0.01
        assert one == pytest.approx(other, abs=1e-7 * np.ptp(other))


def test_energy_is_kept_once_the_drive_lets_go(released):
    """Without damping nothing is lost."""
    after = released.time > PUSH_S + 0.01
    found = energy(released)
    stored = found[-1] - found[0]
    assert stored > 0.1
    assert np.ptp(found[after]) < 1e-6 * stored


def test_work_of_the_drive_becomes_energy(released):
    """A force times the way it goes."""
    found, pushed = energy(released), np.argmin(np.abs(released.time - PUSH_S))
    work = PUSH_N * released.belt_position[: pushed + 1]
    assert found[: pushed + 1] - found[0] == pytest.approx(work, abs=3e-3 * work[-1])


@pytest.mark.parametrize("joint", [0, 1, 2])
def test_damped_joint_loses_what_its_damping_takes(joint):
    """Damping of one joint takes B times the square of that joint's rate."""
    damping = [0.0] * 3
    damping[joint] = 20.0
    task = replace(UNDAMPED, damping_Nms_per_rad=damping)
    motion = moved(SLACK, task, drive=LOOSE, command=push, rate_hz=2000.0)
    after = np.flatnonzero(motion.time > PUSH_S + 0.01)
    found = energy(motion)[after]
    power = 20.0 * joint_angles(motion)[1][after, joint] ** 2
    lost = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) / 2000.0)])
    assert lost[-1] > 0.01
    assert found[0] - found == pytest.approx(lost, abs=1e-3 * lost[-1])


def test_free_joints_oscillate_at_their_natural_frequency():
    """On a belt too heavy to move, with knees and hips almost locked, the body is one inverted pendulum."""
    locked = replace(UNDAMPED, stiffness_Nm_per_rad=[1100.0, 3e5, 3e5])
    heavy = replace(LOOSE, belt_mass_kg=1e6, force_limit_N=1e5)
    motion = moved(SLACK, locked, drive=heavy, command=push, seconds=4.0, rate_hz=2000.0)
    swinging = (motion.angles[:, 0] - 0.06)[motion.time > 0.5]
    time = motion.time[motion.time > 0.5]
    up = np.flatnonzero((swinging[:-1] < 0.0) & (swinging[1:] >= 0.0))
    crossing = time[up] - swinging[up] * (time[up + 1] - time[up]) / (swinging[up + 1] - swinging[up])
    frequency = (crossing.size - 1) / (crossing[-1] - crossing[0])
    centre = centres(np.array([0.0, *PERSON.stance_rad]))[0][1:] - [0.0, 0.08]
    own = sum(segment.inertia_kgm2 for segment in segments(PERSON))
    about_ankles = own + bodies()[1:] @ (centre**2).sum(axis=1)
    critical_stiffness = G * bodies()[1:] @ centre[:, 1]
    assert 0.0 < np.abs(swinging).max() < 0.02
    assert frequency == pytest.approx(
        math.sqrt((1100.0 - critical_stiffness) / about_ankles) / 2.0 / math.pi, rel=3e-3
    )


def test_body_lags_behind_a_belt_that_starts_forwards(released):
    """The shanks tip backwards, the upper body stays where it was."""
    pushed = released.time < 0.05
    assert released.belt_position[pushed][-1] > 0.0
    assert (np.diff(released.angles[pushed, 0])[5:] < 0.0).all()
    head = centres(configuration(released)[0])[0][3, 0]
    assert abs(head[pushed][-1] - head[0]) < 0.2 * released.belt_position[pushed][-1]


# ---- the reaction of the plate -----------------------------------------------------------------


def test_reaction_is_mass_times_acceleration_and_weight(perturbed):
    """Newton and Euler: forces and their moments about the origin add up over the four bodies."""
    q, _, angular = configuration(perturbed)
    (y, z), (ay, az) = centres(q)[0].transpose(1, 0, 2), accelerations(perturbed).transpose(1, 0, 2)
    inertia = np.array([segment.inertia_kgm2 for segment in segments(PERSON)])
    force_y, force_z = bodies()[:, None] * ay, bodies()[:, None] * (az + G)
    # about x, y times Fz - z times Fy; angles grow the other way round
    moment = (0.05 + y) * force_z - z * force_y
    moment = moment.sum(axis=0) - inertia @ angular[1:]
    fx, fy, fz, mx, my, mz = perturbed.reaction.T
    for found, expected in ((fy, force_y.sum(axis=0)), (fz, force_z.sum(axis=0)), (mx, moment)):
        assert np.ptp(expected) > 5.0
        assert found == pytest.approx(expected, abs=2e-3 * np.ptp(expected))
    assert fx == pytest.approx(np.zeros(fx.size))
    assert my == pytest.approx(-0.25 * fz)
    assert mz == pytest.approx(0.25 * fy)


def test_belt_left_alone_feels_the_reaction_only(released):
    """The belt's own equation of motion, once nothing drives it."""
    after = released.time > PUSH_S + 0.01
    belt = 45.0 * released.belt_acceleration[after]
    assert np.ptp(belt) > 1.0
    assert belt == pytest.approx(-released.reaction[after, FY], abs=1e-5 * np.ptp(belt))


def test_moment_on_the_plate_holds_the_ankles_torque(released):
    """The feet feel plate, weight, their own inertia and the ankles."""
    _, fy, fz, mx, _, _ = released.reaction.T
    about_ankle = mx - (0.05 + released.belt_position) * fz + 0.08 * fy
    feet_kg = 2.0 * 0.0129 * 64.0
    of_feet = feet_kg * (G * 0.05 + 0.04 * released.belt_acceleration)
    load = joint_torques(released)[0, 0]
    ankle = load + 1100.0 * (released.angles[:, 0] - 0.06)
    after = released.time > PUSH_S + 0.01
    assert (about_ankle - of_feet)[after] == pytest.approx(ankle[after], abs=1e-5 * np.ptp(ankle))


# ---- reflexes ----------------------------------------------------------------------------------


def test_free_bodies_give_the_torques_of_stiffness_and_damping():
    """Without muscles nothing is left of the joints' torques but the intrinsic part."""
    motion = moved(SLACK, command=one_pulse(0.4), seconds=0.4)
    whole = np.ptp(joint_torques(motion), axis=0)
    assert (whole > 5.0).all()
    assert (np.abs(active_torques(motion, PASSIVE)).max(axis=0) < 2e-3 * whole).all()


def test_reflex_follows_the_stretch_by_its_latency(perturbed):
    """Drive is tone and G [s - 0.02 rad/s]_+ of a latency ago; it rises in the step in which that does."""
    for m, latency in enumerate([44, 42, 41, 40, 43]):  # steps of 1 ms
        over = np.clip(stretch_rates(perturbed)[:, m] - 0.02, 0.0, None)
        rise = np.flatnonzero(over > 0.0)[0]
        drive = perturbed.drive[:, m]
        assert over.max() > 0.1
        assert abs(np.flatnonzero(drive > TONE[m] + 1e-12)[0] - rise - latency) <= 1
        assert drive[latency:] == pytest.approx(TONE[m] + GAIN[m] * over[:-latency], abs=1e-9)


def test_latency_between_two_steps_is_kept():
    """A latency of 40.4 ms, at steps of 1 ms, gives what the stretch was between two steps."""
    muscles = {name: replace(muscle, latency_s=0.0404) for name, muscle in CONTROLLED.items()}
    motion = moved(muscles, REFLEXIVE, command=one_pulse(0.3), seconds=0.4)
    later = motion.time[50:] - 0.0404
    stretch = CubicSpline(motion.time, stretch_rates(motion))(later)
    expected = np.array(TONE) + np.array(GAIN) * np.clip(stretch - 0.02, 0.0, None)
    assert motion.drive[50:] == pytest.approx(expected, abs=2e-3 * np.ptp(expected))
    assert np.abs(motion.drive[50:-1] - expected[1:]).max() > 0.01 * np.ptp(expected)


@pytest.mark.parametrize(
    ("profile", "stretched", "shortened"), [("sine", "TA", "SOL"), ("negative-sine", "SOL", "TA")]
)
def test_only_the_stretched_side_of_the_ankle_answers(profile, stretched, shortened):
    """A belt that goes forwards stretches the front of the shank, one that goes backwards its back."""
    motion = moved(task=REFLEXIVE, command=one_pulse(0.5, profile), seconds=0.3)
    ankle = joint_angles(motion)[1][:, 0]
    way = np.sign(ankle[130])
    # from the command on until the ankle turns back
    until = 110 + int(np.flatnonzero(way * ankle[110:] < -0.02)[0])
    up, down = MUSCLES.index(stretched), MUSCLES.index(shortened)
    assert way == (-1.0 if stretched == "TA" else 1.0)
    assert motion.drive[: until + 40, up].max() > TONE[up] + 0.05
    assert (motion.drive[: until + 40, down] == TONE[down]).all()


def test_slow_stretch_calls_no_reflex():
    """A pulse whose stretch stays below the threshold leaves the drive at its tone."""
    motion = moved(task=REFLEXIVE, command=one_pulse(0.002), seconds=0.5)
    assert 0.0005 < np.abs(stretch_rates(motion)).max() < 0.02
    assert motion.drive == pytest.approx(np.tile(TONE, (motion.time.size, 1)), abs=1e-12)


def test_force_follows_a_step_of_the_drive_critically_damped():
    """1 - (1 + t / T) exp(-t / T), the step response of T^2 x'' + 2 T x' + x = e."""
    # balance that wanders too slowly to be seen adds a constant torque from the start on
    nerves = replace(NO_NERVES, wander_Nm=5.0, wander_s=1e12, twitch_s=0.03)
    motion = moved(nerves=nerves, seconds=0.3)
    step = motion.drive[0] - TONE
    assert np.ptp(motion.drive, axis=0).max() < 1e-6
    assert np.abs(step).max() > 1e-3
    slow = motion.time / 0.03
    share = 1.0 - (1.0 + slow) * np.exp(-slow)
    full = step @ FORCE
    found = active_torques(motion, PASSIVE)
    for joint in range(3):
        assert found[:, joint] == pytest.approx(full[joint] * share, abs=2e-3 * np.abs(full[0]))
    assert found[-1] == pytest.approx(full, abs=2e-3 * np.abs(full[0]))


def test_active_torque_follows_the_reflexes(perturbed):
    """Free bodies above the joints find the twitch of the drive, weighted with the muscles' torques."""
    over = perturbed.drive - perturbed.drive[0]
    twitch = ([1.0], [0.04**2, 2.0 * 0.04, 1.0])
    x = np.column_stack([lsim(twitch, column, perturbed.time)[1] for column in over.T])
    expected = x @ FORCE
    found = active_torques(perturbed, REFLEXIVE)
    assert (np.ptp(expected, axis=0) > 2.0).all()
    for joint in range(3):
        # the belt's force has corners, at which differences of the motion are wrong
        error = np.abs(found[:, joint] - expected[:, joint])
        assert np.quantile(error, 0.95) < 2e-3 * np.ptp(expected[:, joint])


def test_balance_answers_the_centre_of_mass_a_delay_ago():
    """Torque per lean and per its rate, 110 ms late, shared out by its sign; never less than no drive."""
    nerves = replace(NO_NERVES, balance_Nm_per_rad=450.0, balance_Nms_per_rad=200.0)
    motion = moved(nerves=nerves, command=one_pulse(0.5), seconds=0.8)
    # lean of the centre of mass, for small angles: all that an angle carries
    m1, m2, m3 = bodies()[1:]
    shank, thigh, upper = segments(PERSON)
    carried = np.array(
        [
            m1 * shank.com_m + (m2 + m3) * shank.length_m,
            m2 * thigh.com_m + m3 * thigh.length_m,
            m3 * upper.com_m,
        ]
    )
    weights = carried / carried.sum()
    wanted = np.zeros(motion.time.size)
    lean, rate = (motion.angles - PERSON.stance_rad) @ weights, motion.rates @ weights
    wanted[110:] = (450.0 * lean + 200.0 * rate)[:-110]
    forward, backward = np.clip(wanted, 0.0, None), np.clip(wanted, None, 0.0)
    assert forward.max() > 5.0
    assert backward.min() < -5.0
    for m, muscle in enumerate(CONTROLLED.values()):
        ahead, behind = muscle.balance_per_Nm
        expected = np.clip(TONE[m] + ahead * forward + behind * backward, 0.0, None)
        assert motion.drive[:, m] == pytest.approx(expected, abs=1e-9)
    # leaning forwards is answered by the calf, leaning backwards by the front of the shank
    assert motion.drive[np.argmax(wanted), 1] > TONE[1]
    assert motion.drive[np.argmin(wanted), 0] > TONE[0]


def test_wander_has_the_size_and_the_memory_asked_for():
    """Standard deviation and a correlation that falls to 1/e within the correlation time."""
    nerves = replace(NO_NERVES, wander_Nm=2.5, wander_s=0.2)
    drawn = wander(nerves, 400_000, RATE_HZ, generator(1, "wander"))
    assert drawn.std() == pytest.approx(2.5, rel=0.05)
    assert abs(drawn.mean()) < 0.3
    later = np.corrcoef(drawn[:-200], drawn[200:])[0, 1]
    assert later == pytest.approx(math.exp(-1.0), abs=0.05)
    # white after the memory is taken out
    white = lfilter([1.0, -math.exp(-1.0 / 200.0)], [1.0], drawn)[1:]
    assert abs(np.corrcoef(white[:-1], white[1:])[0, 1]) < 0.01


# ---- the shipped person ------------------------------------------------------------------------


def shipped(truth, task, command, seconds, seed=1, factor=1.0, stiffness=None, drive=None, **nerves):
    """Motion of the shipped person at the standing's rate, or a multiple of it."""
    standing = truth["standing"]
    told = TaskTruth(**standing["tasks"][task])
    subject = Subject(
        PersonTruth(**standing["person"]),
        {name: MuscleTruth(**standing["muscles"][name]) for name in MUSCLES},
        told if stiffness is None else replace(told, stiffness_Nm_per_rad=stiffness),
        NervesTruth(**(standing["nerves"] | nerves)),
    )
    return move_person(
        subject,
        DriveTruth(**(truth["treadmill"]["drive"] | (drive or {}))),
        command,
        seconds,
        factor * INTEGRATION_RATE_HZ,
        generator(seed, "person"),
    )


def stance(truth):
    return truth["standing"]["person"]["stance_rad"]


def pressure(motion):
    """Centre of pressure (m) along the belt."""
    return motion.reaction[:, MX] / motion.reaction[:, FZ]


@pytest.fixture(scope="module")
def pulsed(shipped_truth):
    """Both tasks and directions, six pulses of 0.5 m/s, every 2 s from 1 s on."""
    motions = {}
    for profile in ("sine", "negative-sine"):
        command = velocity_command(profile, 0.5, np.arange(1.0, 12.0, 2.0), 0.1)
        for task in TASKS:
            motions[task, profile] = shipped(shipped_truth, task, command, 13.0)
    return motions


@pytest.fixture(scope="module")
def quiet(shipped_truth):
    return {task: shipped(shipped_truth, task, np.zeros_like, 20.0) for task in TASKS}


@pytest.mark.slow
@pytest.mark.parametrize("profile", ["sine", "negative-sine"])
@pytest.mark.parametrize(("force_limit", "angle_rad", "belt_m"), [(1e9, 1e-5, 1e-6), (1150.0, 3e-4, 5e-4)])
def test_halved_step_changes_next_to_nothing(shipped_truth, profile, force_limit, angle_rad, belt_m):
    """Angles are right to 10 millionths of a radian, and to 300 where the drive reaches its limit."""
    # there its integral stops within a step: at most 0.5 m/s too much or too little of 1 ms
    options = {"drive": {"force_limit_N": force_limit}, "wander_Nm": 0.0}
    coarse, fine = (
        shipped(shipped_truth, "stiff", one_pulse(0.5, profile), 2.0, factor=factor, **options)
        for factor in (1.0, 2.0)
    )
    assert np.ptp(coarse.angles, axis=0).min() > 0.01
    assert np.abs(coarse.angles - fine.angles[::2]).max() < angle_rad
    assert np.abs(coarse.belt_position - fine.belt_position[::2]).max() < belt_m


@pytest.mark.slow
@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("profile", ["sine", "negative-sine"])
def test_person_stays_upright_under_the_largest_pulses(shipped_truth, pulsed, task, profile):
    """Pulses of 0.5 m/s move the segments by degrees, and the feet stay flat on the belt."""
    motion, person = pulsed[task, profile], shipped_truth["standing"]["person"]
    moves = np.abs(motion.angles - stance(shipped_truth))
    assert 0.01 < moves.max() < 0.1
    # she comes back before the next pulse
    assert max(moves[1000 + 2000 * k - 100 : 1000 + 2000 * k].max() for k in range(1, 6)) < 0.05
    # heels and toes: 0.06 m behind and 0.17 m in front of the ankles
    forward = pressure(motion) - person["position_y_m"] - motion.belt_position
    assert -0.06 < forward.min() < forward.max() < 0.17
    assert (motion.drive >= 0.0).all()
    assert motion.drive.max() < 1.0


@pytest.mark.slow
def test_stiff_person_gives_way_less(pulsed):
    """Who stiffens moves less in ankles, knees and hips."""
    for profile in ("sine", "negative-sine"):
        relaxed, stiff = (np.ptp(pulsed[task, profile].angles @ TO_JOINTS.T, axis=0) for task in TASKS)
        assert (stiff < relaxed).all()


@pytest.mark.slow
@pytest.mark.parametrize("task", TASKS)
def test_quiet_standing_sways_as_people_do(quiet, task):
    """The centre of pressure wanders by some millimetres, about where the weight acts."""
    sway = pressure(quiet[task])
    assert 0.002 < sway.std() < 0.012
    assert np.ptp(sway) < 0.06
    resting = pressure(quiet[task])[0]
    assert sway.mean() == pytest.approx(resting, abs=0.01)


def test_sway_depends_on_the_seed_only(shipped_truth):
    """The same generator gives the same bits, another one other sway."""
    first, again, other = (
        shipped(shipped_truth, "relax", one_pulse(0.5), 3.0, seed=seed) for seed in (1, 1, 2)
    )
    for field in fields(PersonMotion):
        assert (getattr(first, field.name) == getattr(again, field.name)).all()
    assert np.abs(first.angles - other.angles).max() > 1e-4


NO_BALANCE = {"balance_Nm_per_rad": 0.0, "balance_Nms_per_rad": 0.0}


@pytest.mark.parametrize(
    "stiffness",
    [[50.0, 90.0, 60.0], [50.0, 1400.0, 900.0], [3000.0, 10.0, 900.0], [3000.0, 1400.0, 10.0]],
)
def test_weak_person_falls(shipped_truth, stiffness):
    """Whichever joint is too weak: with stiff ankles the shanks stay up, thighs or upper body fall."""
    with pytest.raises(FloatingPointError, match="falls"):
        shipped(shipped_truth, "relax", one_pulse(0.5), 10.0, stiffness=stiffness, **NO_BALANCE)


def test_balance_is_what_keeps_the_relaxed_person_up(shipped_truth):
    """Her ankles are less stiff than the weight topples: without balance she falls, with it she stands."""
    standing = shipped_truth["standing"]
    ankles = standing["tasks"]["relax"]["stiffness_Nm_per_rad"][0]
    assert ankles < critical_stiffness(PersonTruth(**standing["person"]))
    with pytest.raises(FloatingPointError, match="falls"):
        shipped(shipped_truth, "relax", np.zeros_like, 10.0, **NO_BALANCE)
    standing = shipped(shipped_truth, "relax", np.zeros_like, 10.0)
    assert np.abs(standing.angles - stance(shipped_truth)).max() < 0.05


# ---- markers -----------------------------------------------------------------------------------

PLACES = PersonMarkers(
    foot_m=[[0.14, 0.03], [-0.05, 0.02]],
    shank_m=[[0.025, 0.37], [-0.02, 0.16]],
    thigh_m=[[0.03, 0.3], [-0.03, 0.18], [0.03, 0.06]],
    lateral_m=0.11,
)


def test_markers_at_given_angles_by_hand():
    """Shanks that lean by 3 in 4 and thighs that lean backwards by 7 in 24, on a belt 0.1 m ahead."""
    person = replace(PERSON, stature_m=1.735)  # shanks of 0.4323 m
    time = np.arange(11) / 10.0
    angles = np.tile([math.atan2(3.0, 4.0), -math.atan2(7.0, 24.0), 0.3], (11, 1))
    at_rest = np.zeros(11)
    motion = PersonMotion(
        time,
        at_rest + 0.1,
        *[at_rest] * 5,
        np.zeros((11, 6)),
        angles,
        0.0 * angles,
        np.zeros((11, 5)),
        *[at_rest] * 4,
    )
    paths = person_marker_paths(PLACES, person, SkinTruth(), motion)
    found = np.array([path(np.array([0.5]))[0] for path in paths])
    # ankle at y 0.05 + 0.1 m; knee 0.6 x 0.4323 in front of and 0.8 x 0.4323 above it
    # across (cos, -sin) + along (sin, cos): 0.025 x 0.8 + 0.37 x 0.6, -0.025 x 0.6 + 0.37 x 0.8
    # of the thigh: 0.03 x 0.96 - 0.3 x 0.28, 0.03 x 0.28 + 0.3 x 0.96
    knee_y, knee_z = 0.15 + 0.25938, 0.08 + 0.34584
    expected = {
        "foot1": (0.15 + 0.14, 0.03),
        "foot2": (0.15 - 0.05, 0.02),
        "ankle": (0.15, 0.08),
        "shank1": (0.15 + 0.242, 0.08 + 0.281),
        "shank2": (0.15 + 0.08, 0.08 + 0.14),
        "thigh1": (knee_y - 0.0552, knee_z + 0.2964),
        "thigh2": (knee_y - 0.0792, knee_z + 0.1644),
        "thigh3": (knee_y + 0.012, knee_z + 0.066),
    }
    assert tuple(expected) == MARKERS
    assert found[:, 1:] == pytest.approx(np.array(list(expected.values())), abs=1e-12)
    assert found[:, 0] == pytest.approx(np.full(8, 0.25 + 0.11))


def test_feet_and_ankles_move_with_the_belt(perturbed):
    """The markers below the shank go where the belt goes, those above do not."""
    paths = person_marker_paths(PLACES, PERSON, SkinTruth(), perturbed)
    places = np.array([path(perturbed.time) for path in paths])
    moves = places[:, :, 1] - places[:, :1, 1]
    assert np.ptp(perturbed.belt_position) > 0.01
    for k in range(3):
        assert moves[k] == pytest.approx(perturbed.belt_position, abs=1e-9)
        assert np.ptp(places[k, :, 2]) < 1e-12
    assert np.abs(moves[3:] - perturbed.belt_position).max(axis=1).min() > 1e-3


def test_markers_of_a_segment_keep_their_distances(perturbed):
    """Shank and thigh are rigid."""
    places = np.array(
        [path(perturbed.time) for path in person_marker_paths(PLACES, PERSON, SkinTruth(), perturbed)]
    )
    local = {"shank": [(0.0, 0.0), *PLACES.shank_m], "thigh": PLACES.thigh_m}
    for names, points in ((slice(2, 5), local["shank"]), (slice(5, 8), local["thigh"])):
        for i in range(3):
            for j in range(i):
                found = np.linalg.norm(places[names][i] - places[names][j], axis=1)
                expected = math.dist(points[i], points[j])
                assert found == pytest.approx(np.full(found.size, expected), abs=1e-12)


# ---- the schedule ------------------------------------------------------------------------------


def onsets_of(schedule, amplitude, pulse_s=0.1):
    """When the pulses of a sinusoidal command start (s), from the command itself."""
    time = np.arange(0.0, schedule.ends_s, 0.002)
    commanded = schedule.command(time)
    first = np.flatnonzero((commanded[1:] != 0.0) & (commanded[:-1] == 0.0)) + 1
    past = np.arcsin(commanded[first] / amplitude) * pulse_s / (2.0 * math.pi)
    return time[first] - past


def random_schedule(truth, seed, interval_s=(2.0, 5.0), duration_s=60.0, profile="sine"):
    rng = generator(seed, "schedule")
    return schedule_at_random(truth["treadmill"], Protocol(profile, 0.4, interval_s, duration_s), rng)


def test_intervals_between_perturbations_are_within_their_limits(shipped_truth):
    """From the trigger on every interval is at least the shortest and at most the longest."""
    gaps = []
    for seed in range(20):
        schedule = random_schedule(shipped_truth, seed)
        since = onsets_of(schedule, 0.4) - schedule.trigger_s
        gaps.extend(np.diff([0.0, *since]))
        # the last longest interval is free, but another perturbation would not have fitted before it
        assert 60.0 - 2.0 * 5.0 <= since[-1] < 60.0 - 5.0
        assert schedule.ends_s == pytest.approx(schedule.trigger_s + 60.0 + 0.5)
    assert 2.0 - 1e-9 <= min(gaps) < 2.2
    assert 4.8 < max(gaps) <= 5.0 + 1e-9
    assert np.mean(gaps) == pytest.approx(3.5, abs=0.15)


def test_trial_full_of_shortest_intervals_holds_them_all(shipped_truth):
    """Where the limits coincide the number of perturbations is known."""
    schedule = random_schedule(shipped_truth, 1, (2.0, 2.0), 11.0)
    assert onsets_of(schedule, 0.4) - schedule.trigger_s == pytest.approx([2.0, 4.0, 6.0, 8.0])


def test_schedule_is_drawn_by_its_generator(shipped_truth):
    """The same seed gives the same instants, another one others, whatever the pulses' sign."""
    first, again, other = (random_schedule(shipped_truth, seed) for seed in (1, 1, 2))
    backward = random_schedule(shipped_truth, 1, profile="negative-sine")
    assert (onsets_of(first, 0.4) == onsets_of(again, 0.4)).all()
    assert first.trigger_s != other.trigger_s
    assert np.abs(onsets_of(first, 0.4)[:5] - onsets_of(other, 0.4)[:5]).min() > 1e-3
    assert onsets_of(backward, -0.4) == pytest.approx(onsets_of(first, 0.4), abs=1e-12)


# ---- trials ------------------------------------------------------------------------------------

TRIAL_S = 10.0


def make(truth, folder, condition="relax", task="relax", profile="sine"):
    """Raw files of a trial of 10 s with pulses of 0.4 m/s every 1.5 to 2.5 s."""
    folder.mkdir()
    names = ("log.mat", "calibration.csv", "markers.c3d", "emg.edf")
    paths = {name.split(".")[0]: folder / name for name in names}
    make_standing_trial(truth, condition, task, Protocol(profile, 0.4, (1.5, 2.5), TRIAL_S), paths)
    assert sorted(folder.iterdir()) == sorted(paths.values())
    return paths


def emg_of(files):
    return read_emg(files["emg"], {muscle: f"EMG {muscle}" for muscle in MUSCLES}, "Trigger")


def starts_of(log):
    """Samples before which the commanded pulses start."""
    return np.flatnonzero((log.command[1:] != 0.0) & (log.command[:-1] == 0.0))


@pytest.fixture(scope="module")
def standing_files(shipped_truth, tmp_path_factory):
    return make(shipped_truth, tmp_path_factory.mktemp("standing") / "files")


@pytest.mark.slow
def test_same_seed_makes_the_same_bytes(shipped_truth, standing_files, tmp_path):
    """A trial made again is the same, another condition's or laboratory's is not, on the same plate."""
    again = make(shipped_truth, tmp_path / "again")
    named = make(shipped_truth, tmp_path / "named", "relax-2")
    other = make(shipped_truth | {"seed": 1}, tmp_path / "other")
    for kind, path in standing_files.items():
        assert again[kind].read_bytes() == path.read_bytes()
        assert (named[kind].read_bytes() == path.read_bytes()) == (kind == "calibration")
        assert other[kind].read_bytes() != path.read_bytes()


@pytest.mark.slow
def test_emg_does_not_depend_on_the_plate(shipped_truth, standing_files, tmp_path):
    """Each instrument draws its own noise."""
    noisy = copy.deepcopy(shipped_truth)
    noisy["treadmill"]["plate"]["noise_V"] *= 2.0
    noisy["treadmill"]["capture"]["occlusions_per_minute"] *= 2.0
    changed = make(noisy, tmp_path / "noisy")
    assert changed["emg"].read_bytes() == standing_files["emg"].read_bytes()
    assert changed["log"].read_bytes() != standing_files["log"].read_bytes()


def test_log_holds_the_persons_weight(standing_files):
    """On the right belt stand 64 kg, pushed by the belt at random instants."""
    log = read_treadmill_log(standing_files["log"])
    matrix = read_calibration_matrix(standing_files["calibration"])
    assert log.channels == matrix.channels
    assert log.rate_hz == 1000.0
    assert (log.trigger > 2.5).sum() == pytest.approx(10_000, abs=1)
    weight = log.voltages @ matrix.row("Fz_right")
    assert weight.mean() == pytest.approx(64.0 * G, rel=0.01)
    assert abs((log.voltages @ matrix.row("Fz_left")).mean()) < 5.0
    assert np.abs(log.command).max() == pytest.approx(0.4, rel=0.01)
    assert 3 <= starts_of(log).size <= 5


def test_markers_are_those_of_the_leg_and_ride_on_the_belt(standing_files):
    """The ankle goes as far as the belt's velocity takes it."""
    markers = read_markers(standing_files["markers"], list(MARKERS))
    assert markers.rate_hz == 250.0
    assert markers.positions.shape == (2500, 8, 3)
    log = read_treadmill_log(standing_files["log"])
    edge = int(np.argmax(log.trigger > 2.5))
    travelled = np.cumsum(log.belt_velocity)[edge : edge + 10_000 : 4] / 1000.0
    ankle = markers.positions[:, MARKERS.index("ankle")]
    seen = ~np.isnan(ankle[:, 1])
    assert seen.mean() > 0.95
    shift = (ankle[:, 1] - travelled)[seen]
    assert np.ptp(ankle[seen, 1]) > 0.008
    assert shift == pytest.approx(np.full(shift.size, np.median(shift)), abs=2e-3)
    assert np.nanmean(ankle[:, 2]) == pytest.approx(0.08, abs=1e-3)
    heights = np.nanmean(markers.positions[:, :, 2], axis=0)
    assert (np.diff(heights[[1, 2, 4, 3, 7, 6, 5]]) > 0.0).all()


def test_emg_answers_the_pulses_of_the_log(standing_files):
    """On both clocks the trigger is time 0: calf and front of the shank burst after the pulses only."""
    recording, log = emg_of(standing_files), read_treadmill_log(standing_files["log"])
    assert recording.muscles == MUSCLES
    assert recording.rate_hz == 1000.0
    assert (recording.trigger > 2.5).sum() == pytest.approx(10_000, abs=1)
    edge, of_emg = (int(np.argmax(line > 2.5)) for line in (log.trigger, recording.trigger))
    starts = starts_of(log) - edge + of_emg
    # without the wandering baseline: first differences
    signals = np.diff(recording.signals, axis=0)
    for muscle in ("TA", "SOL"):
        column = signals[:, MUSCLES.index(muscle)]
        before = np.mean([column[start - 100 : start].std() for start in starts])
        early = np.mean([column[start : start + 50].std() for start in starts])
        after = np.mean([column[start + 50 : start + 200].std() for start in starts])
        # belt 12 ms after the command, reflex more than 40 ms after the belt
        assert after > 1.5 * max(before, early)


@pytest.mark.slow
def test_task_and_direction_are_those_asked_for(shipped_truth, standing_files, tmp_path):
    """Who stiffens has more tone in front of the shank; the belt goes backwards first."""
    files = make(shipped_truth, tmp_path / "stiff", "stiff", "stiff", "negative-sine")
    relaxed, stiff = (np.diff(emg_of(f).signals[:400], axis=0).std(axis=0) for f in (standing_files, files))
    ta = MUSCLES.index("TA")
    assert stiff[ta] > 2.0 * relaxed[ta]
    for kind, sign in ((standing_files, 1.0), (files, -1.0)):
        log = read_treadmill_log(kind["log"])
        assert (sign * log.command[starts_of(log) + 10] > 0.0).all()
