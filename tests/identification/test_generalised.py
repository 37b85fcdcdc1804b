"""Generalised least squares with noise in the regressors: instruments, and moments that are subtracted."""

from dataclasses import replace

import numpy as np
import pytest

from tepsipe.identification.regression.generalised import (
    Record,
    generalised_least_squares,
    sensitivity,
    squared_exponential,
)

N, TRUTH = 60, np.array([2.0, -3.0])
TIME = np.arange(N) / 100.0
EXACT = np.column_stack([np.sin(8.0 * TIME), np.sin(8.0 * TIME - 1.0) * np.exp(-TIME)])
# another size and a mixture of the same motion, as a belt is of an angle
LIKE = EXACT @ np.array([[5.0, 1.0], [0.5, -4.0]])


def record(rng, noise, instruments=None, corrected=True):
    """A record whose regressors and target have noise that is related, with its moments."""
    of_regressors = noise * rng.standard_normal((N, 2))
    of_target = 0.5 * of_regressors[:, 0] + 0.1 * rng.standard_normal(N)
    moments = None
    if corrected:
        xx, xy = np.zeros((2, 2, N, N)), np.zeros((2, N, N))
        xx[0, 0] = xx[1, 1] = noise**2 * np.eye(N)
        xy[0] = 0.5 * noise**2 * np.eye(N)
        moments = xx, xy
    covariance = 0.01 * np.eye(N) + 0.05 * squared_exponential(TIME, 0.05)
    return Record(EXACT @ TRUTH + of_target, EXACT + of_regressors, covariance, instruments, moments)


def estimates(noise, draws=300, **choices):
    rng = np.random.default_rng(5)
    return np.array(
        [generalised_least_squares([record(rng, noise, **choices)]).parameters for _ in range(draws)]
    )


def test_instruments_that_span_the_regressors_change_nothing_without_noise(rng):
    plain = record(rng, 0.0, corrected=False)
    ordinary = generalised_least_squares([plain])
    projected = generalised_least_squares([replace(plain, instruments=LIKE)])
    assert projected.parameters == pytest.approx(ordinary.parameters, rel=1e-8)
    assert projected.information == pytest.approx(ordinary.information, rel=1e-8)
    assert projected.noise_share == 0.0


@pytest.mark.parametrize("instruments", [None, LIKE])
def test_noise_is_subtracted(instruments):
    found = estimates(0.15, instruments=instruments)
    error = found.std(axis=0, ddof=1) / np.sqrt(len(found))
    assert (np.abs(found.mean(axis=0) - TRUTH) < 3.5 * error + 0.02).all()


def test_without_correction_noise_attenuates_and_instruments_leave_less_of_it():
    plain, projected = (
        np.abs(estimates(0.15, instruments=z, corrected=False).mean(axis=0) - TRUTH).max()
        for z in (None, LIKE)
    )
    assert plain > 0.5
    assert projected < 0.2 * plain


def test_instruments_scatter_less_than_the_correction_alone():
    alone, projected = (estimates(0.3, instruments=z).std(axis=0) for z in (None, LIKE))
    assert (projected < alone).all()


def test_share_of_noise_is_that_of_one_regressor_by_hand():
    x, noise = np.full((40, 1), 2.0), 0.25 * np.eye(40)
    moments = noise[None, None], np.zeros((1, 40, 40))
    fit = generalised_least_squares([Record(np.ones(40), x, np.eye(40), noise=moments)])
    # 40 * 4 of the products, of which 40 * 0.25 by noise
    assert fit.noise_share == pytest.approx(10.0 / 160.0)
    assert fit.parameters == pytest.approx([80.0 / 150.0])


def test_sensitivity_is_the_change_by_a_small_change_of_the_data(rng):
    first = record(rng, 0.1, instruments=LIKE)
    dy, dx = rng.standard_normal(N), rng.standard_normal((N, 2))
    fit = generalised_least_squares([first])
    step = 1e-6
    moved = replace(first, target=first.target + step * dy, regressors=first.regressors + step * dx)
    change = (generalised_least_squares([moved]).parameters - fit.parameters) / step
    assert sensitivity(fit, [first], [dy], [dx]) == pytest.approx(change, rel=1e-4)
