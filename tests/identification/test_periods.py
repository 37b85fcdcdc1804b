"""The linear joint nearest to a trial of whole periods: known joints, noise, delay, intervals."""

import numpy as np
import pytest
from builders import assert_one_sentence, multisine_record

from tepsipe.errors import InputError
from tepsipe.identification.regression.periods import PeriodicRecord, fit_periods, torque_delay

JOINT = np.array([0.015, 0.1, 8.0])
RATE, PERIOD, BAND = 256.0, 10.0, (1.0, 20.0)


def record(seed=3, noise_rad=0.0, ripple=0.0, periods=4):
    """Torque and angle of whole periods in the steady state, ripple acting on the joint without a record."""
    rng = np.random.default_rng(seed)
    torque, angle = multisine_record(JOINT, periods + 1, seed=7)
    n = torque.size
    omega = 2.0 * np.pi * np.fft.rfftfreq(n, 1.0 / RATE)
    answer = 1.0 / (JOINT[2] - JOINT[0] * omega**2 + 1j * omega * JOINT[1])
    angle = angle + np.fft.irfft(answer * np.fft.rfft(ripple * rng.standard_normal(n)), n)
    angle = angle + noise_rad * rng.standard_normal(n)
    first = round(PERIOD * RATE)
    return torque[first:], angle[first:]


def fit(torque, angle, band=BAND):
    return fit_periods(PeriodicRecord(torque, angle, RATE, PERIOD, band))


def test_joint_without_noise_comes_back_and_its_band_does_not_matter():
    found = fit(*record())
    assert found.parameters == pytest.approx(JOINT, rel=1e-4)
    assert abs(found.delay_s) < 1e-6
    assert np.abs(found.of_band / JOINT).max() < 1e-4


def test_delay_of_the_torque_is_estimated_and_does_not_become_damping():
    torque, angle = record()
    omega = 2.0 * np.pi * np.fft.rfftfreq(torque.size, 1.0 / RATE)
    early = np.fft.irfft(np.fft.rfft(torque) * np.exp(1j * omega * 5e-4), torque.size)
    found = fit(early, angle)
    assert found.delay_s == pytest.approx(5e-4, rel=0.02)
    assert found.parameters == pytest.approx(JOINT, rel=5e-3)


def test_noise_of_the_angle_does_not_soften_the_joint():
    found = np.array([fit(*record(seed, noise_rad=0.01)).parameters for seed in range(20)])
    error = found.mean(axis=0) / JOINT - 1.0
    spread = found.std(axis=0, ddof=1) / np.sqrt(20) / JOINT
    assert (np.abs(error) < 4.0 * spread).all()
    # least squares without instruments is off by many times that
    softened = np.mean([_without_instruments(*record(seed, noise_rad=0.01)) for seed in range(5)])
    assert softened < JOINT[2] * (1.0 - 10.0 * spread[2])


def _without_instruments(torque, angle):
    lines = slice(10, 201)
    spectra = [np.fft.rfft(x.reshape(-1, round(PERIOD * RATE)), axis=1)[:, lines] for x in (torque, angle)]
    omega = 2.0 * np.pi * np.arange(10, 201) / PERIOD
    columns = np.stack([-(omega**2) * spectra[1], 1j * omega * spectra[1], spectra[1]], axis=-1).reshape(
        -1, 3
    )
    both = (
        np.concatenate([columns.real, columns.imag]),
        np.concatenate([f(spectra[0].ravel()) for f in PARTS]),
    )
    return np.linalg.lstsq(*both, rcond=None)[0][2]


PARTS = (np.real, np.imag)


def test_type_a_is_the_spread_over_trials():
    found = [fit(*record(seed, noise_rad=0.002, ripple=0.03)) for seed in range(60)]
    spread = np.std([f.parameters for f in found], axis=0, ddof=1)
    stated = np.sqrt(np.mean([f.type_a**2 for f in found], axis=0))
    assert stated == pytest.approx(spread, rel=0.3)
    held = [np.abs(f.parameters - JOINT) < 2.0 * f.type_a for f in found]
    assert np.mean(held) > 0.88
    assert all(f.freedom > 20.0 for f in found)


def test_units_of_the_torque_scale_every_parameter():
    torque, angle = record(noise_rad=0.002)
    one, thousand = fit(torque, angle), fit(1e3 * torque, angle)
    assert thousand.parameters == pytest.approx(1e3 * one.parameters, rel=1e-6)
    assert thousand.type_a == pytest.approx(1e3 * one.type_a, rel=1e-6)


@pytest.mark.parametrize(
    ("band", "periods", "said"), [((1.0, 2.0), 4, "6 multiples"), (BAND, 1, "two periods")]
)
def test_too_few_lines_or_periods_are_refused(band, periods, said):
    with pytest.raises(InputError) as caught:
        fit(*record(periods=periods), band)
    assert_one_sentence(caught.value, said)


@pytest.mark.parametrize("delay_s", [0.03, 0.01, 0.003, 0.0, -0.01])
def test_delay_that_is_long_against_the_quickest_line_is_found(delay_s):
    torque, angle = multisine_record((0.015, 0.1, 9.0), 4.0)
    late = np.roll(angle, round(delay_s * 256.0))
    found = torque_delay(PeriodicRecord(torque, late, 256.0, 10.0, (1.0, 20.0)))
    assert found == pytest.approx(round(delay_s * 256.0) / 256.0, abs=1e-6)
