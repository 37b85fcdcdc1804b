"""Perturbations are found where the belt moved, whatever was commanded and however large they are."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import RATE_HZ, assert_one_sentence, belt_pulses

from tepsipe.errors import InputError
from tepsipe.signals.perturbations import (
    WindowOptions,
    detect_perturbations,
    filtered_perturbations,
    find_perturbations,
    rest_samples,
)

TIME = np.arange(0.0, 12.0, 1.0 / RATE_HZ)


def detect(velocity, rest_before_s=1.5, rest_after_s=2.0, threshold=0.05, merge_s=0.06):
    return detect_perturbations(
        velocity,
        RATE_HZ,
        rest_before_s=rest_before_s,
        rest_after_s=rest_after_s,
        threshold_fraction=threshold,
        signal_to_noise=5.0,
        merge_s=merge_s,
        what="trial",
    )


def pulses(onsets, peak=0.3):
    return belt_pulses(TIME, onsets, peak)[1]


def windows(found):
    return [(p.start, p.stop) for p in found]


def test_window_holds_exactly_what_exceeds_the_threshold():
    velocity = pulses((2.0, 5.0, 8.0))
    found = detect(velocity)
    assert len(found) == 3
    for p in found:
        threshold = 0.05 * np.abs(velocity).max()
        around = np.abs(velocity[p.start - 100 : p.stop + 100]) > threshold
        moving = np.flatnonzero(around) + p.start - 100
        assert (p.start, p.stop) == (moving[0], moving[-1] + 1)
        assert p.peak_m_per_s == pytest.approx(0.3, rel=0.01)


def test_belt_that_follows_later_is_found_later():
    prompt, late = detect(pulses((2.0, 5.0))), detect(pulses((2.06, 5.2)))
    assert np.subtract(windows(late), windows(prompt)).tolist() == [[15, 15], [50, 50]]


def test_amplitude_does_not_change_the_windows():
    small, large = detect(pulses((2.0, 5.0), 0.1)), detect(pulses((2.0, 5.0), 0.5))
    assert windows(small) == windows(large)
    assert large[0].peak_m_per_s == pytest.approx(5.0 * small[0].peak_m_per_s)


def test_direction_of_the_belt_does_not_matter():
    assert windows(detect(-pulses((2.0, 5.0)))) == windows(detect(pulses((2.0, 5.0))))


def test_offset_of_the_velocity_sensor_does_not_matter():
    velocity = pulses((2.0, 5.0))
    assert windows(detect(velocity + 0.02)) == windows(detect(velocity))


def test_noise_moves_the_windows_by_a_few_samples_only(rng):
    clean = detect(pulses((2.0, 5.0)))
    noisy = detect(pulses((2.0, 5.0)) + 0.001 * rng.standard_normal(TIME.size))
    assert np.abs(np.subtract(windows(noisy), windows(clean))).max() <= 3


def test_two_lobes_of_one_pulse_are_one_perturbation():
    lobes = np.where(TIME % 4.0 < 0.05, 0.3, 0.0) - np.where(np.abs(TIME % 4.0 - 0.1) < 0.025, 0.3, 0)
    velocity = np.where(TIME > 2.0, lobes, 0.0)
    assert len(detect(velocity, merge_s=0.06)) == 2
    assert len(detect(velocity, merge_s=0.01)) == 4


def test_pulses_further_apart_than_the_merging_time_stay_two():
    assert len(detect(pulses((2.0, 2.5)))) == 2


def test_higher_threshold_gives_a_shorter_window():
    wide, narrow = (detect(pulses((2.0,)), threshold=t)[0] for t in (0.02, 0.4))
    assert wide.start < narrow.start
    assert narrow.stop < wide.stop


def test_twitch_much_smaller_than_the_perturbations_is_no_perturbation():
    velocity = pulses((2.0, 5.0, 8.0)) + pulses((3.5,), 0.1)
    assert windows(detect(velocity)) == windows(detect(pulses((2.0, 5.0, 8.0))))


@pytest.mark.parametrize("amplitude", [0.0, 0.001])
def test_trial_without_perturbation_is_refused(amplitude, rng):
    with pytest.raises(InputError) as caught:
        detect(amplitude * rng.standard_normal(TIME.size))
    assert_one_sentence(caught.value, "trial", "perturb")


def test_perturbations_that_hardly_exceed_the_noise_are_refused(rng):
    with pytest.raises(InputError) as caught:
        detect(pulses((2.0, 5.0), 0.05) + 0.002 * rng.standard_normal(TIME.size))
    assert_one_sentence(caught.value, "trial", "noise at rest")


@pytest.mark.parametrize("onset", [0.5, 1.45, 11.0, 9.9])
def test_perturbation_during_the_time_of_rest_is_refused(onset):
    with pytest.raises(InputError) as caught:
        detect(pulses((2.0, 5.0, 8.0, onset)))
    assert_one_sentence(caught.value, "trial", "rest")
    assert "perturbation at" in str(caught.value)


def test_perturbations_next_to_the_time_of_rest_are_kept():
    first = detect(pulses((2.0, 5.0, 8.0)))
    rest_before_s, rest_after_s = first[0].start / RATE_HZ, 12.0 - first[-1].stop / RATE_HZ
    kept = detect(pulses((2.0, 5.0, 8.0)), rest_before_s, rest_after_s)
    assert windows(kept) == windows(first)
    for more in ((rest_before_s + 0.004, rest_after_s), (rest_before_s, rest_after_s + 0.004)):
        with pytest.raises(InputError, match="rest"):
            detect(pulses((2.0, 5.0, 8.0)), *more)


# ---- no false perturbations -----------------------------------------------------------------------

HOURS = 1.0
LONG_HZ = 100.0


def long_time(hours=HOURS):
    return np.arange(round(3600.0 * hours * LONG_HZ)) / LONG_HZ


def walked_on(rng, hours=HOURS):
    """A belt at 1 m/s that every step at about 2.2 Hz slows down by 30 mm/s for 0.1 s."""
    time = long_time(hours)
    velocity = 1.0 + 0.004 * rng.standard_normal(time.size)
    steps = np.cumsum(0.45 + 0.02 * rng.standard_normal(round(time[-1] / 0.46)))
    for sample in np.round(LONG_HZ * steps[steps < time[-1] - 1.0]).astype(int):
        velocity[sample : sample + 10] -= 0.03 * np.hanning(10)
    return velocity


def quantised(rng, hours=HOURS):
    """A belt at rest whose reading is 0 but for rare steps of 5 mm/s."""
    return 0.005 * (rng.random(long_time(hours).size) < 0.002)


NOISE = {
    "at rest": lambda rng: 0.001 * rng.standard_normal(long_time().size),
    "at 1 m/s": lambda rng: 1.0 + 0.002 * rng.standard_normal(long_time().size),
    "at a speed that drifts": lambda rng: (
        1.0 + 1e-5 * long_time() + 0.002 * rng.standard_normal(long_time().size)
    ),
    "quantised": quantised,
    "walked on": walked_on,
    "quiet, then walked on": lambda rng: np.where(
        long_time() < 10.0, 1.0 + 1e-4 * rng.standard_normal(long_time().size), walked_on(rng)
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("belt", NOISE)
def test_hours_without_perturbation_end_in_one_sentence(belt, rng):
    with pytest.raises(InputError) as caught:
        find_perturbations(long_time(), NOISE[belt](rng))
    assert_one_sentence(caught.value, "belt_velocity", "no perturbation above the noise")


def test_belt_that_gathers_speed_at_first_is_not_perturbed(rng):
    time = long_time(0.1)
    for noise, words in ((0.001, "at rest during the first 4 s"), (0.02, "no perturbation above the noise")):
        velocity = np.minimum(0.4 + 0.5 * time, 1.0) + noise * rng.standard_normal(time.size)
        with pytest.raises(InputError, match=words):
            find_perturbations(time, velocity, rest_before_s=4.0)


def walking(path, rng, hours=HOURS):
    """Hours of a real belt's speed: blocks of 2 s of an unperturbed walk at constant speed, shuffled."""
    columns = pd.read_csv(path)
    blocks = []
    for name in ("LeftBeltSpeed", "RightBeltSpeed"):
        speed = columns[name].to_numpy()[400:]  # from which on the belt has its speed
        first = rng.integers(0, speed.size - 200, round(1800.0 * hours))
        blocks.append(speed[first[:, None] + np.arange(200)].ravel())
    return blocks


def test_hours_of_a_real_belt_at_constant_speed_hold_no_perturbation(real_data, rng):
    for velocity in walking(real_data("walking/UnpertPre_data.csv.gz"), rng):
        with pytest.raises(InputError, match="no perturbation above the noise"):
            find_perturbations(np.arange(velocity.size) / LONG_HZ, velocity)


def with_pulses(velocity, peak, rng):
    """Pulses of 0.3 s about every 5 s on top of a velocity, and their first samples."""
    starts = np.arange(500, velocity.size - 1000, 500) + rng.integers(
        0, 100, (velocity.size - 1500 + 499) // 500
    )
    velocity = velocity.copy()
    for start in starts:
        velocity[start : start + 30] += peak * np.sin(np.pi * np.arange(30) / 30)
    return velocity, starts


def assert_all_found(found, starts):
    assert len(found) == starts.size
    assert np.abs(np.array([p.start for p in found]) - starts).max() <= 5
    assert np.median([p.stop - p.start for p in found]) == pytest.approx(28, abs=4)


@pytest.mark.slow
@pytest.mark.parametrize("drift", [0.0, 2e-5])
def test_pulses_on_top_of_a_constant_speed_are_all_found_and_nothing_else(drift, rng):
    time = long_time(0.5)
    velocity, starts = with_pulses(1.0 + drift * time + 0.001 * rng.standard_normal(time.size), 0.3, rng)
    assert_all_found(find_perturbations(time, velocity), starts)
    backwards = find_perturbations(time, 2.0 * (1.0 + drift * time) - velocity)
    assert_all_found(backwards, starts)


def test_pulses_that_need_a_higher_threshold_are_refused_with_it(rng):
    velocity, starts = with_pulses(walked_on(rng, 0.1), 0.4, rng)
    time = np.arange(velocity.size) / LONG_HZ
    with pytest.raises(InputError) as caught:
        find_perturbations(time, velocity)
    assert_one_sentence(caught.value, "belt_velocity", "set threshold_fraction to at least 0.")
    fraction = float(str(caught.value).rpartition(" ")[2])
    assert_all_found(find_perturbations(time, velocity, threshold_fraction=fraction), starts)


def test_pulses_on_a_real_belt_that_is_walked_on_are_all_found(real_data, rng):
    for speed in walking(real_data("walking/UnpertPre_data.csv.gz"), rng, hours=0.5):
        velocity, starts = with_pulses(speed, 0.4, rng)
        found = find_perturbations(np.arange(speed.size) / LONG_HZ, velocity, threshold_fraction=0.2)
        assert_all_found(found, starts)


# ---- rest --------------------------------------------------------------------------------------

REST = WindowOptions(
    rest_before_s=2.0,
    rest_after_s=1.0,
    rest_margin_s=0.1,
    threshold_fraction=0.05,
    signal_to_noise=5.0,
    merge_s=0.06,
)


def test_rest_is_the_time_before_and_after_the_perturbations_without_their_margins():
    time = np.arange(0.0, 10.0, 0.01)
    at_rest = time[rest_samples(time, REST)]
    first, last = at_rest[at_rest < 5.0], at_rest[at_rest > 5.0]
    assert (first[0], first[-1]) == pytest.approx((0.1, 1.9), abs=0.011)
    assert (last[0], last[-1]) == pytest.approx((9.09, 9.89), abs=0.011)


def test_rest_that_its_margin_uses_up_is_refused():
    short = replace(REST, rest_before_s=REST.rest_margin_s)
    with pytest.raises(InputError, match=r"rest_before_s above rest_margin_s .* found 0.1 s"):
        filtered_perturbations(np.zeros(1000), 100.0, short, "a")


def test_trial_without_rest_is_refused():
    for short in ({"rest_after_s": 0.1}, {"rest_before_s": 0.1}):
        with pytest.raises(InputError) as caught:
            rest_samples(np.arange(0.0, 10.0, 0.01), replace(REST, **short))
        assert_one_sentence(caught.value, "rest")
