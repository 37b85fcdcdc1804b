"""Latencies where a reflex needs a fast enough stretch: electromyograms of a laboratory of these tests."""

from dataclasses import replace

import numpy as np
import pytest
from emg_builders import EMG_RATE_HZ, emg
from standing_builders import RESPONSE_TIME, responses_with

from tepsipe.experiments.standing.thesis.latency import latency_estimates, muscle_latency
from tepsipe.experiments.standing.thesis.stretch_threshold import (
    Stretch,
    groups_by_amplitude,
    lateness_of,
    rising_stretch,
)
from tepsipe.signals.emg import EmgOptions, process_emg
from tepsipe.signals.onsets import Onset, OnsetOptions
from tepsipe.statistics.uncertainty import Source

OPTIONS = OnsetOptions(search_s=(0.02, 0.12), bootstrap_draws=100)
START = Source("latency_s", 0.0015, "rectangular")  # of the shipped configuration
LATENCY_S, PULSE_S = 0.042, 0.05
SPEED = 1.2  # rad/s of the stretch per m/s of the belt
TRIALS, RESPONSES = 4, 8


def stretch_of(time, amplitude):
    """Speed of the stretch (rad/s): half of a sine, and then back."""
    inside = (time > 0.0) & (time < 2.0 * PULSE_S)
    return np.where(inside, SPEED * amplitude * np.sin(np.pi * time / PULSE_S), 0.0)


def trial(rng, amplitude, threshold):
    """Responses (uV) to pulses of an amplitude (m/s) of a reflex with a threshold (rad/s) of the stretch."""
    time = np.arange(-700, 1401) / EMG_RATE_HZ
    sizes = amplitude * (1.0 + 0.02 * rng.standard_normal(RESPONSES))[:, None]
    sensed = stretch_of(time - LATENCY_S, sizes)
    gain = 120.0 * np.exp(0.3 * rng.standard_normal((RESPONSES, 1)))
    raw = emg(3.0 + gain * np.maximum(sensed - threshold, 0.0), rng)
    flat = responses_with(0.0 * RESPONSE_TIME, {"SOL": 0.0 * RESPONSE_TIME}, sizes=sizes[:, 0])
    filtered = process_emg(raw.T, EMG_RATE_HZ, EmgOptions()).band_passed.T
    speed = stretch_of(RESPONSE_TIME, sizes)
    return replace(
        flat,
        emg=filtered[:, 400:1701, None],
        perturbed=flat.perturbed | {"belt_velocity": speed / SPEED},
        stretch={"ankle": speed, "knee": 0.0 * speed},
    )


def row_of(rng, amplitudes, threshold):
    """Row of the latency by the change point, with the shipped uncertainty of the start of the stretch."""
    trials = [trial(rng, amplitudes[k % len(amplitudes)], threshold) for k in range(TRIALS)]
    found = muscle_latency(trials, "SOL", {"ankle": 1.0}, OPTIONS, np.random.default_rng(1))
    rows = {row.estimator: row for row in latency_estimates("relax", found, START)}
    return rows["changepoint"], found


# ---- by electromyograms ------------------------------------------------------------------------------


@pytest.mark.parametrize("amplitudes", [(0.2, 0.4), (0.2, 0.3, 0.4, 0.5), (0.3,)])
def test_a_threshold_makes_the_onset_late_and_the_interval_reaches_the_latency(amplitudes, rng):
    row, found = row_of(rng, amplitudes, 0.16)
    assert row.value > LATENCY_S + 0.003
    assert found.onsets["changepoint"].interval_s[0] > LATENCY_S  # missed by the scatter alone
    assert row.ci_low < LATENCY_S < row.ci_high
    assert row.flags == "stretch-threshold"
    assert row.u_type_b > 0.003


def test_onsets_after_small_pulses_tell_that_there_is_no_threshold(rng):
    row, found = row_of(rng, (0.2, 0.3, 0.4, 0.5), 0.0)
    alone, _ = row_of(np.random.default_rng(1), (0.3,), 0.0)
    assert row.ci_low < LATENCY_S < row.ci_high
    assert found.late.amplitudes == 4
    assert row.ci_high - row.ci_low < 0.7 * (alone.ci_high - alone.ci_low)
    assert alone.flags == "stretch-threshold"


@pytest.mark.slow
def test_intervals_cover_the_latency_with_and_without_a_threshold():
    rng, covered = np.random.default_rng(20), []
    for k in range(24):
        row, _ = row_of(rng, ((0.2, 0.35), (0.2, 0.3, 0.4, 0.5))[k % 2], rng.uniform(0.0, 0.2))
        covered.append(row.ci_low < LATENCY_S < row.ci_high)
    assert np.mean(covered) > 0.9


# ---- by onsets that are known ------------------------------------------------------------------------


def known(amplitude, onset_s, error_s=0.0002):
    time = np.arange(-0.1, 0.2, 0.004)
    return Stretch(onset_s, error_s, *rising_stretch(time, stretch_of(time, amplitude), PULSE_S))


def reached_s(threshold, amplitude):
    return PULSE_S / np.pi * np.arcsin(threshold / (SPEED * amplitude))


def test_onsets_of_two_amplitudes_determine_threshold_and_lateness():
    stretches = [known(a, LATENCY_S + reached_s(0.2, a)) for a in (0.2, 0.5)]
    whole_s = LATENCY_S + reached_s(0.2, 0.5)
    late = lateness_of(Onset(whole_s, 0.001, (0.04, 0.06), 1.0, None), stretches, stretches[0])
    assert late.median_s == pytest.approx(whole_s - LATENCY_S, abs=0.0015)
    assert late.most_s < whole_s - LATENCY_S + 0.005


def test_one_amplitude_allows_every_threshold_up_to_the_peak():
    one = known(0.3, 0.05)
    late = lateness_of(Onset(0.05, 0.001, (0.04, 0.06), 1.0, None), [one], one)
    assert late.median_s == pytest.approx(reached_s(0.5 * SPEED * 0.3, 0.3), abs=0.001)
    assert 0.8 * 0.5 * PULSE_S < late.most_s < 0.5 * PULSE_S
    assert lateness_of(Onset(None, None, None, 0.5, "none"), [], one).most_s == late.most_s


def test_pulses_are_grouped_by_size_whatever_their_direction():
    groups = groups_by_amplitude(np.array([0.5, -0.2, 0.21, 0.49, -0.52, 0.3]))
    assert [sorted(group.tolist()) for group in groups] == [[1, 2], [5], [0, 3, 4]]
