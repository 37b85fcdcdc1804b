"""The zero-lag filters: their gain, their missing phase, and what they refuse."""

import numpy as np
import pytest
from builders import RATE_HZ, assert_one_sentence, refused
from scipy import signal

from tepsipe.errors import InputError
from tepsipe.signals.filters import Lowpass, butterworth_bandpass, butterworth_lowpass, lowpass, notch

RATE = 250.0
TIME = np.arange(0.0, 20.0, 1.0 / RATE)
MIDDLE = slice(1000, -1000)


def response_at(frequency_hz, cutoff_hz, order=4):
    """Complex gain of the filter for a long sine, away from its ends."""
    wave = np.exp(2j * np.pi * frequency_hz * TIME)
    filtered = butterworth_lowpass(wave.imag, RATE, cutoff_hz, order)[MIDDLE]
    return 2.0 * np.mean(1j * filtered * wave[MIDDLE].conj())


@pytest.mark.parametrize("order", [2, 4, 8])
def test_gain_at_the_cutoff_is_one_half(order):
    assert abs(response_at(20.0, 20.0, order)) == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("frequency_hz", [2.0, 10.0, 30.0, 60.0])
def test_gain_is_that_of_a_second_order_filter_applied_twice(frequency_hz):
    ratio = np.tan(np.pi * frequency_hz / RATE) / np.tan(np.pi * 20.0 / RATE)
    assert abs(response_at(frequency_hz, 20.0)) == pytest.approx(1.0 / (1.0 + ratio**4), abs=1e-6)


@pytest.mark.parametrize("frequency_hz", [2.0, 20.0, 40.0])
def test_no_frequency_is_delayed(frequency_hz):
    assert np.angle(response_at(frequency_hz, 20.0)) == pytest.approx(0.0, abs=1e-6)


def test_constant_passes_unchanged_up_to_its_ends():
    assert butterworth_lowpass(np.full(300, 7.3), RATE, 20.0) == pytest.approx(np.full(300, 7.3))


def test_filter_is_linear(rng):
    x, y = rng.standard_normal((2, 400))
    together = butterworth_lowpass(3.0 * x - 0.5 * y, RATE, 20.0)
    apart = 3.0 * butterworth_lowpass(x, RATE, 20.0) - 0.5 * butterworth_lowpass(y, RATE, 20.0)
    assert together == pytest.approx(apart, abs=1e-12)


def test_columns_are_filtered_one_by_one_along_either_axis(rng):
    x = rng.standard_normal((400, 3))
    columns = butterworth_lowpass(x, RATE, 20.0)
    assert columns[:, 1] == pytest.approx(butterworth_lowpass(x[:, 1], RATE, 20.0), abs=1e-14)
    assert butterworth_lowpass(x.T, RATE, 20.0, axis=1) == pytest.approx(columns.T, abs=1e-14)


@pytest.mark.parametrize("cutoff_hz", [0.0, -5.0, 125.0, 300.0, np.nan])
def test_cutoff_outside_of_what_the_rate_can_hold_is_refused(cutoff_hz):
    with pytest.raises(InputError, match="expected a cutoff between 0 and half the sampling rate"):
        butterworth_lowpass(TIME, RATE, cutoff_hz)


@pytest.mark.parametrize("order", [0, 1, 3, -2])
def test_order_that_two_equal_passes_cannot_have_is_refused(order):
    with pytest.raises(InputError, match="expected an even order"):
        butterworth_lowpass(TIME, RATE, 20.0, order)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_missing_samples_are_refused_instead_of_spreading(bad):
    x = TIME.copy()
    x[17] = bad
    with pytest.raises(InputError, match="NaN or infinite"):
        butterworth_lowpass(x, RATE, 20.0)


def test_signal_without_samples_is_refused():
    with pytest.raises(InputError) as caught:
        butterworth_lowpass(np.array([]), RATE, 20.0)
    assert_one_sentence(caught.value)


# ---- band-pass and notch -----------------------------------------------------------------------

FAST = 1000.0
FAST_TIME = np.arange(0.0, 10.0, 1.0 / FAST)


def gain_of(how, frequency_hz):
    """Complex gain for a long sine at 1000 Hz, away from its ends."""
    wave = np.exp(2j * np.pi * frequency_hz * FAST_TIME)
    middle = slice(3000, -3000)
    return 2.0 * np.mean(1j * how(wave.imag)[middle] * wave[middle].conj())


def emg_band(x, order=4):
    return butterworth_bandpass(x, FAST, (20.0, 300.0), order)


@pytest.mark.parametrize("order", [2, 4, 8])
@pytest.mark.parametrize("edge_hz", [20.0, 300.0])
def test_gain_at_both_edges_of_a_band_is_one_half(order, edge_hz):
    assert gain_of(lambda x: emg_band(x, order), edge_hz) == pytest.approx(0.5, abs=1e-5)


@pytest.mark.parametrize(("order", "fall"), [(2, 2.0), (4, 4.0)])
def test_band_falls_off_at_its_lower_edge_as_a_high_pass_of_its_order(order, fall):
    gains = [abs(gain_of(lambda x: emg_band(x, order), f)) for f in (2.0, 4.0)]
    assert np.log2(gains[1] / gains[0]) == pytest.approx(fall, rel=0.02)


@pytest.mark.parametrize("frequency_hz", [20.0, 80.0, 150.0, 300.0, 400.0])
def test_band_pass_delays_nothing(frequency_hz):
    gain = gain_of(emg_band, frequency_hz)
    assert abs(gain.imag) < 1e-5
    assert gain.real > 0.0


def test_band_pass_turns_with_time_reversed(rng):
    x = rng.standard_normal(3000)
    x[:500] = x[-500:] = 0.0
    assert emg_band(x[::-1])[::-1] == pytest.approx(emg_band(x), abs=1e-6)


def test_middle_of_the_band_passes_and_an_offset_does_not():
    assert abs(gain_of(emg_band, 80.0)) == pytest.approx(1.0, abs=0.01)
    assert np.abs(emg_band(np.full(4000, 7000.0))).max() < 1e-6


@pytest.mark.parametrize(
    "band_hz", [(0.0, 300.0), (300.0, 20.0), (20.0, 500.0), (20.0, 20.0), (np.nan, 300.0)]
)
def test_band_that_the_rate_cannot_hold_is_refused(band_hz):
    with pytest.raises(InputError, match="band-pass: expected edges that rise"):
        butterworth_bandpass(FAST_TIME, FAST, band_hz)


def test_notch_removes_its_frequency_and_little_else():
    gains = [abs(gain_of(lambda x: notch(x, FAST, 50.0, 2.0), f)) for f in (50.0, 49.0, 51.0, 40.0, 60.0)]
    assert gains[0] < 1e-3
    assert gains[1:3] == pytest.approx([0.5, 0.5], abs=0.01)
    assert min(gains[3:]) > 0.98


@pytest.mark.parametrize(("frequency_hz", "width_hz"), [(0.0, 2.0), (499.5, 2.0), (50.0, 0.0), (0.5, 2.0)])
def test_notch_that_the_rate_cannot_hold_is_refused(frequency_hz, width_hz):
    with pytest.raises(InputError, match="notch: expected a frequency"):
        notch(FAST_TIME, FAST, frequency_hz, width_hz)


def test_low_pass_of_a_slow_recording_is_as_wide_as_its_rate_allows():
    wide = Lowpass(60.0, 4, True)
    assert wide.within(250.0) == wide.within(200.0) == wide
    slow = wide.within(100.0)
    assert slow == Lowpass(30.0, 4, True)
    assert np.isfinite(slow(np.ones(50), 100.0)).all()


def test_lowpass_keeps_units_and_removes_what_lies_above():
    time = np.arange(0.0, 4.0, 1.0 / RATE_HZ)
    slow, fast = np.sin(2.0 * np.pi * time), np.sin(2.0 * np.pi * 80.0 * time)
    assert lowpass(slow + fast, RATE_HZ)[100:-100] == pytest.approx(slow[100:-100], abs=0.01)
    two = lowpass(np.column_stack([slow, fast]), RATE_HZ)
    assert two.shape == (time.size, 2)
    assert np.abs(lowpass(slow, RATE_HZ, zero_lag=False)[100:-100] - slow[100:-100]).max() > 0.05


def test_causal_filter_only_delays(rng):
    x = rng.standard_normal(2000)
    sections = signal.butter(4, 20.0, fs=250.0, output="sos")
    assert Lowpass(20.0, 4, False)(x, 250.0) == pytest.approx(signal.sosfilt(sections, x), abs=1e-12)
    refused(lambda: Lowpass(130.0, 4, False)(x, 250.0), "low-pass", "130")
