"""Spectral estimates of known systems: whole periods are exact, coherence tells noise."""

import numpy as np
import pytest
from builders import RATE_HZ, assert_one_sentence, multisine_record, refused, second_order_response

from tepsipe.errors import InputError
from tepsipe.signals.response import FrequencyResponse
from tepsipe.signals.spectra import frequency_averaged, frequency_response, period_averaged

JOINT = np.array([0.015, 0.1, 8.0])
RATE = 256.0


@pytest.mark.parametrize("periods", [2.0, 2.3, 4.8])
def test_whole_periods_of_a_periodic_perturbation_give_the_exact_response(periods):
    torque, angle = multisine_record(JOINT, periods)
    found = period_averaged(torque, angle, RATE, 10.0, (1.0, 20.0))
    truth = second_order_response(JOINT, found.frequency_hz)
    assert found.frequency_hz == pytest.approx(np.arange(10, 201) / 10.0)
    assert np.abs(found.response / truth - 1.0).max() < 1e-10
    assert found.coherence == pytest.approx(np.ones(191), abs=1e-10)
    assert found.averages == int(periods)


def test_transient_at_the_start_is_left_out_with_the_incomplete_period():
    torque, angle = multisine_record(JOINT, 3.0)
    before = np.full(500, 0.7)
    found = period_averaged(
        np.concatenate([before, torque]), np.concatenate([before, angle]), RATE, 10.0, (1.0, 20.0)
    )
    truth = second_order_response(JOINT, found.frequency_hz)
    assert np.abs(found.response / truth - 1.0).max() < 1e-10


def test_averaging_neighbouring_frequencies_smears_and_loses_coherence_without_any_noise():
    torque, angle = multisine_record(JOINT, 2.3)
    averaged = frequency_averaged(torque, angle, RATE, 8).band(1.0, 9.0)
    whole = period_averaged(torque, angle, RATE, 10.0, (1.0, 20.0)).band(1.0, 9.0)
    errors = [
        np.abs(np.log(s.response / second_order_response(JOINT, s.frequency_hz))).max()
        for s in (averaged, whole)
    ]
    assert errors[0] > 0.05
    assert errors[1] < 1e-9
    assert averaged.coherence.min() < 0.9


def test_noise_as_strong_as_the_signal_halves_the_coherence(rng):
    u, noise = rng.standard_normal((2, 64 * 256))
    found = frequency_averaged(u, 3.0 * (u + noise), RATE, 64)
    assert found.coherence.mean() == pytest.approx(0.5, abs=0.03)
    assert found.response.mean() == pytest.approx(3.0, abs=0.1)
    assert found.averages == 64


def test_coherence_of_unrelated_signals_is_one_over_the_number_of_averages(rng):
    u, noise = rng.standard_normal((2, 64 * 1024))
    found = frequency_averaged(u, noise, RATE, 16)
    assert found.coherence.mean() == pytest.approx(1.0 / 16.0, rel=0.1)
    assert np.diff(found.frequency_hz) == pytest.approx(found.resolution_hz)


def test_noise_lowers_the_coherence_of_periods_but_hardly_the_response(rng):
    torque, angle = multisine_record(JOINT, 20.0)
    noise = 0.3 * angle.std() * rng.standard_normal(angle.size)
    found = period_averaged(torque, angle + noise, RATE, 10.0, (1.0, 9.0))
    truth = second_order_response(JOINT, found.frequency_hz)
    assert found.coherence.mean() < 0.999
    assert np.abs(np.mean(np.log(found.response / truth))) < 0.02


def test_delayed_output_turns_the_phase_and_keeps_the_gain():
    torque, _ = multisine_record(JOINT, 3.0)
    found = period_averaged(torque, np.roll(torque, 4), RATE, 10.0, (1.0, 20.0))
    expected = np.exp(-2j * np.pi * found.frequency_hz * 4.0 / RATE)
    assert found.response == pytest.approx(expected, abs=1e-10)


def test_mean_of_the_signals_does_not_count():
    torque, angle = multisine_record(JOINT, 2.3)
    plain = frequency_averaged(torque, angle, RATE, 8)
    lifted = frequency_averaged(torque + 5.0, angle - 2.0, RATE, 8)
    assert lifted.response == pytest.approx(plain.response, rel=1e-9)


def test_jump_between_the_ends_looks_coherent_beyond_the_band_unless_it_is_tapered(rng):
    torque, angle = multisine_record(JOINT, 2.3)
    noise = 1e-3 * rng.standard_normal((2, angle.size)) * [[torque.std()], [angle.std()]]
    record = (torque + noise[0], angle + noise[1], RATE, 8)
    plain, tapered = frequency_averaged(*record), frequency_averaged(*record, taper=True)
    beyond = (plain.frequency_hz > 40.0) & (plain.frequency_hz < 60.0)
    assert plain.coherence[beyond].min() > 0.9
    assert tapered.coherence[beyond].mean() < 0.3
    inside = (plain.frequency_hz > 2.0) & (plain.frequency_hz < 15.0)
    assert tapered.coherence[inside].mean() > 0.95


def test_band_keeps_both_of_its_ends():
    frequency = np.arange(1.0, 20.0)
    whole = FrequencyResponse(frequency, frequency * 1j, np.ones(19), 3)
    band = whole.band(2.0, 9.0)
    assert band.frequency_hz.tolist() == [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    assert band.response[0] == 2j
    assert band.averages == 3


def test_band_with_too_few_frequencies_is_refused():
    whole = FrequencyResponse(np.arange(1.0, 20.0), np.ones(19), np.ones(19), 3)
    with pytest.raises(InputError) as caught:
        whole.band(2.0, 4.0)
    assert_one_sentence(caught.value, "4 frequencies", "3")


@pytest.mark.parametrize(
    ("samples", "period_s", "found"), [(5120, 10.001, "10.001 s"), (5119, 10.0, "20 s of record")]
)
def test_record_without_two_whole_periods_of_whole_samples_is_refused(samples, period_s, found, rng):
    u = rng.standard_normal(samples)
    with pytest.raises(InputError) as caught:
        period_averaged(u, u, RATE, period_s, (1.0, 20.0))
    assert_one_sentence(caught.value, found)


@pytest.mark.parametrize("silent", ["torque", "angle"])
def test_signal_without_power_is_refused_instead_of_divided_by(silent, rng):
    signals = {"torque": rng.standard_normal(2560), "angle": rng.standard_normal(2560)}
    signals[silent] = np.zeros(2560)
    with pytest.raises(InputError) as caught:
        frequency_averaged(signals["torque"], signals["angle"], RATE, 8)
    assert_one_sentence(caught.value, "power")


def test_unrelated_signals_exceed_the_coherence_threshold_in_5_percent_of_frequencies():
    rng = np.random.default_rng(3)
    time = np.arange(0.0, 400.0, 1.0 / RATE_HZ)
    response = frequency_response(time, *rng.standard_normal((2, time.size)), averaged_bins=16, taper=False)
    assert np.mean(response.coherence > response.coherence_threshold()) == pytest.approx(0.05, abs=0.01)


def test_periodic_perturbation_is_averaged_over_whole_periods():
    time = np.arange(0.0, 40.0, 1.0 / RATE_HZ)
    u = np.sin(2.0 * np.pi * 0.5 * time) + np.sin(2.0 * np.pi * 2.0 * time)
    y = 3.0 * np.roll(u, 5)  # periodic, so rolling delays by 20 ms
    response = frequency_response(time, u, y, period_s=2.0, band_hz=(0.4, 2.1))
    at = np.isclose(response.frequency_hz, 2.0)
    assert response.response[at] == pytest.approx(3.0 * np.exp(-2j * np.pi * 2.0 * 0.02), rel=1e-6)
    refused(lambda: frequency_response(time, u, y, averaged_bins=1), "averaged_bins", "found 1")
