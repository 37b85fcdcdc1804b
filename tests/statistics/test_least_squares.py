"""Standard errors of least squares, by hand."""

import numpy as np
import pytest

from tepsipe.statistics.least_squares import SEM_READINGS, least_squares_line, sems


def test_three_readings_of_the_sem_by_hand():
    inverse = np.array([0.25])
    # R = (1, -2, 2): R'R = 9, norm 3, three residuals, two degrees of freedom
    norm, count, freedom = sems(3.0, 3, inverse)
    assert list(SEM_READINGS) == ["norm", "count", "freedom"]
    assert norm == pytest.approx(np.sqrt(9.0 / 3.0 * 0.25))
    assert count == pytest.approx(np.sqrt(9.0 / 3 * 0.25))
    assert freedom == pytest.approx(np.sqrt(9.0 / 2 * 0.25))
    # ten times the residuals: only the norm is no multiple of their size
    norm, count, freedom = sems(30.0, 3, inverse) / sems(3.0, 3, inverse)
    assert (norm, count, freedom) == pytest.approx((np.sqrt(10.0), 10.0, 10.0))


def test_standard_error_is_infinite_without_degrees_of_freedom():
    assert np.isposinf(sems(0.0, 1, np.array([0.25]))[2]).all()
    assert np.isposinf(sems(1.0, 1, np.array([0.25, 1.0]))[2]).all()
    assert np.isfinite(sems(1.0, 1, np.array([0.25, 1.0]))[:2]).all()


def test_many_fits_at_once_have_the_sems_of_each():
    norms, inverses = np.array([3.0, 5.0]), np.array([[0.25, 1.0], [0.04, 9.0]])
    together = sems(norms, 12, inverses)
    assert together.shape == (2, 3, 2)
    for k in range(2):
        assert together[k] == pytest.approx(sems(norms[k], 12, inverses[k]))


def test_a_line_through_exact_points_leaves_no_residual():
    x = np.array([0.0, 1.0, 3.0, 7.0])
    found = least_squares_line(np.column_stack([x, np.ones(4)]), 2.0 * x - 5.0)
    assert found.parameters == pytest.approx([2.0, -5.0])
