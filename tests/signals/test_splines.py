"""Cubic splines against scipy's class."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tepsipe.signals.differentiation import derivative
from tepsipe.signals.splines import cubic_spline, slopes


def samples(n: int, shape: tuple[int, ...], seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Random instants (s) and a random walk."""
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.uniform(0.5, 1.5, n)) / 250.0, np.cumsum(rng.standard_normal((n, *shape)), axis=0)


@pytest.mark.parametrize("n", [4, 5, 300])
@pytest.mark.parametrize("shape", [(), (1,), (3, 2)])
def test_spline_is_scipys(n, shape):
    time, x = samples(n, shape, n)
    ours, scipys = cubic_spline(time, x), CubicSpline(time, x)
    at = np.linspace(time[0], time[-1], 1000)
    size = np.ptp(x)
    assert ours(at) == pytest.approx(scipys(at), rel=1e-12, abs=1e-12 * size)
    assert ours(at, 1) == pytest.approx(scipys(at, 1), rel=1e-9, abs=1e-7 * size)
    assert ours.antiderivative()(at) == pytest.approx(scipys.antiderivative()(at), rel=1e-12, abs=1e-12)
    assert slopes(time, x) == pytest.approx(scipys(time, 1), rel=1e-9, abs=1e-7 * size)
    assert derivative(time, x) == pytest.approx(scipys(time, 1), rel=1e-9, abs=1e-7 * size)


def test_cubic_is_reproduced():
    time = samples(30, (), 1)[0]
    spline = cubic_spline(time, 2.0 * time**3 - time)
    at = np.linspace(time[0], time[-1], 100)
    assert spline(at) == pytest.approx(2.0 * at**3 - at, abs=1e-14)
    assert spline(at, 3) == pytest.approx(12.0, rel=1e-4)


@pytest.mark.parametrize("n", [2, 3])
def test_few_samples_have_a_straight_line_or_a_parabola(n):
    time, x = samples(n, (2,), n)
    assert cubic_spline(time, x)(time[0] + 1e-3) == pytest.approx(CubicSpline(time, x)(time[0] + 1e-3))


def test_columns_and_whole_numbers_are_splines_of_their_own():
    time, x = samples(50, (2,), 2)
    at = time[:-1] + 1e-3
    assert np.array_equal(cubic_spline(time, x)(at)[:, 1], cubic_spline(time, x[:, 1])(at))
    counts = np.arange(50) ** 2
    assert np.array_equal(
        cubic_spline(np.arange(50), counts)(at), cubic_spline(np.arange(50.0), 1.0 * counts)(at)
    )


def test_unusable_samples_are_refused():
    time, x = samples(20, (), 3)
    with pytest.raises(ValueError, match="finite"):
        cubic_spline(time, np.where(x == x[5], np.nan, x))
    with pytest.raises(ValueError, match="increasing"):
        cubic_spline(time[::-1], x)
