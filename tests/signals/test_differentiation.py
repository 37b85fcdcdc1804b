"""Derivatives that keep their gain."""

import numpy as np
import pytest

from tepsipe.signals.differentiation import degree_at, derivative


def test_derivative_of_a_cubic_is_exact_at_irregular_instants(rng):
    time = np.sort(rng.uniform(0.0, 2.0, 40))
    x = np.column_stack([time**3 - 2.0 * time, 1.0 - time**2])
    expected = np.column_stack([3.0 * time**2 - 2.0, -2.0 * time])
    assert derivative(time, x) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("rate_hz", [100.0, 120.0, 150.0, 200.0, 250.0])
def test_second_derivative_at_the_cutoff_of_slow_cameras_keeps_its_gain(rate_hz):
    """At 0.3 of a low rate, or 30 Hz, within 1 %; a cubic spline would lose 20 % at low rates."""
    time = np.arange(round(20.0 * rate_hz)) / rate_hz
    middle = slice(round(5.0 * rate_hz), round(15.0 * rate_hz))
    omega = 2.0 * np.pi * (30.0 if rate_hz >= 200.0 else 0.3 * rate_hz)
    degree, x = degree_at(rate_hz), np.sin(omega * time)
    found = derivative(time, derivative(time, x, degree), degree)[middle]
    assert found == pytest.approx(-(omega**2) * x[middle], abs=0.01 * omega**2)
    assert degree == (3 if rate_hz >= 200.0 else 7)


def test_derivative_of_a_20_hz_sine_at_250_hz_keeps_its_gain():
    time = np.arange(0.0, 2.0, 0.004)
    omega = 2.0 * np.pi * 20.0
    middle = slice(50, -50)
    found = derivative(time, np.sin(omega * time))[middle]
    expected = omega * np.cos(omega * time)[middle]
    gain = found @ expected / (expected @ expected)
    assert gain == pytest.approx(1.0, abs=1e-3)
    central = np.gradient(np.sin(omega * time), time)[middle]
    assert abs(central @ expected / (expected @ expected) - 1.0) > 0.03
