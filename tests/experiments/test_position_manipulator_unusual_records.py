"""Records of other laboratories: right numbers for unusual ones, one sentence for useless ones."""

import numpy as np
import pytest
from scipy import signal
from scipy.interpolate import make_interp_spline

from tepsipe import fit_parallel_cascade
from tepsipe.errors import InputError
from tepsipe.experiments.position_manipulator.analysis import analyse_position_manipulator
from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions
from tepsipe.ingest.manipulator_options import TableOptions
from tepsipe.ingest.manipulators import ingest_position_manipulator
from tepsipe.io.trial import Signal, Trial
from tepsipe.new_study.measures import driving_sign, resisting_sign
from tepsipe.new_study.study import new_study

OPTIONS = TableOptions(250.0, 0.02, "rad", 1)


def movement(kind, rate_hz, seconds, rng, amplitude=0.05):
    """Angle of a perturbation (rad)."""
    time = np.arange(round(rate_hz * seconds)) / rate_hz
    if kind == "multisine":
        lines = np.arange(1, 81) * 0.25
        waves = np.cos(2.0 * np.pi * lines[:, None] * time + rng.uniform(0.0, 2.0 * np.pi, (80, 1))).sum(
            axis=0
        )
        return time, amplitude * waves / np.abs(waves).max()
    if kind == "sine":
        return time, amplitude * np.sin(4.0 * np.pi * time)
    if kind == "ramp":
        return time, amplitude * signal.sawtooth(0.1 * np.pi * time, 0.5)
    held, cutoff = {"prbs": (0.15, 5.0), "steps": (1.0, 10.0)}[kind]
    levels = np.repeat(rng.choice([-1.0, 0.0, 1.0], round(seconds / held) + 2), round(held * rate_hz))
    sections = signal.butter(2, cutoff, fs=rate_hz, output="sos")
    return time, amplitude * signal.sosfilt(sections, levels[: time.size])


def torque_of(time, angle, joint, rng, noise=0.03, slow=0.1):
    """Torque of I, B, K (N·m) with slow torque and noise."""
    path = make_interp_spline(time, angle, 5)
    rate = 1.0 / (time[1] - time[0])
    keep = np.exp(-1.0 / rate)
    drift = signal.lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], rng.standard_normal(time.size))
    torque = joint @ [path.derivative(2)(time), path.derivative(1)(time), angle]
    return 5.0 + torque + slow * drift + noise * rng.standard_normal(time.size)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "rate_hz", "seconds", "joint"),
    [
        ("prbs", 1000.0, 30.0, (0.014, 0.7, 60.0)),  # ankle
        ("steps", 1000.0, 30.0, (0.3, 3.0, 150.0)),  # knee
        ("multisine", 200.0, 30.0, (0.08, 1.0, 30.0)),  # elbow
    ],
)
def test_usual_perturbations_of_other_joints_give_their_constants(kind, rate_hz, seconds, joint, rng):
    time, angle = movement(kind, rate_hz, seconds, rng)
    fit = fit_parallel_cascade(time, angle, torque_of(time, angle, np.array(joint), rng), bootstrap_draws=100)
    assert fit.details.structure.direction == 0
    assert fit.vaf > 90.0
    for name, true in zip("BK", joint[1:], strict=True):
        assert fit.quantities[name].value == pytest.approx(true, rel=0.06)
        assert fit.quantities[name].low < 1.02 * true
        assert fit.quantities[name].high > 0.98 * true


@pytest.mark.parametrize("kind", ["sine", "ramp"])
def test_one_frequency_does_not_separate_inertia_from_stiffness(kind, rng):
    time, angle = movement(kind, 250.0, 20.0, rng)
    with pytest.raises(InputError, match=r"several frequencies, found movement at one.*random"):
        fit_parallel_cascade(time, angle, torque_of(time, angle, np.array([0.01, 1.0, 60.0]), rng))


def test_rate_that_is_too_low_for_the_filter_is_refused(rng):
    time, angle = movement("prbs", 70.0, 30.0, rng)
    trial = Trial(70.0, {"time": time}, {"angle": Signal(angle, "rad"), "torque": Signal(angle, "Nm")}, {})
    options = PositionManipulatorOptions(30.0, 4, 1.0, 0.5, 32, 1.0, 100)
    with pytest.raises(InputError, match=r"at most 28 Hz at 70 Hz, found 30 Hz: .*lowpass_cutoff_hz"):
        analyse_position_manipulator(trial, options, rng)


@pytest.mark.parametrize(("scale", "every"), [(1000.0, 1), (1.0, 10)], ids=["milliseconds", "50 Hz"])
def test_samples_that_are_far_apart_are_refused(scale, every, rng):
    time, angle = movement("prbs", 500.0, 5.0, rng)
    table = {"time": scale * time[::every], "angle": angle[::every], "torque": 60.0 * angle[::every]}
    with pytest.raises(InputError, match=r"samples closer than 0.02 s, found one every \S+ s: .*seconds"):
        ingest_position_manipulator(table, OPTIONS, 4.0, "a.csv")


def test_sign_of_a_small_torque_is_found_under_slow_torque(rng):
    time, angle = movement("prbs", 500.0, 20.0, rng, amplitude=0.002)
    joint = np.array([0.014, 0.7, 60.0])
    found = []
    for _ in range(6):
        torque = torque_of(time, angle, joint, rng, slow=0.25)
        found.append((driving_sign(angle, torque, 500.0), driving_sign(angle, -torque, 500.0)))
    assert set(found) == {(1, -1)}
    still = np.full(time.size, np.nan)
    assert driving_sign(still, still, 500.0) == resisting_sign(still, still, 500.0) == 1


def test_new_study_of_a_column_without_a_number_is_written(tmp_path, monkeypatch, rng):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    table = np.column_stack([np.arange(500) / 500.0, np.full(500, np.nan), rng.standard_normal(500)])
    header = "time_s,angle_rad,torque_Nm"
    np.savetxt(tmp_path / "lab/a.csv", table, delimiter=",", header=header, comments="")
    assert new_study("lab", output="mine").trials == {"position_manipulator": 1}
