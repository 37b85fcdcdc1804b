"""The treadmill's loaded frame: constants of an independently integrated treadmill come back."""

from dataclasses import replace

import numpy as np
import pytest
from belt_builders import OPTIONS, belt_recording, framed, pulsed_evaluated
from builders import assert_one_sentence, belt_pulses

from tepsipe.errors import InputError
from tepsipe.experiments.weight.calibrate import USUAL_ONLY, _without_other_weights
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.mass_models import fit_loaded_frame
from tepsipe.treadmill.registry import evaluate, fit_model

RATE_HZ, DENSE = 250.0, 40  # samples per second, and steps of the integration per sample
DENSE_TIME = np.arange(round(6.0 * RATE_HZ * DENSE)) / (RATE_HZ * DENSE)
TIME = DENSE_TIME[::DENSE]
PULSES_S = (1.0, 3.0)
GRAVITY, HEIGHT_M = 9.81, 0.1

# the treadmill: 150 kg move on springs of 4 MN/m in fore-aft direction
SPRING_N_PER_M, MOVED_KG, FRAME_DAMPING_S = 4.0e6, 150.0, 4.0e-4
FRAME = np.array([FRAME_DAMPING_S, MOVED_KG / SPRING_N_PER_M, 1.0 / SPRING_N_PER_M])
PARTS_KG, VISCOUS_NS_PER_M, COULOMB_N, COULOMB_N_PER_KG = 4.0, 9.0, 6.0, 0.5
FULL_SPEED_M_PER_S, LEAD_S = 0.15, 0.004
MOUNT_SHARE, MOUNT_S = 0.06, 0.1
EXTRA_N = 20.0  # an unknown force on the belt, beside what is known to be carried


def friction(w, kg, full_speed):
    return (COULOMB_N + COULOMB_N_PER_KG * kg) * w / np.sqrt(full_speed**2 + w**2)


def force_trial(kg, peak, extra=None, full_speed=FULL_SPEED_M_PER_S):
    """Fore-aft force of a weight on the treadmill, from rest; ``extra`` is a function of time (N)."""
    _, v, a = belt_pulses(DENSE_TIME, PULSES_S, peak)
    w = v + LEAD_S * a
    force = kg * a + PARTS_KG * a + VISCOUS_NS_PER_M * w + friction(w, kg, full_speed)
    if extra is not None:
        force = force + extra(DENSE_TIME)
    return trial(kg, v, a, force, kg * a, "N", MOUNT_SHARE)


def moment_trial(kg, peak):
    """Moment about the axis across the belt: the weight's own, and that of moving parts and bearings."""
    y, v, a = belt_pulses(DENSE_TIME, PULSES_S, peak)
    carried = kg * GRAVITY * y - HEIGHT_M * kg * a
    return trial(kg, v, a, carried - 0.8 * a + 1.5 * v, carried, "Nm", 0.0)


def trial(kg, v, a, load, carried, unit, share):
    slowness = FRAME[1] + FRAME[2] * kg
    measured = framed(load, RATE_HZ * DENSE, FRAME[0], slowness, share, MOUNT_S)
    return belt_recording(
        v[::DENSE],
        a[::DENSE],
        (measured - carried)[::DENSE],
        rate_hz=RATE_HZ,
        carried=carried[::DENSE],
        carried_kg=kg,
        rigid_kg=kg,
        unit=unit,
        name=f"{kg:g} kg",
    )


@pytest.fixture(scope="module")
def forces():
    return [force_trial(kg, peak) for kg in (0.0, 20.0) for peak in (0.1, 0.5)]


@pytest.fixture(scope="module")
def moments():
    return [moment_trial(kg, 0.5) for kg in (0.0, 20.0)]


def test_moment_shows_the_frame(moments):
    model = fit_loaded_frame(moments)
    assert model.frame == pytest.approx(FRAME, rel=0.02)
    assert model.motion == pytest.approx([-0.8, 1.5, 0.0, 0.0], rel=2e-3)
    assert (model.mount_share, model.lag_s) == (0.0, 0.0)


def test_resonance_falls_with_the_mass_that_is_carried(moments):
    model = fit_loaded_frame(moments)
    for kg in (0.0, 20.0, 70.0):
        expected = np.sqrt(SPRING_N_PER_M / (MOVED_KG + kg)) / (2.0 * np.pi)
        assert model.resonance_hz(kg) == pytest.approx(expected, rel=0.01)
    assert replace(model, frame=np.zeros(3)).resonance_hz(20.0) == np.inf


def test_force_shows_friction_and_mounts_where_the_frame_is_known(forces):
    model = fit_loaded_frame(forces, FRAME)
    assert model.motion == pytest.approx([PARTS_KG, VISCOUS_NS_PER_M, COULOMB_N, COULOMB_N_PER_KG], rel=0.01)
    # not 9 Ns/m x 4 ms more: viscous friction follows the velocity that runs ahead, too
    assert model.motion[0] == pytest.approx(PARTS_KG, abs=0.01)
    assert model.lag_s == pytest.approx(LEAD_S, abs=5e-5)
    assert model.friction_speed_m_per_s == pytest.approx(FULL_SPEED_M_PER_S, rel=0.02)
    assert model.mount_share == pytest.approx(MOUNT_SHARE, rel=0.02)
    assert model.mount_time_s == pytest.approx(MOUNT_S, rel=0.03)


def test_frame_of_the_moment_and_friction_of_the_force_predict_another_mass_and_speed(forces, moments):
    options = replace(OPTIONS, shortest_s=2.0)
    frame = fit_model("loaded-frame", moments, options).model.frame
    fitted = fit_model("loaded-frame", forces, replace(options, frame=frame))
    unseen = force_trial(10.0, 0.3)
    assert evaluate(fitted, [unseen]).r2 > 0.9995
    # a model that knows the belt's acceleration only does not know what is carried
    # what is taken out is the frame's answer to the true load, not the predicted load alone
    assert np.array_equal(fitted.compensate(unseen), fitted.model.compensate(unseen))
    assert not np.allclose(fitted.compensate(unseen), unseen.load - fitted.predict(unseen), atol=1e-4)
    linear = fit_model("fir", forces, options)
    errors = [np.abs(unseen.load - m.predict(unseen)).max() for m in (fitted, linear)]
    assert errors[1] > 10.0 * errors[0]


def test_true_load_comes_back_from_the_measured_one(forces):
    model = fit_loaded_frame(forces, FRAME)

    def extra(t):
        return EXTRA_N * np.exp(-0.5 * ((t - 3.2) / 0.04) ** 2)

    found = model.compensate(force_trial(20.0, 0.4, extra))
    assert found == pytest.approx(extra(TIME), abs=0.02 * EXTRA_N)
    uncompensated = force_trial(20.0, 0.4, extra).load - extra(TIME)
    assert np.abs(uncompensated).max() > 0.9 * EXTRA_N


def test_prediction_and_compensation_undo_each_other(forces):
    model = fit_loaded_frame(forces, FRAME)
    for r in forces:
        predicted = replace(r, load=model.predict(r))
        assert model.compensate(predicted) == pytest.approx(np.zeros(r.load.size), abs=1e-3)


@pytest.mark.slow
def test_friction_must_be_computed_before_signals_are_filtered():
    lowpass = Lowpass(10.0, 4, True)
    raw = [force_trial(kg, peak, full_speed=0.03) for kg in (0.0, 20.0) for peak in (0.1, 0.5)]
    filtered = [r.filtered(lowpass) for r in raw]
    too_late = [replace(r, raw_velocity=r.velocity, lowpass=None) for r in filtered]

    def left(recordings):
        model = fit_loaded_frame(recordings, FRAME)
        return np.sqrt(np.mean(np.concatenate([r.load - model.predict(r) for r in recordings]) ** 2))

    assert left(too_late) > 3.0 * left(filtered)


def test_filtered_signals_show_the_same_constants(forces):
    model = fit_loaded_frame([r.filtered(Lowpass(20.0, 4, True)) for r in forces], FRAME)
    assert model.motion == pytest.approx([PARTS_KG, VISCOUS_NS_PER_M, COULOMB_N, COULOMB_N_PER_KG], rel=0.02)
    assert model.mount_share == pytest.approx(MOUNT_SHARE, rel=0.03)


def test_force_in_another_unit_gives_the_same_frame_and_scaled_constants(forces, moments):
    scaled = [replace(r, load=1e3 * r.load, carried=1e3 * r.carried) for r in moments]
    one, other = fit_loaded_frame(moments), fit_loaded_frame(scaled)
    assert other.frame == pytest.approx(one.frame, rel=1e-3)
    assert other.motion == pytest.approx(1e3 * one.motion, rel=1e-3)
    scaled = [replace(r, load=1e3 * r.load, carried=1e3 * r.carried) for r in forces]
    one, other = fit_loaded_frame(forces, FRAME), fit_loaded_frame(scaled, FRAME)
    assert other.motion == pytest.approx(1e3 * one.motion, rel=1e-3)
    assert other.predict(scaled[0]) == pytest.approx(1e3 * one.predict(forces[0]), abs=1.0)


def test_only_judged_samples_are_fitted(forces):
    evaluated = pulsed_evaluated(TIME.size, [round(RATE_HZ * t) for t in PULSES_S], 100)
    dirty = [replace(r, evaluated=evaluated, load=np.where(evaluated, r.load, 1e3)) for r in forces]
    model = fit_loaded_frame(dirty, FRAME)
    assert model.motion == pytest.approx([PARTS_KG, VISCOUS_NS_PER_M, COULOMB_N, COULOMB_N_PER_KG], rel=0.01)


def test_a_single_mass_does_not_show_a_loaded_frame(forces):
    with pytest.raises(InputError) as caught:
        fit_loaded_frame(forces[2:], FRAME)
    assert_one_sentence(caught.value, "20 kg", "two different masses", "empty belt")


LOWPASS = Lowpass(20.0, 4, True)


def grouped(heavy=1.0, weights=(0.0, 20.0, 60.0)):
    """Trials to calibrate and to validate; ``heavy`` spoils the loads to calibrate under 60 kg."""
    names = {0.0: "empty", 20.0: "weight", 60.0: "weight of 60 kg"}
    found = []
    for kg in weights:
        for role, peak in (("calibrate", 0.5), ("validate", 0.3)):
            size = heavy if (kg, role) == (60.0, "calibrate") else 1.0
            loads = {"Fy": force_trial(kg, peak), "Mx": moment_trial(kg, peak)}
            loads = {c: replace(r, load=size * r.load, lowpass=LOWPASS) for c, r in loads.items()}
            found.append((names[kg], role, loads))
    return found


def test_frames_without_other_weights_predict_them_unseen():
    options, family = replace(OPTIONS, shortest_s=2.0), ["fir", "loaded-frame"]
    scores = _without_other_weights(grouped(), family, options, {})
    assert {(s.model, s.train) for s in scores} == {("loaded-frame", USUAL_ONLY)}
    unseen = [s.r2 for s in scores if (s.test, s.load) == ("weight of 60 kg", "Fy")]
    assert len(unseen) == 1 and unseen[0] > 0.99
    # trials to calibrate under 60 kg are not used
    assert _without_other_weights(grouped(heavy=5.0), family, options, {}) == scores
    assert _without_other_weights(grouped(weights=(0.0, 20.0)), family, options, {}) == []
