"""The inverse problem: a known dummy gives printed numbers, from which its constants are found again."""

from dataclasses import asdict

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.experiments.thesis_dummy.inverse import (
    JOINTS,
    START,
    fit_joint,
    fit_marker_noise,
    printed_and_predicted,
    printed_quantities,
)
from tepsipe.experiments.thesis_dummy.printed_path import PrintedPath, belt_motion, printed_fits, swings
from tepsipe.io.trial import Signal, Trial
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.rubber_joint import RubberJoint
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.perturbations import WindowOptions

RATE = 250.0
LAYOUT = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.63], [-0.012, 0.39], [0.012, 0.15]])
TWO_MGR, TWO_INERTIA = 2.0 * 0.4 * 9.81 * 0.4485, 2.0 * 0.027
TRUE = RubberJoint(
    stiffness_Nm_per_rad=9.0,
    half_softening_rad=0.03,
    damping_Nms_per_rad=0.04,
    softened_damping_Nms_per_rad=0.08,
    inertia_Nms2_per_rad=0.004,
)


def path(sampled_after_s=0.0):
    return PrintedPath(
        leg=Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027),
        markers=SegmentMarkers(("ankle", "a", "b", "c", "d"), LAYOUT),
        sampled_after_s=np.arange(3, 8) * sampled_after_s,
        rate_hz=RATE,
        cutoff_hz=20.0,
        order=4,
        window=WindowOptions(2.0, 3.0, 0.5, 0.05, 5.0, 0.06),
    )


def trial(peak, pulses=3):
    """Sinusoidal pulses of 0.12 s every 3 s, recorded with noise."""
    t = np.arange(0.0, 2.2 + 3.0 * pulses + 3.0, 1.0 / RATE)
    since = np.mod(t - 2.2, 3.0)
    moving = (t >= 2.2) & (t < 2.2 + 3.0 * pulses) & (since < 0.12)
    velocity = np.where(moving, peak * np.sin(2.0 * np.pi * since / 0.12), 0.0)
    velocity += 1e-4 * np.random.default_rng(3).standard_normal(t.size)
    return Trial(RATE, {"time": t}, {"belt_velocity": Signal(velocity, "m/s")})


PEAKS = {"low": 0.1, "middle": 0.3, "high": 0.5, "other": 0.4}


@pytest.fixture(scope="module")
def belts():
    return {name: belt_motion(trial(peak), path()) for name, peak in PEAKS.items()}


def printed_by(joint, belts, noise=0.0, seed=0):
    angles, rng = swings(path(), [joint], belts), np.random.default_rng(seed)
    found = {
        n: printed_quantities(printed_fits(path(), b, angles[n][0], noise, rng)) for n, b in belts.items()
    }
    return {q: {name: row[q] for name, row in found.items()} for q in next(iter(found.values()))}


def test_the_belt_is_its_mean_pulse_without_noise(belts):
    belt = belts["high"]
    assert len(belt.perturbations) == 3
    assert np.ptp([belt.velocity[p.start : p.start + 40] for p in belt.perturbations], axis=0).max() < 1e-6
    assert belt.velocity.max() == pytest.approx(0.5, rel=0.1)
    assert belt.acceleration.size == 2 * belt.time.size - 1
    fewer = belt_motion(trial(0.5), path(), longest_s=4.0)
    assert len(fewer.perturbations) == 1
    assert fewer.time.size < belt.time.size


def test_a_linear_joint_is_printed_as_the_signs_of_the_equation_demand(belts):
    # damped so that no swing is left in the last rest, from which the angle at rest is taken
    linear = RubberJoint(**(asdict(TRUE) | JOINTS["linear"] | {"damping_Nms_per_rad": 0.4}))
    printed = printed_by(linear, {"low": belts["low"]})
    assert printed["I"]["low"] == pytest.approx(TWO_INERTIA + 0.004, rel=5e-3)
    assert printed["B"]["low"] == pytest.approx(0.4, rel=1e-2)
    assert printed["K"]["low"] == pytest.approx(9.0 - TWO_MGR, rel=2e-2)


def test_sequential_sampling_lowers_the_printed_damping(belts):
    angles = swings(path(), [TRUE], {"low": belts["low"]})["low"][0]
    at_once, later = (
        printed_fits(path(after), belts["low"], angles).mean[1] for after in (0.0, 1.0 / 2500.0)
    )
    assert -0.08 < later - at_once < -0.02


@pytest.mark.slow
def test_known_constants_are_found_again_and_other_conditions_predicted():
    belts = {name: belt_motion(trial(peak, pulses=1), path()) for name, peak in PEAKS.items()}
    printed = printed_by(TRUE, belts)
    found = fit_joint(path(), belts, printed, ["low", "middle", "high"], {})
    for name, value in asdict(TRUE).items():
        assert getattr(found.joint, name) == pytest.approx(value, rel=0.02), name
        assert found.low[name] <= getattr(found.joint, name) <= found.high[name]
    assert found.fitted_rms < 0.02
    assert found.predicted_rms < 0.02
    # a linear joint cannot return them
    linear = fit_joint(path(), belts, printed, ["low", "middle", "high"], JOINTS["linear"])
    assert linear.free == ("stiffness_Nm_per_rad", "damping_Nms_per_rad", "inertia_Nms2_per_rad")
    assert linear.fitted_rms > 10.0 * found.fitted_rms


def test_marker_noise_is_found_from_the_printed_vaf(belts):
    printed = printed_by(TRUE, belts, noise=2e-5, seed=5)
    angles = {name: angle[0] for name, angle in swings(path(), [TRUE], belts).items()}
    noise = fit_marker_noise(path(), belts, angles, printed["VAF_trial"], ["low", "middle"], seed=1)
    assert noise == pytest.approx(2e-5, rel=0.1)
    cells = printed_and_predicted(path(), belts, angles, printed, ["low", "middle"], noise, 2, seed=1)
    assert len(cells) == 4 * 8
    roles = {(cell.condition, cell.quantity): cell.role for cell in cells}
    assert roles["low", "K"] == roles["middle", "VAF_trial"] == "fitted"
    assert roles["other", "K"] == roles["low", "SEM_K"] == "predicted"
    for cell in cells:
        close = 0.5 if cell.quantity.startswith("SEM") else 0.1  # of three perturbations
        assert cell.value == pytest.approx(cell.printed, rel=close, abs=0.01), cell


def test_too_few_printed_numbers_are_refused(belts):
    with pytest.raises(InputError, match="more printed numbers than the 5 constants, found 3"):
        fit_joint(path(), belts, printed_by(START, belts), ["low"], {})
