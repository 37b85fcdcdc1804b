"""The recorder of muscle activity: what it adds to the drive, how it samples, and its file."""

from dataclasses import replace

import numpy as np
import pytest
from edfio import read_edf
from scipy.signal import welch

from tepsipe.virtual_lab.electromyography import (
    CHANNELS,
    MUSCLES,
    STEPS,
    EmgTruth,
    record_emg,
    sample_trigger,
    write_emg,
)
from tepsipe.virtual_lab.seeds import generator

GRID_HZ = 2000.0
TRUTH = EmgTruth(
    rate_hz=1000.0,
    band_hz=(50.0, 180.0),
    full_drive_uV=400.0,
    cross_talk=0.03,
    artefact_uV_per_m_per_s2=5.0,
    artefact_s=0.02,
    hum_uV=3.0,
    hum_hz=50.0,
    hum_third=0.2,
    channel_spread=0.3,
    baseline_uV=20.0,
    baseline_s=0.5,
    noise_uV=1.0,
    limit_uV=2343.0,
)
STEP_UV = 2343.0 / STEPS
QUIET = replace(
    TRUTH, cross_talk=0.0, artefact_uV_per_m_per_s2=0.0, hum_uV=0.0, baseline_uV=0.0, noise_uV=0.0
)


def grid(seconds):
    return np.arange(round(seconds * GRID_HZ) + 1) / GRID_HZ


def record(truth, seconds=20.0, drive=0.0, acceleration=None, seed=1):
    """Signals (uV) and instants (s) of a drive that is a number, one per muscle, or one per grid point."""
    time = grid(seconds)
    drive = np.broadcast_to(drive, (time.size, len(MUSCLES)))
    acceleration = np.zeros(time.size) if acceleration is None else acceleration
    return record_emg(truth, time, drive, acceleration, seconds, generator(seed, "emg"))


def pulses(seconds):
    """Belt acceleration (m/s2) of a pulse of 0.1 s, 0.3 m/s, every second."""
    time = grid(seconds)
    phase = time % 1.0
    return np.where(phase < 0.1, 6.0 * np.pi * np.cos(20.0 * np.pi * phase), 0.0)


def shares(voltages, edge_hz):
    """Part of a channel's power below a frequency (-)."""
    frequency, power = welch(voltages, 1000.0, nperseg=1000)
    return power[frequency < edge_hz].sum() / power.sum()


# ---- muscles -----------------------------------------------------------------------------------


def test_root_mean_square_is_full_drive_times_drive():
    drive = np.array([0.05, 0.1, 0.2, 0.4, 0.8])
    signals, _ = record(QUIET, drive=drive)
    assert signals.std(axis=0) == pytest.approx(400.0 * drive, rel=0.05)
    single, _ = record(QUIET, drive=0.5 * drive)
    assert single == pytest.approx(0.5 * signals, abs=STEP_UV)


def test_burst_begins_and_ends_with_its_drive():
    time = grid(3.0)
    burst = ((time > 1.0) & (time < 1.1)).astype(float)[:, None]
    signals, instants = record(QUIET, 3.0, burst)
    outside = (instants < 1.0) | (instants > 1.1)
    assert np.abs(signals[outside]).max() == 0.0
    first = (instants > 1.0) & (instants < 1.02)
    assert (np.abs(signals[first]).max(axis=0) > 100.0).all()


def test_spectrum_is_that_of_surface_electrodes():
    signals, _ = record(QUIET, 60.0, 1.0)
    frequency, power = welch(signals, 1000.0, nperseg=500, axis=0)
    assert np.interp(0.5, *quantiles(power, frequency)) == pytest.approx(90.0, abs=30.0)
    assert 60.0 < frequency[np.argmax(power.mean(axis=1))] < 110.0
    beyond = power[frequency > 400.0].sum() / power.sum()
    assert beyond < 0.01
    assert power[frequency > 200.0].sum() / power.sum() > 0.05


def quantiles(power, frequency):
    """Cumulative share of the power, and the frequencies (Hz)."""
    cumulative = np.cumsum(power.mean(axis=1))
    return cumulative / cumulative[-1], frequency


def test_muscles_are_independent_but_for_cross_talk_between_neighbours():
    drive = np.array([1.0, 0.0, 0.0, 0.0, 0.5])
    signals, _ = record(replace(QUIET, cross_talk=0.03), drive=drive)
    ta, sol, gas, bf, rf = signals.T
    assert sol == pytest.approx(0.03 * ta, abs=STEP_UV)
    assert bf == pytest.approx(0.03 * rf, abs=STEP_UV)
    assert np.abs(gas).max() == 0.0
    together, _ = record(QUIET, 60.0, 1.0)
    correlation = np.corrcoef(together.T) - np.eye(5)
    assert np.abs(correlation).max() < 0.05


def test_muscle_goes_on_as_it_was_until_the_recorders_second_is_over():
    time = grid(2.25)
    drive = np.full((time.size, 5), 0.3)
    signals, instants = record_emg(QUIET, time, drive, np.zeros(time.size), 2.25, generator(1, "emg"))
    assert signals.shape == (3000, 5)
    assert signals[instants > 2.3].std() == pytest.approx(120.0, rel=0.1)


# ---- what is not muscle ------------------------------------------------------------------------


def test_hum_has_its_amplitude_at_its_frequency_and_thrice():
    signals, instants = record(replace(QUIET, hum_uV=3.0, channel_spread=0.0), 10.0)
    for frequency, amplitude in ((50.0, 3.0), (150.0, 0.6), (100.0, 0.0)):
        turning = np.exp(-2j * np.pi * frequency * instants)
        found = 2.0 * np.abs(turning @ signals) / instants.size
        assert found == pytest.approx(np.full(5, amplitude), abs=STEP_UV)
    spread, _ = record(replace(QUIET, hum_uV=3.0, channel_spread=0.5), 10.0)
    assert np.ptp(spread.std(axis=0)) > 0.5


def test_artefact_follows_the_belt_and_is_slow():
    truth = replace(QUIET, artefact_uV_per_m_per_s2=5.0)
    signals, instants = record(truth, 20.0, acceleration=pulses(20.0))
    for voltages in signals.T:
        assert shares(voltages, 30.0) > 0.95
    phase = instants % 1.0
    during = np.abs(signals[phase < 0.1]).max(axis=0)
    late = np.abs(signals[phase > 0.2]).max(axis=0)
    assert (during > 10.0).all()
    assert (late < 0.05 * during).all()
    assert np.abs(signals[instants < 1e-3]).max() < 5.0


def test_artefact_of_a_lasting_acceleration_is_the_stated_gain():
    truth = replace(QUIET, artefact_uV_per_m_per_s2=5.0, channel_spread=0.0)
    signals, instants = record(truth, 1.0, acceleration=np.full(grid(1.0).size, 2.0))
    expected = 10.0 * (1.0 - (1.0 + instants / 0.02) * np.exp(-instants / 0.02))
    assert np.abs(signals) == pytest.approx(np.tile(expected[:, None], 5), abs=0.1)


def test_baseline_wanders_slowly_about_zero():
    signals, _ = record(replace(QUIET, baseline_uV=20.0), 300.0)
    assert signals.std() == pytest.approx(20.0, rel=0.1)
    for voltages in signals.T:
        assert shares(voltages, 5.0) > 0.99


def test_everything_else_is_white_noise():
    signals, _ = record(replace(QUIET, noise_uV=1.0), 60.0)
    assert signals.std(axis=0) == pytest.approx(np.full(5, 1.0), rel=0.02)
    for voltages in signals.T:
        assert shares(voltages, 250.0) == pytest.approx(0.5, abs=0.02)


def test_draws_of_one_part_do_not_depend_on_the_others():
    """The parts add up: none draws other numbers because another is there."""
    parts = [
        {"artefact_uV_per_m_per_s2": 5.0},
        {"hum_uV": 3.0},
        {"baseline_uV": 20.0},
        {"noise_uV": 1.0},
    ]
    moved, together = pulses(5.0), {}
    total = record(QUIET, 5.0, 0.2, moved)[0]
    for part in parts:
        together |= part
        total = total + record(replace(QUIET, **part), 5.0, 0.0, moved)[0]
    everything, _ = record(replace(QUIET, **together), 5.0, 0.2, moved)
    assert everything == pytest.approx(total, abs=3.0 * STEP_UV)


# ---- converter, clock and file -----------------------------------------------------------------


def test_converter_rounds_to_its_steps_and_clips_at_its_limit():
    signals, _ = record(TRUTH, 5.0, 0.1)
    steps = signals / STEP_UV
    assert steps == pytest.approx(np.round(steps), abs=1e-6)
    assert np.unique(np.round(steps)).size > 500
    clipped, _ = record(TRUTH, 5.0, 5.0)
    assert clipped.max() == 2343.0
    assert clipped.min() == -2343.0


def test_first_sample_falls_within_an_interval_and_the_recorder_runs_for_whole_seconds():
    starts = []
    for seed in range(8):
        signals, instants = record(QUIET, 2.5, seed=seed)
        assert signals.shape == (3000, 5)
        assert np.diff(instants) == pytest.approx(np.full(2999, 1e-3))
        assert instants[-1] >= 2.5
        starts.append(instants[0])
    assert 0.0 <= min(starts) < max(starts) < 1e-3
    assert np.ptp(starts) > 3e-4


def test_trigger_is_high_for_its_duration_on_the_recorders_clock():
    instants = 0.0004 + np.arange(3000) / 1000.0
    line = sample_trigger(instants, 0.5002, 2.0)
    assert set(np.unique(line)) == {0.0, 5.0}
    high = instants[line > 2.5]
    assert high[0] == pytest.approx(0.5004)
    assert high.size == 2000


def write(path, seed=1, seconds=3.0):
    signals, instants = record(TRUTH, seconds, 0.2, pulses(seconds), seed)
    trigger = sample_trigger(instants, 0.5002, 2.0)
    write_emg(path, CHANNELS, signals, trigger, TRUTH.rate_hz, TRUTH.limit_uV)
    return signals, trigger


def test_file_holds_what_was_recorded(tmp_path):
    signals, trigger = write(tmp_path / "emg.edf")
    file = read_edf(tmp_path / "emg.edf")
    assert file.reserved == "EDF+C"
    assert file.data_record_duration == 1.0
    assert file.num_data_records == 3
    assert file.labels == ("EMG TA", "EMG SOL", "EMG GAS", "EMG BF", "EMG RF", "Trigger")
    *channels, line = file.signals
    for channel, voltages in zip(channels, signals.T, strict=True):
        assert channel.physical_dimension == "uV"
        assert channel.sampling_frequency == 1000.0
        assert (channel.physical_min, channel.physical_max) == (-2343.0, 2343.0)
        assert channel.data == pytest.approx(voltages, abs=1e-9)
    assert line.physical_dimension == "V"
    assert line.data == pytest.approx(trigger, abs=1e-9)


def test_file_holds_other_voltages_within_half_a_step(tmp_path, rng):
    voltages = rng.uniform(-2343.0, 2343.0, (1000, 5))
    write_emg(tmp_path / "emg.edf", CHANNELS, voltages, np.zeros(1000), 1000.0, 2343.0)
    read = np.column_stack([channel.data for channel in read_edf(tmp_path / "emg.edf").signals[:5]])
    assert np.abs(read - voltages).max() <= 0.5 * STEP_UV * (1.0 + 1e-9)


def test_same_seed_writes_the_same_bytes(tmp_path):
    for name, seed in (("first", 1), ("again", 1), ("other", 2)):
        write(tmp_path / name, seed)
    first, again, other = ((tmp_path / name).read_bytes() for name in ("first", "again", "other"))
    assert again == first
    assert other != first
