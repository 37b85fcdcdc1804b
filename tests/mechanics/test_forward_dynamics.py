"""The dummy in every engine: against an exact integration, each other, and physics by hand; refusals."""

import hashlib
import importlib.util
import itertools
import math
import subprocess
import sys
from dataclasses import fields, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from builders import LEG, assert_one_sentence
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from syntax import imports

import tepsipe
from tepsipe.errors import InputError
from tepsipe.identification.likelihood.likelihood import softening_forces
from tepsipe.mechanics import engines
from tepsipe.mechanics.engines import ENGINES, engine_version, installed_engines, resolved_engine
from tepsipe.mechanics.forward_dynamics import (
    UPRIGHT,
    Joint,
    Start,
    refuse_unstable,
    resting,
    simulate_dummies,
    simulate_dummy,
)
from tepsipe.mechanics.inverse_dynamics import Foot, foot_torque, leg_torque
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.statistics.goodness_of_fit import vaf

FOOT = Foot(mass_kg=2.1, height_m=0.055)
M_F, M, R, I_L, G = 2.1, 0.4, 0.4485, 0.027, 9.81
K_G = M * G * R
RATE_HZ = 250.0
RUBBER = Joint(0.0, 0.1, 10.0)
SOFT = Joint(  # half of the stiffness goes at large bending, at 0.03 rad a quarter
    0.007,
    0.02,
    10.0,
    softening_Nm_per_rad=5.0,
    softened_damping_Nms_per_rad=0.1,
    half_softening_rad=0.03,
)


def needed(engine):
    """Skip the test, saying what is missing, where the engine is not installed."""
    if engine not in installed_engines():
        pytest.skip(f"the engine {engine} is not installed: {engines.INSTALLED_BY[engine]}")
    return engine


@pytest.fixture(params=ENGINES)
def engine(request):
    return needed(request.param)


def belt(duration_s, peak_m_per_s=0.5, noise_m_per_s=0.0, onsets_s=None):
    """Instants (s) and velocity (m/s): a 10 Hz sine every 4 s, with noise, low-passed at 20 Hz."""
    time = np.arange(round(duration_s * RATE_HZ)) / RATE_HZ
    velocity = np.random.default_rng(11).normal(0.0, noise_m_per_s, time.size)
    for onset in np.arange(6.0, duration_s - 8.0, 4.0) if onsets_s is None else onsets_s:
        since = time - onset
        pulse = peak_m_per_s * np.sin(2.0 * np.pi * 10.0 * since)
        velocity += np.where((since >= 0.0) & (since < 0.1), pulse, 0.0)
    return time, butterworth_lowpass(velocity, RATE_HZ, 20.0)


def still(duration_s):
    time = np.arange(round(duration_s * RATE_HZ)) / RATE_HZ
    return time, np.zeros(time.size)


def run(
    time,
    velocity,
    joint=RUBBER,
    engine="equations",
    step_s=0.001,
    start_angle_rad=0.0,
    start_rate_rad_per_s=0.0,
):
    start = Start(start_angle_rad, start_rate_rad_per_s)
    return simulate_dummy(time, velocity, LEG, FOOT, joint, step_s, engine, start)


def arrays(simulation):
    named = {field.name: getattr(simulation, field.name) for field in fields(simulation)}
    return {name: value for name, value in named.items() if isinstance(value, np.ndarray)}


def digest(simulation):
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays(simulation).values())).hexdigest()


def about_ankle(joint):
    return I_L + M * R**2 + joint.inertia_Nms2_per_rad


# ---- an exact integration ----------------------------------------------------------------------

TIME, VELOCITY = belt(70.0, noise_m_per_s=0.001)
SWINGS = {  # joint, angle (rad) and rate (rad/s) at the start
    "true": (RUBBER, 0.0, 0.0),
    "bent": (Joint(0.015, 0.1, 10.0, rest_angle_rad=0.02), 0.03, -0.2),
    "undamped": (Joint(0.061, -0.002, 5.3), 0.0, 0.0),
}


@pytest.fixture(scope="module")
def exact():
    """theta, theta', theta'' of every swing, all integrated at once along the same spline."""
    spline = CubicSpline(TIME, VELOCITY)
    coefficients = spline.derivative().c.T.tolist()
    last, sin, cos = len(coefficients) - 1, math.sin, math.cos
    joints = [swing[0] for swing in SWINGS.values()]
    constants = [
        (about_ankle(j), j.damping_Nms_per_rad, j.stiffness_Nm_per_rad, j.rest_angle_rad) for j in joints
    ]

    def derivative(t, x):
        piece = min(int(t * RATE_HZ), last)
        since = t - piece / RATE_HZ
        c2, c1, c0 = coefficients[piece]
        y_dd = (c2 * since + c1) * since + c0
        out = []
        for k, (inertia, b, stiffness, rest) in enumerate(constants):
            th, w = x[2 * k], x[2 * k + 1]
            turn = K_G * sin(th) - M * R * y_dd * cos(th) - b * w - stiffness * (th - rest)
            out += [w, turn / inertia]
        return out

    start = [value for _, angle, rate in SWINGS.values() for value in (angle, rate)]
    solution = solve_ivp(
        derivative,
        (0.0, TIME[-1]),
        start,
        method="DOP853",
        t_eval=TIME,
        rtol=1e-10,
        atol=1e-13,
        max_step=1.0 / RATE_HZ,  # no step over a knot of the spline
    )
    rates = np.array([derivative(t, x) for t, x in zip(TIME, solution.y.T, strict=True)]).T
    return {
        name: (solution.y[2 * k], solution.y[2 * k + 1], rates[2 * k + 1]) for k, name in enumerate(SWINGS)
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", SWINGS)
def test_trial_of_70_s_follows_the_exact_equation_of_motion(exact, name, engine):
    joint, angle, rate = SWINGS[name]
    found = run(TIME, VELOCITY, joint, start_angle_rad=angle, start_rate_rad_per_s=rate, engine=engine)
    th, w, w_rate = exact[name]
    y_f_dd = CubicSpline(TIME, VELOCITY)(TIME, 1)
    y_dd = y_f_dd + R * (np.cos(th) * w_rate - np.sin(th) * w**2)
    z_dd = -R * (np.sin(th) * w_rate + np.cos(th) * w**2)
    expected = {
        "theta": th,
        "theta_d": w,
        "theta_dd": w_rate,
        "torque": joint.inertia_Nms2_per_rad * w_rate
        + joint.damping_Nms_per_rad * w
        + joint.stiffness_Nm_per_rad * (th - joint.rest_angle_rad),
        "y_dd": y_dd,
        "z_dd": z_dd,
        "f_ay": -M * y_dd,
        "f_az": -M * (G + z_dd),
        "f_y": M_F * y_f_dd + M * y_dd,
        "f_z": M_F * G + M * (G + z_dd),
    }
    for signal, value in expected.items():
        error = getattr(found, signal) - value
        assert np.abs(error).max() < 1e-4 * np.abs(value).max(), signal
        moving = value - value.mean()  # the weight would hide what happens to F_z
        assert vaf(moving, moving + error) > 99.9999, signal
    assert vaf(th, found.theta) > 99.99999


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "order"), [("pybullet", 2), ("mujoco", 4), ("equations", 4)])
def test_error_falls_with_the_order_of_the_method(exact, engine, order):
    needed(engine)
    errors = [
        np.abs(run(TIME, VELOCITY, step_s=h, engine=engine).theta - exact["true"][0]).max()
        for h in (0.004, 0.002)
    ]
    assert errors[0] / errors[1] == pytest.approx(2.0**order, rel=0.1)
    assert errors[0] < {2: 1e-5, 4: 2e-8}[order]


# ---- engine against engine ---------------------------------------------------------------------

COMPARED = {  # joint, angle (rad) and rate (rad/s) at the start
    "rubber": (RUBBER, 0.0, 0.0),
    "undamped": (Joint(0.0, 0.0, 10.0), 0.0, 0.0),
    "growing, with inertia": (Joint(0.061, -0.002, 5.3), 0.0, 0.0),
    "lightly damped, with inertia": (Joint(0.015, 0.02, 6.5), 0.0, 0.0),
    "less inertia than the leg's": (Joint(-0.02, 0.1, 10.0), 0.0, 0.0),
    "overdamped": (Joint(0.0, 3.0, 10.0), 0.0, 0.0),
    "stiff": (Joint(0.0, 0.5, 300.0), 0.0, 0.0),
    "leaning": (resting(LEG, RUBBER, 0.15), 0.15, 0.0),
    "softening": (replace(SOFT, rest_angle_rad=0.003), 0.05, 0.2),
    "thrown": (Joint(0.015, 0.1, 10.0, 0.02), 0.4, -3.0),
    "too soft": (Joint(0.0, 0.1, 1.2), 0.02, 0.0),
    "repelled": (Joint(0.01, 0.1, -3.0), 0.001, 0.0),
}
SIGNALS = ["theta", "theta_d", "theta_dd", "torque", "y_dd", "z_dd", "f_y", "f_z", "m_x", "f_ay", "f_az"]


@cache
def compared(name, engine):
    joint, angle, rate = COMPARED[name]
    time, velocity = belt(20.0, noise_m_per_s=0.001)
    return run(time, velocity, joint, engine, start_angle_rad=angle, start_rate_rad_per_s=rate)


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPARED)
@pytest.mark.parametrize("pair", list(itertools.combinations(ENGINES, 2)), ids="-".join)
def test_engines_agree_within_a_thousandth_in_motion_and_reactions(pair, name):
    first, second = (compared(name, needed(engine)) for engine in pair)
    assert first.state == second.state
    assert first.growth_per_s == second.growth_per_s
    if first.state == "falls":
        assert first.fell_at_s == pytest.approx(second.fell_at_s, abs=0.0011)  # a step
    else:
        assert first.fell_at_s is second.fell_at_s is None
        assert first.time.size == second.time.size == 5000
    samples = min(first.time.size, second.time.size)
    assert samples > 50
    for signal in SIGNALS:
        a, b = getattr(first, signal)[:samples], getattr(second, signal)[:samples]
        # of what moves: the weight would hide what happens to F_z
        assert np.abs(a - b).max() < 1e-3 * np.ptp(b), signal
        assert np.ptp(b) > 0.0
    for signal in ("time", "foot_y", "foot_y_d", "foot_y_dd"):
        assert (getattr(first, signal)[:samples] == getattr(second, signal)[:samples]).all(), signal


def test_dummies_that_are_moved_together_move_as_each_alone(engine):
    time, velocity = belt(4.0, onsets_s=(1.0, 2.5))
    joints = {
        "rubber": RUBBER,
        "falls": Joint(0.01, 0.1, -3.0),
        "softens": SOFT,
        "falls late": COMPARED["too soft"][0],
    }
    start = Start(0.02, 0.0)
    together = simulate_dummies(time, velocity, LEG, FOOT, joints, 0.001, engine, start)
    assert list(together) == list(joints)
    assert [found.state for found in together.values()] == ["settles", "falls", "settles", "falls"]
    for name, found in together.items():
        assert digest(found) == digest(run(time, velocity, joints[name], engine, start_angle_rad=0.02)), name


# ---- by hand -----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("joint", [Joint(0.0, 0.0, 10.0), Joint(0.061, 0.0, 5.3), Joint(-0.05, 0.0, 10.0)])
def test_free_swing_has_its_natural_frequency_and_keeps_its_energy(joint, engine):
    found = run(*still(20.0), joint, start_angle_rad=0.001, engine=engine)
    natural = math.sqrt((joint.stiffness_Nm_per_rad - K_G) / about_ankle(joint))
    # to the fourth decimal of a radian after some hundred radians
    assert found.theta == pytest.approx(0.001 * np.cos(natural * found.time), abs=3e-6)
    energy = 0.5 * about_ankle(joint) * found.theta_d**2 + K_G * np.cos(found.theta)
    energy += 0.5 * joint.stiffness_Nm_per_rad * found.theta**2
    assert np.ptp(energy) < 1e-4 * 0.5 * joint.stiffness_Nm_per_rad * 0.001**2


def test_rate_is_that_of_the_angle_even_with_long_steps(engine):
    joint = Joint(0.0, 0.0, 60.0)
    found = run(*still(4.0), joint, start_angle_rad=0.001, engine=engine, step_s=0.004)
    natural = math.sqrt((60.0 - K_G) / about_ankle(joint))
    size = np.hypot(found.theta, found.theta_d / natural)
    assert size == pytest.approx(0.001, rel=1e-3)


@pytest.mark.parametrize(("damping", "state"), [(0.1, "settles"), (-0.05, "grows"), (3.0, "settles")])
def test_swing_grows_at_the_rate_that_is_reported(damping, state, engine):
    joint = Joint(0.02, damping, 10.0)
    found = run(*still(4.0), joint, start_angle_rad=1e-3, engine=engine)
    natural = math.sqrt((10.0 - K_G) / about_ankle(joint))
    late = found.time > 2.0
    if damping < 1.0:
        # theta and theta' a quarter of a period apart: their envelope
        rate = found.growth_per_s
        quadrature = (found.theta_d - rate * found.theta) / math.sqrt(natural**2 - rate**2)
        envelope = np.hypot(found.theta, quadrature)
    else:
        envelope = np.abs(found.theta)  # overdamped
    slope = np.polyfit(found.time[late], np.log(envelope[late]), 1)[0]
    assert found.growth_per_s == pytest.approx(slope, rel=1e-3)
    assert found.state == state
    assert found.fell_at_s is None


@pytest.mark.parametrize("joint", [RUBBER, SOFT], ids=["linear", "softening"])
def test_leg_that_leans_stands_still_on_a_joint_bent_for_it(joint, engine):
    gravity_moment = K_G * math.sin(0.1)
    found = run(*still(3.0), resting(LEG, joint, 0.1), start_angle_rad=0.1, engine=engine)
    assert found.theta == pytest.approx(np.full(750, 0.1), abs=1e-13)
    assert found.torque == pytest.approx(np.full(750, gravity_moment), rel=1e-12)
    assert found.f_az == pytest.approx(np.full(750, -M * G), rel=1e-12)
    assert found.f_z == pytest.approx(np.full(750, (M + M_F) * G), rel=1e-12)
    assert np.abs([found.f_y, found.f_ay]).max() < 1e-9
    # the belt presses in front of the ankle, against the weight of the leg
    assert found.m_x == pytest.approx(np.full(750, gravity_moment), rel=1e-9)


def test_joint_that_softens_moves_its_leg_as_a_free_body_does_by_hand(engine):
    """At phi_h, 0.03 rad, half of the softening has taken place; the leg turns at 0.5 rad/s.

    K 10 - 5 / 2 = 7.5 N·m/rad and B 0.02 + 0.1 / 2 = 0.07 N·m·s/rad resist with 0.225 + 0.035 = 0.26 N·m. The
    weight tips the leg with 0.4 x 9.81 x 0.4485 sin(0.03) = 0.052789 N·m, and 0.027 + 0.4 x 0.4485^2 + 0.007
    = 0.1144609 kg·m2 turn.
    """
    found = run(*still(0.2), SOFT, start_angle_rad=0.03, start_rate_rad_per_s=0.5, engine=engine)
    assert found.theta_dd[0] == pytest.approx((0.052789 - 0.26) / 0.1144609, rel=1e-4)
    assert found.torque[0] == pytest.approx(0.26 + 0.007 * found.theta_dd[0], rel=1e-6)
    # the other way round, the same
    mirrored = run(*still(0.2), SOFT, start_angle_rad=-0.03, start_rate_rad_per_s=-0.5, engine=engine)
    assert mirrored.theta == pytest.approx(-found.theta, abs=1e-12)


def test_large_swings_of_a_joint_that_softens_are_slower_and_keep_their_energy(engine):
    """Potential energy K b^2 / 2 - C / 2 [b^2 - h^2 ln(1 + b^2 / h^2)], whose slope is (K - q C) b."""
    joint = replace(SOFT, damping_Nms_per_rad=0.0, softened_damping_Nms_per_rad=0.0)
    periods = []
    for size in (0.0005, 0.06):
        found = run(*still(10.0), joint, start_angle_rad=size, engine=engine)
        b, c, h = found.theta, 5.0, 0.03
        energy = 0.5 * about_ankle(joint) * found.theta_d**2 + K_G * (np.cos(b) - 1.0)
        energy += 0.5 * 10.0 * b**2 - 0.5 * c * (b**2 - h**2 * np.log1p((b / h) ** 2))
        assert np.ptp(energy) < 1e-3 * energy.mean()
        up = np.flatnonzero((b[:-1] < 0.0) & (b[1:] >= 0.0))
        periods.append(float(np.diff(found.time[up]).mean()))
    assert periods[0] == pytest.approx(found.period_s, rel=2e-3)
    assert periods[0] == pytest.approx(2.0 * math.pi * math.sqrt(about_ankle(joint) / (10.0 - K_G)), rel=2e-3)
    assert periods[1] > 1.15 * periods[0]


def test_law_is_that_of_the_joint_likelihood():
    theta, rate = np.random.default_rng(3).normal(0.0, 0.03, (2, 50))
    forces = softening_forces(theta - 0.004, rate, 0.004 - 0.001, 0.03)
    # forces of the likelihood are relative to rest, where the joint is bent by 0.003
    at_rest = SOFT.softened(0.003, 0.0)
    expected = 10.0 * (theta - 0.001) + 0.02 * rate - 5.0 * forces["C"] - 0.1 * forces["B_s"] - at_rest
    assert replace(SOFT, rest_angle_rad=0.001).resistance(theta, rate) == pytest.approx(expected, abs=1e-12)


def test_dummy_on_a_still_belt_does_nothing(engine):
    found = run(*still(2.0), engine=engine)
    for name in ("theta", "theta_d", "theta_dd", "torque", "foot_y", "foot_y_dd", "f_y", "f_ay", "m_x"):
        assert not getattr(found, name).any(), name


@pytest.mark.parametrize("joint", [RUBBER, Joint(0.03, 0.2, 8.0, rest_angle_rad=0.05)])
def test_forces_are_those_of_the_free_bodies(joint, engine):
    time, velocity = belt(4.0, onsets_s=(1.0, 2.5))
    found = run(time, velocity, joint, engine=engine)
    assert np.abs(found.f_ay + M * found.y_dd).max() < 1e-9
    assert np.abs(found.f_az + M * (G + found.z_dd)).max() < 1e-9
    assert np.abs(found.f_y - M_F * found.foot_y_dd - M * found.y_dd).max() < 1e-9
    assert np.abs(found.f_z - M_F * G - M * (G + found.z_dd)).max() < 1e-9
    from_leg = leg_torque(LEG, found.theta, found.theta_dd, found.y_dd, found.z_dd)
    from_foot = foot_torque(FOOT, found.f_y, found.f_z, found.m_x, found.foot_y, found.foot_y_dd)
    assert np.ptp(found.torque) > 0.1
    assert np.abs(from_leg - found.torque).max() < 1e-9
    assert np.abs(from_foot - found.torque).max() < 1e-9


def test_force_of_the_belt_is_the_rate_of_the_momentum_of_foot_and_leg(engine):
    """Foot and leg as one free body: p_y = m_f y_f' + m (y_f' + r cos(th) th'), p_z = -m r sin(th) th'.

    F_y changes p_y. F_z changes p_z and carries the weight, 2.5 x 9.81 = 24.525 N. F_Ay moves the foot
    against F_y.
    """
    time, velocity = belt(4.0, onsets_s=(1.0, 2.5))
    found = run(time, velocity, SOFT, engine=engine, start_angle_rad=0.05)
    along = R * np.cos(found.theta) * found.theta_d
    momentum = {
        "f_y": M_F * found.foot_y_d + M * (found.foot_y_d + along),
        "f_z": -M * R * np.sin(found.theta) * found.theta_d,
        "f_ay": -M * (found.foot_y_d + along),
    }
    for name, p in momentum.items():
        force = getattr(found, name) - (24.525 if name == "f_z" else 0.0)
        impulse = CubicSpline(time, force).antiderivative()(time)
        assert np.ptp(p) > 1e-3, name
        assert impulse == pytest.approx(p - p[0], abs=2e-3 * np.ptp(p)), name


def test_foot_moves_as_the_belt_was_recorded(engine):
    time = np.arange(500) / RATE_HZ
    found = run(time, 0.3 * np.sin(2.0 * np.pi * 2.0 * time), engine=engine)
    omega = 4.0 * np.pi
    assert found.foot_y == pytest.approx(0.3 / omega * (1.0 - np.cos(omega * time)), abs=1e-7)
    assert found.foot_y_d == pytest.approx(0.3 * np.sin(omega * time), abs=1e-15)
    assert found.foot_y_dd == pytest.approx(0.3 * omega * np.cos(omega * time), abs=2e-3)
    # an upright leg stays behind when the belt starts forward
    assert found.theta[10] < 0.0


def test_response_comes_as_late_as_the_belt_and_does_not_know_the_clock(engine):
    (time, early), (_, late) = belt(4.0, onsets_s=(1.0,)), belt(4.0, onsets_s=(1.4,))
    first = run(time, early, engine=engine)
    assert run(time + 1234.5, early, engine=engine).theta == pytest.approx(first.theta, abs=1e-11)
    assert run(time + 1234.5, early, engine=engine).time == pytest.approx(time + 1234.5)
    assert run(time, late, engine=engine).theta[350:] == pytest.approx(first.theta[250:-100], abs=1e-6)


def test_small_swings_are_proportional_to_the_belt_and_all_are_odd_in_it(engine):
    time, velocity = belt(4.0, peak_m_per_s=0.02, onsets_s=(1.0,))
    small, large = run(time, velocity, engine=engine), run(time, 2.0 * velocity, engine=engine)
    assert large.theta == pytest.approx(2.0 * small.theta, abs=1e-5 * np.abs(large.theta).max())
    backwards = run(time, -25.0 * velocity, start_angle_rad=-0.2, engine=engine)
    forwards = run(time, 25.0 * velocity, start_angle_rad=0.2, engine=engine)
    assert backwards.theta == pytest.approx(-forwards.theta, abs=1e-12)
    assert backwards.f_z == pytest.approx(forwards.f_z, abs=1e-9)


# ---- legs that fall ----------------------------------------------------------------------------


def test_leg_on_a_joint_that_is_too_soft_falls_when_it_should(engine):
    soft = Joint(0.0, 0.1, 0.9)

    def derivative(t, x):
        return x[1], (K_G * math.sin(x[0]) - 0.1 * x[1] - 0.9 * x[0]) / about_ankle(soft)

    def quarter_turn(t, x):
        return x[0] - 0.5 * math.pi

    solution = solve_ivp(derivative, (0.0, 9.0), (0.05, 0.0), "DOP853", events=quarter_turn, rtol=1e-10)
    time, velocity = still(9.0)
    found = run(time + 3.0, velocity, soft, start_angle_rad=0.05, engine=engine)
    assert found.state == "falls"
    assert found.growth_per_s > 0.0
    assert found.fell_at_s == pytest.approx(3.0 + solution.t_events[0][0], abs=0.0015)
    assert 0.0 < found.fell_at_s - found.time[-1] < 0.0045
    assert 1.5 < found.theta[-1] <= 0.5 * math.pi
    for name, array in arrays(found).items():
        assert array.shape == found.time.shape, name
        assert np.isfinite(array).all(), name
    with pytest.raises(InputError) as caught:
        refuse_unstable(LEG, soft)
    assert_one_sentence(caught.value, "m g r = 1.76 Nm/rad", "0.9 Nm/rad")


def test_leg_may_turn_faster_than_pybullet_lets_a_joint_turn(engine):
    time = np.arange(20) / 1000.0
    found = run(time, np.zeros(20), engine=engine, start_angle_rad=-1.5, start_rate_rad_per_s=250.0)
    assert found.fell_at_s == pytest.approx(3.07 / 250.0, abs=0.001)


def test_negative_stiffness_throws_the_leg_over_at_once(engine):
    found = run(*still(2.0), Joint(0.0, 0.0, -900.0), start_angle_rad=1.5, engine=engine)
    assert found.state == "falls"
    assert found.time.size < 10
    assert np.isfinite(found.theta_d).all()


# ---- one process, another, and what else is in them --------------------------------------------

IN_ANOTHER_PROCESS = """
import sys
sys.path[:0] = sys.argv[1:3]
from tests.mechanics import test_forward_dynamics as tests
for engine in sys.argv[3:]:
    print(tests.digest(tests.run(*tests.belt(4.0, onsets_s=(1.0,)), engine=engine)))
    if engine == "equations":
        print({"pybullet", "mujoco"} & set(sys.modules))
"""


@pytest.mark.slow
def test_every_bit_is_the_same_again_and_in_another_process(root, tmp_path):
    expected = []
    names = installed_engines()[::-1]  # the equations first: others are imported only when they are used
    for engine in names:
        first, again = (digest(run(*belt(4.0, onsets_s=(1.0,)), engine=engine)) for _ in range(2))
        assert first == again
        expected += [first, "set()"] if engine == "equations" else [first]
    command = [sys.executable, "-c", IN_ANOTHER_PROCESS, str(root), str(root / "tests"), *names]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout.split("\n")[:-1] == expected  # and no engine prints to stdout
    assert list(tmp_path.iterdir()) == []  # or keeps a log


def test_another_pybullet_is_left_alone(monkeypatch, capfd):
    needed("pybullet")
    import pybullet

    mine = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0.0, 0.0, -1.0, mine)
        ball = pybullet.createMultiBody(baseMass=1.0, physicsClientId=mine)
        run(*still(0.1), engine="pybullet")

        def broken(_):
            raise KeyboardInterrupt

        with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
            patch.setattr(pybullet, "stepSimulation", broken)
            run(*still(0.1), engine="pybullet")
        after = pybullet.connect(pybullet.DIRECT)
        pybullet.disconnect(after)
        assert after == mine + 1  # no other client is left
        assert pybullet.getNumBodies(mine) == 1
        for _ in range(240):
            pybullet.stepSimulation(mine)
        assert pybullet.getBaseVelocity(ball, mine)[0][2] == pytest.approx(-1.0, rel=0.05)
    finally:
        pybullet.disconnect(mine)
    assert capfd.readouterr().out == ""


# ---- which engine --------------------------------------------------------------------------------


def test_equations_need_no_engine_and_what_has_to_be_installed_is_asked_for():
    """Which module imports an engine is in test_walls.py."""
    found = imports(Path(tepsipe.__file__).parent / "mechanics/engines/equations.py")
    names = {getattr(node, "module", None) or node.names[0].name for node in found}
    assert {name.partition(".")[0] for name in names} == {"math", "numpy", "tepsipe"}
    assert set(engines.INSTALLED_BY) == {"pybullet", "mujoco"}


@pytest.fixture
def only(monkeypatch):
    """Pretend that only some packages are installed."""

    def install(*packages):
        monkeypatch.setattr(importlib.util, "find_spec", lambda name: name if name in packages else None)

    return install


def test_auto_takes_the_first_engine_that_is_installed(only):
    for packages, taken in (
        (("pybullet", "mujoco"), "pybullet"),
        (("mujoco",), "mujoco"),
        ((), "equations"),
    ):
        only(*packages)
        assert resolved_engine("auto") == taken
        assert installed_engines() == [*packages, "equations"]
    found = run(*still(0.1), engine="auto", start_angle_rad=0.1)
    assert digest(found) == digest(run(*still(0.1), engine="equations", start_angle_rad=0.1))


def test_engine_that_is_missing_is_refused_with_what_to_install(only):
    only()
    for name in ("pybullet", "mujoco"):
        for refusing in (lambda e: run(*still(0.1), engine=e), resolved_engine, engine_version):
            with pytest.raises(InputError) as caught:
                refusing(name)
            assert_one_sentence(caught.value, repr(name), f"pip install 'tepsipe[{name}]'", "'auto'")
    for wrong in ("bullet", "", "PyBullet", None):
        with pytest.raises(InputError) as caught:
            run(*still(0.1), engine=wrong)
        assert_one_sentence(caught.value, "pybullet, mujoco, equations or auto", repr(wrong))


def test_engine_that_cannot_be_loaded_is_refused(monkeypatch, only):
    only("mujoco")

    def broken():
        raise ImportError("libGL.so.1: cannot open shared object file")

    monkeypatch.setitem(ENGINES, "mujoco", broken)
    with pytest.raises(InputError) as caught:
        run(*still(0.1), engine="mujoco")
    assert_one_sentence(caught.value, "mujoco", "libGL.so.1", "another engine")


def test_version_of_an_engine_is_that_of_its_package(engine):
    package = "tepsipe" if engine == "equations" else engine
    assert engine_version(engine) == version(package)


# ---- refusals ----------------------------------------------------------------------------------


def test_leg_may_be_a_mass_at_a_point(engine):
    point = replace(LEG, inertia_kgm2=0.0)
    time, velocity = belt(4.0, onsets_s=(1.0,))
    found = simulate_dummy(time, velocity, point, FOOT, RUBBER, 0.001, engine)
    from_leg = leg_torque(point, found.theta, found.theta_dd, found.y_dd, found.z_dd)
    assert np.ptp(found.torque) > 0.1
    assert np.abs(from_leg - found.torque).max() < 1e-9


def test_what_cannot_be_simulated_is_refused():
    time, velocity = still(1.0)

    def refused(
        *names,
        time=time,
        velocity=velocity,
        foot=FOOT,
        joint=RUBBER,
        step_s=0.001,
        start=UPRIGHT,
    ):
        with pytest.raises(InputError) as caught:
            simulate_dummy(time, velocity, LEG, foot, joint, step_s, "equations", start)
        assert_one_sentence(caught.value, *names)

    gap = velocity.copy()
    gap[[10, 11]] = np.nan
    refused("belt velocity", "found 2", "sample 11", velocity=gap)
    refused("time", "sample 11", time=np.where(np.isnan(gap), np.nan, time))
    refused("(249,)", "(250,)", velocity=velocity[1:])
    refused("at least 4", time=time[:3], velocity=velocity[:3])
    refused("increasing", "0.16 s followed by 0.032 s", time=np.r_[time[:41], time[8:217]])
    refused("regular clock", "0.004 s to 0.006 s", time=np.r_[time[:100], time[100:] + 0.002])
    refused("more than -0.1075 Nms2/rad", "-0.2", joint=Joint(-0.2, 0.1, 10.0))
    refused("damping_Nms_per_rad", "nan", joint=Joint(0.0, math.nan, 10.0))
    refused("mass of the foot", "0 kg", foot=Foot(0.0, 0.055))
    refused("quarter turn", "1.6 rad", start=Start(1.6, 0.0))
    refused("quarter turn", "inf rad/s", start=Start(0.0, math.inf))
    for step_s in (0.003, 0.008, 0.0, -0.001, math.nan):
        refused("whole part", "0.004 s", f"{step_s:.6g} s", step_s=step_s)
    # at most 0.1 sqrt(J / (K - m g r)) and 0.1 J / B
    refused("0.00104 s", "natural frequency", "0.004 s", joint=Joint(0.0, 0.1, 1000.0), step_s=0.004)
    refused("0.00269 s", "J / B", "0.004 s", joint=Joint(0.0, -4.0, 10.0), step_s=0.004)
    run(time, velocity, Joint(0.0, 0.1, 1000.0), step_s=0.001)


@pytest.mark.parametrize("joint", [Joint(0.0, 0.1, 1000.0), Joint(0.0, 10.0, 10.0), Joint(0.0, 10.0, 1000.0)])
def test_longest_step_that_is_allowed_is_stable(joint, engine):
    time = np.arange(1000) / 1000.0
    found = run(time, np.zeros(1000), joint, step_s=0.001, start_angle_rad=0.01, engine=engine)
    assert np.abs(found.theta).max() <= 0.01 * 1.01
    assert np.abs(found.theta[-50:]).max() < 0.01
