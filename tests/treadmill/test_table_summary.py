"""Coefficients, range and cross-prediction of a recorded treadmill, on a belt whose law is known."""

import numpy as np
import pytest
import scipy

from tepsipe.treadmill.mass_models import fit_mass_spring_damper
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FamilyOptions, FittedModel
from tepsipe.treadmill.table_summary import beyond, cross_prediction, model_coefficients, range_of_validity

RATE, MASS, DAMPING = 100.0, 2.8, -1.5


def belt(seed, noise=0.3, scale=1.0, name="one"):
    """A belt under random accelerations whose load is m a + c v and noise that is correlated over 0.2 s."""
    rng = np.random.default_rng(seed)
    n = 6000
    lowpass = scipy.signal.butter(2, 3.0, fs=RATE, output="sos")
    velocity = 1.2 + scale * scipy.signal.sosfiltfilt(lowpass, rng.normal(0.0, 0.5, n))
    acceleration = np.gradient(velocity, 1.0 / RATE)
    colour = scipy.signal.lfilter([1.0], [1.0, -0.95], rng.normal(0.0, 1.0, n))
    load = MASS * acceleration + DAMPING * (velocity - velocity.mean()) + noise * colour / colour.std()
    return BeltRecording(
        name=name, condition=name, rate_hz=RATE, velocity=velocity, acceleration=acceleration,
        raw_velocity=velocity, load=load, carried=np.zeros(n), carried_kg=0.0, unit="Nm",
        evaluated=np.ones(n, dtype=bool),
    )  # fmt: skip


def fitted(recording):
    return FittedModel("mass-spring-damper", fit_mass_spring_damper([recording]), "Nm", None, ("one",))


def test_intervals_hold_the_coefficients_although_residuals_are_correlated():
    held = 0
    for seed in range(40):
        recording = belt(seed)
        m, low, high = model_coefficients([fitted(recording)], [recording])["mass-spring-damper"]["m"]
        assert low < m < high
        held += low <= MASS <= high
    # 95 % of 40, five standard deviations below
    assert held >= 31
    width = [
        np.diff(model_coefficients([fitted(r)], [r])["mass-spring-damper"]["m"][1:])[0]
        for r in (belt(0), belt(0, noise=0.6))
    ]
    assert width[1] == pytest.approx(2.0 * width[0], rel=0.05)


def test_range_is_that_of_the_calibration_and_faster_belts_lie_beyond():
    slow, fast = belt(1), belt(1, scale=2.0)
    ranges = range_of_validity([slow])
    assert ranges["velocity"] == [slow.velocity.min(), slow.velocity.max()]
    assert beyond(slow, ranges) == 0.0
    assert 0.0 < beyond(fast, ranges) < 1.0


def test_every_recording_predicts_every_other():
    recordings = {"one": belt(1), "two": belt(2, name="two")}
    crossed = cross_prediction(recordings, ["mass-spring-damper", "hnat2014"], FamilyOptions())
    assert list(crossed) == ["mass-spring-damper"]
    found = crossed["mass-spring-damper"]
    assert found["one"]["one"] >= found["two"]["one"] > 0.8
    assert cross_prediction({"one": belt(1)}, ["mass-spring-damper"], FamilyOptions()) == {}
