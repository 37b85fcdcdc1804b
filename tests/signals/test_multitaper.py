"""Confidence bands of a frequency response: 95 of 100 hold the truth, and the coherence of noise is known."""

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.signals.spectra import frequency_averaged, frequency_response, multitaper_response

RATE = 200.0
SIZE, ROOM = 12000, 2000


def impedance(frequency_hz):
    """Of an ankle with a delayed reflex (N·m/rad)."""
    s = 2j * np.pi * frequency_hz
    w = 2.0 * np.pi * 1.6
    reflex = 15.0 * s * np.exp(-0.04 * s) * w**2 / (s + w) ** 2
    return 0.014 * s**2 + 0.8 * s + 60.0 + reflex


def record(rng, noise):
    """60 s of random steps of the angle (rad) and torque (N·m) with slow and fast noise."""
    size = SIZE + 2 * ROOM
    steps = np.repeat(rng.choice([-0.03, 0.03], size // 30 + 1), 30)[:size]
    angle = butterworth_lowpass(steps, RATE, 8.0, 4)
    at = np.fft.rfftfreq(size, 1.0 / RATE)
    torque = np.fft.irfft(np.fft.rfft(angle) * impedance(at), size)
    drift = np.cumsum(rng.standard_normal(size))
    fast = butterworth_lowpass(rng.standard_normal(size), RATE, 40.0, 4)
    torque += noise * torque.std() * (0.5 * drift / drift.std() + 0.2 * fast)
    return angle[ROOM:-ROOM], torque[ROOM:-ROOM]


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.1, 0.7])
def test_bands_hold_the_truth_at_95_of_100_frequencies(noise):
    gain, phase = [], []
    for seed in range(25):
        found = multitaper_response(*record(np.random.default_rng(seed), noise), RATE, 12.0)
        factor, half = found.confidence_band()
        ratio = found.response / impedance(found.frequency_hz)
        # where the gain is unknown by more than half, the error is not small against the response
        known = factor < 1.5
        gain.append((np.abs(np.log(np.abs(ratio))) <= np.log(factor))[known])
        phase.append((np.abs(np.degrees(np.angle(ratio))) <= half)[known])
    for covered in (np.concatenate(gain), np.concatenate(phase)):
        assert covered.size > 900
        assert 0.93 < covered.mean() < 0.97


def test_bands_of_averaged_neighbours_are_those_of_bendat_and_piersol(rng):
    u, noise = rng.standard_normal((2, 64 * 1024))
    found = frequency_averaged(u, 3.0 * u + 2.0 * noise, RATE, 32)
    factor, half = found.confidence_band()
    ratio = found.response / 3.0
    assert np.mean(np.abs(np.log(np.abs(ratio))) <= np.log(factor)) == pytest.approx(0.95, abs=0.02)
    assert np.mean(np.abs(np.degrees(np.angle(ratio))) <= half) == pytest.approx(0.95, abs=0.02)


@pytest.mark.parametrize("averaged_bins", [None, 16])
def test_coherence_of_unrelated_signals_exceeds_its_level_at_5_of_100_frequencies(averaged_bins):
    rng = np.random.default_rng(4)
    above = []
    for _ in range(3):
        time = np.arange(0.0, 400.0, 1.0 / RATE)
        found = frequency_response(time, *rng.standard_normal((2, time.size)), averaged_bins=averaged_bins)
        above.append(found.coherence > found.coherence_threshold())
    assert np.mean(np.concatenate(above)) == pytest.approx(0.05, abs=0.015)


def test_response_without_noise_is_exact_although_it_bends_within_its_bands():
    found = multitaper_response(*record(np.random.default_rng(0), 0.0), RATE, 5.0)
    # random steps of 0.15 s have no power at 6.7 Hz, so the bands end before it
    assert np.abs(found.response / impedance(found.frequency_hz) - 1.0).max() < 0.01


def test_records_without_a_response_are_refused():
    still = np.zeros(SIZE)
    with pytest.raises(InputError) as error:
        multitaper_response(still, still, RATE, 20.0)
    assert_one_sentence(error, "power")
    with pytest.raises(InputError) as error:
        multitaper_response(np.ones(50), np.ones(50), RATE, 20.0)
    assert_one_sentence(error, "record longer")
