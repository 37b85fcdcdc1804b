"""Derivatives that keep their gain."""

import numpy as np
import pytest

from tepsipe.signals.differentiation import derivative


def test_derivative_of_a_cubic_is_exact_at_irregular_instants(rng):
    time = np.sort(rng.uniform(0.0, 2.0, 40))
    x = np.column_stack([time**3 - 2.0 * time, 1.0 - time**2])
    expected = np.column_stack([3.0 * time**2 - 2.0, -2.0 * time])
    assert derivative(time, x) == pytest.approx(expected, abs=1e-9)


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
