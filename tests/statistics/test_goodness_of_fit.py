"""Measures of fit against numbers worked out by hand and against certified and reference values."""

import numpy as np
import pytest
from builders import refused
from scipy import stats

from tepsipe.statistics.bootstrap import bootstrap_blocks
from tepsipe.statistics.goodness_of_fit import evaluate_held_out, vaf
from tepsipe.statistics.least_squares import least_squares_line

# NIST Statistical Reference Datasets, Norris (ozone monitors): y, x, and certified values
NORRIS = np.loadtxt(
    """\
    0.1 0.2  338.8 337.4  118.1 118.2  888.0 884.6  9.2 10.1  228.1 226.5
    668.5 666.3  998.5 996.3  449.1 448.6  778.9 777.0  559.2 558.2  0.3 0.4
    0.1 0.6  778.1 775.5  668.8 666.9  339.3 338.0  448.9 447.5  10.8 11.6
    557.7 556.0  228.3 228.1  998.0 995.8  888.8 887.6  119.6 120.2  0.3 0.3
    0.6 0.3  557.6 556.8  339.3 339.1  888.0 887.2  998.5 999.0  778.9 779.0
    10.2 11.1  117.6 118.3  228.9 229.2  668.4 669.1  449.2 448.9  0.2 0.5""".splitlines()
).reshape(-1, 2)
NORRIS_PARAMETERS = [-0.262323073774029, 1.00211681802045]
NORRIS_ERRORS = [0.232818234301152, 0.429796848199937e-3]


def test_vaf_of_a_small_record_by_hand():
    assert vaf(np.array([3.0, 4.0]), np.array([3.0, 3.0])) == pytest.approx(96.0)


def test_vaf_keeps_the_mean_as_the_thesis_prints_it():
    around_ten = np.array([11.0, 9.0, 11.0, 9.0])
    assert vaf(around_ten, around_ten - 10.0) == pytest.approx(100.0 * (1.0 - 400.0 / 404.0))
    assert vaf(around_ten, np.full(4, 10.0)) == pytest.approx(100.0 * (1.0 - 4.0 / 404.0))


def test_vaf_is_zero_for_no_prediction_and_negative_for_a_worse_one(rng):
    measured = rng.standard_normal(50)
    assert vaf(measured, np.zeros(50)) == 0.0
    assert vaf(measured, -measured) == pytest.approx(-300.0)


def test_small_regression_by_hand():
    fit = least_squares_line(np.ones((3, 1)), np.array([1.0, 2.0, 4.0]))
    assert fit.parameters == pytest.approx([7.0 / 3.0])
    assert fit.residuals == pytest.approx([-4.0 / 3.0, -1.0 / 3.0, 5.0 / 3.0])
    # R'R = 14/3, (J'J)^-1 = 1/3
    assert fit.sem_as_printed == pytest.approx([np.sqrt(np.sqrt(14.0 / 3.0) / 3.0)])
    assert fit.sem[1] == pytest.approx([np.sqrt(14.0 / 3.0 / 3.0 / 3.0)])
    assert fit.standard_error == pytest.approx([np.sqrt(14.0 / 3.0 / 2.0 / 3.0)])
    assert fit.condition_number == pytest.approx(1.0)


def test_regression_returns_the_certified_values_of_norris():
    y, x = NORRIS.T
    fit = least_squares_line(np.column_stack([np.ones_like(x), x]), y)
    assert fit.parameters == pytest.approx(NORRIS_PARAMETERS, rel=1e-10)
    assert fit.standard_error == pytest.approx(NORRIS_ERRORS, rel=1e-10)


def test_standard_errors_are_those_of_linregress(rng):
    x = rng.standard_normal(40)
    y = 2.0 * x - 1.0 + 0.3 * rng.standard_normal(40)
    fit = least_squares_line(np.column_stack([x, np.ones(40)]), y)
    reference = stats.linregress(x, y)
    assert fit.parameters == pytest.approx([reference.slope, reference.intercept])
    assert fit.standard_error == pytest.approx([reference.stderr, reference.intercept_stderr])


def test_printed_sem_grows_with_the_root_of_the_signals_unit(rng):
    jacobian, y = rng.standard_normal((30, 2)), rng.standard_normal(30)
    in_newton_metres = least_squares_line(jacobian, y)
    in_millinewton_metres = least_squares_line(jacobian, 1000.0 * y)
    ratio = in_millinewton_metres.sem_as_printed / in_newton_metres.sem_as_printed
    assert ratio == pytest.approx(np.full(2, np.sqrt(1000.0)))
    ratio = in_millinewton_metres.standard_error / in_newton_metres.standard_error
    assert ratio == pytest.approx(np.full(2, 1000.0))


def test_printed_sem_does_not_shrink_with_the_number_of_samples_as_an_error_does(rng):
    jacobian, y = rng.standard_normal((50, 1)), rng.standard_normal(50)
    once, often = (least_squares_line(np.tile(jacobian, (n, 1)), np.tile(y, n)) for n in (1, 100))
    assert once.standard_error / often.standard_error == pytest.approx([10.0], rel=0.02)
    assert once.sem_as_printed / often.sem_as_printed == pytest.approx([np.sqrt(10.0)], rel=1e-6)


def test_standard_error_covers_the_truth_under_white_noise(rng):
    jacobian = rng.standard_normal((25, 2)) * [1.0, 100.0]
    covered, repeats = np.zeros(2), 1000
    half = stats.t.ppf(0.975, 23)
    for _ in range(repeats):
        fit = least_squares_line(jacobian, jacobian @ [3.0, -0.02] + rng.standard_normal(25))
        covered += np.abs(fit.parameters - [3.0, -0.02]) < half * fit.standard_error
    assert (covered / repeats > 0.93).all()
    assert (covered / repeats < 0.97).all()


def test_no_standard_error_where_no_freedom_is_left():
    fit = least_squares_line(np.array([[1.0, 0.0], [1.0, 1.0]]), np.array([1.0, 3.0]))
    assert fit.parameters == pytest.approx([1.0, 2.0])
    assert np.isposinf(fit.standard_error).all()


def test_units_of_the_regressors_do_not_change_the_fit(rng):
    jacobian, y = rng.standard_normal((30, 3)), rng.standard_normal(30)
    units = np.array([1e-6, 1.0, 1e5])
    plain, scaled = least_squares_line(jacobian, y), least_squares_line(jacobian * units, y)
    assert scaled.parameters * units == pytest.approx(plain.parameters, rel=1e-9)
    assert scaled.residuals == pytest.approx(plain.residuals, abs=1e-12)
    assert scaled.condition_number == pytest.approx(plain.condition_number, rel=1e-9)


@pytest.mark.parametrize("second", [lambda x: 0.0 * x, lambda x: -3.0 * x], ids=["zero", "dependent"])
def test_regressors_that_do_not_determine_the_parameters_are_refused(second, rng):
    x = rng.standard_normal(20)
    with pytest.raises(np.linalg.LinAlgError):
        least_squares_line(np.column_stack([x, second(x)]), x)


def test_prediction_is_judged_before_and_after_the_end_of_the_fit():
    measured = np.array([9.0, 11.0, 9.0, 11.0, 10.0, 14.0])
    predicted = np.array([9.0, 11.0, 9.0, 10.0, 9.0, 13.0])
    found = evaluate_held_out(measured, predicted, training=4)
    # about the mean of the first four, 10
    assert found.training == pytest.approx(100.0 * (1.0 - 1.0 / 4.0))
    assert found.held_out == pytest.approx(100.0 * (1.0 - 2.0 / 16.0))
    assert found.held_out_any_offset == pytest.approx(100.0)
    assert found.held_out_as_printed == pytest.approx(100.0 * (1.0 - 2.0 / 296.0))


def test_bootstrapped_blocks_scatter_as_the_estimate_does(rng):
    jacobian = np.column_stack([rng.standard_normal(4000), np.ones(4000)])
    y = jacobian @ [2.0, -1.0] + 0.5 * rng.standard_normal(4000)
    drawn = bootstrap_blocks(jacobian, y, 20, 600, rng)
    fit = least_squares_line(jacobian, y)
    assert drawn.mean(axis=0) == pytest.approx(fit.parameters, abs=0.003)
    assert drawn.std(axis=0) == pytest.approx(fit.standard_error, rel=0.2)


def test_bootstrapped_blocks_keep_the_penalty_and_the_units(rng):
    jacobian, y = rng.standard_normal((200, 2)), rng.standard_normal(200) + 3.0
    penalty = np.diag([0.0, 1e12])
    units = np.array([1e-3, 1e3])
    plain = bootstrap_blocks(jacobian, y, 10, 50, np.random.default_rng(1), penalty)
    scaled = bootstrap_blocks(
        jacobian * units, y, 10, 50, np.random.default_rng(1), penalty * np.outer(units, units)
    )
    assert np.abs(plain[:, 1]).max() < 1e-6
    assert scaled * units == pytest.approx(plain, rel=1e-6, abs=1e-12)


def test_vaf_is_the_thesiss_and_can_be_centred():
    measured, predicted = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 2.0])
    assert vaf(measured, predicted) == pytest.approx(100.0 * (1.0 - 1.0 / 14.0))
    assert vaf(measured, predicted, centred=True) == pytest.approx(100.0 * (1.0 - (2.0 / 3.0) / 2.0))
    refused(lambda: vaf(measured, predicted[:2]), "vaf", "(3,)", "(2,)")
