"""Checks of a parallel-cascade fit, and the flags of a manipulator's trial, on records that were spoiled."""

import copy

import numpy as np
import pytest
from builders import trial_of
from scipy.signal import butter, sosfiltfilt

import tepsipe
from tepsipe.experiments.position_manipulator import fit as position_manipulator
from tepsipe.experiments.position_manipulator.analysis import cascade_record
from tepsipe.identification.cascade.checks import (
    failed_checks,
    late,
    torque_delay,
    varying_stiffness,
)
from tepsipe.identification.cascade.parallel_cascade import identify_cascade
from tepsipe.identification.consistency import DelayProfile, moved_by
from tepsipe.ingest.manipulator_options import TableOptions
from tepsipe.ingest.manipulators import ingest_position_manipulator
from tests.identification.test_parallel_cascade import FEW_DRAWS, RATE, REFLEX, joint_with_reflex
from workflow.settings.complete import settings_of


@pytest.fixture(scope="module")
def recorded():
    """Time (s), angle (rad) and torque (N·m) of a joint with a reflex."""
    trial, _ = joint_with_reflex(np.random.default_rng(424), noise=0.1)
    rng = np.random.default_rng(425)
    angle = trial.values("angle") + 2e-5 * rng.standard_normal(trial.time.size)
    return trial.time, angle, trial.values("torque")


def fitted(_time, angle, torque):
    """Record and fit of signals (rad, N·m)."""
    trial = trial_of(RATE, angle=(angle, "rad"), torque=(torque, "Nm"))
    record, block = cascade_record(trial, FEW_DRAWS, REFLEX)
    return record, identify_cascade(record, block, 10, np.random.default_rng(1))


@pytest.fixture(scope="module")
def sound(recorded):
    """Record and fit of the joint as it was recorded."""
    return fitted(*recorded)


@pytest.fixture(scope="module")
def study(shipped_config):
    """Function from signals to the rows of a study's trial."""
    section = copy.deepcopy(settings_of(shipped_config)["position_manipulator"])
    section["analysis"]["bootstrap_draws"] = 20
    options = TableOptions(resample_rate_hz=RATE, max_gap_s=0.02, angle_unit="rad", torque_sign=1)

    def rows(time, angle, torque):
        table = {"time": time, "angle": angle, "torque": torque}
        trial = ingest_position_manipulator(table, options, time[-1], "log")
        return position_manipulator.fit(trial, section, "a", 1).estimates

    return rows


def flags(rows):
    return {name for row in rows for name in row.flags.split(";")}


NEW = {
    "torque-delay",
    "time-varying",
    "halves-differ",
    "filtered-signal",
    "spikes",
    "held-samples",
    "clipped",
}


def test_a_sound_record_fails_no_check(recorded, sound, study):
    assert failed_checks(*sound) == ()
    assert not tepsipe.fit_parallel_cascade(*recorded, bootstrap_draws=100).notes
    rows = study(*recorded)
    assert not NEW & flags(rows)
    assert {row.quantity for row in rows if row.recommended} == set("IBK")


@pytest.mark.parametrize("delay_s", [-0.004, 0.002])
def test_delay_of_the_torque_is_found_beside_a_reflex(delay_s, recorded):
    time, angle, torque = recorded
    record, fit = fitted(time, angle, moved_by(time, torque, -delay_s))
    assert torque_delay(record, fit).value_s == pytest.approx(delay_s, abs=5e-4)
    assert failed_checks(record, fit) == ("torque-delay",)


@pytest.mark.parametrize(
    ("profile", "expected"),
    [
        (DelayProfile(0.0009, 1e-5, 50.0), False),
        (DelayProfile(0.0011, 1e-5, 50.0), True),
        (DelayProfile(-0.0011, 1e-5, 50.0), True),
        (DelayProfile(0.005, 0.002, 50.0), False),
        (DelayProfile(0.005, reason="unknown", excludes_zero=True), True),
        (DelayProfile(reason="unknown"), False),
    ],
)
def test_a_delay_counts_beyond_its_error_and_a_millisecond(profile, expected):
    assert late(profile) == expected


def test_stiffness_that_varies_leaves_nothing_to_recommend(recorded, sound, study):
    time, angle, torque = recorded
    gain = 1.0 + 0.3 * np.sin(2.0 * np.pi * time / 17.0)
    record, fit = fitted(time, angle, gain * torque)
    # the standard deviation of the gain
    assert varying_stiffness(record, fit) == pytest.approx(0.3 / np.sqrt(2.0), abs=0.06)
    assert varying_stiffness(*sound) == 0.0
    rows = study(time, angle, gain * torque)
    assert "time-varying" in flags(rows)
    assert not any(row.recommended for row in rows)


def test_a_record_of_few_segments_tells_no_variation(recorded):
    time, angle, torque = (x[: round(16.0 * RATE)] for x in recorded)
    assert varying_stiffness(*fitted(time, angle, (1.0 + 0.5 * (time > 8.0)) * torque)) == 0.0


def filtered(x):
    return sosfiltfilt(butter(2, 12.0, fs=RATE, output="sos"), x)


def spiked(x):
    return x + np.ptp(x) * np.isin(np.arange(x.size), [3000, 5000])


def held(x):
    """Two of three samples repeat the one before, in every fifth second."""
    still = (np.arange(x.size) // round(RATE)) % 5 == 0
    return np.where(still, x[np.arange(x.size) // 12 * 12], x)


def ruined(x):
    return np.where(np.arange(x.size) > x.size // 2, np.roll(x, 700), x)


@pytest.mark.parametrize(
    ("spoil", "flag"),
    [
        (filtered, "filtered-signal"),
        # rounding is white, as the noise of an instrument
        (lambda x: np.round(filtered(x), 3), "filtered-signal"),
        (spiked, "spikes"),
        (held, "held-samples"),
        (lambda x: np.maximum(x, np.quantile(x, 0.006)), "clipped"),
        (ruined, "halves-differ"),
    ],
    ids=["filtered", "filtered-and-rounded", "spikes", "held", "clipped", "ruined"],
)
def test_a_spoiled_torque_is_flagged_by_what_was_spoiled(spoil, flag, recorded, study):
    time, angle, torque = recorded
    rows = study(time, angle, spoil(torque))
    assert all(flag in row.flags.split(";") for row in rows)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda time, x: moved_by(time, x, -0.004), "torque-delay"),
        (lambda time, x: np.round(filtered(x), 3), "filtered-signal"),
        (lambda time, x: (1.0 + 0.4 * np.sin(time / 3.0)) * x, "time-varying"),
    ],
    ids=["delay", "filter", "gain"],
)
def test_the_public_fit_notes_the_same(change, name, recorded):
    time, angle, torque = recorded
    notes = tepsipe.fit_parallel_cascade(time, angle, change(time, torque), bootstrap_draws=100).notes
    assert any(note.endswith(f"({name}).") for note in notes)
