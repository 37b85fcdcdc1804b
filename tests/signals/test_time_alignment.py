"""How late markers are, from what both instruments see: the belt moves."""

import numpy as np
import pytest
from builders import assert_one_sentence, belt_pulses, multisine_record

from tepsipe.errors import InputError
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.time_alignment import (
    advanced,
    clock_error,
    common_signal_delay,
    marker_delay,
    stamp_jitter,
)

RATE_HZ = 250.0
TIME = np.arange(2500) / RATE_HZ
ONSETS_S = (2.0, 4.1, 6.3)


def late_marker(delay_s, peak=0.3):
    """Position of a riding marker that is recorded late, and the belt's velocity (m, m/s)."""
    return belt_pulses(TIME - delay_s, ONSETS_S, peak)[0], belt_pulses(TIME, ONSETS_S, peak)[1]


@pytest.mark.parametrize("delay_s", [0.0003, -0.0012, 0.0, 0.004, -0.015])
@pytest.mark.parametrize("peak", [0.1, 0.5])
def test_delay_of_a_riding_marker_is_found(delay_s, peak):
    position, velocity = late_marker(delay_s, peak)
    assert marker_delay(TIME, 0.7 + position, velocity, "trial") == pytest.approx(delay_s, abs=2e-5)


def test_delay_is_found_through_noise_and_filters(rng):
    found = []
    for _ in range(20):
        position, velocity = late_marker(0.0003)
        noisy = position + 1e-4 * rng.standard_normal(TIME.size)
        signals = (butterworth_lowpass(x, RATE_HZ, 20.0) for x in (noisy, velocity))
        found.append(marker_delay(TIME, *signals, "trial"))
    assert np.mean(found) == pytest.approx(0.0003, abs=1e-4)
    assert np.std(found) < 3e-4


def test_noise_while_the_belt_rests_is_no_marker_that_slips(rng):
    """Slow pulses, 0.5 mm of noise at 100 Hz: over a minute the noise has more power than the pulses."""
    time = np.arange(6500) / 100.0
    position, velocity, _ = belt_pulses(time, 4.0 + 6.0 * np.arange(10), 0.2)[:3]
    noisy = position + 5e-4 * rng.standard_normal(time.size)
    marker, belt = (butterworth_lowpass(x, 100.0, 20.0) for x in (noisy, velocity))
    slope = np.gradient(marker, time)
    assert np.sum((slope - belt) ** 2) > 0.25 * np.sum(belt**2)
    assert marker_delay(time, marker, belt, "trial") == pytest.approx(0.0, abs=2e-3)


def test_marker_that_is_much_too_late_is_refused():
    for delay_s in (0.03, -0.03, 0.5):
        position, velocity = late_marker(delay_s)
        with pytest.raises(InputError) as caught:
            marker_delay(TIME, position, velocity, "dummy/sine-0.3")
        assert_one_sentence(caught.value, "dummy/sine-0.3", "20 ms", "trigger")


def test_marker_that_does_not_follow_the_belt_is_refused(rng):
    position, velocity = late_marker(0.0)
    slipping = 0.4 * position
    for other in (-position, slipping, 1e-3 * np.cumsum(rng.standard_normal(TIME.size))):
        with pytest.raises(InputError) as caught:
            marker_delay(TIME, other, velocity, "dummy/sine-0.3")
        assert_one_sentence(caught.value, "dummy/sine-0.3", "slip")


def test_signals_are_taken_earlier_by_a_delay_and_held_at_their_ends():
    x = np.column_stack([np.sin(3.0 * TIME), TIME**2])
    inside = slice(10, -10)
    for delay_s in (0.0123, -0.0123):
        later = TIME + delay_s
        expected = np.column_stack([np.sin(3.0 * later), later**2])
        assert advanced(TIME, x, delay_s)[inside] == pytest.approx(expected[inside], abs=1e-7)
    assert advanced(TIME, x, 1.0)[-250:] == pytest.approx(np.tile(x[-1], (250, 1)))
    position, velocity = late_marker(0.003)
    again = advanced(TIME, position, marker_delay(TIME, position, velocity, "trial"))
    assert marker_delay(TIME, again, velocity, "trial") == pytest.approx(0.0, abs=2e-6)


def test_delay_of_two_records_of_one_signal(rng):
    time = np.arange(0.0, 12.0, 0.01)
    reference = belt_pulses(time, ONSETS_S, 0.3)[1]
    signal = 3.0 * belt_pulses(time[:-100] - 0.3456, ONSETS_S, 0.3)[1] + 1.0
    reference[30:40] = np.nan
    delay, correlation, gain = common_signal_delay(reference, signal, 100.0, 2.0)
    assert delay == pytest.approx(0.3456, abs=5e-4)
    assert correlation > 0.95
    assert gain == pytest.approx(1.0 / 3.0, rel=0.05)
    assert common_signal_delay(np.ones(100), signal, 100.0, 0.5) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("still", [0, 1])
def test_lags_at_which_one_of_two_records_stands_still_do_not_count(still, rng):
    """Only the first tenth of one record moves, so at half of the lags nothing of it overlaps."""
    records = [np.zeros(400), rng.standard_normal(400)]
    records[0][:40] = records[1][40:80]
    for sign in (1.0, -1.0):
        pair = [records[still], sign * records[1 - still]]
        delay, correlation, _ = common_signal_delay(*pair, 100.0, 2.0)
        assert delay == pytest.approx(-0.4 if still else 0.4, abs=0.01)
        assert np.sign(correlation) == sign


@pytest.mark.parametrize("error", [0.0, 1e-3, -1e-3, 1e-4, 3e-3])
def test_clock_that_runs_fast_turns_the_phase_of_the_response(error):
    torque, angle = multisine_record((0.015, 0.1, 9.0), 6.0)
    time = np.arange(torque.size) / 256.0
    # an instant t has the stamp (1 + error) t
    logged = np.interp(time / (1.0 + error), time, angle)
    assert clock_error(torque, logged, 256.0) == pytest.approx(error, abs=5e-6)


def test_clock_is_taken_as_right_in_a_record_too_short_to_show_it():
    torque, angle = multisine_record((0.015, 0.1, 9.0), 1.5)
    assert clock_error(torque, angle, 256.0) == 0.0


@pytest.mark.parametrize("error_s", [0.0, 0.001, 0.002])
def test_errors_of_stamps_grow_with_the_rate_and_noise_does_not(error_s, rng):
    torque, angle = multisine_record((0.015, 0.1, 9.0), 6.0)
    true = np.arange(torque.size) / 256.0
    stamps = np.arange(5.0, 55.0, 1.0 / 163.0) + 0.0006 * rng.standard_normal(8150)
    noise = 2e-5 * rng.standard_normal(stamps.size)
    sampled = np.interp(stamps + error_s * rng.standard_normal(stamps.size), true, angle) + noise
    assert stamp_jitter(np.sort(stamps), sampled) == pytest.approx(error_s, abs=1.5e-4)


def test_coarse_steps_are_no_errors_of_stamps():
    torque, angle = multisine_record((0.015, 0.1, 9.0), 6.0)
    step = np.ptp(angle) / 25.0
    time = np.arange(torque.size) / 256.0
    assert stamp_jitter(time, step * np.round(angle / step)) < 0.0012


def test_delay_beyond_the_longest_is_that_at_the_limit():
    time = np.arange(1000) / 100.0
    bump = np.exp(-((time - 5.0) ** 2) / 2.0)
    late = np.exp(-((time - 7.0) ** 2) / 2.0)
    for reference, signal, sign in ((bump, late, 1.0), (late, bump, -1.0)):
        delay, correlation, _ = common_signal_delay(reference, signal, 100.0, 0.5)
        assert abs(delay) == pytest.approx(0.51)
        assert sign * delay == pytest.approx(0.51)
        assert 0.0 < correlation < 0.9


def test_correlation_is_that_of_the_samples_that_both_have(rng):
    reference = rng.standard_normal(300) + 5.0 * (np.arange(300) > 150)
    signal = np.roll(2.0 * reference, 3)
    signal[:3] = signal[40:60] = np.nan
    delay, correlation, gain = common_signal_delay(reference, signal, 100.0, 0.2)
    assert delay == pytest.approx(0.03, abs=1e-3)
    assert correlation == pytest.approx(1.0, abs=1e-9)
    assert gain == pytest.approx(0.5)
