"""Rows of latencies: their Type B, and onsets at an end of the searched time."""

import math

import numpy as np
import pytest

from tepsipe.experiments.standing.thesis.latency import MuscleLatency, latency_estimates
from tepsipe.signals.onsets import Onset, OnsetOptions, detect_onset
from tepsipe.statistics.uncertainty import Source

STRETCH = Source("latency_s", 0.0015, "rectangular")


def latency(onset):
    return MuscleLatency("SOL", {"changepoint": onset}, np.zeros(1), np.zeros(1), 35)


def test_type_b_widens_the_interval_and_keeps_its_skewness():
    onset = Onset(0.042, 0.001, (0.038, 0.043), 1.0, None)
    (alone,), (row,) = latency_estimates("x", latency(onset)), latency_estimates("x", latency(onset), STRETCH)
    assert (alone.ci_low, alone.ci_high, alone.u_type_b) == (0.038, 0.043, None)
    assert row.value == 0.042 and row.u_type_b == 0.0015
    assert row.standard_error == pytest.approx(math.hypot(0.001, 0.0015))
    assert row.ci_low < 0.038 and row.ci_high > 0.043
    assert row.ci_high - 0.043 == pytest.approx(0.038 - row.ci_low)


def test_onset_at_the_edge_of_its_search_has_no_value(rng):
    time = np.arange(-0.2, 0.2, 0.001)
    responses = rng.standard_normal((30, time.size)) * (1.0 + 20.0 * np.clip((time - 0.05) / 0.01, 0.0, 1.0))
    inside = detect_onset(time, responses, OnsetOptions("threshold", 0.0, (0.02, 0.15)), rng)
    assert inside.latency_s == pytest.approx(0.05, abs=0.006) and not inside.at_edge
    at = inside.latency_s
    edge = detect_onset(time, responses, OnsetOptions("threshold", 0.0, (at + 0.0003, 0.15)), rng)
    assert edge.latency_s is None and (edge.at_edge or "none" in edge.reason)
    last = detect_onset(time, responses, OnsetOptions("threshold", 0.0, (0.02, at + 0.0008)), rng)
    assert last.at_edge and "search elsewhere" in last.reason
    (row,) = latency_estimates("x", latency(last), STRETCH)
    assert math.isnan(row.value) and row.flags == "edge-of-search" and row.ci_low is None
