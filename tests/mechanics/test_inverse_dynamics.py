"""The leg's free body against torques worked out by hand, and what a wrong torque formula does."""

import numpy as np
import pytest
from builders import LEG, Joint, assert_one_sentence, refused, swing
from scipy.integrate import solve_ivp

from tepsipe.errors import InputError
from tepsipe.mechanics.inverse_dynamics import (
    Foot,
    Leg,
    foot_torque_as_printed,
    leg_pathway_torque,
    leg_torque,
    leg_torque_as_printed,
)
from tepsipe.mechanics.joint_simulation import simulate_joint
from tepsipe.mechanics.joint_torque import joint_torque
from tepsipe.mechanics.segment_chain import Chain, linearised
from tepsipe.statistics.goodness_of_fit import vaf
from tepsipe.statistics.least_squares import least_squares_line

ANGLES = np.array([-0.4, -0.05, 0.0, 0.1, 0.7])
STILL = np.zeros_like(ANGLES)


def rotation_about_the_ankle(leg, theta, theta_d, theta_dd):
    """Acceleration of the leg's centre at r (sin theta, cos theta) from an ankle that stays."""
    r = leg.com_m
    y_dd = r * (np.cos(theta) * theta_dd - np.sin(theta) * theta_d**2)
    z_dd = -r * (np.sin(theta) * theta_dd + np.cos(theta) * theta_d**2)
    return y_dd, z_dd


def test_leg_held_still_needs_its_toppling_moment(leg):
    torque = leg_torque(leg, ANGLES, STILL, STILL, STILL)
    assert torque == pytest.approx(0.4 * 9.81 * 0.4485 * np.sin(ANGLES), abs=1e-15)


def test_upright_leg_carried_forward_pulls_backwards_on_its_joint(leg):
    torque = leg_torque(leg, STILL, STILL, np.full(5, 3.0), STILL)
    assert torque == pytest.approx(np.full(5, -0.4 * 3.0 * 0.4485), rel=1e-14)


def test_horizontal_leg_in_free_fall_needs_no_torque(leg):
    falling = np.full(5, -9.81)
    torque = leg_torque(leg, np.full(5, 0.5 * np.pi), STILL, STILL, falling)
    assert torque == pytest.approx(STILL, abs=1e-15)


def test_leg_that_turns_about_a_fixed_ankle_shows_its_inertia_about_the_ankle(leg):
    theta_d, theta_dd = 1.3, np.array([-20.0, 7.0, 11.0, 3.0, -5.0])
    accelerations = rotation_about_the_ankle(leg, ANGLES, theta_d, theta_dd)
    torque = leg_torque(leg, ANGLES, theta_dd, *accelerations)
    about_ankle = 0.027 + 0.4 * 0.4485**2
    expected = -about_ankle * theta_dd + 0.4 * 9.81 * 0.4485 * np.sin(ANGLES)
    assert torque == pytest.approx(expected, rel=1e-12)


def test_torque_of_a_swinging_leg_is_that_of_its_rubber(leg):
    moved = swing(Joint(damping=0.1, stiffness=10.0, rest=0.01))
    m = moved.motion
    torque = leg_torque(leg, m.theta, m.theta_dd, m.y_dd, m.z_dd)
    assert np.ptp(moved.torque) > 0.1
    assert torque == pytest.approx(moved.torque, abs=1e-12)


def test_inertia_at_the_joint_stays_in_the_torque_and_that_of_the_leg_does_not(leg):
    moved = swing(Joint(inertia=0.015))
    m = moved.motion
    torque = leg_torque(leg, m.theta, m.theta_dd, m.y_dd, m.z_dd)
    fit = least_squares_line(np.column_stack([m.theta_dd, m.theta_d, m.theta]), torque)
    assert fit.parameters == pytest.approx([0.015, 0.1, 10.0], rel=1e-6)


def test_printed_torque_differs_by_twice_the_inertia_and_twice_the_weight(leg, rng):
    theta, theta_dd, y_dd, z_dd = rng.uniform(-1.0, 1.0, (4, 50)) * [[0.5], [80.0], [20.0], [5.0]]
    arguments = (leg, theta, theta_dd, y_dd, z_dd)
    difference = leg_torque_as_printed(*arguments) - leg_torque(*arguments)
    expected = 2.0 * 0.027 * theta_dd - 2.0 * 0.4 * 9.81 * 0.4485 * np.sin(theta)
    assert difference == pytest.approx(expected, abs=1e-12)


def test_both_torques_are_odd_in_the_direction_of_motion(leg, rng):
    theta, theta_dd, y_dd, z_dd = rng.standard_normal((4, 20))
    for torque in (leg_torque, leg_torque_as_printed):
        mirrored = torque(leg, -theta, -theta_dd, -y_dd, z_dd)
        assert mirrored == pytest.approx(-torque(leg, theta, theta_dd, y_dd, z_dd), rel=1e-14)


def linear_swing(leg, joint):
    """Linearised motion J th'' + B th' + (K - m g r) th = -m r y_f'' under a smooth random belt."""
    m, r, g = leg.mass_kg, leg.com_m, leg.gravity_m_per_s2
    about_ankle, k_g = leg.inertia_kgm2 + m * r**2 + joint.inertia, m * g * r
    phases = np.random.default_rng(7).uniform(0.0, 2.0 * np.pi, 8)
    frequencies = np.arange(1.0, 9.0)

    def belt(t):
        return np.sum(2.0 * np.sin(2.0 * np.pi * frequencies * t + phases))

    def rate(t, x):
        bent = joint.damping * x[1] + (joint.stiffness - k_g) * x[0]
        return x[1], (-m * r * belt(t) - bent) / about_ankle

    time = np.linspace(0.0, 3.0, 600)
    solution = solve_ivp(rate, (0.0, 3.0), (0.0, 0.0), t_eval=time, rtol=1e-9, atol=1e-12)
    theta, theta_d = solution.y
    belt_dd = np.array([belt(t) for t in time])
    theta_dd = np.array([rate(t, x)[1] for t, x in zip(time, solution.y.T, strict=True)])
    return theta, theta_d, theta_dd, belt_dd


@pytest.mark.parametrize(
    ("a", "b", "c", "d"),
    [
        (-0.18, 0.027, 0.0, -1.76),
        (0.0, 0.05, 0.2, 3.0),
        (0.3, 0.0, 0.0, 0.0),
        (-0.05, 0.4, -0.3, 25.0),
    ],
)
def test_any_linear_torque_formula_fits_perfectly_with_apparent_parameters(leg, a, b, c, d):
    joint = Joint(inertia=0.015, damping=0.1, stiffness=10.0)
    theta, theta_d, theta_dd, belt_dd = linear_swing(leg, joint)
    torque = a * belt_dd + b * theta_dd + c * theta_d + d * theta
    jacobian = np.column_stack([theta_dd, theta_d, theta])
    fit = least_squares_line(jacobian, torque)
    p = 0.4 * 0.4485
    about_ankle = 0.027 + 0.4 * 0.4485**2 + 0.015
    k_g = 0.4 * 9.81 * 0.4485
    apparent = [b - a * about_ankle / p, c - a * 0.1 / p, d - a * (10.0 - k_g) / p]
    assert vaf(torque, jacobian @ fit.parameters) == pytest.approx(100.0, abs=1e-9)
    assert fit.parameters == pytest.approx(apparent, rel=1e-6, abs=1e-9)


def test_foot_torque_without_the_vertical_force_gives_the_predicted_wrong_parameters(leg):
    joint = Joint(inertia=0.015, damping=0.1, stiffness=10.0)
    theta, theta_d, theta_dd, belt_dd = linear_swing(leg, joint)
    foot_mass, foot_height = 2.1, 0.055
    shear = -leg.mass_kg * (belt_dd + leg.com_m * theta_dd)
    ground = foot_mass * belt_dd - shear
    torque = -ground * foot_height / 2.0 + shear * foot_height / 2.0
    jacobian = np.column_stack([theta_dd, theta_d, theta])
    fit = least_squares_line(jacobian, torque)
    assert fit.parameters == pytest.approx([0.0446, 0.0445, 3.66], rel=5e-3)
    assert vaf(torque, jacobian @ fit.parameters) == pytest.approx(100.0, abs=1e-9)


def test_printed_leg_torque_is_one_of_those_formulas(leg):
    joint = Joint(inertia=0.0, damping=0.1, stiffness=10.0)
    theta, theta_d, theta_dd, belt_dd = (1e-3 * x for x in linear_swing(leg, joint))
    y_dd = belt_dd + leg.com_m * theta_dd
    torque = leg_torque_as_printed(leg, theta, theta_dd, y_dd, np.zeros_like(y_dd))
    fit = least_squares_line(np.column_stack([theta_dd, theta_d, theta]), torque)
    k_g = 0.4 * 9.81 * 0.4485
    assert fit.parameters == pytest.approx([2.0 * 0.027, 0.1, 10.0 - 2.0 * k_g], rel=1e-4)


def two_segments():
    return Chain(mass_kg=(3.0, 7.0), length_m=(0.4, 0.5), com_m=(0.25, 0.2), inertia_kgm2=(0.05, 0.2))


def test_double_pendulum_upright_has_the_matrices_of_the_textbook():
    """In joint angles: M from the kinetic energy, G from the heights, b from the belt's acceleration."""
    found = linearised(two_segments(), np.zeros(2))
    upper = 0.2 + 7.0 * 0.2**2
    # both turn about the ankle: the upper centre of mass is at 0.4 + 0.2
    whole = 0.05 + 3.0 * 0.25**2 + 0.2 + 7.0 * 0.6**2
    coupled = 0.2 + 7.0 * 0.6 * 0.2
    np.testing.assert_allclose(found.inertia_parts.sum(axis=0), [[whole, coupled], [coupled, upper]])
    s_1, s_2 = 3.0 * 0.25 + 7.0 * 0.4, 7.0 * 0.2
    gravity = -9.81 * np.array([[s_1 + s_2, s_2], [s_2, s_2]])
    np.testing.assert_allclose(found.gravity_parts.sum(axis=0), gravity)
    np.testing.assert_allclose(found.belt_parts.sum(axis=0), [-(s_1 + s_2), -s_2])


def test_torque_needs_a_motion_and_a_leg():
    motion = swing(Joint()).motion
    for arguments, words in (((motion, motion), "Leg"), ((LEG, LEG), "segment_motion")):
        with pytest.raises(InputError) as caught:
            joint_torque(*arguments)
        assert_one_sentence(caught.value, words)


def test_simulation_of_too_many_steps_is_refused():
    time = np.arange(200) / 250.0
    joint = {"leg": LEG, "I": 0.002, "B": 0.1, "K": 10.0}
    with pytest.raises(InputError) as caught:
        simulate_joint(time, np.zeros(200), **joint, step_s=1e-9)
    assert_one_sentence(caught.value, "lengthen step_s")
    assert np.abs(simulate_joint(time, np.zeros(200), **joint).theta).max() < 1e-6


def test_foot_as_printed_by_hand(leg):
    # the horizontal forces of plate and leg at the ends of a foot of 0.06 m: -10 x 0.03 - 0.4 x 2 x 0.03
    foot = Foot(mass_kg=0.3, height_m=0.06)
    torque = foot_torque_as_printed(foot, leg, np.array([10.0]), np.array([2.0]))
    assert torque == pytest.approx([-0.324])


def test_unknown_torque_and_a_leg_for_a_foot_are_refused(leg):
    with pytest.raises(InputError) as caught:
        leg_pathway_torque("hip", leg, swing(Joint()).motion)
    assert_one_sentence(caught.value, "'hip'", "a torque of")
    with pytest.raises(InputError) as caught:
        simulate_joint(np.arange(10) / 250.0, np.zeros(10), leg=LEG, foot=LEG, I=0.002, B=0.1, K=10.0)
    assert_one_sentence(caught.value, "Foot")


def test_leg_that_cannot_be_is_refused():
    refused(lambda: Leg(mass_kg=0.4, com_m=0.027, inertia_kgm2=0.4485), "com_m and inertia_kgm2", "swapped")
    refused(lambda: Leg(mass_kg=-0.4, com_m=0.4485, inertia_kgm2=0.027), "mass_kg", "-0.4")
    refused(lambda: Leg(mass_kg=0.4, com_m="0.45", inertia_kgm2=0.027), "com_m", "'0.45'")
    with pytest.raises(TypeError):
        Leg(0.4, 0.4485, 0.027)  # by name only: numbers in a row are easily swapped


def test_radius_of_gyration_may_be_three_times_the_distance_of_the_centre_of_mass():
    Leg(mass_kg=1.0, com_m=0.5, inertia_kgm2=1.49**2)
    refused(lambda: Leg(mass_kg=1.0, com_m=0.5, inertia_kgm2=1.51**2), "1.51 m and 0.5 m")
