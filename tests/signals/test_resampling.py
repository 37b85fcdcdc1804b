"""Repairing, filling, aligning and resampling: exact where it can be, refused where it cannot."""

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.signals.resampling import (
    align_sequential_samples,
    bridge_gaps,
    fill_gaps,
    refuse_short,
    regular_time,
    repair_time_stamps,
    resample,
    rising_edge,
    runs_of,
)

# ---- time stamps -------------------------------------------------------------------------------


def test_repeated_stamps_are_dropped_and_counted():
    time = np.array([0.0, 0.1, 0.1, 0.1, 0.2, 0.3, 0.3])
    repaired = repair_time_stamps(time, 0.15, "log.txt")
    assert time[repaired.keep].tolist() == [0.0, 0.1, 0.2, 0.3]
    assert repaired.repeated == 3
    assert repaired.longest_step_s == pytest.approx(0.1)


def test_gap_is_measured_between_the_stamps_that_are_kept():
    time = np.array([0.0, 0.1, 0.1, 0.35, 0.4])
    assert repair_time_stamps(time, 0.3, "log.txt").longest_step_s == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("time", "found"),
    [
        ([0.0, 0.1, 0.05, 0.2], "backwards"),
        ([0.0, 0.1, np.nan, 0.2], "line 3"),
        ([0.0, 0.1, np.inf, 0.2], "line 3"),
        ([0.0, 0.1, 0.9, 1.0], "0.8 s"),
        ([0.0], "1 samples"),
        ([], "0 samples"),
    ],
)
def test_stamps_that_cannot_be_trusted_are_refused(time, found):
    with pytest.raises(InputError) as caught:
        repair_time_stamps(np.array(time), 0.5, "log.txt")
    assert_one_sentence(caught.value, "log.txt", found)


# ---- gaps --------------------------------------------------------------------------------------


def cubic(time):
    return np.column_stack([time**3 - time, 2.0 - time**2, 3.0 * time])


def test_gap_in_a_cubic_is_filled_exactly_and_marked():
    time = np.arange(200) / 250.0
    x = cubic(time)
    x[90:110, 1] = np.nan
    filled, missing = fill_gaps(x, 250.0, 0.1, "marker")
    assert filled == pytest.approx(cubic(time), abs=1e-12)
    assert np.flatnonzero(missing).tolist() == list(range(90, 110))


def test_samples_that_were_recorded_are_not_touched(rng):
    x = rng.standard_normal(300)
    x[[3, 100, 101, 250]] = np.nan
    filled, missing = fill_gaps(x, 250.0, 0.1, "marker")
    assert missing.sum() == 4
    assert (filled[~missing] == x[~missing]).all()
    assert np.isfinite(filled).all()
    assert np.isnan(x).sum() == 4


def test_gap_at_either_end_is_held_instead_of_extrapolated():
    x = np.arange(100.0) ** 2
    x[:5] = np.nan
    x[-5:] = np.nan
    filled, _ = fill_gaps(x, 250.0, 0.1, "marker")
    assert filled[:5] == pytest.approx(np.full(5, 25.0))
    assert filled[-5:] == pytest.approx(np.full(5, 94.0**2))


def test_gap_of_exactly_the_longest_time_is_filled_and_one_sample_more_is_refused():
    x = np.sin(np.arange(500) / 20.0)
    x[200:225] = np.nan
    assert fill_gaps(x, 250.0, 0.1, "marker")[1].sum() == 25
    x[225] = np.nan
    with pytest.raises(InputError) as caught:
        fill_gaps(x, 250.0, 0.1, "marker 'leg1'")
    assert_one_sentence(caught.value, "marker 'leg1'", "0.104 s", "0.800 s")


def test_signal_that_is_missing_almost_throughout_is_refused():
    x = np.full(8, np.nan)
    x[[1, 4, 6]] = 1.0
    with pytest.raises(InputError) as caught:
        fill_gaps(x, 250.0, 1.0, "marker")
    assert_one_sentence(caught.value, "marker", "only 3")


def test_long_gap_is_bridged_by_a_straight_line_and_short_ones_are_left(rng):
    x = rng.standard_normal((300, 2))
    x[100:130] = np.nan
    x[50:60, 0] = np.nan
    bridged, long = bridge_gaps(x, 250.0, 0.1, "marker")
    assert np.flatnonzero(long).tolist() == list(range(100, 130))
    line = x[99] + (x[130] - x[99]) * (np.arange(100, 130) - 99)[:, None] / 31.0
    assert bridged[100:130] == pytest.approx(line)
    assert np.flatnonzero(np.isnan(bridged).any(axis=1)).tolist() == list(range(50, 60))
    untouched = ~np.isnan(x)
    assert (bridged[untouched] == x[untouched]).all()
    filled, missing = fill_gaps(bridged, 250.0, 0.1, "marker")
    assert np.isfinite(filled).all()
    assert np.flatnonzero(missing).tolist() == list(range(50, 60))


def test_long_gap_at_either_end_is_held():
    x = np.arange(200.0)[:, None] * np.ones(3)
    x[:40] = x[160:] = np.nan
    bridged, long = bridge_gaps(x, 250.0, 0.1, "marker")
    assert long.sum() == 80
    assert (bridged[:40] == 40.0).all()
    assert (bridged[160:] == 159.0).all()


def test_gap_of_exactly_the_longest_time_is_not_bridged_and_one_sample_more_is():
    x = np.sin(np.arange(500.0) / 20.0)[:, None]
    x[200:225] = np.nan
    assert not bridge_gaps(x, 250.0, 0.1, "marker")[1].any()
    x[225] = np.nan
    assert bridge_gaps(x, 250.0, 0.1, "marker")[1].sum() == 26


def test_marker_that_was_never_seen_cannot_be_bridged():
    x = np.full((50, 3), np.nan)
    x[:3] = 1.0
    with pytest.raises(InputError) as caught:
        bridge_gaps(x, 250.0, 0.1, "markers.c3d, marker 'ankle'")
    assert_one_sentence(caught.value, "'ankle'", "found 3 of 50")


def test_runs_are_told_by_their_first_sample_and_the_one_after_their_last():
    marked = np.array([1, 1, 0, 1, 0, 0, 1, 1, 1], dtype=bool)
    assert runs_of(marked) == [(0, 2), (3, 4), (6, 9)]
    assert runs_of(~marked) == [(2, 3), (4, 6)]
    assert runs_of(np.zeros(4, dtype=bool)) == []
    assert runs_of(np.ones(4, dtype=bool)) == [(0, 4)]


# ---- resampling --------------------------------------------------------------------------------


def test_nothing_is_extrapolated_at_either_end():
    time = np.arange(0.0, 1.0, 0.01)
    for wanted in ([-0.02, 0.5], [0.5, 1.01]):
        with pytest.raises(InputError) as caught:
            resample(time, time, np.array(wanted))
        assert_one_sentence(caught.value, "too short")
    assert resample(time, time, time[[0, -1]]) == pytest.approx([0.0, 0.99])


def test_what_would_fold_onto_the_band_is_removed_and_the_band_is_kept():
    time = np.arange(4000) / 1000.0
    grid = regular_time(1.0, 3.0, 250.0)
    kept, folding = np.sin(2.0 * np.pi * 20.0 * time), np.sin(2.0 * np.pi * 230.0 * time)
    aliased = resample(time, folding, grid)
    assert np.ptp(aliased) > 1.9
    filtered = resample(time, kept + folding, grid, band_hz=100.0)
    assert filtered == pytest.approx(np.sin(2.0 * np.pi * 20.0 * grid), abs=5e-3)


def test_ends_of_a_straight_line_are_not_bent_by_the_band_limit():
    time = np.arange(1000) / 1000.0
    grid = regular_time(0.0, 0.999, 250.0)
    limited = resample(time, np.column_stack([time, 3.0 - time]), grid, band_hz=100.0)
    assert limited == pytest.approx(np.column_stack([grid, 3.0 - grid]), abs=1e-12)


def test_irregular_samples_of_a_smooth_motion_come_out_on_the_grid(rng):
    time = np.arange(0.0, 4.0, 1.0 / 163.0)
    time = time + 6e-4 * rng.standard_normal(time.size)
    grid = regular_time(0.5, 3.5, 256.0)
    found = resample(time, np.sin(2.0 * np.pi * 5.0 * time), grid)
    assert found == pytest.approx(np.sin(2.0 * np.pi * 5.0 * grid), abs=2e-3)


def test_grid_holds_whole_periods_within_its_ends():
    grid = regular_time(0.0031, 0.0209, 250.0)
    assert grid == pytest.approx([0.004, 0.008, 0.012, 0.016, 0.020])
    assert regular_time(0.004, 0.008, 250.0) == pytest.approx([0.004, 0.008])


# ---- trigger -----------------------------------------------------------------------------------


def test_trigger_is_the_first_sample_at_or_above_the_threshold():
    line = np.array([0.1, -0.2, 2.4, 2.5, 5.0, 0.0, 5.0])
    assert rising_edge(line, 2.5, "log.mat") == 3


@pytest.mark.parametrize(("line", "found"), [([0.1, 0.4, 0.2], "0.4 V"), ([5.0, 5.0, 0.0], "first sample")])
def test_trigger_that_never_rises_is_refused(line, found):
    with pytest.raises(InputError) as caught:
        rising_edge(np.array(line), 2.5, "log.mat")
    assert_one_sentence(caught.value, "log.mat", found)


# ---- strobed markers ---------------------------------------------------------------------------


def test_strobed_markers_are_brought_to_common_instants():
    rate, strober, markers = 250.0, 2500.0, 8
    frames = np.arange(500) / rate
    instants = frames[:, None] + np.arange(markers) / strober
    sampled = np.repeat(np.sin(2.0 * np.pi * 5.0 * instants)[..., None], 3, axis=2)
    time, aligned = align_sequential_samples(sampled, rate, strober)
    truth = np.sin(2.0 * np.pi * 5.0 * time)[:, None, None]
    middle = slice(20, -20)
    uncorrected = np.abs(sampled[1:] - truth)[middle].max(axis=(0, 2))
    left = np.abs(aligned - truth)[middle].max(axis=(0, 2))
    assert uncorrected[1:].min() > 0.01
    assert (left[1:] < 0.01 * uncorrected[1:]).all()
    assert aligned[:, 0] == pytest.approx(sampled[1:, 0], abs=1e-12)


def test_markers_that_do_not_fit_into_a_frame_are_refused():
    with pytest.raises(
        InputError, match="found 8 markers that take 7 ms when sampled sequentially at 1000 Hz"
    ):
        align_sequential_samples(np.zeros((10, 8, 3)), 250.0, 1000.0)


# ---- length ------------------------------------------------------------------------------------


def test_record_that_ends_early_is_refused_and_one_that_ends_in_time_is_not():
    refuse_short(59.95, 60.0, "log.txt")
    with pytest.raises(InputError) as caught:
        refuse_short(59.5, 60.0, "log.txt")
    assert_one_sentence(caught.value, "log.txt", "60 s", "59.50 s")


def test_rounding_beyond_the_last_sample_is_no_missing_time():
    time = np.arange(1000) / 100.0
    rounded = time[-1] + 5e-9  # less than a millionth of a sample
    assert resample(time, time, np.array([rounded]))[0] == pytest.approx(time[-1])
    with pytest.raises(InputError, match=r"expected samples from .* found them only from 0\.0000 s to 9\.99"):
        resample(time, time, np.array([time[-1] + 2e-8]))
