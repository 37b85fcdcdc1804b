"""Output error gives the joint back from the foot's motion and the angle, and its intervals cover it."""

from dataclasses import replace

import numpy as np
import pytest
from builders import LEG, RATE_HZ, Joint, assert_one_sentence, scaled_leg, swing
from scipy.interpolate import CubicSpline

from tepsipe.errors import InputError
from tepsipe.identification.budgets.leg import changed_motion
from tepsipe.identification.notes import of_belt
from tepsipe.identification.regression.output_error import match_angle, simulate_leg
from tepsipe.mechanics.rubber_joint import RubberJoint
from tepsipe.mechanics.rubber_joint import swing as rubber_swing
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.perturbations import WindowOptions, filtered_perturbations
from tepsipe.statistics.bootstrap import bootstrap_mean

WINDOW = WindowOptions(
    rest_before_s=2.0,
    rest_after_s=1.0,
    rest_margin_s=0.1,
    threshold_fraction=0.05,
    signal_to_noise=5.0,
    merge_s=0.06,
)
MANY_S = tuple(np.arange(2.0, 34.0, 4.0))  # the leg rings for 2 s: intervals must be longer


def fit(moved, motion=None, foot=None, belt=None, leg=LEG, source="instruments"):
    motion = moved.motion if motion is None else motion
    found = filtered_perturbations(moved.belt_velocity, RATE_HZ, WINDOW, "belt")
    foot = moved.belt_position if foot is None else foot
    belt = moved.belt_velocity if belt is None else belt
    return match_angle(motion, foot, belt, leg, found, motion.time < 1.9, source)


def values(found):
    return found.mean


@pytest.fixture(scope="module")
def still():
    return swing(Joint(rest=0.01))


@pytest.fixture(scope="module")
def fitted(still):
    """What the exact motion gives, which must not change with what does not matter."""
    return fit(still)


@pytest.fixture(scope="module")
def small():
    return swing(Joint(rest=0.005), MANY_S, 0.1, 36.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("inertia", "damping", "stiffness", "rest", "peak"),
    [
        (0.0, 0.1, 10.0, 0.0, 0.3),
        (0.0, 0.03, 15.0, 0.02, 0.5),
        (0.015, 0.2, 8.0, -0.01, 0.1),
        (0.0, 0.5, 30.0, 0.0, 0.3),
        (0.0, 0.05, 4.0, 0.0, 0.1),
    ],
)
@pytest.mark.parametrize("source", ["instruments", "markers", "belt"])
def test_exact_motion_gives_the_joint_back(inertia, damping, stiffness, rest, peak, source):
    found = fit(swing(Joint(inertia, damping, stiffness, rest), peak_m_per_s=peak), source=source)
    assert values(found) == pytest.approx([inertia, damping, stiffness], rel=1e-3, abs=2e-5)
    assert found.theta_0_rad == pytest.approx(rest, abs=1e-6)
    assert found.delay_s == pytest.approx(0.0, abs=2e-6)
    assert found.vaf_angle > 99.999
    assert found.vaf_trial > 99.99


def test_sensitivities_are_the_derivatives_of_the_angle(still):
    motion = still.motion
    about = np.array([LEG.inertia_kgm2 + LEG.mass_kg * LEG.com_m**2, 0.1, 10.0, 0.01, 0.0004])
    given = (LEG, motion.time, motion.theta, still.belt_acceleration)
    slopes = simulate_leg(about, *given)[1]
    for k, step in enumerate([1e-5, 1e-4, 1e-3, 1e-5, 1e-5]):
        moved = step * np.eye(5)[k]
        expected = (
            (simulate_leg(about + moved, *given)[0] - simulate_leg(about - moved, *given)[0]) / 2 / step
        )
        assert np.abs(slopes[:, k] - expected).max() < 0.01 * np.abs(expected).max(), k


def test_delay_of_the_leg_after_the_foot_is_found_and_leaves_the_joint_alone(still, fitted):
    # both signals are moved by whole samples, so nothing is interpolated
    motion = still.motion
    shifted = replace(motion, theta=np.roll(motion.theta, 1))
    found = fit(still, shifted)
    assert found.delay_s - fitted.delay_s == pytest.approx(1.0 / RATE_HZ, abs=1e-5)
    assert values(found) == pytest.approx(values(fitted), rel=1e-3, abs=2e-5)


def test_perturbations_that_start_later_give_the_same_joint(fitted):
    later = swing(Joint(rest=0.01), onsets_s=(2.4, 4.4, 6.4))
    assert values(fit(later)) == pytest.approx(values(fitted), rel=1e-4, abs=1e-5)


def test_a_leg_taken_twice_as_heavy_doubles_every_parameter(still, fitted):
    doubled = fit(still, leg=scaled_leg(LEG, 2.0))
    # joint and leg are told apart by the leg's inertia, which is taken off: I was 0
    assert values(doubled) == pytest.approx(2.0 * values(fitted), rel=1e-6, abs=1e-8)


def test_scale_offset_and_delay_of_the_belts_velocity_do_not_matter(still, fitted):
    belt = 0.9 * np.roll(still.belt_velocity, 1) + 0.02
    assert values(fit(still, belt=belt)) == pytest.approx(values(fitted), rel=1e-3, abs=3e-5)
    biased = fit(still, belt=0.9 * still.belt_velocity, source="belt")
    assert abs(values(biased)[2] - 10.0) > 0.3


def noisy_fit(moved, rng, source, foot_m=5e-5, angle_rad=1.5e-4, belt_m_per_s=5e-4):
    """A fit with white noise on foot, angle and belt before their common filter."""

    def measured(x, noise):
        return butterworth_lowpass(x + noise * rng.standard_normal(x.size), RATE_HZ, 20.0)

    motion = replace(moved.motion, theta=measured(moved.motion.theta, angle_rad))
    foot, belt = measured(moved.belt_position, foot_m), measured(moved.belt_velocity, belt_m_per_s)
    return fit(moved, motion, foot, belt, source=source)


@pytest.mark.slow
def test_noise_does_not_bias_the_joint_and_intervals_cover_it(small, rng):
    truth, draws = np.array([0.0, 0.1, 10.0]), 20
    found = np.empty((draws, 3))
    covered = np.zeros(3)
    errors = np.empty((draws, 3))
    for k in range(draws):
        regression = noisy_fit(small, rng, "instruments")
        interval = bootstrap_mean(regression.parameters, 500, rng)
        found[k], errors[k] = regression.mean, interval.standard_error
        covered += (interval.low <= truth) & (truth <= interval.high)
    monte_carlo = found.std(axis=0, ddof=1) / np.sqrt(draws)
    assert (np.abs(found.mean(axis=0) - truth) < 3.5 * monte_carlo + [2e-5, 2e-4, 0.005]).all()
    assert monte_carlo[2] < 0.04
    assert errors.mean(axis=0) == pytest.approx(found.std(axis=0, ddof=1), rel=0.4)
    assert (covered >= 0.8 * draws).all()


@pytest.mark.slow
def test_noise_of_the_foot_biases_least_squares_but_not_instruments(small, rng):
    stiffness = {
        source: np.mean([values(noisy_fit(small, rng, source, foot_m=3e-4))[2] for _ in range(4)])
        for source in ("markers", "instruments")
    }
    assert stiffness["markers"] > 10.1
    assert abs(stiffness["instruments"] - 10.0) < 0.5 * abs(stiffness["markers"] - 10.0)


@pytest.mark.slow
def test_every_interval_contributes_and_the_same_noise_gives_the_same(small):
    again, same = (noisy_fit(small, np.random.default_rng(5), "instruments") for _ in range(2))
    assert len(again.fits) == len(MANY_S)
    assert again.parameters.shape == (len(MANY_S), 3)
    assert np.isnan([fit.sem_as_printed for fit in again.fits]).all()
    # nothing of the contributions is left over: they are all steps from one estimate
    assert again.parameters.tolist() == same.parameters.tolist()


@pytest.mark.parametrize(("signal", "word"), [("foot", "belt-fixed markers"), ("belt", "perturbed")])
def test_foot_or_belt_that_stands_still_is_refused(still, signal, word):
    with pytest.raises(InputError) as caught:
        fit(still, **{signal: np.zeros(still.motion.time.size)})
    assert_one_sentence(caught.value, word)


def test_angle_that_has_nothing_to_do_with_the_foot_is_refused(still, rng):
    noise = 1e-3 * rng.standard_normal(still.motion.time.size)
    with pytest.raises(InputError) as caught:
        fit(still, replace(still.motion, theta=noise))
    assert_one_sentence(caught.value, "I, B, K", "parameters at the bounds")


# ---- a joint that softens ------------------------------------------------------------------------


def softening_swing(joint, peak_m_per_s, onsets_s=(2.0, 4.0, 6.0), duration_s=10.0):
    """As `swing`, with a joint that softens; integrated by a Runge-Kutta method."""
    linear = swing(Joint(), onsets_s, peak_m_per_s, duration_s)
    halves = np.arange(2 * linear.motion.time.size - 1) / (2.0 * RATE_HZ)
    push = CubicSpline(linear.motion.time, linear.belt_acceleration)(halves)
    theta = rubber_swing(LEG, [joint], push[None], 1.0 / RATE_HZ)[0][0, 0]
    return linear, replace(linear.motion, theta=theta)


RUBBER = RubberJoint(
    stiffness_Nm_per_rad=10.0,
    half_softening_rad=0.025,
    damping_Nms_per_rad=0.06,
    softened_damping_Nms_per_rad=0.1,
    inertia_Nms2_per_rad=0.007,
)


@pytest.mark.slow
@pytest.mark.parametrize("peak", [0.2, 0.4])
def test_a_joint_that_softens_gives_the_constants_of_small_movements(peak):
    linear, motion = softening_swing(RUBBER, peak)
    found = fit(linear, motion)
    assert found.softening is not None
    assert values(found) == pytest.approx([0.007, 0.06, 10.0], rel=0.03, abs=5e-4)
    assert found.vaf_angle > 99.95


@pytest.mark.slow
def test_a_linear_joint_is_not_said_to_soften(fitted, small, rng):
    assert fitted.softening is None or abs(fitted.softening[0]) < 0.05
    assert [noisy_fit(small, rng, "instruments").softening for _ in range(3)] == [None] * 3


def test_axes_that_are_not_level_turn_the_accelerations():
    motion, layout = swing(Joint()).motion, SegmentMarkers(("a", "b"), np.array([[0.0, 0.1], [0.0, 0.8]]))
    found = changed_motion(motion, layout, 0.4, {"vertical_rad": 0.1})
    assert found.theta == pytest.approx(motion.theta + 0.1)
    cosine, sine = np.cos(0.1), np.sin(0.1)
    assert found.y_dd == pytest.approx(cosine * motion.y_dd + sine * motion.z_dd)
    assert found.z_dd == pytest.approx(cosine * motion.z_dd - sine * motion.y_dd)


def test_foot_that_does_not_move_with_the_belt_is_noted_or_refused():
    belt = np.sin(np.arange(200) / 5.0)
    assert of_belt(belt, belt) == ()
    (note,) = of_belt(1.5 * belt, belt)
    assert "1.5 times as fast" in note
    for gain, words in ((-1.0, "opposite sign"), (1000.0, "another unit")):
        with pytest.raises(InputError) as caught:
            of_belt(gain * belt, belt)
        assert_one_sentence(caught.value, words)
