"""Onsets are found where bursts begin, shift as they do, and are not made of noise."""

from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np
import pytest
from builders import assert_one_sentence
from emg_builders import EMG_RATE_HZ, ramp_burst, raw_responses, sine_burst
from scipy import signal

from tepsipe.errors import InputError
from tepsipe.signals.emg import EmgOptions, process_emg
from tepsipe.signals.epochs import without_artefact
from tepsipe.signals.onsets import (
    DETECTORS,
    OnsetOptions,
    _looked_at,
    _moving_mean,
    detect_onset,
    ramp_onset,
)
from tepsipe.signals.resampling import regular_time, resample

LATENCY_S = 0.045
CHOSEN = OnsetOptions()
QUICK = OnsetOptions(bootstrap_draws=0)


def responses(burst, events, peak, rng, **disturbances):
    """Time (s) and band-passed responses (uV)."""
    time, raw = raw_responses(burst, events, peak, rng, **disturbances)
    return time, process_emg(raw.T, EMG_RATE_HZ, EmgOptions()).band_passed.T


def errors(detector, shape, events, peak, repeats, seed=7, **disturbances):
    """Errors of the latency (s) over many ensembles, NaN where there was no onset."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(repeats):
        truth = LATENCY_S + rng.uniform(0.0, 1e-3)
        time, x = responses(partial(shape, onset_s=truth), events, peak, rng, **disturbances)
        onset = detect_onset(time, x, replace(QUICK, detector=detector), rng)
        found.append(np.nan if onset.latency_s is None else onset.latency_s - truth)
    return np.array(found)


# ---- accuracy ----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("shape", [ramp_burst, sine_burst])
@pytest.mark.parametrize(("events", "peak"), [(40, 5.0), (80, 10.0)])
def test_change_point_is_within_two_milliseconds(shape, events, peak):
    found = errors("changepoint", shape, events, peak, 40)
    assert np.isfinite(found).all()
    assert abs(found.mean()) < 1.2e-3
    assert found.std() < 1.2e-3
    assert abs(found.mean()) + 2.0 * found.std() < 2.5e-3


@pytest.mark.slow
@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize(("events", "peak"), [(40, 5.0), (60, 7.0)])
def test_every_detector_is_within_five_milliseconds(detector, events, peak):
    found = errors(detector, ramp_burst, events, peak, 30)
    assert np.isfinite(found).all()
    assert abs(np.median(found)) + np.median(np.abs(found - np.median(found))) < 5e-3


@pytest.mark.slow
def test_change_point_does_not_depend_on_the_size_of_the_burst_as_a_threshold_does():
    drift = {
        detector: abs(
            np.subtract(*(errors(detector, ramp_burst, 60, peak, 25).mean() for peak in (3.0, 12.0)))
        )
        for detector in DETECTORS
    }
    assert drift["changepoint"] < 1e-3
    assert drift["changepoint"] < 0.5 * drift["teager-kaiser"]
    assert drift["changepoint"] < 0.5 * drift["threshold"]


def test_weak_response_of_twice_the_rest_is_found_without_much_bias():
    found = errors("changepoint", ramp_burst, 40, 2.0, 40)
    assert np.isfinite(found).mean() > 0.9
    assert abs(np.nanmedian(found)) < 2.5e-3


def test_strong_hum_and_unequal_bursts_do_not_spoil_the_change_point():
    found = errors("changepoint", ramp_burst, 60, 7.0, 30, rest=1.0, hum=3.0, spread=0.6)
    assert abs(found.mean()) + found.std() < 2e-3


def test_second_burst_does_not_hide_the_first():
    def two(time):
        return 0.5 * sine_burst(time, LATENCY_S) + sine_burst(time, 0.12)

    rng = np.random.default_rng(3)
    for detector in DETECTORS:
        onset = detect_onset(*responses(two, 60, 10.0, rng), replace(QUICK, detector=detector), rng)
        assert onset.latency_s == pytest.approx(LATENCY_S, abs=0.008)


def test_artefact_of_the_perturbation_is_not_taken_for_a_reflex(rng):
    time, raw = raw_responses(partial(ramp_burst, onset_s=LATENCY_S), 60, 7.0, rng)
    sizes = rng.choice([0.2, 0.3, 0.4, 0.5], 60) * rng.choice([-1.0, 1.0], 60)
    swing = np.maximum(time - 0.025, 0.0)
    moved = 150.0 * np.sin(2.0 * np.pi * 40.0 * swing) * np.exp(-swing / 0.03)
    x = process_emg((raw + np.outer(sizes / 0.5, moved)).T, EMG_RATE_HZ, EmgOptions()).band_passed.T
    spoilt = detect_onset(time, x, QUICK, rng).latency_s
    assert spoilt is None or abs(spoilt - LATENCY_S) > 5e-3
    assert detect_onset(time, without_artefact(x, sizes), QUICK, rng).latency_s == pytest.approx(
        LATENCY_S, abs=3e-3
    )


# ---- invariance --------------------------------------------------------------------------------


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("shift_s", [0.0123, -0.0301])
def test_time_shift_moves_the_latency_by_exactly_that(detector, shift_s, rng):
    time, x = responses(partial(ramp_burst, onset_s=0.06), 40, 7.0, rng)
    options = replace(CHOSEN, detector=detector, bootstrap_draws=50)
    before = detect_onset(time, x, options, np.random.default_rng(1))
    moved = replace(
        options,
        baseline_until_s=options.baseline_until_s + shift_s,
        search_s=(options.search_s[0] + shift_s, options.search_s[1] + shift_s),
    )
    after = detect_onset(time + shift_s, x, moved, np.random.default_rng(1))
    assert after.latency_s == pytest.approx(before.latency_s + shift_s, abs=1e-9)
    assert after.standard_error_s == pytest.approx(before.standard_error_s, abs=1e-9)


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("scale", [1e-6, 1e3])
def test_unit_does_not_matter(detector, scale, rng):
    time, x = responses(partial(ramp_burst, onset_s=LATENCY_S), 40, 7.0, rng)
    options = replace(QUICK, detector=detector)
    found = [detect_onset(time, s * x, options, rng).latency_s for s in (1.0, scale)]
    assert found[0] == pytest.approx(found[1], abs=1e-9)


@pytest.mark.parametrize("detector", DETECTORS)
def test_order_of_the_events_does_not_matter(detector, rng):
    time, x = responses(partial(ramp_burst, onset_s=LATENCY_S), 40, 7.0, rng)
    options = replace(QUICK, detector=detector)
    found = [detect_onset(time, each, options, rng).latency_s for each in (x, x[::-1])]
    assert found[0] == pytest.approx(found[1], abs=1e-9)


@pytest.mark.parametrize("detector", DETECTORS)
def test_without_any_noise_the_first_sample_of_a_burst_is_its_onset(detector, rng):
    time = np.arange(-400, 401) / EMG_RATE_HZ
    burst = rng.standard_normal((40, time.size)) * ramp_burst(time, LATENCY_S)
    onset = detect_onset(time, burst, replace(QUICK, detector=detector), rng)
    assert onset.latency_s == pytest.approx(LATENCY_S, abs=0.0025)


def test_quiet_sine_that_grows_is_found_where_it_grows(rng):
    time = np.arange(-400, 401) / EMG_RATE_HZ
    phase = rng.uniform(0.0, 2.0 * np.pi, (50, 1))
    carrier = np.sin(2.0 * np.pi * 110.0 * time + phase)
    x = carrier * (1.0 + 6.0 * np.clip((time - LATENCY_S) / 0.02, 0.0, 1.0))
    assert detect_onset(time, x, QUICK, rng).latency_s == pytest.approx(LATENCY_S, abs=1e-3)


# ---- uncertainty and what is no onset ----------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("detector", DETECTORS)
def test_standard_error_is_the_spread_over_ensembles(detector):
    rng = np.random.default_rng(11)
    options = replace(CHOSEN, detector=detector, bootstrap_draws=100)
    found = [
        detect_onset(*responses(partial(ramp_burst, onset_s=LATENCY_S), 50, 6.0, rng), options, rng)
        for _ in range(25)
    ]
    latencies = np.array([each.latency_s for each in found])
    middle = np.percentile(latencies, [16.0, 84.0])
    assert np.median([each.standard_error_s for each in found]) == pytest.approx(
        0.5 * np.ptp(middle), rel=0.6
    )
    for each in found:
        assert each.found_share > 0.9
        assert each.interval_s[0] < each.latency_s + 1e-3
        assert each.interval_s[1] > each.latency_s - 1e-3
        assert 0.0 < np.ptp(each.interval_s) < 6.0 * each.standard_error_s
        assert each.reason is None


def test_interval_of_the_change_point_covers_the_truth():
    rng = np.random.default_rng(12)
    covered = []
    for _ in range(30):
        time, x = responses(partial(ramp_burst, onset_s=LATENCY_S), 40, 4.0, rng)
        low, high = detect_onset(time, x, replace(CHOSEN, bootstrap_draws=100), rng).interval_s
        covered.append(low <= LATENCY_S <= high)
    assert np.mean(covered) > 0.75


def test_the_seed_decides_the_uncertainty(rng):
    time, x = responses(partial(ramp_burst, onset_s=LATENCY_S), 40, 5.0, rng)
    found = [detect_onset(time, x, CHOSEN, np.random.default_rng(seed)) for seed in (1, 1, 2)]
    assert found[0] == found[1]
    assert found[0].latency_s == found[2].latency_s
    assert found[0].standard_error_s != found[2].standard_error_s


@pytest.mark.slow
@pytest.mark.parametrize("detector", DETECTORS)
def test_no_onset_is_made_of_noise(detector):
    rng = np.random.default_rng(13)
    options = replace(CHOSEN, detector=detector, bootstrap_draws=20)
    found = [detect_onset(*responses(np.zeros_like, 40, 5.0, rng), options, rng) for _ in range(60)]
    invented = [each for each in found if each.latency_s is not None]
    assert len(invented) <= 1
    for each in found:
        if each.latency_s is None:
            assert_one_sentence(each.reason)
            assert each.standard_error_s is each.interval_s is None


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("value", [0.0, 3.0])
def test_flat_responses_have_no_onset(detector, value, rng):
    time = np.arange(-400, 401) / EMG_RATE_HZ
    onset = detect_onset(time, np.full((10, time.size), value), replace(CHOSEN, detector=detector), rng)
    assert onset.latency_s is None
    assert_one_sentence(onset.reason)


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("onset_s", [-0.03, 0.005, 0.25])
def test_burst_that_begins_outside_of_the_searched_time_is_no_onset(detector, onset_s, rng):
    time, x = responses(partial(ramp_burst, onset_s=onset_s), 60, 10.0, rng)
    options = replace(CHOSEN, detector=detector, baseline_until_s=-0.05)
    assert detect_onset(time, x, options, rng).latency_s is None


def test_silence_after_the_event_is_no_onset(rng):
    time, x = responses(lambda t: -0.24 * ramp_burst(t, LATENCY_S, decay_s=0.2), 60, 5.0, rng, rest=20.0)
    assert detect_onset(time, x, CHOSEN, rng).latency_s is None


def test_without_draws_there_is_a_latency_and_no_uncertainty(rng):
    onset = detect_onset(*responses(partial(ramp_burst, onset_s=LATENCY_S), 40, 7.0, rng), QUICK, rng)
    assert onset.latency_s is not None
    assert onset.standard_error_s is onset.interval_s is onset.found_share is None


@pytest.mark.parametrize("detector", DETECTORS)
def test_five_hundred_draws_take_no_time(detector, rng):
    time, x = responses(partial(ramp_burst, onset_s=LATENCY_S), 80, 7.0, rng)
    start = perf_counter()
    detect_onset(time, x, replace(CHOSEN, detector=detector), rng)
    assert perf_counter() - start < 1.0


# ---- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "changes",
    [
        {"detector": "eye"},
        {"search_s": (-0.01, 0.2)},
        {"search_s": (0.2, 0.1)},
        {"search_s": (0.02, 0.5)},
        {"baseline_until_s": -0.35},
        {"longest_rise_s": 0.5},
        {"bootstrap_draws": 1},
        {"bootstrap_draws": -5},
    ],
)
def test_options_that_do_not_fit_are_refused(changes, rng):
    time, x = responses(partial(ramp_burst, onset_s=LATENCY_S), 10, 7.0, rng)
    with pytest.raises(InputError) as caught:
        detect_onset(time, x, replace(CHOSEN, **changes), rng)
    assert_one_sentence(caught.value)


def test_responses_that_cannot_be_used_are_refused(rng):
    time, x = responses(partial(ramp_burst, onset_s=LATENCY_S), 10, 7.0, rng)
    holed = x.copy()
    holed[3, 400] = np.nan
    for bad in (x[:4], x[:, :-1], x[0], holed):
        with pytest.raises(InputError) as caught:
            detect_onset(time, bad, CHOSEN, rng)
        assert_one_sentence(caught.value)


# ---- onset of a motion -------------------------------------------------------------------------

SLOW_HZ = 250.0


def belt_velocity(time, onset_s, lag_s=0.0):
    """One period of a sine of 0.1 s, behind a drive of second order (one if there is a lag)."""
    fine = np.arange(-0.1, 0.7, 1e-4)
    velocity = np.where((fine > 0.0) & (fine < 0.1), np.sin(2.0 * np.pi * fine / 0.1), 0.0)
    if lag_s:
        drive = signal.butter(2, 1.0 / (2.0 * np.pi * lag_s), fs=1e4, output="sos")
        velocity = signal.sosfilt(drive, velocity)
    return np.interp(time - onset_s, fine, velocity)


def at_250_hz(onset_s, rng, noise=0.0, lag_s=0.0):
    """Time (s) and velocity as the ingest makes them: from 1000 Hz, low-passed at 100 Hz."""
    fast = np.arange(-600, 601) / EMG_RATE_HZ
    slow = regular_time(-0.5, 0.5, SLOW_HZ)
    velocity = belt_velocity(fast, onset_s, lag_s) + noise * rng.standard_normal(fast.size)
    return slow, resample(fast, velocity, slow, band_hz=0.4 * SLOW_HZ)


@pytest.mark.parametrize("onset_s", [0.0, 0.0007, 0.0013, 0.0021, 0.0039])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_onset_of_a_belt_is_found_between_the_samples(onset_s, sign, rng):
    time, velocity = at_250_hz(onset_s, rng)
    assert ramp_onset(time, 0.3 * sign * velocity, -0.012) == pytest.approx(onset_s, abs=5e-4)


def test_noise_on_the_belt_hardly_matters(rng):
    found = [ramp_onset(*at_250_hz(0.0013, rng, noise=0.01), -0.012) - 0.0013 for _ in range(40)]
    assert abs(np.mean(found)) < 5e-4
    assert np.std(found) < 5e-4


@pytest.mark.parametrize("rate_hz", [250.0, 1000.0])
def test_straight_ramp_from_an_offset_has_an_exact_onset(rate_hz):
    time = np.arange(-0.4, 0.4, 1.0 / rate_hz)
    x = 0.7 + 3.0 * np.clip(time - 0.01234, 0.0, 0.08)
    assert ramp_onset(time, x, 0.0) == pytest.approx(0.01234, abs=2e-4)


def test_shift_moves_the_onset_of_a_motion_by_exactly_that(rng):
    time, velocity = at_250_hz(0.001, rng)
    there = ramp_onset(time + 3.0, velocity, 2.99)
    assert there == pytest.approx(ramp_onset(time, velocity, -0.01) + 3.0, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("lag_s", [0.0, 0.004, 0.008])
def test_delay_behind_a_soft_start_is_that_between_both_onsets(lag_s):
    rng = np.random.default_rng(21)
    delays = []
    for _ in range(12):
        start = rng.uniform(0.0, 0.004)
        motion = ramp_onset(*at_250_hz(start, rng, 0.003, lag_s), -0.012)
        drive = partial(belt_velocity, onset_s=start + LATENCY_S, lag_s=lag_s)
        time, x = responses(lambda t, drive=drive: np.maximum(0.0, drive(t)), 60, 7.0, rng)
        delays.append(detect_onset(time, x, QUICK, rng).latency_s - motion)
    assert np.mean(delays) == pytest.approx(LATENCY_S, abs=2e-3)
    assert np.std(delays) < 2e-3


@pytest.mark.parametrize(
    ("change", "until_s"),
    [
        (lambda x: np.zeros_like(x), -0.01),
        (lambda x: np.where(np.arange(x.size) == 9, np.nan, x), -0.01),
        (lambda x: x, -0.49),
        (lambda x: x, 0.6),
        (lambda x: x, 0.03),
    ],
    ids=["no motion", "NaN", "no rest", "only rest", "moving at rest"],
)
def test_motion_without_an_onset_is_refused(change, until_s, rng):
    time, velocity = at_250_hz(0.001, rng)
    with pytest.raises(InputError) as caught:
        ramp_onset(time, change(velocity), until_s)
    assert_one_sentence(caught.value)


def test_rest_of_five_samples_is_enough_for_a_ramp_and_one_of_four_is_not():
    time = np.arange(40) / 100.0
    ramp = np.maximum(0.0, time - 0.1)
    assert ramp_onset(time, ramp, baseline_until_s=0.045) == pytest.approx(0.1, abs=0.002)
    with pytest.raises(InputError) as caught:
        ramp_onset(time, ramp, baseline_until_s=0.035)
    assert_one_sentence(caught.value, "at least 5 samples at rest", "4 of 40")


def test_whitening_of_a_process_of_first_order_leaves_its_innovations(rng):
    time = np.arange(-2000, 2000) / 1000.0
    innovations = rng.standard_normal((20, time.size))
    x = signal.lfilter([1.0], [1.0, -0.9], innovations, axis=1)
    options = replace(CHOSEN, whitening_order=1)
    found = _looked_at(time, x, replace(options, baseline_until_s=0.0))
    np.testing.assert_allclose(found[:, 500:], np.abs(innovations[:, 500:]), atol=0.15)


def test_moving_mean_covers_its_window():
    time = np.arange(11) / 100.0
    impulse = np.where(np.arange(11) == 5, 1.0, 0.0)
    assert np.count_nonzero(_moving_mean(time, impulse, 0.09)) == 9


def test_missing_onset_is_told_with_the_searched_time(rng):
    time = np.arange(-400, 401) / EMG_RATE_HZ
    options = replace(CHOSEN, search_s=(0.02, 0.15))
    found = detect_onset(time, np.full((10, time.size), 3.0), options, rng)
    assert "20 to 150 ms after the event" in found.reason
