"""The fit to all trials of a torque-controlled manipulator: known joints, friction only if there is any."""

from dataclasses import replace

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.identification.regression.pooled import PerturbedRecord, fit_pooled
from tepsipe.reporting.recovery import true_parameters
from tepsipe.virtual_lab.integrate import stepper

RATE, PERIOD = 256.0, 4.0
INERTIA, DAMPING, STIFFNESS = 0.015, 0.06, 10.0


def trial(rms, seed, friction=0.0, cubic=0.0, softening=0.0, ripple=0.01, periods=5):
    """Torque, and the angle of a joint with friction, hardening and softening, integrated at 4 times RATE."""
    rng, phases = np.random.default_rng(seed), np.random.default_rng(7)
    n, fine = round(PERIOD * RATE), 4
    spectrum = np.zeros(n * fine // 2 + 1, dtype=complex)
    lines = np.arange(4, 60)
    spectrum[lines] = np.exp(2j * np.pi * phases.random(lines.size))
    torque = np.fft.irfft(spectrum, n * fine)
    torque = np.tile(rms * torque / torque.std(), periods + 1)
    applied = torque + ripple * np.repeat(rng.standard_normal(torque.size // 16), 16)
    step, state, angle, h = stepper(2), (0.0, 0.0), [], 1.0 / (fine * RATE)

    def motion(load, x):
        th, w = x
        part = th * th / (th * th + 0.02**2)
        resisting = STIFFNESS * th * (1.0 - softening * part) + DAMPING * w + cubic * th**3
        return w, (load - resisting - friction * np.tanh(w / 0.01)) / INERTIA

    for load in applied.tolist():
        angle.append(state[0])
        state = step(motion, motion(load, state), load, load, state, h)
    angle = np.array(angle)[::fine] + 1e-5 * rng.standard_normal(torque.size // fine)
    # the torque is held for a step: half of it later than its sample
    return PerturbedRecord(torque[::fine], angle, slice(n, None))


def trials(**joint):
    return [trial(rms, k, **joint) for k, rms in enumerate((0.08, 0.15, 0.25))]


def fit(records):
    return fit_pooled(records, RATE, PERIOD, 16.0)


@pytest.fixture(scope="module")
def records():
    return trials()


@pytest.fixture(scope="module")
def linear(records):
    return fit(records)


@pytest.mark.slow
def test_linear_joint_gives_its_constants_back_and_nothing_else(linear):
    assert set(linear.values) == {"I", "B", "K", "friction", "K_cubic", "delay"}
    for name, true in (("I", INERTIA), ("B", DAMPING), ("K", STIFFNESS)):
        assert linear.values[name] == pytest.approx(true, rel=0.01 if name == "I" else 0.05)
    for name in ("friction", "K_cubic"):
        assert linear.low[name] < 0.0 < linear.high[name]
    assert linear.low["B"] < DAMPING < linear.high["B"]
    assert linear.low["K"] < STIFFNESS < linear.high["K"]


@pytest.mark.slow
def test_friction_is_separated_from_damping_and_hardening_from_stiffness():
    found = fit(trials(friction=0.01, cubic=1500.0))
    assert found.values["friction"] == pytest.approx(0.01, rel=0.2)
    assert found.low["friction"] > 0.005
    assert found.values["B"] == pytest.approx(DAMPING, rel=0.1)
    assert found.values["K"] == pytest.approx(STIFFNESS, rel=0.03)
    assert found.values["K_cubic"] == pytest.approx(1500.0, rel=0.1)
    # hardening adds more to the linear joint of a larger motion, friction more to that of a smaller one
    assert (np.diff(found.shares["hardening"][:, 2]) > 0.0).all()
    assert (np.diff(found.shares["friction"][:, 1]) < 0.0).all()


@pytest.mark.slow
def test_softening_is_a_part_of_the_model_where_the_data_ask_for_it():
    found = fit(trials(softening=0.4, cubic=800.0))
    assert found.values["K_softened"] == pytest.approx(0.4 * STIFFNESS, rel=0.15)
    assert found.values["softening_angle"] == pytest.approx(0.02, rel=0.15)
    assert found.values["K"] == pytest.approx(STIFFNESS, rel=0.04)
    assert found.systematic_Nm < 0.3 * found.without_softening_Nm


def test_units_of_the_torque_scale_every_constant(records, linear):
    scaled = fit([replace(r, torque=1e3 * r.torque) for r in records])
    for name in ("I", "B", "K", "friction", "K_cubic"):
        assert scaled.values[name] == pytest.approx(1e3 * linear.values[name], rel=1e-6)
        assert scaled.standard_error[name] == pytest.approx(1e3 * linear.standard_error[name], rel=1e-6)
    assert scaled.values["delay"] == pytest.approx(linear.values["delay"], rel=1e-6)


@pytest.mark.parametrize(
    ("seconds", "said"), [(4.5, "at least 2 whole periods"), (12.0, "at least 12 periods")]
)
def test_too_few_periods_are_refused(records, seconds, said):
    short = [replace(r, kept=slice(0, round(seconds * RATE))) for r in records]
    with pytest.raises(InputError) as caught:
        fit(short)
    assert_one_sentence(caught.value, said)


def test_joint_at_rest_is_refused(records):
    with pytest.raises(InputError) as caught:
        fit([*records[:2], replace(records[2], angle=0.0 * records[2].angle)])
    assert_one_sentence(caught.value, "constant")


def test_truth_of_all_trials_together_has_friction_and_the_rubbers_constants(shipped_truth):
    truth = true_parameters(shipped_truth)["wristalyzer/pooled"]
    rig, rubber = shipped_truth["wristalyzer"]["manipulator"], shipped_truth["dummy"]["rubber"]
    assert truth["friction"] == rig["friction_Nm"]
    assert truth["K"] == rubber["stiffness_Nm_per_rad"]
    assert truth["B"] == rubber["damping_Nms_per_rad"]
    assert truth["K_softened"] == rubber["softening"] * rubber["stiffness_Nm_per_rad"]
