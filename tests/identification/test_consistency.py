"""Tests of consistency: residual against rest, delay of the torque, noise floors, and parts of the record."""

import numpy as np
import pytest
from builders import refused
from scipy.signal import butter, sosfilt, sosfiltfilt

from tepsipe import fit_admittance, fit_impedance, fit_parallel_cascade, frequency_response
from tepsipe.identification.consistency import parts_differ, residual_test
from tepsipe.signals.perturbations import Perturbation
from tepsipe.signals.sample_faults import clipped, held, noise_floors, spikes

RATE_HZ, COUNT, APART_S, FIRST_S = 250.0, 10, 1.5, 3.0
JOINT = {"I": 0.02, "B": 0.3, "K": 12.0}
TIME = np.arange(0.0, FIRST_S + APART_S * COUNT, 1.0 / RATE_HZ)
ONSETS_S = FIRST_S + APART_S * np.arange(COUNT)
WINDOWS = [(round((t - 0.12) * RATE_HZ), round((t + 0.28) * RATE_HZ)) for t in ONSETS_S]
DIRECTION = (-1.0) ** np.arange(COUNT)
WIDTH_S, TURN = 0.07, 30.0


def moved(time):
    """Angle (rad) and its two derivatives: damped turns about every onset, in either direction.

    theta = 0.02 exp(-x^2) cos(TURN s), x = s / WIDTH_S, s = time since the onset.
    """
    found = np.zeros((3, time.size))
    for onset, sign in zip(ONSETS_S, DIRECTION, strict=True):
        s = time - onset
        bell = 0.02 * sign * np.exp(-((s / WIDTH_S) ** 2) + 1j * TURN * s)
        slope = -2.0 * s / WIDTH_S**2 + 1j * TURN
        found += np.real([bell, slope * bell, (slope**2 - 2.0 / WIDTH_S**2) * bell])
    return found


def record(seed, late_s=0.0, noise=0.01, **joint):
    """Time (s), angle (rad) and torque (N·m) that is recorded too late, with noise relative to its spread."""
    joint = JOINT | joint
    angle = moved(TIME)[0]
    theta, rate, acceleration = moved(TIME - late_s)
    torque = joint["I"] * acceleration + joint["B"] * rate + joint["K"] * theta
    rng = np.random.default_rng(seed)
    return TIME, *(x + noise * x.std() * rng.standard_normal(x.size) for x in (angle, torque))


def fit_of(signals, **how):
    return fit_impedance(*signals, **({"perturbations": WINDOWS} | how))


def covered(fit, names="IBK"):
    return all(fit.quantities[name].low <= JOINT[name] <= fit.quantities[name].high for name in names)


# ---- delay ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("late_ms", [-20, -5, -1, 1, 2, 5, 10, 20])
def test_delay_is_found_and_removed(late_ms):
    fit = fit_of(record(1, 1e-3 * late_ms))
    delay = fit.quantities["delay"]
    assert delay.value == pytest.approx(1e-3 * late_ms, abs=3e-4)
    assert delay.low < 1e-3 * late_ms < delay.high
    assert fit.parameters == pytest.approx([0.02, 0.3, 12.0], rel=0.03)
    (note,) = fit.notes
    assert ("too late" if late_ms > 0 else "too early") in note and "corrected" in note


def test_intervals_with_a_delay_cover_as_often_as_without():
    draws, held, late = 60, np.zeros((2, 3)), []
    for seed in range(draws):
        for k, late_s in enumerate((0.0, 0.002)):
            fit = fit_of(record(seed, late_s, noise=0.03))
            held[k] += [covered(fit, name) for name in "IBK"]
        late.append([fit.quantities[name] for name in ("I", "B", "K", "delay")])
    # 95 % of 60, less three standard deviations of the binomial distribution
    assert held.min() >= 52
    assert not fit_of(record(1)).notes
    # nor wider than they have to be: Student's 2.26 for ten perturbations, and three standard errors of 60
    half = np.mean([[q.high - q.low for q in row] for row in late], axis=0) / 2.0
    spread = np.std([[q.value for q in row] for row in late], axis=0, ddof=1)
    assert (half / spread < 3.1).all()


def test_delay_of_a_joint_without_inertia_is_undetermined():
    # tau(t - d) = B theta' + K theta - d (B theta'' + K theta') + ..., which another I and B explain
    fit = fit_of(record(1, 0.001, noise=0.03, I=0.0))
    delay = fit.quantities["delay"]
    assert not delay.identified and str(delay) == "undetermined"
    assert "torque_delay_s" in delay.refusal and delay.refusal in fit.findings
    assert any(line.split()[:2] == ["delay", "undetermined"] for line in fit.summary().splitlines())
    assert set(fit.budget["B"]) == {"scatter"}
    assert "delays are not included" in fit.interval_type


def test_delay_is_a_source_of_uncertainty():
    signals = record(1)
    plain, sure = fit_of(signals), fit_of(signals, uncertainty={"torque_delay_s": 0.0})
    assert plain.budget["B"]["torque_delay_s"] > 0.0 and "delay of the torque" in plain.interval_type
    # a delay that is known is not estimated
    assert sure.budget["B"]["torque_delay_s"] == 0.0
    error = plain.quantities["delay"].standard_error
    for u in (0.1 * error, error, 100.0 * error):
        stated = fit_of(signals, uncertainty={"torque_delay_s": u})
        share = u**2 / (u**2 + error**2)
        parts = [fit.budget["B"]["torque_delay_s"] for fit in (stated, plain)]
        assert parts[0] / parts[1] == pytest.approx(np.sqrt(share), rel=0.02)
        change = stated.B - sure.B
        assert change == pytest.approx(share * (plain.B - sure.B), abs=2e-3 * plain.B)


def test_stated_uncertainty_counts_where_the_record_does_not_determine_the_delay():
    signals = record(1, noise=0.03, I=0.0)
    fit = fit_of(signals, uncertainty={"torque_delay_s": 0.001})
    # tau' is about K theta', so B is uncertain by about K u
    assert fit.budget["B"]["torque_delay_s"] == pytest.approx(0.001 * JOINT["K"], rel=0.5)
    assert not any("delay" in finding for finding in fit.findings)


def test_delay_cannot_be_told_from_a_reflex():
    time, angle, torque = record(1)
    stretch = np.maximum(moved(time - 0.06)[1], 0.0)
    fit = fit_of((time, angle, torque + 0.5 * sosfilt(butter(2, 4.0, fs=RATE_HZ, output="sos"), stretch)))
    assert not fit.quantities["delay"].identified
    assert any("reflexes" in note for note in fit.notes)


def test_thesis_equation_has_no_delay():
    assert "delay" not in fit_of(record(1), thesis=True).quantities


# ---- residual, noise floor, parts ----------------------------------------------------------------


@pytest.mark.parametrize("of", [1, 2])
@pytest.mark.parametrize("cutoff_hz", [6.0, 10.0])
def test_signal_that_was_filtered_before_is_noted(of, cutoff_hz):
    signals = list(record(1))
    signals[of] = sosfiltfilt(butter(2, cutoff_hz, fs=RATE_HZ, output="sos"), signals[of])
    notes = fit_of(signals).notes
    assert any(f"The {('angle', 'torque')[of - 1]} was filtered" in note for note in notes)
    assert any("times as much as at rest" in note for note in notes)


def test_signals_that_were_filtered_alike_have_no_note():
    sos = butter(2, 12.0, fs=RATE_HZ, output="sos")
    time, angle, torque = record(1)
    assert not fit_of((time, sosfiltfilt(sos, angle), sosfiltfilt(sos, torque))).notes


def test_residual_of_noise_is_rarely_above_the_residual_at_rest():
    rng = np.random.default_rng(3)
    windows = [Perturbation(*w, np.nan) for w in WINDOWS]
    at_rest = TIME < 2.8
    sos = butter(2, 20.0, fs=RATE_HZ, output="sos")
    p = []
    for _ in range(300):
        x = sosfiltfilt(sos, rng.standard_normal(TIME.size))
        p.append(residual_test(x, 10.0 * x, windows, at_rest).p)
    # a probability below 5 % is found in about 5 % of the records
    assert 0.02 < np.mean(np.array(p) < 0.05) < 0.1
    louder = residual_test(np.where(at_rest, x, 2.0 * x), x, windows, at_rest)
    assert louder.failed and louder.ratio == pytest.approx(2.0, rel=0.3)
    # what is less than 1 % of the torque does not matter
    assert not residual_test(np.where(at_rest, x, 2.0 * x), 300.0 * x, windows, at_rest).failed


def test_noise_floor_needs_a_second_of_rest():
    white = np.random.default_rng(1).standard_normal((2, TIME.size))
    filtered = sosfiltfilt(butter(2, 8.0, fs=RATE_HZ, output="sos"), white[0])
    assert noise_floors(TIME < 2.0, RATE_HZ, one=filtered, other=white[1]) == ("one",)
    assert noise_floors(TIME < 0.9, RATE_HZ, one=filtered, other=white[1]) == ()
    assert noise_floors(TIME < 2.0, RATE_HZ, one=white[0], other=white[1]) == ()


@pytest.mark.parametrize("what", ["half", "direction"])
def test_gain_that_changes_is_noted(what):
    time, angle, torque = record(1)
    number = np.clip(np.floor((time - FIRST_S + 0.5) / APART_S), 0, COUNT - 1).astype(int)
    part = number < COUNT // 2 if what == "half" else DIRECTION[number] > 0.0
    notes = fit_of((time, angle, torque * np.where(part, 1.3, 1.0))).notes
    assert any("half" in note or "directions" in note for note in notes)


def test_parts_differ_by_more_than_they_scatter():
    rng = np.random.default_rng(1)
    values = np.array([0.02, 0.3, 12.0]) * (1.0 + 0.01 * rng.standard_normal((12, 3)))
    direction = np.where(np.arange(12) % 2, 1.0, -1.0)
    assert parts_differ(values, direction) == ()
    values[6:, 2] *= 1.2
    ((name, what, one, other),) = parts_differ(values, direction)
    assert (name, what) == ("K", "the first and the second half")
    assert other / one == pytest.approx(1.2, rel=0.02)
    assert parts_differ(values[4:8], direction[4:8]) == ()


# ---- drift and samples -------------------------------------------------------------------------


@pytest.mark.parametrize("drift", [0.01, -0.05])
def test_drift_is_noted_and_an_own_zero_removes_most_of_it(drift):
    time, angle, torque = record(1)
    signals = time, angle, torque + drift * time
    fit, each = fit_of(signals), fit_of(signals, baseline="each")
    assert any('baseline="each"' in note for note in fit.notes)
    assert not any('baseline="each"' in note for note in each.notes)
    errors = [abs(found.K / JOINT["K"] - 1.0) for found in (fit, each)]
    assert errors[1] < 0.1 * errors[0]
    assert covered(each)


def test_own_zero_gives_the_same_joint():
    fit, each = (fit_of(record(1), baseline=b) for b in ("rest", "each"))
    assert each.parameters == pytest.approx(fit.parameters, rel=0.01)
    assert covered(each) and not each.notes
    for how in ({"baseline": "own"}, {"baseline": "each", "thesis": True}):
        refused(lambda how=how: fit_of(record(1), **how), "baseline", "expected")
    refused(lambda: fit_of(record(1), perturbations=None, baseline="each"), "baseline", "expected")


def test_spoiled_samples_are_counted():
    x = record(1)[2]
    assert spikes(x) == held(x) == clipped(x) == 0
    rounded = np.round(x / np.ptp(x) * 4096)
    assert spikes(rounded) == held(rounded) == clipped(rounded) == 0
    spiked = x.copy()
    spiked[[100, 900, 1800]] += 0.3 * np.ptp(x)
    assert spikes(spiked) == 3
    frozen = x.copy()
    start = WINDOWS[2][0] + 25
    frozen[start : start + 10] = frozen[start]
    assert held(frozen) == 1 and held(np.repeat(x[::2], 2)) >= COUNT
    # rounded noise repeats values, and jumps by a large part of the range of a small signal
    noise = np.random.default_rng(1).normal(size=(20, 10_000))
    assert [held(x) for x in np.round(noise + np.sin(np.arange(10_000) / 100.0), 1)] == [0] * 20
    assert clipped(np.clip(x, None, 0.6 * x.max())) >= COUNT // 2


@pytest.mark.parametrize("of", [1, 2])
def test_spoiled_samples_are_noted(of):
    signals = list(record(1))
    signals[of] = signals[of].copy()
    signals[of][1000] += np.ptp(signals[of])
    name = ("angle", "torque")[of - 1]
    assert any(f"The {name} has 1 single samples" in note for note in fit_of(signals).notes)


def test_stiffness_that_may_be_zero_is_noted():
    assert any("not distinguishable from 0" in note for note in fit_of(record(1, noise=0.3, K=0.05)).notes)


# ---- records without perturbations, and responses ---------------------------------------------


def movement(seed, late_s=0.0, seconds=40.0):
    """Time (s), angle (rad) and late torque (N·m) of eight periods of a random movement up to 8 Hz."""
    rng = np.random.default_rng(seed)
    count = round(seconds * RATE_HZ)
    frequency = np.fft.rfftfreq(count, 1.0 / RATE_HZ)
    inside = (frequency > 0.2) & (frequency < 8.0) & (np.arange(frequency.size) % 8 == 0)
    spectrum = inside * np.exp(2j * np.pi * rng.uniform(size=frequency.size))
    w = 2j * np.pi * frequency
    impedance = JOINT["I"] * w**2 + JOINT["B"] * w + JOINT["K"]
    angle, torque = (np.fft.irfft(x, count) for x in (spectrum, spectrum * impedance * np.exp(-w * late_s)))
    angle, torque = 0.02 * angle / angle.std(), 0.02 * torque / angle.std()
    return np.arange(count) / RATE_HZ, angle, torque + 0.01 * torque.std() * rng.standard_normal(count)


@pytest.mark.parametrize("late_ms", [0, -10, 2, 20])
def test_delay_of_a_record_and_of_a_response_is_found(late_ms):
    time, angle, torque = movement(1, 1e-3 * late_ms)
    response = frequency_response(time, torque, angle, period_s=5.0, band_hz=(0.3, 7.9))
    for fit in (fit_impedance(time, angle, torque), fit_admittance(response)):
        delay = fit.quantities["delay"]
        assert delay.value == pytest.approx(1e-3 * late_ms, abs=3e-4)
        assert any("corrected" in note for note in fit.notes) == bool(late_ms)
        assert fit.parameters == pytest.approx([0.02, 0.3, 12.0], rel=0.02)
        assert fit.budget["B"]["torque_delay_s"] > 0.0


@pytest.mark.parametrize(("period_s", "noted"), [(5.0, False), (20.0, False), (15.0, True)])
def test_part_of_a_record_that_is_not_used_is_noted(period_s, noted):
    time, angle, torque = movement(1)
    notes = frequency_response(time, torque, angle, period_s=period_s, band_hz=(0.3, 7.9)).notes
    assert any("Only the last 30 s of 40 s are used" in note for note in notes) == noted


def test_gain_that_changes_in_a_record_and_in_a_response_is_noted():
    time, angle, torque = movement(1)
    torque = torque * np.where(time > time.mean(), 1.2, 1.0)
    response = frequency_response(time, torque, angle, period_s=5.0, band_hz=(0.3, 7.9))
    for fit in (fit_impedance(time, angle, torque), fit_admittance(response)):
        assert any("second half" in note for note in fit.notes)


def test_reflexes_leave_the_delay_undetermined():
    time, angle, torque = movement(1, seconds=60.0)
    fit = fit_parallel_cascade(time, angle, torque, bootstrap_draws=100)
    assert not fit.quantities["delay"].identified
    assert any("delay of the torque is undetermined" in finding for finding in fit.findings)
    spoiled = np.where(time > time.mean(), np.random.default_rng(1).permutation(torque), torque)
    notes = fit_parallel_cascade(time, angle, spoiled, bootstrap_draws=100).notes
    assert any("held out" in note for note in notes)


# ---- command -------------------------------------------------------------------------------------


def test_command_takes_uncertainties_by_name(tmp_path, capsys, monkeypatch):
    import json

    from tepsipe.cli import main

    monkeypatch.chdir(tmp_path)

    table = tmp_path / "record.csv"
    np.savetxt(table, np.column_stack(record(1)), delimiter=",", header="time,angle,torque", comments="")
    columns = ["fit", str(table), "--time", "time", "--angle", "angle", "--torque", "torque", "--json"]
    assert main([*columns, "--uncertainty", "torque_scale=0.02", "--uncertainty", "angle_scale=0.01"]) == 0
    parts = json.loads(capsys.readouterr().out)["quantities"]["K"]["parts"]
    assert parts["torque_scale"] == pytest.approx(2.0 * parts["angle_scale"])
    for given, found in (
        (["torque_delay"], "torque_delay"),
        (["torque_scale=much"], "torque_scale=much"),
        (["mass=1"], "mass"),
        (["torque_scale=1", "torque_scale=2"], "twice"),
    ):
        options = [x for each in given for x in ("--uncertainty", each)]
        assert main([*columns, *options]) == 2
        error = capsys.readouterr().err
        assert "uncertainty" in error and found in error
    refused(lambda: fit_of(record(1), uncertainty={"torque_delay": 1.0}), "torque_delay_s", "expected")
