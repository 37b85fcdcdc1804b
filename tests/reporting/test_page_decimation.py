"""Decimation of traces for the pages: what must survive, and how small the rest becomes."""

import numpy as np
import pytest

from tepsipe.drawing.trial_page import decimate, pack, plan_runs, unpack


def spiky(rng, size):
    x = np.cumsum(rng.normal(size=size))
    x[rng.integers(0, size, 5)] += rng.choice([-1e3, 1e3], 5)
    x[rng.random(size) < 0.01] = np.nan
    return x


@pytest.mark.parametrize("seed", range(30))
def test_every_extreme_of_every_stretch_survives(seed):
    rng = np.random.default_rng(seed)
    size, points = int(rng.integers(1, 20_000)), int(rng.integers(4, 3_000))
    focus = [
        (int(a), int(a + rng.integers(0, 400))) for a in rng.integers(-100, size + 100, rng.integers(0, 9))
    ]
    x = spiky(rng, size)
    runs = plan_runs(size, points, focus)
    # they cover the trace without gap or overlap, and are as few as they may be
    assert [r.start for r in runs] == [0, *(r.stop for r in runs[:-1])]
    assert runs[-1].stop == size
    assert sum(r.points for r in runs) <= max(size, 0) or size > points
    assert sum(r.points for r in runs) <= points + 2 * (len(focus) + 1)
    kept = decimate(x, runs)
    assert kept.size == sum(r.points for r in runs)
    at = 0
    for run in runs:
        own, shown = x[run.start : run.stop], kept[at : at + run.points]
        at += run.points
        if run.step == 1:
            np.testing.assert_array_equal(shown, own)
            continue
        for k, pair in enumerate(shown.reshape(-1, 2)):
            bucket = own[k * run.step : (k + 1) * run.step]
            there = bucket[np.isfinite(bucket)]
            if not there.size:
                assert np.isnan(pair).all()
                continue
            assert {pair.min(), pair.max()} == {there.min(), there.max()}
            # in the order in which they happened
            first, second = (np.flatnonzero(bucket == value)[0] for value in pair)
            assert first <= second


def test_samples_in_focus_are_kept_unless_they_are_too_many():
    x = np.sin(np.arange(10_000.0))
    runs = plan_runs(x.size, 2_000, [(4_000, 4_500), (4_400, 4_600)])
    (whole,) = [r for r in runs if r.step == 1]
    assert (whole.start, whole.stop) == (4_000, 4_600)
    assert {r.step for r in plan_runs(x.size, 2_000, [(0, 9_000)])} == {10}
    assert plan_runs(0, 100) == ()
    assert decimate(np.empty(0), ()).size == 0


@pytest.mark.parametrize("offset", [0.0, 1e6, -3e-7])
def test_packed_numbers_come_back_to_a_65534th_of_their_range(rng, offset):
    x = offset + rng.normal(size=999)
    x[[3, 500]] = np.nan
    back = unpack(pack(x))
    assert np.isnan(back[[3, 500]]).all()
    span = np.nanmax(x) - np.nanmin(x)
    assert np.nanmax(np.abs(back - x)) <= 0.51 * span / 65534 + 1e-15 * abs(offset)
    for extreme in (np.nanmin, np.nanmax):
        assert extreme(back) == pytest.approx(extreme(x), abs=1e-9 * span + 1e-15 * abs(offset))


@pytest.mark.parametrize(
    ("x", "back"),
    [
        ([2.5, 2.5], [2.5, 2.5]),
        ([np.nan], [np.nan]),
        ([np.inf, 1.0], [np.nan, 1.0]),
        ([], []),
        ([-7.0], [-7.0]),
    ],
)
def test_traces_without_a_range_are_packed_too(x, back):
    np.testing.assert_array_equal(unpack(pack(np.array(x, dtype=float))), back)
