"""The fit of I, B, K: it finds a known joint from anywhere, and its intervals hold the truth."""

from dataclasses import replace

import numpy as np
import pytest
from builders import multisine_record, noisy_spectrum, second_order_response
from scipy import optimize, stats

from tepsipe.identification.admittance_fit import (
    TABLE_3_2,
    Bounds,
    change_by_smearing,
    error_of_misfit,
    fit_as_printed,
    fit_from_many_starts,
    fit_scaled,
    fit_within_random_bounds,
    profile_stiffness,
    residuals,
    residuals_as_printed,
)
from tepsipe.signals.response import FrequencyResponse
from tepsipe.signals.spectra import frequency_averaged, period_averaged

# thesis Table 3-2
BOUNDS = Bounds(
    start=np.array([0.001, 0.1, 10.0]),
    lower=np.array([-10.0, 0.01, -20.0]),
    upper=np.array([10.0, 10.0, 20.0]),
)
JOINT = np.array([0.015, 0.1, 8.0])


@pytest.mark.parametrize("joint", [(0.015, 0.1, 10.0), (0.005, 0.3, 15.0), (0.05, 0.05, 3.0)])
def test_noise_free_joint_is_found_exactly(joint):
    frequency = np.arange(1.0, 9.01, 0.1)
    exact = FrequencyResponse(frequency, second_order_response(joint, frequency), np.ones_like(frequency), 1)
    fit = fit_scaled(exact, BOUNDS)
    assert fit.parameters == pytest.approx(joint, rel=1e-6)
    assert fit.cost < 1e-10
    assert fit.converged
    assert not fit.at_bound


def test_joint_is_found_from_a_record_of_its_angle_and_torque():
    torque, angle = multisine_record(JOINT, 2.3)
    estimate = period_averaged(torque, angle, 256.0, 10.0, (1.0, 20.0)).band(1.0, 9.0)
    assert fit_scaled(estimate, BOUNDS).parameters == pytest.approx(JOINT, rel=1e-6)


def test_averaged_frequencies_of_a_leaking_record_bias_damping_most():
    torque, angle = multisine_record(JOINT, 2.3)
    estimate = frequency_averaged(torque, angle, 256.0, 8).band(1.0, 9.0)
    bias = np.abs(fit_scaled(estimate, BOUNDS).parameters / JOINT - 1.0)
    assert bias[1] > 0.05
    assert bias[0] < 0.03
    assert bias[2] < 0.03


def test_an_error_that_one_noisy_frequency_determines_has_two_degrees_of_freedom(rng):
    frequency = np.arange(1.0, 9.01, 0.1)
    response = second_order_response(JOINT, frequency)
    noise = 1e-4 * rng.standard_normal((2, frequency.size))
    noisy = response * np.exp(noise[0] + 1j * noise[1])
    even = FrequencyResponse(frequency, noisy, np.ones_like(frequency), 1)
    disturbed = even.response.copy()
    disturbed[20] *= 1.01 * np.exp(0.01j)
    one = FrequencyResponse(frequency, disturbed, np.ones_like(frequency), 1)
    (_, of_all), (_, of_one) = (error_of_misfit(fit_scaled(x, BOUNDS), x) for x in (even, one))
    # amplitude and phase of the one; the others still carry a part of I
    assert of_one[1:] == pytest.approx([2.0, 2.0], rel=0.2)
    assert 2.0 < of_one[0] < 5.0
    assert (of_all > 15.0).all()


@pytest.mark.slow
def test_interval_from_the_standard_error_covers_the_joint(rng):
    covered, repeats = np.zeros(3), 150
    for _ in range(repeats):
        estimate = noisy_spectrum(JOINT, 0.03, rng)
        fit = fit_scaled(estimate, BOUNDS)
        half = stats.t.ppf(0.975, 2 * estimate.frequency_hz.size - 3) * fit.standard_error
        covered += np.abs(fit.parameters - JOINT) <= half
    assert (covered / repeats >= 0.90).all()
    assert (covered / repeats <= 0.99).all()


@pytest.mark.slow
def test_profile_interval_covers_the_stiffness(rng):
    covered, repeats, grid = 0, 40, np.linspace(7.0, 9.0, 21)
    for _ in range(repeats):
        estimate = noisy_spectrum(JOINT, 0.05, rng)
        best = fit_scaled(estimate, BOUNDS)
        low, high = profile_stiffness(estimate, BOUNDS, best, grid).interval
        assert low < best.parameters[2] < high
        covered += low <= JOINT[2] <= high
    assert covered >= 0.85 * repeats


def test_profile_is_lowest_at_the_estimate_and_rises_on_either_side(rng):
    estimate = noisy_spectrum(JOINT, 0.05, rng)
    best = fit_scaled(estimate, BOUNDS)
    profile = profile_stiffness(estimate, BOUNDS, best, np.linspace(5.0, 12.0, 57))
    lowest = int(np.argmin(profile.cost))
    assert profile.stiffness[lowest] == pytest.approx(best.parameters[2], abs=0.13)
    assert (np.diff(profile.cost[: lowest + 1]) < 0.0).all()
    assert (np.diff(profile.cost[lowest:]) > 0.0).all()
    assert (profile.cost >= best.cost * (1.0 - 1e-9)).all()


def test_profile_interval_agrees_with_the_standard_error_for_small_noise(rng):
    estimate = noisy_spectrum(JOINT, 0.01, rng)
    best = fit_scaled(estimate, BOUNDS)
    stiffness = best.parameters[2] + np.linspace(-0.1, 0.1, 81)
    low, high = profile_stiffness(estimate, BOUNDS, best, stiffness).interval
    half = stats.t.ppf(0.975, 2 * estimate.frequency_hz.size - 3) * best.standard_error[2]
    assert (high - low) / 2.0 == pytest.approx(half, rel=0.1)


def test_profile_that_does_not_reach_its_limit_has_an_infinite_end(rng):
    estimate = noisy_spectrum(JOINT, 0.05, rng)
    best = fit_scaled(estimate, BOUNDS)
    above = profile_stiffness(estimate, BOUNDS, best, np.linspace(best.parameters[2], 12.0, 30))
    assert above.interval[0] == -np.inf
    assert np.isfinite(above.interval[1])


def test_starting_values_do_not_matter_to_the_scaled_fit(rng):
    fits = fit_from_many_starts(noisy_spectrum(JOINT, 0.05, rng), BOUNDS, 25, rng)
    starts = np.array([fit.start for fit in fits])
    found = np.array([fit.parameters for fit in fits])
    assert len(fits) == 26
    assert fits[0].start.tolist() == BOUNDS.start.tolist()
    assert np.ptp(starts, axis=0)[2] > 20.0
    assert np.ptp(np.log10(starts[:, 0])) > 2.0
    assert all(fit.converged for fit in fits)
    assert np.ptp(found, axis=0) == pytest.approx(np.zeros(3), abs=1e-4)


def test_fits_within_random_bounds_reach_the_minimum_or_end_at_a_bound(rng):
    estimate = noisy_spectrum(JOINT, 0.05, rng)
    best = fit_scaled(estimate, BOUNDS)
    fits = fit_within_random_bounds(estimate, BOUNDS, 40, rng)
    free = [fit for fit in fits if not fit.at_bound]
    assert len(fits) == 40 and 0 < len(free) < 40
    for fit in free:
        assert fit.parameters == pytest.approx(best.parameters, rel=1e-3)
    assert all(fit.cost > 1.001 * best.cost for fit in fits if fit.at_bound)


def test_modulus_as_residual_stalls_where_the_smooth_residual_converges(rng):
    estimate = noisy_spectrum(JOINT, 0.02, rng)
    smooth, modulus = fit_scaled(estimate, BOUNDS), fit_as_printed(estimate, BOUNDS)
    assert smooth.start.tolist() == modulus.start.tolist() == [0.001, 0.1, 10.0]
    assert modulus.cost > 20.0 * smooth.cost
    assert np.abs(modulus.parameters[1] / JOINT[1] - 1.0) > 1.0
    assert smooth.parameters == pytest.approx(JOINT, rel=0.05)


def test_stalled_fit_depends_on_the_starting_stiffness(rng):
    estimate = noisy_spectrum(JOINT, 0.02, rng)
    starts = [Bounds(np.array([0.001, 0.1, k]), BOUNDS.lower, BOUNDS.upper) for k in (1.0, 19.0)]
    modulus = [fit_as_printed(estimate, start).parameters[2] for start in starts]
    smooth = [fit_scaled(estimate, start).parameters[2] for start in starts]
    assert abs(modulus[1] - modulus[0]) > 0.5
    assert abs(smooth[1] - smooth[0]) < 1e-5


def test_neither_scaling_nor_tolerances_stall_the_smooth_residual(rng):
    estimate = noisy_spectrum(JOINT, 0.02, rng)
    best = fit_scaled(estimate, BOUNDS).parameters
    for k in (1.0, 10.0, 19.0):
        start, bounds = [0.001, 0.1, k], (BOUNDS.lower, BOUNDS.upper)
        tolerances = dict.fromkeys(("xtol", "ftol", "gtol"), 1e-6)
        found = optimize.least_squares(residuals, start, bounds=bounds, args=(estimate,), **tolerances)
        assert found.x == pytest.approx(best, rel=1e-3)


def test_both_residuals_have_the_printed_sum_of_squares(rng):
    estimate = noisy_spectrum(JOINT, 0.1, rng)
    for parameters in (JOINT, BOUNDS.start):
        model = second_order_response(parameters, estimate.frequency_hz)
        error = np.sqrt(estimate.coherence / estimate.frequency_hz) * np.abs(
            np.log(estimate.response / model)
        )
        printed = residuals_as_printed(parameters, estimate)
        assert printed == pytest.approx(error)
        smooth = residuals(parameters, estimate)
        assert np.sum(smooth**2) == pytest.approx(np.sum(error**2))


def test_incoherent_frequencies_do_not_count(rng):
    estimate = noisy_spectrum(JOINT, 0.0, rng)
    spoilt = estimate.response.copy()
    spoilt[::5] *= 3.0
    coherence = np.where(np.arange(spoilt.size) % 5 == 0, 0.0, 1.0)
    fit = fit_scaled(FrequencyResponse(estimate.frequency_hz, spoilt, coherence, 1), BOUNDS)
    assert fit.parameters == pytest.approx(JOINT, rel=1e-6)


def test_stiffness_beyond_its_bound_is_reported_at_the_bound(rng):
    fit = fit_scaled(noisy_spectrum((0.015, 0.1, 30.0), 0.01, rng), BOUNDS)
    assert fit.at_bound
    assert fit.parameters[2] == pytest.approx(20.0, abs=1e-4)


def test_smearing_is_the_mean_over_the_band_of_each_value():
    frequency = np.arange(1.0, 9.01, 0.25)
    fine = (np.arange(4001) - 2000.0) / 4001.0
    smeared = second_order_response(JOINT, (frequency[:, None] + 0.5 * fine).ravel())
    ones = np.ones_like(frequency)
    estimate = FrequencyResponse(frequency, second_order_response(JOINT, frequency), ones, 1)
    exact = replace(estimate, response=smeared.reshape(frequency.size, -1).mean(axis=1))
    change = fit_scaled(exact, BOUNDS).parameters - JOINT
    found = change_by_smearing(fit_scaled(estimate, BOUNDS), replace(estimate, resolution_hz=0.5), BOUNDS)
    assert found == pytest.approx(change, rel=0.05)


def test_bounds_of_the_public_fit_are_those_of_table_3_2():
    assert np.array_equal(np.array(TABLE_3_2), [BOUNDS.start, BOUNDS.lower, BOUNDS.upper])
