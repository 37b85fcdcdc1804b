"""Ripple of the rollers: orders found over distance, amplitude and phase tracked from the past only."""

from dataclasses import replace

import numpy as np
import pytest
from belt_builders import OPTIONS, RATE_HZ, RIPPLE, belt_recording, swaying_belt
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.black_box_models import (
    BLOCK_S,
    RippleTracker,
    fit_ripple_tracker,
    spectrum_over_distance,
)
from tepsipe.treadmill.registry import evaluate, fit_model

ORDERS, SIZES = (0.57, 1.73), (2.0, 1.0)
SHORT = replace(OPTIONS, fir_lead_s=0.0, fir_lag_s=0.02)


def with_ripple(rng, sizes=SIZES, noise=0.3, phase=0.0):
    """Load of 3 Nm per m/s2, ripple of two rollers, and noise."""

    def load(x, v, a):
        waves = [
            size * np.cos(2.0 * np.pi * order * x + phase + 1.0)
            for order, size in zip(ORDERS, sizes, strict=True)
        ]
        return 3.0 * a + np.sum(waves, axis=0) + noise * rng.standard_normal(a.size)

    return load


class Gain:
    """A base model that is known: 3 Nm per m/s2."""

    rate_hz = RATE_HZ

    def predict(self, recording):
        return 3.0 * recording.acceleration


def tracker_of(recordings, **changes):
    return fit_ripple_tracker(recordings, Gain(), replace(RIPPLE, **changes))


def test_orders_and_amplitudes_are_found_over_distance_at_any_speed_and_phase(rng):
    recordings = [swaying_belt(with_ripple(rng, phase=phase), rng, 120.0) for phase in (0.0, 2.0)]
    assert np.ptp(recordings[0].velocity) > 0.5
    tracker = tracker_of(recordings)
    assert tracker.orders_per_m == pytest.approx(ORDERS, abs=1e-3)  # the stronger one first
    assert tracker.amplitudes == pytest.approx(SIZES, rel=0.03)
    assert tracker.noise == pytest.approx(np.sqrt(0.5 * (2.0**2 + 1.0**2) + 0.3**2), rel=0.02)
    assert tracker_of(recordings, most_orders=1).orders_per_m == pytest.approx([0.57], abs=1e-3)


def test_tracked_ripple_leaves_little_more_than_the_noise(rng):
    train = swaying_belt(with_ripple(rng), rng, 120.0)
    test = swaying_belt(with_ripple(rng, phase=2.5), rng, 120.0)
    untracked, tracked = (fit_model(name, [train], SHORT) for name in ("fir", "ripple-tracking"))
    assert tracked.model.orders_per_m == pytest.approx(ORDERS, abs=1e-3)
    assert evaluate(untracked, [test]).rms_after == pytest.approx(np.sqrt(2.5 + 0.3**2), rel=0.03)
    # four amplitudes learnt within 20 s, and from nothing in the beginning
    settled = replace(test, evaluated=np.arange(test.load.size) > 2000)
    assert 0.3 < evaluate(tracked, [settled]).rms_after < 0.33
    assert evaluate(tracked, [test]).rms_after < 0.4


def test_ripple_is_not_tracked_without_options(rng):
    train = swaying_belt(with_ripple(rng), rng, 30.0)
    with pytest.raises(InputError) as caught:
        fit_model("ripple-tracking", [train], replace(SHORT, ripple=None))
    assert_one_sentence(caught.value, "options of the ripple", "'ripple-tracking'")


@pytest.mark.parametrize("last", [37, 3000, 3005, 5999])
def test_nothing_is_predicted_from_the_present_or_the_future(last, rng):
    train, test = (swaying_belt(with_ripple(rng), rng) for _ in range(2))
    fitted = fit_model("ripple-tracking", [train], SHORT)
    changed = test.load.copy()
    changed[last:] += 50.0 * rng.standard_normal(changed.size - last)
    before, after = fitted.predict(test), fitted.predict(replace(test, load=changed))
    assert np.array_equal(after[: last + 1], before[: last + 1])
    if last < 5000:
        assert np.abs(after - before)[last + 20 :].max() > 0.1


def test_first_moments_are_predicted_by_the_base_alone_and_the_ripple_within_seconds(rng):
    test = swaying_belt(with_ripple(rng, noise=0.1), rng)
    tracker = tracker_of([test])
    left = tracker.predict(test) - 3.0 * test.acceleration
    assert np.array_equal(left[:10], np.zeros(10))
    ripple = test.load - 3.0 * test.acceleration
    error = np.sqrt(np.mean((ripple - left)[500:1000] ** 2))
    assert error < 0.25 * np.sqrt(np.mean(ripple**2))


@pytest.mark.parametrize(("memory_s", "share"), [(5.0, np.exp(-2.0)), (20.0, np.exp(-0.5))])
def test_ripple_that_stops_is_forgotten_with_the_memory(memory_s, share, rng):
    test = swaying_belt(with_ripple(rng, noise=0.0), rng, 120.0)
    tracker = tracker_of([test], memory_s=memory_s)
    stopped = 6000
    silent = np.where(np.arange(test.load.size) < stopped, test.load, 3.0 * test.acceleration)
    left = tracker.predict(replace(test, load=silent)) - 3.0 * test.acceleration
    size = np.sqrt(np.mean(left[stopped + 850 : stopped + 1150] ** 2) / 2.5)  # 10 s later
    # before the stop a time T of ripple had been collected; (1 - exp(-60 s / T)) of it
    assert size == pytest.approx(share * (1.0 - np.exp(-60.0 / memory_s)), rel=0.12)


def test_waves_pass_the_filter_that_the_load_has_passed(rng):
    lowpass = Lowpass(2.0, 2, False)  # the 1.73/m at 1.2 m/s lie at 2.1 Hz: delayed and halved
    recordings = [swaying_belt(with_ripple(rng, noise=0.05), rng, 120.0).filtered(lowpass) for _ in range(2)]
    train, test = recordings
    tracker = tracker_of([train], most_orders=2)
    assert tracker.orders_per_m == pytest.approx(ORDERS, abs=1e-3)
    assert tracker.amplitudes == pytest.approx(SIZES, rel=0.03)  # before the filter
    settled = slice(3000, None)
    error = (test.load - tracker.predict(test))[settled]
    unfiltered = replace(test, lowpass=None)
    other = tracker_of([replace(train, lowpass=None)], most_orders=2)
    worse = (test.load - other.predict(unfiltered))[settled]
    assert np.sqrt(np.mean(error**2)) < 0.06
    assert np.sqrt(np.mean(worse**2)) > 3.0 * np.sqrt(np.mean(error**2))


def test_belt_that_hardly_travels_has_no_orders_and_is_predicted_by_the_base(rng):
    r = swaying_belt(with_ripple(rng), rng)
    still = replace(r, raw_velocity=r.raw_velocity - 1.2)
    tracker = tracker_of([still])
    assert tracker.order == 0
    assert np.array_equal(tracker.predict(still), 3.0 * still.acceleration)


def test_spectrum_over_distance_shows_order_and_size_of_a_wave(rng):
    r = swaying_belt(with_ripple(rng, sizes=(2.0, 0.0), noise=0.0), rng, 120.0)
    found = spectrum_over_distance(r, r.load - 3.0 * r.acceleration)
    highest = np.argmax(found.power)
    assert found.order_per_m[highest] == pytest.approx(0.57, abs=0.6 / 144.0)  # 144 m travelled
    assert 0.85 * 2.0 < np.sqrt(found.power[highest]) < 1.01 * 2.0
    assert spectrum_over_distance(replace(r, evaluated=np.arange(r.load.size) < 800), r.load) is None  # 9.6 m


def test_amplitudes_of_the_second_block_are_drawn_to_zero_by_what_is_typical_of_them():
    """Ridge noise^2 / amplitude^2 per wave: normal equations of the first block, by hand."""
    still = np.zeros(2 * round(BLOCK_S * RATE_HZ))
    belt = belt_recording(still + 1.2, still, still)
    phase = 2.0 * np.pi * 1.5 * belt.position
    belt = replace(belt, load=4.0 * np.cos(phase))
    tracker = RippleTracker(Gain(), np.array([1.5]), np.array([0.5]), 3.0, 1e9, RATE_HZ)
    first, second = np.split(np.arange(still.size), 2)
    columns = np.column_stack([np.cos(phase), np.sin(phase)])
    normal = columns[first].T @ columns[first] + np.eye(2) * 3.0**2 / 0.5**2
    expected = columns[second] @ np.linalg.solve(normal, columns[first].T @ belt.load[first])
    assert tracker.predict(belt)[second] == pytest.approx(expected, rel=1e-6)
