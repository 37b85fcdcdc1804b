"""Standard errors of least squares, by hand."""

import numpy as np
import pytest

from tepsipe.statistics.least_squares import least_squares_line, sem_as_printed, standard_error


def test_standard_error_by_hand_and_infinite_without_degrees_of_freedom():
    residuals, inverse = np.array([1.0, -2.0, 2.0]), np.array([0.25])
    # R'R = 9, two degrees of freedom
    assert standard_error(residuals, inverse) == pytest.approx(np.sqrt(9.0 / 2.0 * 0.25))
    assert np.isposinf(standard_error(np.zeros(1), inverse)).all()
    assert np.isposinf(standard_error(residuals[:1], np.array([0.25, 1.0]))).all()
    assert sem_as_printed(residuals, inverse) == pytest.approx(np.sqrt(3.0 * 0.25))


def test_a_line_through_exact_points_leaves_no_residual():
    x = np.array([0.0, 1.0, 3.0, 7.0])
    found = least_squares_line(np.column_stack([x, np.ones(4)]), 2.0 * x - 5.0)
    assert found.parameters == pytest.approx([2.0, -5.0])
