"""A joint under imposed movement: I, B, K of a known joint, and the ankles of real people."""

from dataclasses import replace

import numpy as np
import pytest
from builders import assert_one_sentence, trial_of

from tepsipe.errors import InputError
from tepsipe.experiments.position_manipulator.analysis import (
    analyse_position_manipulator,
    position_manipulator_estimates,
)
from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions
from tepsipe.ingest.manipulator_options import TableOptions
from tepsipe.ingest.manipulators import ingest_position_manipulator
from tepsipe.io.readers.text_table import read_text_table

JOINT = np.array([0.015, 0.8, 60.0])
OFFSET_NM = -2.0
RATE = 250.0
OPTIONS = PositionManipulatorOptions(
    lowpass_cutoff_hz=30.0,
    lowpass_order=4,
    cut_s=1.0,
    training_fraction=0.5,
    averaged_bins=16,
    block_s=1.0,
    bootstrap_draws=300,
)


def moved_joint(rng, noise=0.0, seconds=40.0):
    """Random smooth angle of sines with known derivatives, and the torque (Nm) of a known joint."""
    time = np.arange(round(seconds * RATE)) / RATE
    omega = 2.0 * np.pi * rng.uniform(0.3, 12.0, 60)
    phase = rng.uniform(0.0, 2.0 * np.pi, 60)
    waves = np.exp(1j * (omega * time[:, None] + phase))
    angle, rate, acceleration = (
        0.003 * (waves * (1j * omega) ** order).sum(axis=1).imag for order in range(3)
    )
    torque = np.column_stack([acceleration, rate, angle]) @ JOINT + OFFSET_NM
    torque = torque + noise * rng.standard_normal(time.size)
    return trial_of(RATE, angle=(angle + 0.1, "rad"), torque=(torque + JOINT[2] * 0.1, "Nm"))


def test_noise_free_joint_is_recovered(rng):
    found = analyse_position_manipulator(moved_joint(rng), OPTIONS, rng)
    assert found.fit.parameters[:3] == pytest.approx(JOINT, rel=2e-3)
    assert found.fit.parameters[3] == pytest.approx(OFFSET_NM, rel=0.01)
    assert found.vaf.training > 99.999
    assert found.vaf.held_out > 99.999


@pytest.mark.slow
def test_intervals_over_blocks_cover_the_joint(rng):
    covered, repeats = np.zeros(3), 30
    for _ in range(repeats):
        found = analyse_position_manipulator(moved_joint(rng, 0.5), OPTIONS, rng)
        rows = position_manipulator_estimates("position_manipulator", "trial", found)
        for k, row in enumerate(rows[:3]):
            assert row.ci_low < row.value < row.ci_high
            covered[k] += row.ci_low <= JOINT[k] <= row.ci_high
    assert (covered >= 0.8 * repeats).all()


def test_held_out_vaf_is_what_the_noise_leaves(rng):
    noisy, clean = (moved_joint(np.random.default_rng(4), noise) for noise in (0.5, 0.0))
    found = analyse_position_manipulator(noisy, OPTIONS, rng)
    clean = clean.values("torque")[250:-250][found.training :]
    # the filter leaves the part of white noise below its cutoff
    noise = 0.5**2 * 30.0 / (0.5 * RATE)
    expected = 100.0 * (1.0 - noise / (np.var(clean) + noise))
    assert 80.0 < expected < 99.9
    assert found.vaf.held_out == pytest.approx(expected, abs=0.3 * (100.0 - expected))
    assert found.vaf.training == pytest.approx(expected, abs=0.3 * (100.0 - expected))


def test_held_out_part_is_not_fitted(rng):
    trial = moved_joint(rng)
    spoilt = trial.values("torque").copy()
    spoilt[6000:] += 5.0 * rng.standard_normal(4000)
    changed = trial_of(RATE, angle=(trial.values("angle"), "rad"), torque=(spoilt, "Nm"))
    found = analyse_position_manipulator(changed, OPTIONS, rng)
    assert found.fit.parameters[:3] == pytest.approx(JOINT, rel=2e-3)
    assert found.vaf.held_out < 90.0


def test_noise_in_the_fitted_part_does_not_count_against_the_held_out_part(rng):
    trial = moved_joint(rng)
    noisy = trial.values("torque").copy()
    noisy[:4900] += rng.standard_normal(4900)
    changed = trial_of(RATE, angle=(trial.values("angle"), "rad"), torque=(noisy, "Nm"))
    found = analyse_position_manipulator(changed, OPTIONS, rng)
    assert 100.0 - found.vaf.training > 0.5
    assert 100.0 - found.vaf.held_out < 0.1 * (100.0 - found.vaf.training)


def test_mean_torque_that_is_left_in_flatters_the_printed_vaf(rng):
    trial = moved_joint(rng, 2.0)
    lifted = trial.values("torque") + 50.0
    heavy = trial_of(RATE, angle=(trial.values("angle"), "rad"), torque=(lifted, "Nm"))
    plain = analyse_position_manipulator(trial, OPTIONS, np.random.default_rng(1))
    found = analyse_position_manipulator(heavy, OPTIONS, np.random.default_rng(1))
    assert found.vaf.held_out == pytest.approx(plain.vaf.held_out, abs=1e-6)
    assert found.vaf.held_out_as_printed > found.vaf.held_out + 1.0


def test_spectral_impedance_is_that_of_the_joint(rng):
    found = analyse_position_manipulator(moved_joint(rng, 0.01, 120.0), OPTIONS, rng).spectrum
    inside = (found.frequency_hz > 1.0) & (found.frequency_hz < 11.0)
    s = 2j * np.pi * found.frequency_hz[inside]
    known = JOINT[0] * s**2 + JOINT[1] * s + JOINT[2]
    error = np.abs(found.response[inside] / known - 1.0)
    assert np.median(error) < 0.05
    assert np.median(found.coherence[inside]) > 0.99


def test_same_seed_gives_the_same_intervals(rng):
    trial = moved_joint(rng, 0.5)
    first, again, other = (
        analyse_position_manipulator(trial, OPTIONS, np.random.default_rng(seed)).bootstrap
        for seed in (1, 1, 2)
    )
    assert (first == again).all()
    assert (first != other).any()


@pytest.mark.parametrize("seconds", [2.0, 5.0, 9.0])
def test_record_that_is_too_short_for_its_blocks_is_refused(seconds, rng):
    with pytest.raises(InputError) as caught:
        analyse_position_manipulator(moved_joint(rng, seconds=seconds), OPTIONS, rng)
    assert_one_sentence(caught.value, "blocks")


@pytest.mark.parametrize("angle", [0.0, 0.1])
def test_joint_that_does_not_move_is_refused(angle, rng):
    torque = rng.standard_normal(10000)
    still = trial_of(RATE, angle=(np.full(10000, angle), "rad"), torque=(torque, "Nm"))
    with pytest.raises(InputError) as caught:
        analyse_position_manipulator(still, OPTIONS, rng)
    assert_one_sentence(caught.value, "moving joint")


def test_signal_that_is_missing_is_named(rng):
    with pytest.raises(InputError) as caught:
        analyse_position_manipulator(trial_of(RATE, angle=(np.zeros(9000), "rad")), OPTIONS, rng)
    assert_one_sentence(caught.value, "'torque'")


@pytest.fixture(scope="module", params=["ankle_trial1", "ankle_trial3"])
def real_ankle(request, real_data, shipped_config):
    """One recorded ankle, analysed with the shipped configuration."""
    path = real_data(f"human-ankle/{request.param}.csv.gz")
    section = shipped_config["position_manipulator"]
    table = read_text_table(path, section["files"]["columns"], ",")
    options = TableOptions(
        angle_unit=section["files"]["angle_unit"],
        torque_sign=section["files"]["torque_sign"],
        **section["ingest"],
    )
    trial = ingest_position_manipulator(table, options, 60.0, str(path))
    choices = {key: value for key, value in section["analysis"].items() if key != "parallel_cascade"}
    choices = replace(PositionManipulatorOptions(**choices), bootstrap_draws=200)
    return analyse_position_manipulator(trial, choices, np.random.default_rng(1))


@pytest.mark.slow
def test_real_ankle_is_predicted_on_data_that_were_not_fitted(real_ankle):
    assert 60.0 < real_ankle.vaf.held_out < 97.0
    assert 60.0 < real_ankle.vaf.training < 97.0


def test_real_ankle_has_the_impedance_of_an_ankle(real_ankle):
    inertia, damping, stiffness = real_ankle.fit.parameters[:3]
    assert 0.002 < inertia < 0.05
    assert 0.1 < damping < 5.0
    assert 20.0 < stiffness < 200.0
    low, high = np.percentile(real_ankle.bootstrap, [2.5, 97.5], axis=0)
    assert (low[:3] > 0.0).all()
    assert ((high - low)[:3] < real_ankle.fit.parameters[:3]).all()
