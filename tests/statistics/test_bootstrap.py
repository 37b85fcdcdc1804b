"""Bootstrap over perturbations: standard error and interval of their mean."""

import numpy as np
import pytest

from tepsipe.statistics.bootstrap import bootstrap_mean, expanded_tail


def test_bootstrapped_interval_covers_a_known_mean_in_about_95_percent_of_draws(rng):
    mean, covered = np.array([10.0, -0.2]), np.zeros(2)
    repeats = 400
    for _ in range(repeats):
        values = mean + [1.0, 0.05] * rng.standard_normal((14, 2))
        interval = bootstrap_mean(values, 400, rng)
        covered += (interval.low <= mean) & (mean <= interval.high)
    assert (0.90 * repeats <= covered).all()
    assert (covered <= 0.99 * repeats).all()


def test_bootstrapped_standard_error_is_that_of_a_mean(rng):
    values = rng.standard_normal((14, 1))
    interval = bootstrap_mean(values, 20000, rng)
    assert interval.standard_error == pytest.approx(values.std(ddof=1) / np.sqrt(14.0), rel=0.03)


def test_a_single_perturbation_says_nothing_about_its_spread(rng):
    interval = bootstrap_mean(np.array([[0.1, 10.0]]), 100, rng)
    assert np.isposinf(interval.standard_error).all()
    assert np.isneginf(interval.low).all()
    assert np.isposinf(interval.high).all()


def test_tail_is_expanded_for_few_blocks():
    # Student's quantile of 9 degrees of freedom is 2.262: Phi(-sqrt(10 / 9) * 2.262) = 0.85 %
    assert expanded_tail(0.95, 10) == pytest.approx(0.855, abs=0.005)
    assert expanded_tail(0.95, 1e9) == pytest.approx(2.5, abs=1e-3)
