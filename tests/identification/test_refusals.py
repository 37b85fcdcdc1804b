"""Refusals of fits that the table of misuse cannot state, each with what they still take."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from builders import assert_one_sentence
from misuse import good, moved

import tepsipe
from tepsipe import InputError
from tepsipe.identification.estimators import LEAST_SQUARES, Record, estimate
from tepsipe.identification.regression.batched import instrumental_variables, window_parameters
from tepsipe.identification.time_varying import MovedJoint, impedance_of_ensemble
from tepsipe.signals.filters import butterworth_bandpass
from tepsipe.signals.onsets import ramp_onset
from tepsipe.signals.perturbations import unperturbed_samples
from tepsipe.signals.spectra import multitaper_response

RATE_HZ = 250.0
TIME = np.arange(500) / RATE_HZ
WINDOW = SimpleNamespace(start=100, stop=150)


def rows(seed=1):
    """Regressors of two windows, shape (2, 3, 40), and their torque."""
    x = np.random.default_rng(seed).standard_normal((2, 3, 40))
    return x, x.sum(axis=1)


def spoiled(change):
    """The same, where the second window is changed."""
    x, torque = rows()
    x[1] = change(x[1])
    return x, torque


def ensemble(length_s, segment_s, realisations):
    """A joint whose realisations follow each other."""
    angle, torque = 0.01 * np.random.default_rng(3).standard_normal((2, round(realisations * RATE_HZ)))
    starts = np.arange(realisations) * round(RATE_HZ)
    options = {"length_s": length_s, "segment_s": segment_s, "step_s": 0.1, "draws": 100}
    joint = MovedJoint(angle, torque, RATE_HZ)
    return impedance_of_ensemble(joint, starts, **options, rng=np.random.default_rng(4))


def ramp(baseline_until_s):
    """Onset of a step at 1 s."""
    return ramp_onset(TIME, (TIME >= 1.0).astype(float), baseline_until_s)


def rows_of_a_minute(gain):
    """An input, and the output of a gain."""
    u = np.random.default_rng(8).standard_normal(15000)
    return u, gain * u


def unperturbed(quiet_after_s):
    """Samples of 2 s with a pulse, outside of it and of the time after it."""
    return unperturbed_samples(500, RATE_HZ, [WINDOW], 0.2, quiet_after_s, "trial 1")


# call that is taken, call that is refused, words of the refusal
CALLS = {
    "windows-that-move": (
        lambda: window_parameters(*rows()),
        lambda: window_parameters(*spoiled(np.zeros_like)),
        "perturbations: expected motion in every window",
    ),
    "windows-that-determine": (
        lambda: window_parameters(*rows()),
        lambda: window_parameters(*spoiled(lambda x: np.stack([x[0], x[1], -2.0 * x[0]]))),
        "perturbations: expected windows that determine I, B, K",
    ),
    "belt-that-moves": (
        lambda: instrumental_variables(rows(2)[0], *rows()),
        lambda: instrumental_variables(0.0 * rows()[0], *rows()),
        "belt: expected motion in the windows",
    ),
    "long-segments": (
        lambda: ensemble(0.9, 0.5, 20),
        lambda: ensemble(0.9, 0.012, 20),
        "segments of at least",
    ),
    "even-order": (
        lambda: butterworth_bandpass(TIME, RATE_HZ, (1.0, 20.0), 4),
        lambda: butterworth_bandpass(TIME, RATE_HZ, (1.0, 20.0), 3),
        "even order",
    ),
    "motion-after-the-rest": (lambda: ramp(0.9), lambda: ramp(1.0), "which lasts until 1 s"),
    "output-with-power": (
        lambda: multitaper_response(*rows_of_a_minute(1.0), RATE_HZ, 20.0),
        lambda: multitaper_response(*rows_of_a_minute(0.0), RATE_HZ, 20.0),
        "power in input and output",
    ),
    "unperturbed-second": (
        lambda: unperturbed(0.6),
        lambda: unperturbed(0.7),
        "trial 1: expected at least 1 s of unperturbed standing",
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_value_on_either_side(name):
    taken, refused, words = CALLS[name]
    taken()
    with pytest.raises(InputError) as caught:
        refused()
    assert_one_sentence(caught.value, words)


def test_estimators_need_their_name_and_their_record():
    made, _, torque, windows = moved()
    record = Record(motion=made.motion, torque=torque, perturbations=windows, at_rest=made.time < 1.9)
    assert np.isfinite(estimate(LEAST_SQUARES, record).mean).all()
    with pytest.raises(InputError, match=r"expected an estimator of .*, found 'least'"):
        estimate("least", record)
    with pytest.raises(InputError, match=r"estimator windowed.*: expected a record with .*'torque'"):
        estimate(LEAST_SQUARES, replace(record, torque=None))


def test_xarray_and_axes_of_a_fit(monkeypatch):
    fit = tepsipe.fit_impedance(**good("fit_impedance"))
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(InputError, match="to_xarray: expected the package xarray, found none"):
        fit.to_xarray()
    with pytest.raises(InputError, match=r"plot: expected .* matplotlib Axes as ax, found 'int'"):
        fit.plot(ax=3)


def test_a_record_whose_second_half_rests_is_fitted():
    good_call = good("fit_impedance") | {"perturbations": None, "block_s": 0.5}
    time = good_call["time"]
    pulse = np.exp(-(((time - 2.0) / 0.1) ** 2))
    fit = tepsipe.fit_impedance(**(good_call | {"angle": 0.01 * pulse, "torque": 0.1 * pulse}))
    assert fit.quantities["K"].value == pytest.approx(10.0, rel=1e-3)
