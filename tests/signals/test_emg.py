"""Electromyograms are processed as printed; a faulty channel is separated from a weak but healthy muscle."""

from time import perf_counter

import numpy as np
import pytest
from builders import assert_one_sentence, refused
from emg_builders import EMG_RATE_HZ, emg

from tepsipe.errors import InputError
from tepsipe.signals.emg import (
    CLIPPED_SHARE,
    EVALUATED_WINDOW_S,
    FLAT_SHARE,
    FLAT_UV,
    HUM_SHARE,
    HUM_UV,
    NOISE_UV,
    EmgOptions,
    channel_fault,
    clipped_perturbations,
    process_emg,
)

LIMITS = np.array([-3276.8, 3276.7])
SAMPLES = 65000
TIME = np.arange(SAMPLES) / EMG_RATE_HZ
PRINTED = EmgOptions()


def fault(x, limits=LIMITS, **options):
    """Fault of a channel after the recorder's converter (0.1 uV), checked to be one sentence."""
    found = channel_fault(np.clip(np.round(x, 1), *limits), limits, EMG_RATE_HZ, **options)
    if found is not None:
        assert_one_sentence(found)
    return found


def channel(rng, rest=2.0, **disturbances):
    return emg(np.full(SAMPLES, rest), rng, **disturbances)


# ---- processing --------------------------------------------------------------------------------


def test_stages_are_those_of_the_thesis(rng):
    x = channel(rng)
    found = process_emg(x, EMG_RATE_HZ, PRINTED)
    assert found.rectified.tolist() == np.abs(found.band_passed).tolist()
    assert found.rectified.mean() == pytest.approx(np.sqrt(2.0 / np.pi) * found.band_passed.std(), rel=0.02)
    assert found.envelope.mean() == pytest.approx(found.rectified.mean(), rel=0.01)
    spectrum = np.abs(np.fft.rfft(found.envelope - found.envelope.mean())) ** 2
    frequency = np.fft.rfftfreq(SAMPLES, 1.0 / EMG_RATE_HZ)
    assert spectrum[frequency > 12.0].sum() < 0.01 * spectrum.sum()


@pytest.mark.parametrize("frequency_hz", [31.0, 83.0, 173.0])
def test_envelope_of_a_sine_is_its_mean_rectified_value(frequency_hz):
    found = process_emg(10.0 * np.sin(2.0 * np.pi * frequency_hz * TIME), EMG_RATE_HZ, PRINTED)
    gain = found.band_passed[20000:40000].std() * np.sqrt(2.0) / 10.0
    assert found.envelope[20000:40000] == pytest.approx(gain * 20.0 / np.pi, rel=0.02)


@pytest.mark.parametrize(("frequency_hz", "gain"), [(20.0, 0.5), (300.0, 0.5), (5.0, 0.0), (80.0, 1.0)])
def test_gain_in_and_beside_the_band(frequency_hz, gain):
    found = process_emg(np.sin(2.0 * np.pi * frequency_hz * TIME), EMG_RATE_HZ, PRINTED).band_passed
    assert np.sqrt(2.0) * found[20000:40000].std() == pytest.approx(gain, abs=0.01)


def test_result_is_in_the_unit_of_the_electromyogram(rng):
    x = channel(rng)[:5000]
    in_uv, in_volts = (process_emg(scale * x, EMG_RATE_HZ, PRINTED) for scale in (1.0, 1e-6))
    for name in ("band_passed", "rectified", "envelope"):
        assert 1e6 * getattr(in_volts, name) == pytest.approx(getattr(in_uv, name), abs=1e-9)


def test_all_stages_are_aligned_in_time():
    impulse = np.zeros(8001)
    impulse[4000] = 1.0
    found = process_emg(impulse, EMG_RATE_HZ, PRINTED)
    for x in (found.band_passed, found.rectified, found.envelope):
        assert x == pytest.approx(x[::-1], abs=1e-9)
        assert np.argmax(x) == 4000


def test_muscles_are_processed_one_by_one(rng):
    x = rng.standard_normal((5000, 3))
    together = process_emg(x, EMG_RATE_HZ, PRINTED).envelope
    assert together[:, 2] == pytest.approx(process_emg(x[:, 2], EMG_RATE_HZ, PRINTED).envelope, abs=1e-12)


def test_notches_remove_the_mains_and_leave_the_muscle(rng):
    muscle = emg(np.full(SAMPLES, 5.0), rng, noise=0.0, hum=0.0)
    hum = sum(20.0 / k * np.sin(2.0 * np.pi * 50.0 * k * TIME) for k in (1, 3, 5))
    options = EmgOptions(mains_hz=50.0)
    clean, humming = (process_emg(x, EMG_RATE_HZ, options).band_passed for x in (muscle, muscle + hum))
    assert (humming - clean)[3000:-3000].std() < 0.01
    untouched = process_emg(muscle, EMG_RATE_HZ, PRINTED).band_passed
    assert clean.std() == pytest.approx(untouched.std(), rel=0.05)
    assert process_emg(hum, EMG_RATE_HZ, PRINTED).band_passed.std() > 10.0


def test_missing_samples_are_refused():
    with pytest.raises(InputError, match="NaN"):
        process_emg(np.full(1000, np.nan), EMG_RATE_HZ, PRINTED)


def test_recorder_that_is_too_slow_for_the_band_is_refused(rng):
    with pytest.raises(InputError, match="band-pass: expected edges"):
        process_emg(rng.standard_normal(5000), 500.0, PRINTED)


# ---- faulty channels ---------------------------------------------------------------------------


@pytest.mark.parametrize("rest", [0.0, 1.0, 3.0, 30.0, 400.0])
@pytest.mark.parametrize("noise", [0.5, 1.0])
@pytest.mark.parametrize("hum", [0.0, 2.0, 5.0])
def test_healthy_channel_has_no_fault(rest, noise, hum, rng):
    x = emg(np.full(20000, rest), rng, noise=noise, hum=hum)
    assert fault(x) is None


def test_bursts_offset_drift_and_artefacts_are_no_fault(rng):
    envelope = 1.0 + 300.0 * np.exp(-0.5 * ((TIME % 6.0 - 3.0) / 0.05) ** 2)
    x = emg(envelope, rng, noise=0.7) + 500.0 + 200.0 * np.sin(2.0 * np.pi * 0.1 * TIME)
    x += np.where(TIME % 6.0 < 0.02, 5000.0, 0.0)
    assert fault(x) is None


@pytest.mark.parametrize("step_uV", [0.05, 1.0, 3.0])
def test_coarse_converter_is_no_fault(step_uV, rng):  # noqa: N803
    x = step_uV * np.round(channel(rng, noise=1.0) / step_uV)
    assert channel_fault(x, 32767.0 * step_uV * np.array([-1.0, 1.0]), EMG_RATE_HZ) is None


@pytest.mark.parametrize("value", [0.0, 17.3, -250.0])
def test_constant_channel_is_flat(value):
    assert "flat" in fault(np.full(SAMPLES, value))


@pytest.mark.parametrize(("times", "flat"), [(0.6, True), (1.7, False)])
def test_noise_below_that_of_any_amplifier_is_flat(times, flat, rng):
    x = times * FLAT_UV * rng.standard_normal(SAMPLES)
    assert (channel_fault(x, LIMITS, EMG_RATE_HZ) is not None) is flat


@pytest.mark.parametrize(("times", "flat"), [(0.5, False), (2.0, True)])
def test_channel_that_dies_for_long_enough_is_flat(times, flat, rng):
    x = channel(rng)
    x[: round(times * FLAT_SHARE * SAMPLES)] = 12.0
    found = fault(x)
    assert (found is not None and "flat" in found) is flat


@pytest.mark.parametrize("value", [LIMITS[0], LIMITS[1], 5000.0])
def test_channel_at_its_limits_was_saturated(value):
    assert "saturated" in fault(np.full(SAMPLES, value))


@pytest.mark.parametrize(("times", "clipped"), [(0.6, False), (1.5, True)])
@pytest.mark.parametrize("rail", [5000.0, 1200.0])
def test_clipping_is_a_fault_from_its_share_on(times, clipped, rail, rng):
    x = channel(rng)
    length = round(times * CLIPPED_SHARE * SAMPLES / 10)
    for k in range(10):
        x[6000 * k + 1000 : 6000 * k + 1000 + length] = rail
    found = fault(x)
    assert (found is not None and "saturated" in found) is clipped


@pytest.mark.parametrize(("share", "faulty"), [(0.9, True), (0.65, False)])
@pytest.mark.parametrize("mains_hz", [50.0, 60.0])
def test_hum_is_a_fault_where_it_dominates(share, faulty, mains_hz, rng):
    assert 0.65 < HUM_SHARE < 0.9
    rest = 10.0
    amplitude = np.sqrt(2.0 * share / (1.0 - share)) * rest
    x = emg(np.full(SAMPLES, rest), rng, hum=0.0) + amplitude * np.sin(2.0 * np.pi * (mains_hz + 0.1) * TIME)
    found = fault(x, mains_hz=mains_hz)
    assert (found is not None and "mains" in found) is faulty


@pytest.mark.parametrize(("times", "faulty"), [(0.7, False), (1.5, True)])
def test_hum_below_its_level_is_no_fault_whatever_its_share(times, faulty, rng):
    x = emg(np.full(SAMPLES, 0.5), rng, noise=0.5, hum=np.sqrt(2.0) * times * HUM_UV)
    assert (fault(x) is not None) is faulty


@pytest.mark.parametrize(("times", "faulty"), [(0.7, False), (1.4, True)])
def test_noise_that_no_muscle_makes_is_a_fault(times, faulty, rng):
    x = emg(np.full(SAMPLES, times * NOISE_UV), rng)
    found = fault(x, limits=np.array([-32768.0, 32767.0]))
    assert (found is not None and "more than a muscle generates" in found) is faulty


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_missing_samples_are_a_fault(bad, rng):
    x = channel(rng)
    x[[1500, 1501]] = bad
    found = channel_fault(x, LIMITS, EMG_RATE_HZ)
    assert_one_sentence(found, "found none in 2", "1.500 s")


def test_channel_that_is_too_short_to_judge_is_refused(rng):
    with pytest.raises(InputError) as caught:
        channel_fault(rng.standard_normal(900), LIMITS, EMG_RATE_HZ)
    assert_one_sentence(caught.value)


@pytest.mark.parametrize("rail", [5000.0, 900.0], ids=["recorder", "amplifier"])
def test_perturbations_in_which_a_channel_was_clipped_are_told(rail, rng):
    x = channel(rng)
    x[10020:10035] = rail
    x[20000:20012] = -rail
    x[30050:30070] = rail
    x = np.clip(x, *LIMITS)
    onsets = np.array([5.0, 10.0, 20.1, 30.0, 40.0])
    found = clipped_perturbations(x, LIMITS, EMG_RATE_HZ, onsets, 0.05, 0.2)
    assert found.tolist() == [False, True, False, True, False]
    shifted = clipped_perturbations(x, LIMITS, EMG_RATE_HZ, onsets - 7.0, 0.05, 0.2, start_s=-7.0)
    assert shifted.tolist() == found.tolist()
    assert fault(x) is None


def test_three_samples_at_the_recorder_s_limit_count_and_one_does_not(rng):
    x = channel(rng)
    x[10000:10003] = LIMITS[1]
    x[20000] = LIMITS[0]
    onsets = np.array([9.9, 10.05, 10.06, 19.9])
    found = clipped_perturbations(x, LIMITS, EMG_RATE_HZ, onsets, 0.05, 0.2)
    assert found.tolist() == [True, True, False, False]


def test_limits_that_are_the_channel_s_own_extremes_do_not_make_it_clipped(rng):
    """As many programs write them."""
    x = channel(rng)
    own = np.array([x.min(), x.max()])
    assert channel_fault(x, own, EMG_RATE_HZ) is None
    assert not clipped_perturbations(x, own, EMG_RATE_HZ, np.arange(1.0, 64.0), 0.5, 0.5).any()
    flat = channel_fault(np.zeros(SAMPLES), np.array([0.0, 1.0]), EMG_RATE_HZ)
    assert "the channel is flat" in flat


def test_a_trial_is_processed_and_judged_in_no_time(rng):
    x = np.column_stack([channel(rng) for _ in range(5)])
    start = perf_counter()
    process_emg(x, EMG_RATE_HZ, EmgOptions(mains_hz=50.0))
    for column in x.T:
        channel_fault(column, LIMITS, EMG_RATE_HZ)
    assert perf_counter() - start < 2.0


def test_samples_a_little_inside_of_the_recorder_s_limits_are_clipped(rng):
    """Converters and filters leave clipped samples a little short of the limit."""
    onsets = np.array([9.9])
    for short_uV, told in ((0.2, True), (500.0, False)):
        x = channel(rng)
        x[10000:10003] = LIMITS[1] - short_uV
        assert clipped_perturbations(x, LIMITS, EMG_RATE_HZ, onsets, 0.05, 0.2).tolist() == [told]


def test_channel_of_exactly_one_window_is_evaluated(rng):
    size = round(EVALUATED_WINDOW_S * EMG_RATE_HZ)
    assert channel_fault(channel(rng)[:size], LIMITS, EMG_RATE_HZ) is None
    refused(lambda: channel_fault(channel(rng)[: size - 1], LIMITS, EMG_RATE_HZ), "found")
