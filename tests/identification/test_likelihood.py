"""The joint likelihood gives the joint back from markers and log, and its intervals cover it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import LEG, RATE_HZ, Joint, assert_one_sentence, belt_pulses, scaled_leg, swing
from scipy.interpolate import CubicSpline

from tepsipe import fit_joint_likelihood
from tepsipe.errors import InputError
from tepsipe.identification.estimators import Record, estimate
from tepsipe.identification.likelihood.channels import DummyMarkers, dummy_markers
from tepsipe.identification.likelihood.likelihood import Point, maximise_likelihood
from tepsipe.identification.likelihood.result import _law_forces, innovations
from tepsipe.mechanics.rubber_joint import RubberJoint
from tepsipe.mechanics.rubber_joint import swing as rubber_swing
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, segment_motion
from tepsipe.signals.perturbations import WindowOptions, filtered_perturbations

WINDOW = WindowOptions(
    rest_before_s=2.0,
    rest_after_s=1.0,
    rest_margin_s=0.1,
    threshold_fraction=0.05,
    signal_to_noise=5.0,
    merge_s=0.06,
)
ON_LEG = SegmentMarkers(("ankle", "a", "b", "c"), [[0.0, 0.0], [-0.012, 0.87], [0.012, 0.6], [-0.01, 0.3]])
FOOT = ("foot1", "foot2", "ankle")
LABELS = [*FOOT, *ON_LEG.labels[1:]]
OWN = LEG.inertia_kgm2 + LEG.mass_kg * LEG.com_m**2
MANY_S = tuple(np.arange(2.0, 26.0, 3.0))


def markers_of(theta, foot, noise_m=0.0, rng=None):
    """Markers of a leg at theta (rad) on a foot (m), with white noise."""
    layout = np.vstack([np.zeros((2, 2)), ON_LEG.layout_m])
    across, along = layout.T
    y = foot[:, None] + np.outer(np.cos(theta), across) + np.outer(np.sin(theta), along)
    z = np.outer(np.cos(theta), along) - np.outer(np.sin(theta), across)
    positions = np.stack([y, z], axis=2)
    if noise_m:
        positions = positions + noise_m * rng.standard_normal(positions.shape)
    return dummy_markers(positions, LABELS, ON_LEG, FOOT)


def fit(moved, markers=None, log="log", leg=LEG, softening=False):
    markers = markers_of(moved.motion.theta, moved.belt_position) if markers is None else markers
    log = moved.belt_velocity if isinstance(log, str) else log
    return maximise_likelihood(
        moved.motion.time, markers, log, leg, moved.motion.time < 1.9, softening=softening
    )


def values(found):
    return [found.value("J") - found.model.leg_inertia, found.value("B"), found.value("K")]


@pytest.fixture(scope="module")
def still():
    return swing(Joint(rest=0.01))


@pytest.fixture(scope="module")
def small():
    return swing(Joint(inertia=0.007, rest=0.005), MANY_S, 0.1, 28.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("inertia", "damping", "stiffness", "rest", "peak"),
    [
        (0.0, 0.1, 10.0, 0.0, 0.3),
        (0.0, 0.02, 15.0, 0.02, 0.5),
        (0.015, 0.2, 8.0, -0.01, 0.1),
        (0.0, 1.5, 30.0, 0.0, 0.3),
        (0.0, 4.0, 10.0, 0.0, 0.3),
    ],
)
def test_exact_markers_give_the_joint_back_even_while_the_leg_still_rings(
    inertia, damping, stiffness, rest, peak
):
    found = fit(swing(Joint(inertia, damping, stiffness, rest), peak_m_per_s=peak))
    assert values(found) == pytest.approx([inertia, damping, stiffness], rel=2e-4, abs=1e-5)
    assert found.value("delay") == pytest.approx(0.0, abs=1e-6)


def test_net_displacement_and_a_missing_log_do_not_matter(still):
    time = still.motion.time
    drift = 0.05 * np.sin(0.5 * np.pi * time / time[-1]) ** 2
    moved = markers_of(still.motion.theta, still.belt_position)
    assert values(fit(still, log=None)) == pytest.approx(values(fit(still)), rel=1e-4, abs=1e-6)
    away = replace(moved, positions=moved.positions + drift[:, None, None] * [1.0, 0.0])
    log = still.belt_velocity + CubicSpline(time, drift)(time, 1)
    # the belt that creeps pushes the leg by m r y'', which is 1e-5 of a pulse here
    assert values(fit(still, away, log)) == pytest.approx(values(fit(still)), rel=1e-2, abs=1e-3)


def test_derivatives_are_those_of_the_model(still):
    found = fit(still, softening=True)
    names = (*found.point.names[:12], "log_phi_h")
    point = Point(names, found.point.values | {"C": 1.0, "B_s": 0.05, "delay": 2e-4, "lag": 1e-4})
    model, foot = found.model, found.residuals.foot
    at = model.spectra(point)
    for k, name in enumerate(names):
        if name in ("J", "B", "K", "c_1", "c_2"):
            continue  # of the free swing they are those of the equation, up to another free swing
        step = 1e-6 * max(1.0, abs(point.values[name])) * np.eye(len(names))[k]
        ahead, behind = model.spectra(point.moved(step)), model.spectra(point.moved(-step))
        expected = ((ahead.response - behind.response) * foot + ahead.independent - behind.independent) / (
            2.0 * step[k]
        )
        slope = at.response_slopes[k] * foot + at.independent_slopes[k]
        assert np.abs(slope - expected).max() < 1e-4 * np.abs(expected).max(), name


@pytest.mark.slow
def test_derivatives_of_the_softening_law_are_those_of_its_torque(small):
    found = fit(small, softening=True)
    law = {"C": 3.0, "B_s": 0.05, "log_phi_h": float(np.log(0.02)), "b_0": 0.005}
    point = Point(found.point.names, found.point.values | law)

    def torque(values):
        moved = replace(found, point=replace(point, values=point.values | values))
        return sum(moved.value(name) * _law_forces(moved)[name] for name in ("C", "B_s"))

    slopes = _law_forces(replace(found, point=point))
    for name, value in law.items():
        step = 1e-6 * value
        slope = (torque({name: value + step}) - torque({name: value - step})) / (2.0 * step)
        assert np.abs(slopes[name] - slope).max() < 1e-5 * np.abs(slope).max(), name


def test_a_leg_taken_twice_as_heavy_doubles_every_parameter(small, rng):
    noisy = markers_of(small.motion.theta, small.belt_position, 1e-4, rng)
    log = small.belt_velocity + 5e-4 * rng.standard_normal(small.belt_velocity.size)
    one, two = (fit(small, noisy, log, leg) for leg in (LEG, scaled_leg(LEG, 2.0)))
    assert values(two) == pytest.approx(2.0 * np.array(values(one)), rel=1e-3, abs=1e-6)
    assert two.standard_error("K") == pytest.approx(2.0 * one.standard_error("K"), rel=1e-3)


def test_delay_lag_and_gain_are_found_and_leave_the_joint_alone(still):
    later = markers_of(np.roll(still.motion.theta, 1), still.belt_position)
    found, plain = fit(still, later, 0.9 * np.roll(still.belt_velocity, 1)), fit(still)
    assert found.value("delay") == pytest.approx(1.0 / RATE_HZ, abs=1e-5)
    assert found.value("lag") == pytest.approx(1.0 / RATE_HZ, abs=1e-5)
    assert found.value("gain") == pytest.approx(0.9, rel=1e-3)
    assert values(found) == pytest.approx(values(plain), rel=1e-3, abs=2e-5)


@pytest.mark.slow
@pytest.mark.parametrize("noise_m", [1e-5, 1e-4])
def test_noise_is_measured_and_intervals_cover_the_joint(small, rng, noise_m):
    truth, draws, scaled = np.array([0.007, 0.1, 10.0]), 16, []
    for _ in range(draws):
        markers = markers_of(small.motion.theta, small.belt_position, noise_m, rng)
        found = fit(small, markers, small.belt_velocity + 5e-4 * rng.standard_normal(small.motion.time.size))
        errors = [found.standard_error(name) for name in "JBK"]
        scaled.append((values(found) - truth) / errors)
        assert found.channels.marker_noise_m == pytest.approx(noise_m, rel=0.1)
        assert found.log_noise_m_per_s == pytest.approx(5e-4, rel=0.3)
        assert innovations(found).var(axis=1) == pytest.approx(1.0, abs=0.25)
    scaled = np.array(scaled)
    assert (np.abs(scaled.mean(axis=0)) < 3.5 / np.sqrt(draws)).all()
    assert scaled.std(axis=0) == pytest.approx(1.0, abs=0.5)


def test_hidden_samples_are_replaced_by_what_the_others_say(still):
    exact = markers_of(still.motion.theta, still.belt_position)
    hidden = np.zeros(exact.positions.shape[:2], dtype=bool)
    hidden[520:540, 3] = hidden[1030:1040, 0] = True
    spoiled = exact.positions.copy()
    spoiled[hidden] += 0.003
    found = fit(still, DummyMarkers(spoiled, exact.layout_m, exact.on_foot, hidden))
    assert values(found) == pytest.approx(values(fit(still)), rel=1e-3, abs=1e-4)
    assert abs(values(fit(still, replace(exact, positions=spoiled)))[2] - 10.0) > 0.01


# ---- a joint that softens ------------------------------------------------------------------------

RUBBER = RubberJoint(
    stiffness_Nm_per_rad=10.0,
    half_softening_rad=0.025,
    damping_Nms_per_rad=0.06,
    softened_damping_Nms_per_rad=0.1,
    inertia_Nms2_per_rad=0.007,
)


@cache
def rubber_motion(joint, peak_m_per_s):
    """Instants (s), angle (rad), position (m) and velocity (m/s) of the belt."""
    halves = np.arange(2 * round(28.0 * RATE_HZ) - 1) / (2.0 * RATE_HZ)
    position, velocity, acceleration = belt_pulses(halves, MANY_S, peak_m_per_s)
    theta = rubber_swing(LEG, [joint], acceleration[None], 1.0 / RATE_HZ)[0][0, 0]
    return halves[::2], theta, position[::2], velocity[::2]


def rubber_record(joint, peak_m_per_s, rng=None):
    """Record of a softening joint, and the linear joint nearest to its torque in the windows."""
    time, theta, position, velocity = rubber_motion(joint, peak_m_per_s)
    noise = 0.0 if rng is None else 1e-5
    markers = markers_of(theta, position, noise, rng)
    windows = filtered_perturbations(velocity, RATE_HZ, WINDOW, "belt")
    spline = CubicSpline(time, theta)
    rate, acceleration = spline(time, 1), spline(time, 2)
    share = theta**2 / (theta**2 + joint.half_softening_rad**2)
    torque = (
        joint.stiffness_Nm_per_rad * theta * (1.0 - 0.5 * share) + joint.inertia_Nms2_per_rad * acceleration
    )
    torque += (joint.damping_Nms_per_rad + joint.softened_damping_Nms_per_rad * share) * rate
    columns = np.column_stack([acceleration, rate, theta])
    each = []
    for p in windows:
        weight = np.ones((p.stop - p.start, 1))
        weight[[0, -1]] = np.sqrt(0.5)
        own = slice(p.start, p.stop)
        each.append(np.linalg.lstsq(weight * columns[own], weight[:, 0] * torque[own], rcond=None)[0])
    motion = segment_motion(time, markers.positions[:, 2:], ON_LEG, LEG.com_m)
    log = velocity + (0.0 if rng is None else 5e-4 * rng.standard_normal(time.size))
    record = Record(
        motion=motion, markers=markers, belt_log=log, leg=LEG, perturbations=windows, at_rest=time < 1.9
    )
    return record, np.mean(each, axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("peak", [0.2, 0.4])
def test_a_joint_that_softens_has_constants_of_small_and_of_working_movements(peak):
    record, at_work = rubber_record(RUBBER, peak)
    found = estimate("joint-likelihood", record)
    assert found.small == pytest.approx([0.007, 0.06, 10.0], rel=2e-3)
    assert found.mean == pytest.approx(at_work, rel=3e-3)
    assert found.softening == pytest.approx([5.0, 0.1, 0.025], rel=0.02)
    assert at_work[2] < 9.8
    assert found.vaf_angle > 99.99
    linear = estimate("joint-likelihood-linear", record)
    assert linear.softening is None
    assert abs(linear.mean[2] - at_work[2]) > 10.0 * abs(found.mean[2] - at_work[2])


@pytest.mark.slow
def test_intervals_hold_at_both_amplitudes_and_the_intervals_contribute(rng):
    inside, draws = np.zeros(6), 8
    for _ in range(draws):
        record, at_work = rubber_record(RUBBER, 0.3, rng)
        found = estimate("joint-likelihood", record)
        for k, (own, truth) in enumerate(
            [(found.interval(), at_work), (found.small_interval(), [0.007, 0.06, 10.0])]
        ):
            inside[3 * k : 3 * k + 3] += (own.low <= truth) & (truth <= own.high)
    assert (inside >= 0.7 * draws).all()
    assert found.parameters.shape == (len(MANY_S), 3)
    spread = found.parameters.std(axis=0, ddof=1) / np.sqrt(len(MANY_S))
    assert spread == pytest.approx(found.interval().standard_error, rel=1.0)


def test_noise_in_the_angle_does_not_bias_the_terms_of_softening(rng):
    record, at_work = rubber_record(RUBBER, 0.3)
    found, exact = [], record.markers.positions
    for _ in range(3):
        noise = 3e-4 * rng.standard_normal(exact.shape)
        # noise of both signs: what is left of the mean error is its part of second order, the bias
        for sign in (1.0, -1.0):
            markers = replace(record.markers, positions=exact + sign * noise)
            found.append(estimate("joint-likelihood", replace(record, markers=markers)))
    errors = np.mean([fit.interval().standard_error for fit in found], axis=0)
    bias = np.mean([fit.mean for fit in found], axis=0) - at_work
    # from the measured angle, I would be 0.7 and K 4 standard errors too low
    assert (np.abs(bias) < 0.25 * errors).all()


@pytest.mark.slow
def test_public_function_gives_both_amplitudes(rng):
    record, at_work = rubber_record(RUBBER, 0.4, rng)
    found = fit_joint_likelihood(
        record.motion.time,
        record.markers.positions,
        ON_LEG,
        LEG,
        labels=LABELS,
        belt_fixed=FOOT,
        perturbations=record.perturbations,
        belt_velocity=record.belt_log,
    )
    assert found.estimator == "joint-likelihood"
    assert found.parameters == pytest.approx(at_work, rel=0.01)
    assert found.quantities["K_small"].value == pytest.approx(10.0, rel=0.01)
    assert found.quantities["delay"].standard_error < 1e-4
    assert found.quantities["K_softened"].low > 0.0
    assert "K" in found.summary()


# ---- what it refuses -----------------------------------------------------------------------------


@pytest.mark.parametrize("still_part", ["foot", "leg", "log"])
def test_what_stands_still_is_refused(still, still_part):
    motion = np.zeros_like(still.motion.theta)
    markers = markers_of(
        motion if still_part == "leg" else still.motion.theta,
        motion if still_part == "foot" else still.belt_position,
    )
    with pytest.raises(InputError) as caught:
        fit(still, markers, motion if still_part == "log" else still.belt_velocity)
    assert_one_sentence(caught.value, "stands still")


def test_unknown_markers_are_refused(still):
    positions = markers_of(still.motion.theta, still.belt_position).positions
    with pytest.raises(InputError) as caught:
        dummy_markers(positions, LABELS, ON_LEG, ("foot1", "toe"))
    assert_one_sentence(caught.value, "toe")
