"""The clock of a file of samples: its rate, its gaps, and stamps that are those of no clock."""

import numpy as np
import pytest
from builders import refused

from tepsipe.io.readers.clock import regular_clock

TIME = 3.0 + np.arange(200) / 50.0


def test_samples_that_are_missing_leave_their_places():
    kept = np.delete(np.arange(200), [10, 11, 100])
    clock = regular_clock(TIME[kept], "a.csv")
    assert (clock.rate_hz, clock.size) == (50.0, 200)
    assert clock.index.tolist() == kept.tolist()
    assert clock.first_s == pytest.approx(3.0)
    placed = clock.placed(np.arange(197.0))
    assert np.flatnonzero(np.isnan(placed)).tolist() == [10, 11, 100]
    assert placed[12] == 10.0


def test_equal_stamps_are_no_samples_of_their_own():
    clock = regular_clock(np.sort([*TIME, TIME[50]]), "a.csv")
    assert (clock.rate_hz, clock.size, clock.rows.size) == (50.0, 200, 200)


@pytest.mark.parametrize(
    ("time", "words"),
    [
        (np.where(np.arange(200) == 7, np.nan, TIME), ("none on line 8",)),
        (np.where(np.arange(200) == 7, 3.0, TIME), ("running backwards from 3.12 s to 3 s at sample 8",)),
        (TIME[:19], ("at least 20 samples at different times", "found 19")),
        (np.delete(TIME, np.arange(60, 100)), ("longer than 0.5 s", "one of 0.82 s at 4.18 s")),
        (np.repeat(TIME[::2], 2), ("found 50 % equal to the preceding one",)),
        (TIME + 0.009 * np.sign(np.sin(np.arange(200) ** 2)), ("of a regular clock", "ms away")),
    ],
)
def test_stamps_of_no_clock_are_refused(time, words):
    refused(lambda: regular_clock(time, "a.csv"), "a.csv", *words)
