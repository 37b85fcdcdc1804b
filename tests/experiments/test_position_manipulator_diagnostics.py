"""Diagnostics of a joint under imposed movement: operating point, bandwidth, a change of K, slow residual."""

from types import SimpleNamespace

import numpy as np
import pytest
from builders import trial_of

from tepsipe.experiments.position_manipulator.analysis import analyse_position_manipulator
from tepsipe.experiments.position_manipulator.diagnostics import diagnose
from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass

RATE = 200.0
OPTIONS = PositionManipulatorOptions(
    lowpass_cutoff_hz=30.0,
    lowpass_order=4,
    cut_s=1.0,
    training_fraction=0.5,
    averaged_bins=16,
    block_s=1.0,
    bootstrap_draws=20,
)


def diagnosed(rng, growth=0.0, slow=0.05):
    """A joint of 50 N·m/rad about 0.1 rad that stiffens by ``growth`` over 60 s, with a slow torque (N·m)."""
    size = round(60.0 * RATE)
    time = np.arange(size) / RATE
    angle = 0.1 + 0.5 * butterworth_lowpass(rng.standard_normal(size), RATE, 4.0, 4) / 4.0
    velocity = derivative(time, angle)
    stiffness = 50.0 * (1.0 + growth * time / time[-1])
    torque = 0.01 * derivative(time, velocity) + 0.5 * velocity + stiffness * (angle - 0.1) + 3.0
    torque += slow * butterworth_lowpass(rng.standard_normal(size), RATE, 0.5, 2) * 20.0
    trial = trial_of(RATE, angle=(angle, "rad"), torque=(torque, "Nm"))
    analysis = analyse_position_manipulator(trial, OPTIONS, rng)
    model = SimpleNamespace(predicted=analysis.predicted, impedance=analysis.fit.parameters[:3])
    return trial, diagnose(trial, OPTIONS, analysis, model)


def test_operating_point_amplitude_and_bandwidth_are_those_of_the_record(rng):
    trial, found = diagnosed(rng)
    recording = found.facts["diagnostics"]["recording"]
    assert recording["mean_angle_rad"] == pytest.approx(0.1, abs=0.003)
    assert recording["mean_torque_Nm"] == pytest.approx(3.0, abs=0.3)
    assert recording["sd_angle_rad"] == pytest.approx(trial.values("angle").std(), rel=0.05)
    assert recording["used_s"] == pytest.approx(58.0)
    assert 2.0 < recording["half_power_hz"] < 6.0
    assert recording["half_power_hz"] < recording["velocity_95_hz"] < 20.0


def test_impedance_of_a_known_joint_lies_within_its_bands(rng):
    _, found = diagnosed(rng)
    arrays = {key.removeprefix("diagnostics/"): x for key, x in found.arrays.items()}
    s = 2j * np.pi * arrays["frequency"]
    ratio = arrays["impedance"] / (0.01 * s**2 + 0.5 * s + 50.0)
    below = arrays["frequency"] < 6.0
    inside = np.abs(np.log(np.abs(ratio))) <= np.log(arrays["gain_factor"])
    assert inside[below].mean() > 0.85
    assert (arrays["coherence"] > arrays["coherence_level"])[below].mean() > 0.9


@pytest.mark.parametrize(("growth", "differs"), [(0.0, False), (0.6, True)])
def test_stiffness_of_the_thirds_differs_only_if_it_changes(rng, growth, differs):
    _, found = diagnosed(rng, growth)
    thirds = found.arrays["diagnostics/part_stiffness"]
    half = found.arrays["diagnostics/part_stiffness_half_width"]
    truth = 50.0 * (1.0 + growth * np.array([1.0, 3.0, 5.0]) / 6.0)
    assert (np.abs(thirds - truth) < 2.0 * half).all()
    assert (found.facts["diagnostics"]["stiffness_equal_p"] < 0.01) is differs


def test_slow_torque_is_told_as_the_slow_part_of_the_residual(rng):
    _, found = diagnosed(rng, slow=0.2)
    residual = found.facts["diagnostics"]["residual"]
    assert residual["below_1_hz_percent"] > 70.0
    assert residual["white_p"] < 1e-6
    assert residual["memory_s"] > 0.1
