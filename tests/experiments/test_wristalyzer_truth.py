"""Why a fit in the manipulator could be biased: resampling, the true torque, unequal ends of periods."""

from dataclasses import replace

import numpy as np
import pytest

from tepsipe.identification.regression.periods import PeriodicRecord, fit_periods, without_transient
from tepsipe.reporting.recovery import linear_truth
from tepsipe.signals.resampling import BAND_PER_RATE, resample
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.wristalyzer_trial import ManipulatorTruth, record_manipulator
from workflow.support.yaml_file import read_settings


@pytest.mark.parametrize(("old_hz", "new_hz"), [(2048.0, 256.0), (1000.0, 250.0)])
def test_resampling_to_a_lower_rate_keeps_amplitudes_and_lets_nothing_alias(old_hz, new_hz):
    time = np.arange(0.0, 4.0, 1.0 / old_hz)
    new = np.arange(1.0, 3.0, 1.0 / new_hz)
    band = BAND_PER_RATE * new_hz
    for hz in np.array([0.01, 0.05, 0.13, 0.2, 0.29]) * new_hz:
        sine = np.sin(2.0 * np.pi * hz * time)
        assert np.abs(resample(time, sine, new, band) - np.sin(2.0 * np.pi * hz * new)).max() < 3e-4
    for hz in np.array([0.51, 0.7, 0.95]) * new_hz:
        assert np.abs(resample(time, np.sin(2.0 * np.pi * hz * time), new, band)).max() < 3e-4


def test_true_torque_of_a_linear_joint_in_the_manipulator_is_that_of_its_constants(root):
    constants = read_settings(root / "config/virtual_lab.yaml")
    rig = ManipulatorTruth(**constants["wristalyzer"]["manipulator"])
    rig = replace(rig, friction_Nm=0.0, contact_Nm_per_rad3=0.0)
    rubber = Rubber(**constants["dummy"]["rubber"] | {"softening": 0.0, "softened_damping_Nms_per_rad": 0.0})
    generators = (np.random.default_rng(seed) for seed in (1, 2))
    motion = record_manipulator(rig, rubber, 0.2, 4.0, *generators).motion
    found = linear_truth(motion, [(0.5, 3.5)], about_mean=True)
    expected = {"I": rig.inertia_kgm2, "B": rubber.damping_Nms_per_rad, "K": rubber.stiffness_Nm_per_rad}
    assert found == pytest.approx(expected, rel=1e-3)


def drifting(rng, rate_hz, seconds):
    """A joint that is moved by lines of the period and between them, and the torque that this takes."""
    time = np.arange(0.0, seconds, 1.0 / rate_hz)
    lines = np.arange(10, 200, 7) / 10.0
    between = rng.uniform(0.3, 18.0, 30)
    angle, torque = np.zeros(time.size), np.zeros(time.size)
    for hz, size in [*((f, 0.01 / f) for f in lines), *((f, 0.004 / f) for f in between)]:
        omega, phase = 2.0 * np.pi * hz, rng.uniform(0.0, 2.0 * np.pi)
        angle += size * np.cos(omega * time + phase)
        torque += size * (10.0 - 0.015 * omega**2) * np.cos(omega * time + phase)
        torque -= size * 0.1 * omega * np.sin(omega * time + phase)
    return torque, angle


def test_periods_that_end_in_another_state_than_they_began_in_do_not_bias_the_fit():
    found = fit_periods(
        PeriodicRecord(*drifting(np.random.default_rng(5), 1024.0, 40.0), 1024.0, 10.0, (1.0, 20.0))
    )
    assert found.parameters == pytest.approx([0.015, 0.1, 10.0], rel=2e-3)
    # the same lines with their transients are far from this joint
    assert found.type_a[2] < 0.01


def test_transients_of_both_kinds_vanish_and_a_projection_is_one():
    omega = 2.0 * np.pi * np.arange(1.0, 20.0, 0.1)
    rng = np.random.default_rng(1)
    a, b = rng.standard_normal((2, 4, 1))
    assert np.abs(without_transient(omega, a + 1j * omega * b)).max() < 1e-10
    spectra = rng.standard_normal((4, omega.size, 3)) + 1j * rng.standard_normal((4, omega.size, 3))
    once = without_transient(omega, spectra)
    assert without_transient(omega, once) == pytest.approx(once)
