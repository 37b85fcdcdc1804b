"""What a model leaves: white noise passes, slow noise does not; a change of K over a record is found."""

import numpy as np
import pytest

from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.statistics.residuals import (
    cumulative_periodogram,
    equal_means_p,
    memory_s,
    share_below,
    solution_with_errors,
)

RATE = 100.0


def test_white_noise_is_refused_in_5_of_100_records(rng):
    refused = [cumulative_periodogram(x, RATE, 30.0) for x in rng.standard_normal((600, 1000))]
    assert np.mean([found.p_value < 0.05 for found in refused]) == pytest.approx(0.05, abs=0.025)
    assert all((found.distance > found.limit) == (found.p_value < 0.05) for found in refused)


def test_filtered_white_noise_is_white_below_the_cutoff_only(rng):
    x = butterworth_lowpass(rng.standard_normal(4000), RATE, 30.0, 8)
    assert cumulative_periodogram(x, RATE, 15.0).p_value > 0.05
    assert cumulative_periodogram(x, RATE, 50.0).p_value < 1e-6


def test_slow_noise_is_not_white_and_is_said_to_be_slow(rng):
    x = butterworth_lowpass(rng.standard_normal(6000), RATE, 0.5, 8)[500:-500]
    assert cumulative_periodogram(x, RATE, 30.0).p_value < 1e-6
    assert share_below(x, RATE, 1.0) > 0.95
    assert 0.2 < memory_s(x, RATE) < 1.5
    assert memory_s(rng.standard_normal(6000), RATE) == pytest.approx(0.01)


def test_share_below_counts_the_mean_and_every_line_once():
    time = np.arange(0.0, 10.0, 1.0 / RATE)
    x = 1.0 + np.sqrt(2.0) * (np.sin(2.0 * np.pi * 0.5 * time) + np.sin(2.0 * np.pi * 5.0 * time))
    assert share_below(x, RATE, 0.1) == pytest.approx(1.0 / 3.0)
    assert share_below(x, RATE, 1.0) == pytest.approx(2.0 / 3.0)
    assert share_below(x, RATE, 50.0) == pytest.approx(1.0)


def thirds(rng, stiffness):
    """K of three parts of a record with slow noise, its standard errors and degrees of freedom."""
    size = 1800
    angle = butterworth_lowpass(rng.standard_normal(3 * size), RATE, 2.0, 2)
    slow = butterworth_lowpass(rng.standard_normal(3 * size), RATE, 1.0, 2)
    torque = np.repeat(stiffness, size) * angle + 2.0 * slow
    found = []
    for part in np.split(np.arange(3 * size), 3):
        columns = np.column_stack([angle[part], np.ones(size)])
        solution, error, freedom = solution_with_errors(columns, torque[part], 100)
        found.append((solution[0], error[0], freedom))
    return tuple(np.array(column) for column in zip(*found, strict=True))


@pytest.mark.slow
def test_equal_stiffness_is_refused_in_about_5_of_100_records_and_a_change_found(rng):
    level = [equal_means_p(*thirds(rng, [10.0, 10.0, 10.0])) < 0.05 for _ in range(120)]
    assert np.mean(level) == pytest.approx(0.05, abs=0.04)
    assert np.mean([equal_means_p(*thirds(rng, [10.0, 12.0, 14.0])) < 0.05 for _ in range(20)]) > 0.9


@pytest.mark.slow
def test_standard_errors_hold_for_noise_that_is_correlated_within_blocks(rng):
    inside = []
    for _ in range(120):
        k, error, freedom = thirds(rng, [10.0, 10.0, 10.0])
        assert (freedom == 17).all()
        inside.append(np.abs(k - 10.0) < 2.11 * error)
    assert np.mean(inside) == pytest.approx(0.95, abs=0.04)


def test_no_error_no_verdict():
    assert np.isnan(equal_means_p(np.ones(3), np.zeros(3), np.full(3, 5)))


def test_cumulative_power_of_a_sine_jumps_at_its_frequency():
    time = np.arange(1000) / RATE
    found = cumulative_periodogram(np.sin(2.0 * np.pi * 5.0 * time), RATE, 30.0)
    assert found.frequency_hz[-1] == pytest.approx(30.0)
    before = found.frequency_hz < 4.95
    assert found.cumulative[before] == pytest.approx(0.0, abs=1e-12)
    assert found.cumulative[~before] == pytest.approx(1.0)


@pytest.mark.parametrize("size", [400, 401])
def test_share_of_two_sines_and_a_mean_below_a_frequency(size):
    time = np.arange(size) / RATE
    k = np.round(np.array([5.0, 20.0]) * size / RATE) * RATE / size  # whole periods
    x = 1.0 + np.sin(2.0 * np.pi * k[0] * time) + 2.0 * np.sin(2.0 * np.pi * k[1] * time)
    assert share_below(x, RATE, 10.0) == pytest.approx((1.0 + 0.5) / (1.0 + 0.5 + 2.0))
