"""Long records: the same estimates from sums over spans of them, in bounded memory, on one thread."""

import inspect
import tracemalloc
from threading import Thread

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import tepsipe
from tepsipe import fit_impedance, fit_output_error, fit_parallel_cascade, load_example, segment_motion
from tepsipe.identification.cascade import normal_equations
from tepsipe.identification.one_thread import one_thread
from tepsipe.signals import differentiation
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.resampling import resample
from tepsipe.statistics import least_squares

FITS = [name for name in tepsipe.__all__ if name.startswith("fit_")]


@pytest.fixture
def short_spans(monkeypatch):
    """Spans and pieces so short that a record of a minute consists of many."""
    monkeypatch.setattr(normal_equations, "SPAN", 997)
    monkeypatch.setattr(least_squares, "SPAN", 997)
    monkeypatch.setattr(differentiation, "PIECE", 997)


def ankle(repeats=1):
    """Time (s), angle (rad) and torque (N·m) of the example, several times over."""
    example = load_example("ankle")
    angle, torque = (np.tile(x, repeats) for x in (example.angle, example.torque))
    return np.arange(angle.size) * (example.time[1] - example.time[0]), angle, torque


def assert_alike(fit, whole, tolerance=1e-9):
    """Equal values, errors and intervals, within a tolerance relative to the standard error."""
    assert fit.quantities.keys() == whole.quantities.keys()
    for name, quantity in fit.quantities.items():
        of_whole, scale = whole.quantities[name], quantity.standard_error
        if not np.isfinite(scale):
            assert quantity.value == pytest.approx(of_whole.value, nan_ok=True)
            continue
        for end in ("value", "low", "high", "standard_error"):
            assert abs(getattr(quantity, end) - getattr(of_whole, end)) <= tolerance * scale, (name, end)


# ---- sums over spans -----------------------------------------------------------------------------


@pytest.mark.slow
def test_cascade_by_spans_is_that_of_the_whole_record(short_spans, monkeypatch):
    fit = fit_parallel_cascade(*ankle(), bootstrap_draws=100)
    monkeypatch.undo()
    whole = fit_parallel_cascade(*ankle(), bootstrap_draws=100)
    # another number of threads changes the normal equations' solutions by up to 3e-8 standard errors
    assert_alike(fit, whole, 1e-6)
    assert fit.details.structure == whole.details.structure
    predicted = whole.curve.predicted
    assert fit.curve.predicted == pytest.approx(predicted, abs=1e-9 * np.abs(predicted).max())
    assert fit.vaf == pytest.approx(whole.vaf, rel=1e-9)
    assert fit.details.models[-1].vaf_held_out == pytest.approx(whole.details.models[-1].vaf_held_out)


def test_regression_by_spans_is_that_of_the_whole_record(short_spans, monkeypatch):
    fit = fit_impedance(*ankle())
    monkeypatch.undo()
    whole = fit_impedance(*ankle())
    assert_alike(fit, whole)
    assert fit.details.condition_number == pytest.approx(whole.details.condition_number)


@pytest.mark.parametrize("degree", [3, 5, 7])
def test_spline_of_pieces_is_that_of_the_whole_record(short_spans, monkeypatch, rng, degree):
    time, x = np.arange(5000) / 250.0, rng.standard_normal((5000, 2))
    slopes = derivative(time, x, degree)
    monkeypatch.undo()
    whole = derivative(time, x, degree)
    assert slopes == pytest.approx(whole, abs=1e-12 * np.abs(whole).max())


def test_resampled_pieces_are_those_of_the_whole_record(short_spans, monkeypatch, rng):
    time, x = np.arange(5000) / 1000.0, rng.standard_normal(5000)
    clock = np.arange(3, 1240) / 250.0
    found = resample(time, x, clock)
    monkeypatch.undo()
    assert found == pytest.approx(resample(time, x, clock), abs=1e-12)


# ---- memory --------------------------------------------------------------------------------------


def peak_in_signals(compute, size):
    """Largest memory over that of one signal of the record."""
    tracemalloc.start()
    try:
        compute()
        return tracemalloc.get_traced_memory()[1] / (8.0 * size)
    finally:
        tracemalloc.stop()


@pytest.mark.slow
def test_memory_of_a_cascade_is_that_of_the_fitted_regressors_once(short_spans):
    record, few = ankle(4), {"folds": 4, "profiled_delays_s": (0.036, 0.044), "bootstrap_draws": 100}
    peak = peak_in_signals(lambda: fit_parallel_cascade(*record, **few), record[0].size)
    # up to 98 regressors, of which half a record is fitted, and signals
    assert peak < 120


def test_memory_of_a_regression_is_that_of_few_signals(short_spans):
    time, angle, torque = ankle(4)
    fit = lambda: fit_impedance(time, angle, torque, bootstrap_draws=100)  # noqa: E731
    # the delay is searched on up to all samples of the regressors
    fit()  # modules are imported
    assert peak_in_signals(fit, time.size) < 24.5


def test_windows_of_an_output_error_share_one_residual():
    dummy = load_example("dummy")
    motion = segment_motion(dummy.time, dummy.positions, dummy.markers, dummy.leg.com_m, labels=dummy.labels)
    foot = [dummy.labels.index(label) for label in dummy.belt_fixed]
    fit = fit_output_error(
        motion,
        dummy.positions[:, foot, 0].mean(axis=1),
        dummy.belt_velocity,
        dummy.leg,
        perturbations=dummy.perturbations,
    )
    assert len({id(window.residuals.base) for window in fit.details.fits}) == 1


# ---- one thread ----------------------------------------------------------------------------------


def threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_threads_are_as_before_after_a_fit_and_after_a_refusal():
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        with one_thread():
            assert threads() == {1}
        assert threads() == before
        fit_impedance(*(x[:2000] for x in ankle()))
        with pytest.raises(tepsipe.InputError):
            fit_impedance([], [], [])
        assert threads() == before != {1}


def test_fits_at_the_same_time_share_the_limit():
    with threadpool_limits(2, user_api="blas"):
        before, first, second = threads(), one_thread(), one_thread()
        first.__enter__()
        other = Thread(target=second.__enter__)
        other.start()
        other.join()
        first.__exit__(None, None, None)
        assert threads() == {1}
        second.__exit__(None, None, None)
        assert threads() == before


@pytest.mark.parametrize("name", FITS)
def test_public_fits_compute_on_one_thread_and_keep_their_signature(name, monkeypatch):
    fit = getattr(tepsipe, name)
    assert inspect.signature(fit) == inspect.signature(fit.__wrapped__)
    assert fit.__doc__ == fit.__wrapped__.__doc__ and fit.__name__ == name
    seen = []
    module = inspect.getmodule(fit)
    monkeypatch.setattr(module, "checked", lambda *args, **kwargs: seen.append(threads()) or 1 / 0)
    monkeypatch.setattr(module, "bootstrap_generator", lambda *args: seen.append(threads()) or 1 / 0, False)
    with threadpool_limits(2, user_api="blas"), pytest.raises(ZeroDivisionError):
        call(fit)
    assert seen == [{1}]


def call(fit):
    """Call a fit with valid arguments of the example."""
    dummy = load_example("dummy")
    if fit.__name__ in ("fit_impedance", "fit_parallel_cascade"):
        return fit(*ankle())
    motion = segment_motion(dummy.time, dummy.positions, dummy.markers, dummy.leg.com_m, labels=dummy.labels)
    if fit.__name__ == "fit_output_error":
        foot = dummy.positions[:, 0, 0]
        return fit(motion, foot, dummy.belt_velocity, dummy.leg, perturbations=dummy.perturbations)
    if fit.__name__ == "fit_joint_likelihood":
        names = {"labels": dummy.labels, "belt_fixed": dummy.belt_fixed}
        windows = dummy.perturbations
        return fit(dummy.time, dummy.positions, dummy.markers, dummy.leg, perturbations=windows, **names)
    return fit(tepsipe.frequency_response(dummy.time, dummy.torque, dummy.angle))
