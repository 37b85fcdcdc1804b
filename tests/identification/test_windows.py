"""TEP-SIPE gives the joint's parameters back, and the printed way gives what its signs predict."""

from dataclasses import replace

import numpy as np
import pytest
from builders import LEG, RATE_HZ, Joint, assert_one_sentence, scaled_leg, swing
from scipy.interpolate import CubicSpline

from tepsipe.errors import InputError
from tepsipe.identification.regression.windows import (
    damping_per_com_lag,
    regress_perturbations,
    regress_torque,
)
from tepsipe.mechanics.segment_kinematics import JointMotion, SegmentMarkers, segment_motion
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.perturbations import Perturbation, WindowOptions, filtered_perturbations
from tepsipe.statistics.bootstrap import bootstrap_mean
from tepsipe.statistics.least_squares import least_squares_line

WINDOW = WindowOptions(
    rest_before_s=2.0,
    rest_after_s=1.0,
    rest_margin_s=0.1,
    threshold_fraction=0.05,
    signal_to_noise=5.0,
    merge_s=0.06,
)
RECOMMENDED = ("leg", False)
PRINTED = ("leg-thesis", True)
WEIGHT = 0.4 * 9.81 * 0.4485  # m g r (Nm/rad)


def regress(moved, torque_pathway, thesis=False, leg=LEG, motion=None):
    """Regression over the perturbations that the belt shows; at rest before the first of them."""
    found = filtered_perturbations(moved.belt_velocity, RATE_HZ, WINDOW, "belt")
    motion = moved.motion if motion is None else motion
    at_rest = motion.time < 1.9
    return regress_perturbations(motion, leg, found, at_rest, torque_pathway, thesis=thesis)


@pytest.fixture(scope="module")
def upright():
    return swing(Joint())


@pytest.fixture(scope="module")
def leaning():
    return swing(Joint(rest=0.02))


@pytest.mark.parametrize(
    ("inertia", "damping", "stiffness", "rest"),
    [(0.0, 0.1, 10.0, 0.0), (0.0, 0.03, 15.0, 0.02), (0.015, 0.2, 8.0, -0.01)],
)
def test_leg_pathway_returns_the_joint_of_a_swinging_leg(inertia, damping, stiffness, rest):
    moved = swing(Joint(inertia, damping, stiffness, rest))
    found = regress(moved, *RECOMMENDED)
    assert len(found.fits) == 3
    truth = np.tile([inertia, damping, stiffness], (3, 1))
    assert found.parameters == pytest.approx(truth, rel=1e-5, abs=1e-8)
    assert found.vaf_trial == pytest.approx(100.0, abs=1e-6)


def test_printed_pathway_adds_twice_the_legs_inertia_and_takes_twice_its_weight(upright):
    found = regress(upright, *PRINTED)
    inertia, damping, stiffness = found.mean
    assert inertia == pytest.approx(2.0 * 0.027, rel=0.01)
    assert damping == pytest.approx(0.1, rel=0.01)
    assert stiffness == pytest.approx(10.0 - 2.0 * WEIGHT, rel=0.01)
    assert (found.vaf_per_perturbation > 99.999).all()


def test_printed_pathway_keeps_the_joints_own_inertia():
    found = regress(swing(Joint(inertia=0.015)), *PRINTED)
    assert found.mean[0] == pytest.approx(0.015 + 2.0 * 0.027, rel=0.01)


def test_torque_left_at_rest_biases_the_printed_regression_of_a_leaning_leg(leaning):
    left_in = regress(leaning, "leg", thesis=True)
    taken_out = regress(leaning, "leg")
    assert left_in.torque_rest_Nm == pytest.approx(WEIGHT * np.sin(0.02), rel=1e-6)
    assert left_in.theta_rest_rad == pytest.approx(0.02, rel=1e-6)
    assert abs(left_in.mean[2] / 10.0 - 1.0) > 0.2
    assert taken_out.mean[2] == pytest.approx(10.0, rel=1e-5)


def test_torque_left_at_rest_does_not_matter_for_an_upright_leg(upright):
    left_in = regress(upright, "leg", thesis=True)
    assert left_in.mean == pytest.approx([0.0, 0.1, 10.0], rel=1e-5, abs=1e-8)


@pytest.mark.parametrize("pathway", [RECOMMENDED, PRINTED])
def test_a_leg_taken_twice_as_heavy_doubles_every_parameter(upright, pathway):
    found = regress(upright, *pathway)
    doubled = regress(upright, *pathway, leg=scaled_leg(LEG, 2.0))
    assert doubled.parameters == pytest.approx(2.0 * found.parameters, rel=1e-9, abs=1e-12)
    assert doubled.vaf_per_perturbation == pytest.approx(found.vaf_per_perturbation)


def test_perturbations_that_start_later_give_the_same_parameters(leaning):
    shifted = swing(Joint(rest=0.02), onsets_s=(2.4, 4.4, 6.4))
    first, second = regress(leaning, *RECOMMENDED), regress(shifted, *RECOMMENDED)
    starts = [[p.start for p in found.perturbations] for found in (first, second)]
    assert np.subtract(starts[1], starts[0]).tolist() == [100, 100, 100]
    printed, shifted_printed = regress(leaning, *PRINTED), regress(shifted, *PRINTED)
    assert shifted_printed.mean == pytest.approx(printed.mean, rel=1e-6)
    assert second.mean == pytest.approx(first.mean, rel=1e-6, abs=1e-8)


def test_amplitude_of_the_perturbation_does_not_change_a_linear_joint():
    small = regress(swing(Joint(rest=0.01), peak_m_per_s=0.1), *RECOMMENDED)
    large = regress(swing(Joint(rest=0.01), peak_m_per_s=0.5), *RECOMMENDED)
    assert small.mean == pytest.approx(large.mean, rel=1e-4, abs=1e-7)


def test_skew_between_angle_and_position_moves_damping_and_hardly_anything_else(upright):
    found = regress(upright, *RECOMMENDED)
    motion = upright.motion
    # recorded a millisecond late: y(t - 1 ms) beside theta(t)
    late = CubicSpline(motion.time, motion.y_dd)(np.maximum(motion.time - 0.001, motion.time[0]))
    skewed = regress(upright, *RECOMMENDED, motion=replace(motion, y_dd=late))
    change = (skewed.mean - found.mean) / [0.107, 0.1, 10.0]
    assert change[1] > 0.3
    slope = damping_per_com_lag(motion, LEG, found.perturbations, motion.time < 1.9, "leg")
    assert skewed.mean[1] - found.mean[1] == pytest.approx(1e-3 * slope, rel=0.05)
    assert abs(change[0]) < 0.01
    assert abs(change[2]) < 0.01


def test_damping_per_com_lag_is_the_projection_of_the_jerk_on_the_angular_rate(upright):
    motion = upright.motion
    found = regress(upright, *RECOMMENDED)
    slope = damping_per_com_lag(motion, LEG, found.perturbations, motion.time < 1.9, "leg")
    # m r y''' of the leg is minus the rate of I_l th'' + B th' + (K - m g r) th
    theta_ddd = derivative(motion.time, motion.theta_dd)
    rate = -0.027 * theta_ddd - 0.1 * motion.theta_dd - (10.0 - WEIGHT) * motion.theta_d
    expected = [
        least_squares_line(found.regressors[p.start : p.stop], rate[p.start : p.stop]).parameters[1]
        for p in found.perturbations
    ]
    assert slope == pytest.approx(np.mean(expected), rel=0.02)
    assert slope > 40.0


def with_markers(moved, layout):
    """Positions of markers that ride on the leg, one of them on the belt."""
    theta, ankle = moved.motion.theta, moved.belt_position
    positions = np.zeros((theta.size, len(layout) + 1, 3))
    positions[:, 0, 1] = ankle
    for k, (across, along) in enumerate(layout, start=1):
        positions[:, k, 1] = ankle + across * np.cos(theta) + along * np.sin(theta)
        positions[:, k, 2] = 0.055 - across * np.sin(theta) + along * np.cos(theta)
    return positions


LAYOUT = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.63], [-0.012, 0.15]])
LABELS = ["foot", "ankle", "top", "middle", "low"]
ON_LEG = SegmentMarkers(("ankle", "top", "middle", "low"), LAYOUT)


def motion_from(positions, labels=LABELS, cutoff_hz=40.0):
    time = np.arange(positions.shape[0]) / RATE_HZ
    return segment_motion(time, positions, ON_LEG, 0.4485, labels=labels, cutoff_hz=cutoff_hz)


def test_markers_on_the_leg_give_its_motion_back(upright):
    motion, truth = motion_from(with_markers(upright, LAYOUT), cutoff_hz=120.0), upright.motion
    assert motion.marker_residual_rms_m < 1e-5
    for name in ("theta", "theta_d", "theta_dd", "y_dd"):
        expected = getattr(truth, name)[100:-100]
        error = getattr(motion, name)[100:-100] - expected
        assert np.std(error) < 0.005 * np.std(expected), name


def test_parameters_survive_the_filter_because_all_signals_go_through_it(upright):
    motion = motion_from(with_markers(upright, LAYOUT), cutoff_hz=20.0)
    found = regress(upright, *RECOMMENDED, motion=motion)
    assert found.mean == pytest.approx([0.0, 0.1, 10.0], rel=0.01, abs=2e-4)


def test_markers_in_another_order_in_the_file_give_the_same_motion(upright):
    positions = with_markers(upright, LAYOUT)
    turned = motion_from(positions[:, ::-1], LABELS[::-1])
    assert turned.theta == pytest.approx(motion_from(positions).theta, abs=1e-15)


def test_marker_that_is_not_recorded_is_named(upright):
    positions = with_markers(upright, LAYOUT)[:, :4]
    with pytest.raises(InputError) as caught:
        motion_from(positions, LABELS[:4])
    assert_one_sentence(caught.value, "'low'", "foot, ankle, top, middle")


def test_markers_that_do_not_ride_on_one_body_are_refused(upright):
    positions = with_markers(upright, LAYOUT)
    positions[:, [2, 4]] = positions[:, [4, 2]]
    with pytest.raises(InputError) as caught:
        motion_from(positions)
    assert_one_sentence(caught.value, "rigid body")


def test_leg_that_does_not_move_does_not_determine_the_parameters(upright):
    still = np.zeros_like(upright.motion.theta)
    motion = replace(upright.motion, theta=still, theta_d=still, theta_dd=still)
    with pytest.raises(InputError) as caught:
        regress(upright, *RECOMMENDED, motion=motion)
    assert_one_sentence(caught.value, "I, B, K")


def test_unknown_torque_is_refused(upright):
    with pytest.raises(InputError) as caught:
        regress(upright, "legg")
    assert_one_sentence(caught.value, "'leg', 'leg-thesis'", "'legg'")


def test_interval_over_noisy_perturbations_covers_the_joint(rng):
    moved = swing(Joint(rest=0.01), onsets_s=tuple(np.arange(2.0, 14.0)), duration_s=16.0)
    truth, covered, repeats = np.array([0.0, 0.1, 10.0]), np.zeros(3), 60
    for _ in range(repeats):
        noisy = moved.motion.y_dd + 0.05 * rng.standard_normal(moved.motion.time.size)
        found = regress(moved, *RECOMMENDED, motion=replace(moved.motion, y_dd=noisy))
        assert found.parameters[:, 2].std() > 0.01
        interval = bootstrap_mean(found.parameters, 400, rng)
        covered += (interval.low <= truth) & (truth <= interval.high)
    assert (covered >= 0.85 * repeats).all()


# ---- noise in the regressors -----------------------------------------------------------------------

TRUTH = np.array([0.01, 0.1, 10.0])


def noisy_pulses(signs, noise_rad, seed, of_markers=False):
    """Fit of equal responses, in either direction, with noise of the angle (rad).

    The torque is exact, or has the noise of the angle, as a torque that comes from the same markers.
    """
    onsets = np.arange(1, len(signs) + 1)
    time = np.arange(round((len(signs) + 1) * RATE_HZ)) / RATE_HZ
    shapes = np.exp(-(((time - onsets[:, None] - 0.1) / 0.03) ** 2))
    exact = 0.02 * np.array(signs) @ shapes
    noise = noise_rad * np.random.default_rng(seed).standard_normal(time.size)
    noise = butterworth_lowpass(noise, RATE_HZ, 20.0, 4)

    def columns(angle):
        rate = derivative(time, angle)
        return np.column_stack([derivative(time, rate), rate, angle])

    torque = columns(exact) @ TRUTH
    if of_markers:
        torque = torque + columns(noise) @ (-0.1, 0.0, 1.0)
    acceleration, rate, angle = columns(exact + noise).T
    found = [Perturbation(round(t * RATE_HZ), round((t + 0.25) * RATE_HZ), 0.3) for t in onsets]
    return regress_torque(JointMotion(time, angle, rate, acceleration), torque, found, time < 0.8)


@pytest.mark.parametrize("of_markers", [False, True])
@pytest.mark.parametrize("signs", [(1.0,) * 10, (1.0, -1.0) * 5])
def test_noise_does_not_bias_perturbations_that_repeat_each_other(signs, of_markers):
    fits = [noisy_pulses(signs, 2e-3, seed, of_markers) for seed in range(20)]
    means = np.array([fit.mean for fit in fits]) / TRUTH
    error = means.std(axis=0, ddof=1) / np.sqrt(len(fits))
    assert all(fit.crossed for fit in fits)
    assert (np.abs(means.mean(axis=0) - 1.0) < 3.5 * error + 0.002).all()


def test_noise_attenuates_perturbations_that_are_too_few():
    fits = [noisy_pulses((1.0, 1.0), 2e-3, seed) for seed in range(20)]
    assert not any(fit.crossed for fit in fits)
    assert np.mean([fit.mean for fit in fits], axis=0)[0] < 0.9 * TRUTH[0]


def test_perturbations_that_do_not_repeat_are_fitted_one_by_one(rng):
    time = np.arange(4000) / RATE_HZ
    angle = butterworth_lowpass(rng.standard_normal(time.size), RATE_HZ, 10.0, 4)
    rate = derivative(time, angle)
    acceleration = derivative(time, rate)
    torque = np.column_stack([acceleration, rate, angle]) @ TRUTH
    found = [Perturbation(start, start + 200, 0.3) for start in range(500, 3500, 250)]
    fit = regress_torque(JointMotion(time, angle, rate, acceleration), torque, found, time < 1.0)
    assert not fit.crossed
    alone = least_squares_line(fit.regressors[500:700], fit.torque[500:700])
    assert fit.parameters[0] == pytest.approx(alone.parameters)


def test_pseudo_values_scatter_as_the_estimates_do():
    fits = [noisy_pulses((1.0,) * 8, 1e-3, seed) for seed in range(60)]
    errors = [fit.parameters.std(axis=0, ddof=1) / np.sqrt(8.0) for fit in fits]
    means = np.array([fit.mean for fit in fits])
    assert np.sqrt(np.mean(np.square(errors), axis=0)) == pytest.approx(means.std(axis=0, ddof=1), rel=0.3)
