"""Linear frame: a frame of two degrees of freedom, integrated here with all that stands on it, comes back.

The frame sways and pitches on coupled springs; its log is ahead of the belt's. The load on it, integrated
together with it, is known, and must be recovered from what the springs and dampers hold.
"""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from belt_builders import belt_recording, pulsed_evaluated
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.compensation import compensated_draws, compensated_loads
from tepsipe.treadmill.held_out import held_out_residuals, model_flags, read_held_out
from tepsipe.treadmill.linear_frame import AT, fit_linear_frame
from tepsipe.treadmill.pulse_windows import pulse_windows
from tepsipe.treadmill.registry import FittedModel, evaluate, load_treadmill_models, pick, save_models
from tepsipe.treadmill.trial_recordings import zeroed_per_pulse

RATE_HZ, DENSE = 250.0, 8
ONSETS_S = 1.2 + 1.8 * np.arange(4)
LENGTH_S = 9.0
LOWPASS = Lowpass(20.0, 4, True)
G, HEIGHT_M, LEVER_M, LEAD_S = 9.81, 0.1, 0.04, 5e-4
FRAME_KG, FRAME_KGM2, DAMPING_S = 150.0, 40.0, 4e-4
BODY_KG, BODY_HZ = 60.0, 4.0
NOISE = {"Fy": 0.05, "Mx": 0.005}
UNITS = {"Fy": "N", "Mx": "Nm"}


def stiffness(hz):
    """Springs of a frame with one resonance near ``hz``, whose pitch moves the belt."""
    sway, pitch = FRAME_KG * (2 * np.pi * hz) ** 2, FRAME_KGM2 * (3.4 * np.pi * hz) ** 2
    return np.array([[sway, 0.03 * sway], [0.03 * sway, pitch]])


def linear(system, inputs, driven, step_s):
    """States of a linear system from rest, exact for inputs that are straight between their samples."""
    own = (system, inputs, np.eye(len(system)), np.zeros(inputs.shape))
    a, b, c, d, _ = scipy.signal.cont2discrete(own, step_s, "foh")
    values, modes = np.linalg.eig(a)
    pushed = driven @ np.linalg.solve(modes, b).T
    found = [
        scipy.signal.lfilter([0.0, 1.0], [1.0, -value], push)
        for value, push in zip(values, pushed.T, strict=True)
    ]
    return (np.array(found).T @ modes.T).real @ c.T + driven @ d.T


def integrated(time, y, v, a, rubbing, hz, weight_kg, body):
    """Force and moment of the springs and dampers, and of the load, all from rest."""
    k = stiffness(hz)
    lever = np.array([1.0, -HEIGHT_M])  # motion of the weight by sway and pitch
    mass = np.diag([FRAME_KG, FRAME_KGM2]) + weight_kg * np.outer(lever, lever)
    inverse = np.linalg.inv(mass)
    # states: u, u', and place and speed of a body on springy legs; inputs: y, v, a, friction
    down = np.array([1.0, -0.08])  # force and moment of its legs
    spring = BODY_KG * (2 * np.pi * BODY_HZ) ** 2 * body
    damper = 0.3 * 2 * BODY_KG * (2 * np.pi * BODY_HZ) * body
    legs = np.array([spring, 0, damper, 0, -spring, -damper])  # force on the body by the states
    of_belt = np.array([spring, damper, 0, 0])
    system, inputs = np.zeros((6, 6)), np.zeros((6, 4))
    system[:2, 2:4] = np.eye(2)
    pushed = np.zeros((2, 6))
    pushed[:, :2], pushed[:, 2:4] = -k, -DAMPING_S * k
    system[2:4] = inverse @ (pushed - np.outer(down, legs))
    own = np.zeros((2, 4))
    own[:, 2] = -weight_kg * lever
    own[1, 0] = -weight_kg * G
    own[:, 3] = -1.0, -LEVER_M
    inputs[2:4] = inverse @ (own - np.outer(down, of_belt))
    system[4, 5] = 1.0
    system[5], inputs[5] = legs / BODY_KG, of_belt / BODY_KG
    driven = np.column_stack([y, v, a, rubbing])
    states = linear(system, inputs, driven, time[1] - time[0])
    held = (states[:, :2] + DAMPING_S * states[:, 2:4]) @ k.T
    under = states @ system[2:4].T + driven @ inputs[2:4].T
    force = weight_kg * (a + under @ lever) + states @ legs + driven @ of_belt
    moment = weight_kg * G * y - HEIGHT_M * weight_kg * (a + under @ lever)
    moment += -0.08 * (states @ legs + driven @ of_belt)
    return -held, np.column_stack([force, moment]), under[:, 0]


def trial(hz, kg, peak, rng, *, body=False, noise=1.0, lead_s=LEAD_S, zeroed=True):
    """Recordings of a weight, or of a body of the same pressure, and the load and the frame's motion."""
    time = np.arange(round(LENGTH_S * RATE_HZ * DENSE)) / (RATE_HZ * DENSE)
    phase = np.clip((time[:, None] - ONSETS_S) / 0.12, 0.0, 1.0)
    v = peak * (np.sin(2.0 * np.pi * phase) * np.sin(np.pi * phase)).sum(axis=1)
    a, y = np.gradient(v, time), np.cumsum(v) / (RATE_HZ * DENSE)
    rubbing = (15.0 + 0.8 * kg) * np.tanh(v / 0.1) + 20.0 * v + 0.5 * a
    weight_kg = 0.0 if body else kg
    held, load, under = integrated(time, y, v, a, rubbing, hz, weight_kg, body)
    held = scipy.interpolate.CubicSpline(time, held)(time[::DENSE] + lead_s)
    carried = np.column_stack([weight_kg * a, weight_kg * (G * y - HEIGHT_M * a)])[::DENSE]
    measured = held + noise * rng.standard_normal(held.shape) * list(NOISE.values())
    moving = v[::DENSE] + 2e-4 * rng.standard_normal(len(held))
    onsets, found = tuple(np.round(ONSETS_S * RATE_HZ).astype(int).tolist()), {}
    for k, (c, unit) in enumerate(UNITS.items()):
        r = belt_recording(v[::DENSE], a[::DENSE], (measured - carried)[:, k], rate_hz=RATE_HZ)
        r = replace(r, name=f"{kg:g} kg {peak:g}", carried=carried[:, k], carried_kg=kg, unit=unit)
        r = replace(r, beside=measured[:, 1 - k], beside_carried=carried[:, 1 - k], raw_velocity=moving)
        r = replace(r, rigid_kg=weight_kg, rigid_height_m=HEIGHT_M)
        evaluated = pulsed_evaluated(r.load.size, onsets, 75)
        r = replace(r.filtered(LOWPASS), onsets=onsets, evaluated=evaluated)
        found[c] = zeroed_per_pulse(r) if zeroed else r
    return found, LOWPASS(load[::DENSE], RATE_HZ), LOWPASS(under[::DENSE], RATE_HZ)


def calibration(hz, seed, **choice):
    rng = np.random.default_rng(seed)
    pulses = [(0.0, 0.2), (0.0, -0.4), (20.0, 0.2), (20.0, -0.4), (60.0, 0.3), (60.0, -0.4)]
    return [trial(hz, kg, peak, rng, **choice)[0] for kg, peak in pulses]


def models_of(calibrated):
    few = calibrated.deviations[:60]
    return {
        c: FittedModel("linear-frame", calibrated.models[c], unit, LOWPASS, (), few, left_out=1.0)
        for c, unit in UNITS.items()
    }


pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", params=[30.0, 50.0, 90.0])
def frame(request):
    """Natural frequency of a frame (Hz), its calibration trials, and the fit."""
    trials = calibration(request.param, 3)
    return request.param, trials, fit_linear_frame(trials, 400, np.random.default_rng(1))


def in_pulses(x, recording):
    """Change of ``x`` in every pulse, from before it."""
    return np.array([x[k - 10 : k + 60] - x[k - 60 : k - 10].mean() for k in recording.onsets])


@pytest.mark.parametrize(("kg", "body"), [(0.0, False), (40.0, False), (64.0, True)])
def test_a_known_load_is_recovered_within_its_uncertainty(frame, kg, body):
    hz, _, calibrated = frame
    found, load, under = trial(hz, kg, 0.35, np.random.default_rng(4), body=body, zeroed=False)
    # the analysis is told how heavily it presses on the belt, and nothing else
    found = {
        c: replace(r, load=r.load + r.carried, carried=0.0 * r.load, rigid_kg=0.0) for c, r in found.items()
    }
    models = models_of(calibrated)
    loads, draws = compensated_loads(models, found), compensated_draws(models, found)
    for k, c in enumerate(UNITS):
        error = in_pulses(loads[c] - load[:, k], found[c])
        peak = np.abs(in_pulses(found[c].load, found[c])).max()
        spread = np.std([in_pulses(x, found[c]) for x in draws[c]], axis=0)
        assert np.abs(error).max() < 0.05 * peak, c
        within = np.abs(error) < 2.0 * np.hypot(spread, 0.005 * peak)
        assert within.mean() >= 0.9, (c, within.mean())
    moved = in_pulses(models["Fy"].model.frame_acceleration(found["Fy"]), found["Fy"])
    assert moved == pytest.approx(in_pulses(under, found["Fy"]), abs=0.1 * np.abs(under).max() + 0.02)


def test_constants_of_the_frame_and_the_delay_are_found_within_their_uncertainty(frame):
    hz, _, calibrated = frame
    model, sd = calibrated.models["Fy"], calibrated.deviations.std(axis=0)
    assert model.converged
    compliance, masses = np.linalg.inv(stiffness(hz)), [FRAME_KG, FRAME_KGM2]
    inertia = np.diag(masses) @ compliance
    for name, true in (
        ("lead_s", LEAD_S),
        ("lever_m", LEVER_M),
    ):
        assert abs(model.named[name] - true) < 3.0 * sd[AT[name]] + 0.02 * abs(true), name
    assert sd[AT["lead_s"]] < 2e-4
    shown = np.sqrt(1.0 / np.linalg.eigvals(inertia).max()) / (2.0 * np.pi)
    # far above the band of the pulses it is not well known
    assert model.resonance_hz(0.0) == pytest.approx(shown, rel=0.05 if hz < 60.0 else 0.25)
    assert model.resonance_hz(60.0) < (0.95 if hz < 60.0 else 1.0) * model.resonance_hz(0.0)
    assert model_flags(model, 64.0) == []
    assert model_flags(model, 67.0) == ["beyond-calibrated-mass"]


def test_prediction_and_compensation_are_inverse(frame):
    hz, _, calibrated = frame
    models = models_of(calibrated)
    unseen, *_ = trial(hz, 40.0, 0.3, np.random.default_rng(5))
    for c in UNITS:
        assert evaluate(models[c], [unseen[c]]).r2 > 0.99, c
    whole = {c: models[c].predict(unseen[c]) for c in UNITS}
    other = {"Fy": "Mx", "Mx": "Fy"}
    predicted = {
        c: replace(unseen[c], load=whole[c], beside=whole[other[c]] + unseen[c].beside_carried) for c in UNITS
    }
    # each later pulse begins at 0, where a step of the predicted load is no motion of the frame
    for c, left in compensated_loads(models, predicted).items():
        assert np.abs(in_pulses(left, unseen[c])[0]).max() < 0.002 * np.abs(whole[c]).max(), c


def test_draws_are_of_first_order_and_belong_to_both_components(frame):
    hz, _, calibrated = frame
    models = models_of(calibrated)
    unseen, *_ = trial(hz, 64.0, 0.3, np.random.default_rng(6), body=True, zeroed=False)
    best, drawn = compensated_loads(models, unseen), compensated_draws(models, unseen)
    small = 0.02 * calibrated.deviations[0]
    moved = {c: replace(m, model=m.model.moved(small), deviations=None) for c, m in models.items()}
    for c, x in compensated_loads(moved, unseen).items():
        expected = 0.02 * (drawn[c][0] - best[c])
        assert x - best[c] == pytest.approx(expected, abs=0.1 * np.abs(expected).max()), c


def test_draws_contain_variants_that_the_trials_do_not_tell_apart(frame):
    hz, trials, calibrated = frame
    model, error = calibrated.models["Fy"], calibrated.left_out
    assert calibrated.error == min(error.values()) == error["+".join(model.terms)]
    drawn = calibrated.deviations
    alone = fit_linear_frame(trials, 400, np.random.default_rng(1), calibrated).deviations
    if hz == 30.0:  # without the pitch no variant predicts these trials half as well: none is drawn
        assert min(left for terms, left in error.items() if "pitch" not in terms) > 2.0 * calibrated.error
        assert np.abs(np.abs(drawn[:, AT["pitch"]]) - abs(model.named["pitch"])).min() > 0.0
    else:
        used = alone.any(axis=0)
        assert sorted(error.values())[1] < 1.1 * calibrated.error
        assert 0.0 < drawn[:, ~used].any(axis=1).mean() < 0.5
    assert (np.abs(drawn.mean(axis=0)) <= 4.0 * drawn.std(axis=0) / np.sqrt(len(drawn))).all()


def test_noise_of_the_measured_load_does_not_shrink_the_frame():
    quiet, noisy = (
        fit_linear_frame(calibration(35.0, 7, noise=noise), 20, np.random.default_rng(1)).models["Fy"].named
        for noise in (1.0, 10.0)
    )
    for name in ("force_inertia", "sway"):
        assert noisy[name] == pytest.approx(quiet[name], rel=0.1), name


def test_a_log_that_is_not_ahead_and_one_that_is_behind():
    for lead_s in (0.0, -1e-3):
        calibrated = fit_linear_frame(calibration(40.0, 8, lead_s=lead_s), 40, np.random.default_rng(1))
        found, sd = calibrated.models["Fy"].named["lead_s"], calibrated.deviations[:, AT["lead_s"]].std()
        assert abs(found - lead_s) < 3.0 * sd + 2e-5


def test_trials_left_out_and_files(frame, tmp_path):
    hz, trials, calibrated = frame
    held_out = read_held_out(held_out_residuals(calibrated, trials[:-1], trials[-1:]))
    windows = pulse_windows(trials[-1:], whole=True)
    left = calibrated.residuals(windows, calibrated.models["Fy"].constants)
    for c in UNITS:
        assert held_out.residual[c][-1].mean(axis=0) == pytest.approx(
            left[c][0][: held_out.residual[c][-1].shape[1]], abs=1e-3 * np.ptp(windows.load[c])
        )
    fitted = models_of(calibrated)["Fy"]
    save_models(tmp_path / "models.json", [fitted])
    kept = load_treadmill_models(tmp_path / "models.json")
    assert pick(kept, "best-frame").name == "linear-frame"
    unseen, *_ = trial(hz, 20.0, 0.3, np.random.default_rng(9))
    assert kept["linear-frame"].predict(unseen["Fy"]) == pytest.approx(
        fitted.predict(unseen["Fy"]), abs=1e-12
    )


def test_force_without_the_moment_is_refused(frame):
    _, trials, calibrated = frame
    alone = replace(trials[0]["Fy"], beside=None, beside_carried=None)
    with pytest.raises(InputError) as caught:
        models_of(calibrated)["Fy"].compensate(alone)
    assert_one_sentence(caught.value, "moment")
    with pytest.raises(InputError, match="force and moment of the plate together"):
        models_of(calibrated)["Fy"].model.predict(replace(alone, rigid_kg=5.0))
    with pytest.raises(InputError, match="a treadmill model of Mx, found models of 'Fy'"):
        compensated_loads({"Fy": models_of(calibrated)["Fy"]}, trials[0])
    with pytest.raises(InputError, match="filtered forward and backward"):
        pulse_windows([trials[0] | {"Fy": replace(trials[0]["Fy"], lowpass=None)}])
    with pytest.raises(InputError) as caught:
        fit_linear_frame(trials[:2], 10, np.random.default_rng(1))
    assert_one_sentence(caught.value, "0 kg")
