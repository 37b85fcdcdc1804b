"""Formula, filter and noise each do what they should, and the recommended estimator is unbiased."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from builders import LEG, RATE_HZ, assert_one_sentence
from scipy.integrate import solve_ivp

from tepsipe.errors import InputError
from tepsipe.experiments.noise.filtered_noise import (
    PROCESSINGS,
    Processing,
    cell_generators,
    filtered_trial,
    noise_chunks,
    windowed_trial,
)
from tepsipe.experiments.noise.monte_carlo import (
    clipped,
    cross_validated_vaf,
    estimate_draws,
    is_stable,
    predict_angle,
    sweep,
)
from tepsipe.experiments.noise.trial import SimulatedTrial, apparent_impedance
from tepsipe.identification.regression.batched import instrumental_variables, regress_windows
from tepsipe.mechanics.inverse_dynamics import Foot
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.statistics.goodness_of_fit import vaf
from tepsipe.statistics.least_squares import sems

FOOT = Foot(mass_kg=2.1, height_m=0.055)
M, R, I_L, G, M_F, L_F = 0.4, 0.4485, 0.027, 9.81, 2.1, 0.055
WEIGHT = M * G * R  # m g r (Nm/rad)
PULSE_S = 0.1
SERVO = 2.0 * np.pi * 12.0  # of the belt's drive (rad/s)
DAMPING_RATIO = 0.7
SEED = 20140612


def commanded(profile, s):
    """Belt velocity over its amplitude, at a part s of the pulse."""
    if profile == "sine":
        return np.sin(2.0 * np.pi * s)
    half = 2.0 * (s % 0.5)
    return (1.0 if s < 0.5 else -1.0) * 16.0 * half**2 * (1.0 - half) ** 2


def simulated(profile, amplitude, stiffness=10.0, duration_s=70.0, damping=0.1, inertia=0.015):
    """The dummy on a belt with a drive of finite bandwidth, integrated from pulse to pulse."""
    about_ankle = I_L + M * R**2 + inertia
    onsets = np.arange(6.0, duration_s - 8.5, 4.0)
    edges = [0.0, *np.stack([onsets, onsets + PULSE_S], axis=1).ravel(), duration_s]
    time = np.arange(round(duration_s * RATE_HZ)) / RATE_HZ
    states = np.zeros((5, time.size))
    x = np.zeros(5)

    def rate(t, x, start, perturbed):
        th, w, _, v, a = x
        command = amplitude * commanded(profile, (t - start) / PULSE_S) if perturbed else 0.0
        torque = damping * w + stiffness * th
        w_rate = (M * G * R * np.sin(th) - M * R * a * np.cos(th) - torque) / about_ankle
        return w, w_rate, v, a, SERVO**2 * (command - v) - 2.0 * DAMPING_RATIO * SERVO * a

    for k, (start, stop) in enumerate(pairwise(edges)):
        now = (time >= start) & (time < stop)
        solution = solve_ivp(
            rate,
            (start, stop),
            x,
            method="DOP853",
            t_eval=[*time[now], stop],
            rtol=1e-9,
            atol=1e-13,
            args=(start, k % 2),
        )
        states[:, now], x = solution.y[:, :-1], solution.y[:, -1]
    th, w, y, v, a = states
    w_rate = (M * G * R * np.sin(th) - M * R * a * np.cos(th) - damping * w - stiffness * th) / about_ankle
    y_leg_dd = a + R * (np.cos(th) * w_rate - np.sin(th) * w**2)
    z_leg_dd = -R * (np.sin(th) * w_rate + np.cos(th) * w**2)
    y_leg, z_leg = y + R * np.sin(th), L_F + R * np.cos(th)
    # the rate of the angular momentum about the place of rest, and gravity's moment
    m_x = M * (y_leg * z_leg_dd - z_leg * y_leg_dd) - I_L * w_rate - M_F * a * 0.5 * L_F
    m_x += (M_F * y + M * y_leg) * G
    first = np.round(onsets * RATE_HZ).astype(int)
    return SimulatedTrial(
        name=f"{profile}-{amplitude:g}",
        time=time,
        theta=th,
        theta_d=w,
        theta_dd=w_rate,
        y_leg_dd=y_leg_dd,
        z_leg_dd=z_leg_dd,
        y_foot=y,
        y_foot_d=v,
        y_foot_dd=a,
        f_y=M_F * a + M * y_leg_dd,
        f_z=M_F * G + M * (G + z_leg_dd),
        m_x=m_x,
        windows=np.stack([first, first + 35], axis=1),
        leg=LEG,
        foot=FOOT,
        truth=np.array([inertia, damping, stiffness]),
    )


@pytest.fixture(scope="module")
def sine():
    return simulated("sine", 0.3)


@pytest.fixture(scope="module")
def small():
    return simulated("sine", 0.01, duration_s=20.0)


@pytest.fixture(scope="module")
def others():
    return simulated("sine", 0.1, duration_s=20.0), simulated("minjerk", 0.5, duration_s=20.0)


def windowed_of(trial, estimator, noise_on, snr_db):
    return windowed_trial(filtered_trial(trial), PROCESSINGS[estimator], noise_on, snr_db)


def draws_of(trial, processing, noise_on, snr_db, draws, seed=SEED):
    filtered = filtered_trial(trial)
    windowed = windowed_trial(filtered, processing, noise_on, snr_db)
    chunks = noise_chunks(filtered, noise_on, draws, cell_generators(seed, trial.name))
    return estimate_draws([windowed], chunks)[0]


def noisy_signals(windowed, draws, generators):
    """Torque and regressors, both with noise."""
    (chunk,) = noise_chunks(windowed.trial, "both", draws, generators)
    torque = windowed.torque + windowed.torque_noise(chunk["tau"])
    return torque, windowed.regressors + windowed.regressor_noise(chunk["theta"])


def cell_of(trial, noise_on, snr_db, draws, seed=SEED, estimator="recommended", others=()):
    others = [filtered_trial(other) for other in others]
    return sweep(filtered_trial(trial), noise_on, snr_db, draws, seed, [estimator], others)[0]


# ---- without noise -----------------------------------------------------------------------------


@pytest.mark.slow
def test_foot_and_leg_feel_the_torque_of_the_joint(sine):
    joint = sine.truth @ sine.regressors
    assert np.ptp(joint) > 0.4
    assert sine.torque("leg") == pytest.approx(joint, abs=1e-10)
    assert sine.torque("foot") == pytest.approx(joint, abs=1e-10)


@pytest.mark.parametrize("estimator", ["recommended", "recommended-regression"])
def test_joint_comes_back_without_noise(estimator, sine, others):
    stiffer = simulated("minjerk", 0.2, stiffness=15.0, duration_s=20.0)
    for trial in (sine, *others, stiffer):
        cell = cell_of(trial, "none", np.inf, 200, SEED, estimator)
        assert cell.n_draws == 1
        assert cell.mean == pytest.approx(trial.truth, rel=1e-6)
        assert cell.vaf_perturbation == pytest.approx(100.0, abs=1e-9)
        assert cell.vaf_trial == pytest.approx(100.0, abs=1e-9)
        assert cell.vaf_theta_trial == pytest.approx(100.0, abs=0.02)


@pytest.mark.parametrize(
    ("stiffness", "expected"), [(10.0, [0.0446, 0.0445, 3.66]), (15.0, [0.0446, 0.0445, 5.89])]
)
def test_printed_equation_shows_the_apparent_impedance_and_a_perfect_fit(stiffness, expected):
    trial = simulated("sine", 0.01, stiffness=stiffness, duration_s=20.0)
    cell = cell_of(trial, "none", np.inf, 1, SEED, "as-printed")
    assert cell.apparent == pytest.approx(expected, rel=2e-3)
    assert cell.mean == pytest.approx(cell.apparent, rel=1e-4)
    assert cell.vaf_perturbation == pytest.approx(100.0, abs=1e-6)
    assert cell.vaf_theta_trial < 50.0


def test_apparent_impedance_is_linear_in_the_joint():
    joints = np.array([[0.0, 0.0, WEIGHT], [0.015, 0.1, 10.0]])
    bare, dummy = (apparent_impedance(LEG, FOOT, joint) for joint in joints)
    # a joint that just carries the leg shows no stiffness, one without damping no damping
    assert bare[1:] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert dummy[2] / dummy[1] == pytest.approx((10.0 - WEIGHT) / 0.1)


def test_unequal_filters_bias_and_equal_ones_do_not(sine):
    unequal = Processing("leg", "windowed-least-squares", "noisy")

    def limit(noise_on):  # of ever less noise
        return draws_of(sine, unequal, noise_on, 200.0, 1)[0][0]

    torque_only, motion_only = limit("tau"), limit("theta")
    assert torque_only[[0, 2]] == pytest.approx([0.0136, 7.9], rel=0.06)
    assert motion_only[[0, 2]] == pytest.approx([0.0164, 12.0], rel=0.06)
    assert limit("both") == pytest.approx(sine.truth, rel=1e-6)


# ---- noise -------------------------------------------------------------------------------------


def test_noise_around_the_windows_is_that_of_the_whole_trial_filtered_and_differentiated(sine, rng):
    unit = rng.standard_normal((1, sine.time.size))
    windowed = windowed_of(sine, "recommended", "both", 20.0)
    around = unit[:, windowed.trial.noise_samples]
    assert around.size < 0.2 * sine.time.size
    filtered = butterworth_lowpass(unit[0], RATE_HZ, 20.0)
    rate = derivative(sine.time, filtered)
    expected = np.stack([derivative(sine.time, rate), rate, filtered])
    found = windowed.regressor_noise(windowed.trial.differentiated_noise(around))[0]
    torque = windowed.torque_noise(windowed.trial.filtered_noise(around))[0]
    for k, (start, stop) in enumerate(sine.windows):
        part = 0.1 * np.sqrt(np.mean(sine.theta**2)) * expected[:, start:stop]
        scale = np.abs(part).max(axis=1, keepdims=True)
        assert found[k] / scale == pytest.approx(part / scale, abs=1e-8)
        power = np.mean(sine.torque("leg") ** 2)
        assert torque[k] == pytest.approx(0.1 * np.sqrt(power) * filtered[start:stop], abs=1e-9)


def test_noisy_signals_are_those_that_a_user_would_filter_and_differentiate(others, rng):
    trial = others[1]
    noise = 0.1 * np.sqrt(np.mean(trial.theta**2)) * rng.standard_normal(trial.time.size)
    angle = butterworth_lowpass(trial.theta + noise, RATE_HZ, 20.0)
    rate = derivative(trial.time, angle)
    measured = np.stack([derivative(trial.time, rate), rate, angle])
    windowed = windowed_of(trial, "recommended", "theta", 20.0)
    unit = (noise / windowed.deviation["theta"])[None, windowed.trial.noise_samples]
    found = windowed.regressors + windowed.regressor_noise(windowed.trial.differentiated_noise(unit))[0]
    for k, (start, stop) in enumerate(trial.windows):
        part = measured[:, start:stop]
        assert found[k] == pytest.approx(part, abs=3e-3 * np.abs(part[0]).max())
        assert found[k, 2] == pytest.approx(part[2], abs=1e-9)


@pytest.mark.parametrize("noise_on", ["tau", "theta", "both"])
def test_batches_equal_a_loop_over_windows_and_draws(noise_on, sine):
    windows = sine.windows.copy()
    windows[::3, 1] -= 4  # of unequal length
    trial = replace(sine, windows=windows)
    windowed = windowed_of(trial, "recommended-regression", noise_on, 10.0)
    torque, regressors = noisy_signals(windowed, 6, cell_generators(1, "loop"))
    fits = regress_windows(regressors, torque)
    for draw in range(6):
        for k, length in enumerate(np.diff(windows, axis=1)[:, 0]):
            x, y = regressors[draw, k, :, :length].T, torque[draw, k, :length]
            one = np.linalg.lstsq(x, y, rcond=None)[0]
            assert fits.parameters[draw, k] == pytest.approx(one, rel=1e-9)
            # shorter windows end with zeros, which count
            count, inverse = torque.shape[-1], np.diag(np.linalg.inv(x.T @ x))
            sem = sems(float(np.linalg.norm(y - x @ one)), count, inverse)
            assert fits.sem[draw, k] == pytest.approx(sem, rel=1e-6)
            missed = torque[draw, k, :length] - x @ one
            assert fits.residuals[draw, k, :length] == pytest.approx(missed, abs=1e-9)
            assert np.abs(fits.residuals[draw, k, length:]).max(initial=0.0) == 0.0
    shared = regress_windows(windowed.regressors, torque)
    repeated = regress_windows(np.stack(6 * [windowed.regressors]), torque)
    assert shared.parameters == pytest.approx(repeated.parameters, rel=1e-12)


def test_instruments_solve_their_normal_equations(sine):
    windowed = windowed_of(sine, "recommended", "both", 10.0)
    torque, regressors = noisy_signals(windowed, 3, cell_generators(1, "iv"))
    fits = instrumental_variables(windowed.instruments, regressors, torque)
    z = np.concatenate(list(windowed.instruments), axis=1)
    for draw in range(3):
        x, y = np.concatenate(list(regressors[draw]), axis=1), torque[draw].ravel()
        assert fits.parameters[draw] == pytest.approx(np.linalg.solve(z @ x.T, z @ y), rel=1e-9)
    # with the regressors for instruments it is least squares, and so is its SEM
    own = windowed.regressors
    fits = instrumental_variables(own, own, torque)
    x = np.concatenate(list(own), axis=1).T
    for draw in range(3):
        one = np.linalg.lstsq(x, torque[draw].ravel(), rcond=None)[0]
        assert fits.parameters[draw] == pytest.approx(one, rel=1e-9)
        norm = float(np.linalg.norm(torque[draw].ravel() - x @ one))
        sem = sems(norm, torque[draw].size, np.diag(np.linalg.inv(x.T @ x)))
        assert fits.sem[draw] == pytest.approx(sem, rel=1e-6)


@pytest.mark.parametrize("noise_on", ["tau", "theta", "both"])
def test_recommended_estimator_is_unbiased_at_20_db(noise_on, sine):
    cell = cell_of(sine, noise_on, 20.0, 600, SEED)
    half_width = 2.64 * cell.sd / np.sqrt(cell.n_draws)  # nine intervals that together hold with 95 %
    assert (np.abs(cell.bias) < 1.05 * half_width).all()
    assert (half_width < [1e-5, 2e-3, 2e-2]).all()


def test_noise_on_the_angle_biases_least_squares(sine):
    cell = cell_of(sine, "theta", 20.0, 200, SEED, "recommended-regression")
    error = cell.sd / np.sqrt(cell.n_draws)
    assert cell.bias[2] < -8.0 * error[2]
    assert (np.abs(cell_of(sine, "tau", 20.0, 200, SEED, "recommended-regression").bias) < 4.0 * error).all()


def test_estimates_do_not_depend_on_amplitude_and_spread_with_the_noise(small):
    processing = PROCESSINGS["recommended"]
    scaled = {
        name: 7.0 * getattr(small, name)
        for name in (
            "theta",
            "theta_d",
            "theta_dd",
            "y_leg_dd",
            "z_leg_dd",
            "y_foot",
            "y_foot_d",
            "y_foot_dd",
        )
    }
    larger = replace(small, **scaled)
    found = draws_of(small, processing, "both", 20.0, 20)[0]
    assert draws_of(larger, processing, "both", 20.0, 20)[0] == pytest.approx(found, rel=1e-3)
    on_torque = [draws_of(small, processing, "tau", snr, 20)[0] - small.truth for snr in (20.0, 40.0)]
    assert on_torque[0] == pytest.approx(10.0 * on_torque[1], rel=1e-3, abs=1e-9)
    spread = [draws_of(small, processing, "both", snr, 100)[0].std(axis=0) for snr in (40.0, 60.0)]
    assert spread[0] == pytest.approx(10.0 * spread[1], rel=0.05)


# ---- the thesis's table ------------------------------------------------------------------------


def test_noise_hides_the_stiffness_only_if_its_power_is_not_that_of_the_signal(sine, others):
    cells = {
        (name, noise_on): cell_of(sine, noise_on, 20.0, 50, SEED, name, others)
        for name in ("as-printed", "as-tabulated")
        for noise_on in ("tau", "theta")
    }
    # what filter and formula make of the joint, noise at 20 dB hardly changes
    printed = cells["as-printed", "theta"]
    assert printed.mean == pytest.approx(printed.without_noise, rel=0.1)
    tabulated = cells["as-tabulated", "theta"]
    assert tabulated.mean[0] == pytest.approx(0.039, abs=0.002)
    assert abs(tabulated.mean[2]) < 0.2
    assert tabulated.unstable_fraction == 1.0
    assert np.isnan(tabulated.vaf_theta_trial).all()
    assert clipped(tabulated.vaf_theta_trial).max() == 0.0
    assert (tabulated.vaf_perturbation > 95.0).all()
    on_torque = cells["as-tabulated", "tau"].vaf_cross_validated.mean()
    assert on_torque < 85.0 < tabulated.vaf_cross_validated.mean()


def test_sensor_of_the_joint_returns_the_first_column_of_the_table_and_no_other(sine):
    without = cell_of(sine, "none", 20.0, 1, SEED, "joint-sensor")
    assert without.mean == pytest.approx(sine.truth, rel=1e-9)
    assert without.vaf_perturbation == pytest.approx([100.0])
    assert cell_of(sine, "none", 20.0, 1, SEED, "as-printed").mean != pytest.approx(sine.truth, rel=0.1)
    for noise_on in ("tau", "theta", "both"):
        inertia = cell_of(sine, noise_on, 20.0, 20, SEED, "joint-sensor").mean[0]
        assert abs(inertia / 0.039 - 1.0) > 0.3


# ---- predictions -------------------------------------------------------------------------------


def test_predicted_angle_is_that_of_the_linear_leg(small):
    joints = np.stack([small.truth, [0.015, 0.1, 1.0], [0.015, -0.1, 10.0], [-0.2, 0.1, 10.0]])
    assert is_stable(LEG, joints).tolist() == [True, False, False, False]
    predicted = predict_angle(LEG, joints, small.y_foot_d, RATE_HZ)
    assert predicted[0] == pytest.approx(small.theta, abs=4e-3 * np.abs(small.theta).max())
    assert np.isnan(predicted[1:]).all()


def test_vaf_of_the_torque_over_the_trial_is_that_of_an_independent_recording(sine, rng):
    parameters = np.array([0.014, 0.12, 9.0])
    for noise_on, deviation in (("tau", (1.0, 0.0)), ("theta", (0.0, 1.0)), ("both", (1.0, 1.0))):
        found = cross_validated_vaf(parameters, [windowed_of(sine, "recommended", noise_on, 10.0)])
        torque, angle = sine.torque("leg"), sine.theta
        noisy = [
            butterworth_lowpass(
                x + d * np.sqrt(0.1 * np.mean(x**2)) * rng.standard_normal(x.size), RATE_HZ, 20.0
            )
            for x, d in zip((torque, angle), deviation, strict=True)
        ]
        rate = derivative(sine.time, noisy[1])
        predicted = parameters @ np.stack([derivative(sine.time, rate), rate, noisy[1]])
        assert 100.0 - found == pytest.approx(100.0 - vaf(noisy[0], predicted), rel=0.1), noise_on


def test_rows_are_tidy(sine, others):
    rows = cell_of(sine, "both", 20.0, 5, SEED, "recommended", others).rows()
    assert {tuple(row) for row in rows} == {
        ("condition", "noise_on", "snr_db", "estimator", "quantity", "unit", "mean", "sd", "bias", "n_draws")
    }
    by_quantity = {row["quantity"]: row for row in rows}
    assert len(by_quantity) == len(rows) == 18
    assert by_quantity["K"]["bias"] == pytest.approx(by_quantity["K"]["mean"] - 10.0)
    assert all(np.isfinite(row["mean"]) and row["n_draws"] == 5 for row in rows)


# ---- draws -------------------------------------------------------------------------------------


def test_a_cell_depends_on_its_names_and_the_seed_alone(sine, others):
    first = cell_of(sine, "both", 20.0, 60, SEED)
    cell_of(others[0], "tau", 5.0, 10, SEED)
    again = cell_of(sine, "both", 20.0, 130, SEED)
    assert np.array_equal(first.parameters[:50], again.parameters[:50])
    assert first.parameters == pytest.approx(again.parameters[:60], rel=1e-9)
    for different in (
        cell_of(sine, "both", 25.0, 60, SEED),
        cell_of(sine, "both", 20.0, 60, SEED + 1),
        cell_of(replace(sine, name="sine-0.3-8s"), "both", 20.0, 60, SEED),
    ):
        assert np.abs(different.parameters / first.parameters - 1.0).max() > 1e-4
    correlation = np.corrcoef(
        first.parameters[:, 2],
        cell_of(sine, "both", 20.0, 60, SEED, "recommended-regression").parameters[:, 2],
    )[0, 1]
    assert correlation > 0.5  # the estimators of a cell see the same noise


# ---- refusals ----------------------------------------------------------------------------------


def test_what_cannot_be_used_is_refused(sine, others):
    def refused(*names, trial=sine, noise_on="tau", snr_db=20.0, draws=5, **options):
        with pytest.raises(InputError) as caught:
            cell_of(trial, noise_on, snr_db, draws, SEED, **options)
        assert_one_sentence(caught.value, *names)

    for snr in (np.nan, np.inf, -np.inf, "20", None, True):
        refused("signal-to-noise", repr(snr).strip("'"), snr_db=snr)
    refused("'thta'", "'theta'", noise_on="thta")
    refused(sine.name, "windows", trial=replace(sine, windows=np.empty((0, 2), dtype=int)))
    refused(sine.name, "75 samples", trial=replace(sine, windows=np.array([[10, 45]])))
    refused(sine.name, trial=replace(sine, windows=np.array([[17460, 17495]])))
    refused(sine.name, "3 samples", trial=replace(sine, windows=np.array([[1500, 1503]])))
    refused("'ols'", "'recommended'", estimator="ols")
    refused("draw", "0", draws=0)
    still = replace(sine, theta=0.0 * sine.theta, theta_d=0.0 * sine.theta, theta_dd=0.0 * sine.theta)
    refused("perturbations", trial=still, estimator="as-printed")
    refused("belt", trial=replace(sine, y_foot=0.0 * sine.theta), estimator="recommended")
    with pytest.raises(InputError, match="expected other trials"):
        cross_validated_vaf(sine.truth, [])
    for name in ("torque", "estimator", "filtered", "power"):
        wrong = replace(PROCESSINGS["recommended"], **{name: "knee"})
        with pytest.raises(InputError) as caught:
            windowed_trial(filtered_trial(others[0]), wrong, "tau", 20.0)
        assert_one_sentence(caught.value, name, "'knee'")
