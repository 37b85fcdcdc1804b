"""Stiffness and damping of several joints: engines against equations, truth recovered, refusal, scaling."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.experiments.planning.several_joints import (
    EXACT,
    MODELS,
    UNKNOWN,
    WITHIN,
    Epochs,
    Point,
    Recording,
    epochs_of,
    estimate,
    expected_parameters,
    neglected_inertia,
    predict,
    sets_of,
)
from tepsipe.identification.several_joints.determined import Limits
from tepsipe.identification.several_joints.matrices import (
    Perturbation,
    Setting,
    fit_matrices,
    responses,
    unperturbed_covariance,
)
from tepsipe.mechanics.engines import installed_engines
from tepsipe.mechanics.segment_chain import Chain, joint_angles, linearised
from tepsipe.virtual_lab.standing_chain import STEP_S, ChainPerson, ChainProtocol, Pulse, record_chain

if not {"pybullet", "mujoco"} & set(installed_engines()):
    pytest.skip("needs a multi-body engine", allow_module_level=True)

K = ((1150.0, 260.0, 0.0), (260.0, 720.0, 190.0), (0.0, 190.0, 520.0))
B = ((40.0, 8.0, 0.0), (8.0, 18.0, 5.0), (0.0, 5.0, 20.0))
MATRICES = (np.array(K), np.array(B))
PERSON = ChainPerson(
    mass_kg=(7.0, 15.0, 51.0),
    length_m=(0.43, 0.43, 0.6),
    com_m=(0.244, 0.244, 0.32),
    inertia_kgm2=(0.118, 0.289, 3.3),
    posture_deg=(6.0, -4.0, 3.0),
    stiffness_Nm_per_rad=K,
    damping_Nms_per_rad=B,
    own_torque_Nm=(2.5, 2.0, 2.0),
    own_band_hz=(0.1, 1.5),
)
POSTURE = np.deg2rad(PERSON.posture_deg)
PULSES = {
    "belt": Pulse(None, 0.02, 0.1),
    "shank": Pulse(0, 100.0, 0.12, 0.3),
    "thigh": Pulse(1, 100.0, 0.12, 0.25),
    "pelvis": Pulse(2, 100.0, 0.12, 0.08),
}
POINTS = {name: Point(pulse.segment, pulse.height_m) for name, pulse in PULSES.items()}
PROTOCOL = ChainProtocol(
    PULSES, epochs=40, before_s=0.1, after_s=0.25, unperturbed_s=90.0, rate_hz=200.0, angle_noise_rad=2e-4
)
CHAIN = Chain(PERSON.mass_kg, PERSON.length_m, PERSON.com_m, PERSON.inertia_kgm2)
LIMITS = Limits()
THREE = ("belt", "thigh", "pelvis")


def seen(person, protocol, seed=1):
    record = record_chain(person, protocol, np.random.default_rng(seed))
    before = round(protocol.before_s * protocol.rate_hz)
    return Recording(record.unperturbed, record.angle, record.drive, protocol.rate_hz, 1.0 / STEP_S, before)


@cache
def recorded():
    return seen(PERSON, PROTOCOL)


@cache
def epochs_by(model=MODELS[0]):
    return epochs_of(recorded(), CHAIN, POINTS, model)


def exact(epochs, perturbed=tuple(PULSES), matrices=MATRICES):
    """The same epochs with the responses of the linear equations, without noise."""
    p = expected_parameters(epochs.setting, *matrices)
    found = {}
    for name in perturbed:
        one = epochs.perturbations[name]
        response = responses(epochs.setting, p, one)[0]
        found[name] = replace(one, response=np.repeat(response[None], 3, axis=0))
    return Epochs(epochs.setting, found)


# ---- the body ------------------------------------------------------------------------------------


def test_upright_chain_is_a_compound_pendulum():
    body = linearised(CHAIN, np.zeros(3))
    mass, length = np.array(CHAIN.mass_kg), np.array(CHAIN.length_m)
    height = np.cumsum(length) - length + np.array(CHAIN.com_m)
    # all segments turn as one with the ankle
    assert body.inertia[0, 0] == pytest.approx((np.array(CHAIN.inertia_kgm2) + mass * height**2).sum())
    assert body.gravity[0, 0] == pytest.approx(-9.81 * (mass * height).sum())
    assert body.belt_parts.sum(axis=0)[0] == pytest.approx(-(mass * height).sum())
    # the trunk alone turns with the hip
    assert body.inertia[2, 2] == pytest.approx(3.3 + 51.0 * 0.32**2)
    assert body.push(2, 0.08) == pytest.approx([0.94, 0.51, 0.08])
    assert np.linalg.eigvalsh(linearised(CHAIN, POSTURE).inertia).min() > 0.0


@cache
def engine_errors(engine, size):
    """Largest difference of the engine's joint angles from the linear ones, in parts of the largest (-)."""
    quiet = replace(PERSON, own_torque_Nm=(0.0, 0.0, 0.0))
    pulses = {name: replace(pulse, size=size * pulse.size) for name, pulse in PULSES.items()}
    protocol = replace(
        PROTOCOL, pulses=pulses, epochs=2, unperturbed_s=3.0, angle_noise_rad=0.0, engine=engine
    )
    recording, body = seen(quiet, protocol), linearised(CHAIN, POSTURE)
    assert recording.unperturbed == pytest.approx(np.tile(POSTURE, (600, 1)), abs=1e-7)
    setting = Setting(body, np.eye(3), recording.before, 1.0 / protocol.rate_hz, 5)
    p, found = expected_parameters(setting, *MATRICES), {}
    for name, point in POINTS.items():
        drive = recording.drive[name][0]
        one = Perturbation(drive, recording.angle[name], point.push(body))
        linear = responses(setting, p, one)[0]
        moved = joint_angles(recording.angle[name][0] - POSTURE)
        found[name] = np.abs(moved - linear).max() / np.abs(linear).max()
    return found


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_engines_agree_with_the_linear_equations_the_better_the_smaller_the_movement(engine):
    pytest.importorskip(engine)
    full, small, smaller = (engine_errors(engine, size) for size in (1.0, 0.1, 0.01))
    for name in PULSES:
        # 1.2 degrees; what is left is of second order in the angles, and of the engine's step
        assert full[name] < 0.02
        assert small[name] < 0.15 * full[name] + 2e-4
        assert smaller[name] < 0.15 * small[name] + 2e-4


# ---- the estimator -------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_truth_is_recovered_without_noise(model):
    epochs = exact(epochs_by(model), THREE)
    fit = fit_matrices(epochs.setting, [epochs.perturbations[name] for name in THREE])
    truth = expected_parameters(epochs.setting, *MATRICES)
    # the start pulls by its small weight, most where least is known
    assert np.abs((fit.parameters - truth) / fit.setting.scale(truth)).max() < (
        0.015 if model[1] == UNKNOWN else 2e-3
    )


@pytest.mark.slow
def test_slopes_are_those_of_the_response():
    for model in ((False, UNKNOWN), (True, UNKNOWN)):
        epochs = epochs_by(model)
        p = expected_parameters(epochs.setting, *MATRICES)
        scale = epochs.setting.scale(p)
        for name in ("belt", "thigh") if model[0] else ("pelvis",):
            one = epochs.perturbations[name]
            slopes = responses(epochs.setting, p, one)[1] * scale
            for k in range(p.size):
                step = 1e-4 * scale[k] * np.eye(p.size)[k]
                change = (
                    responses(epochs.setting, p + step, one)[0] - responses(epochs.setting, p - step, one)[0]
                )
                assert np.abs(change / 2e-4 - slopes[..., k]).max() < 0.02 * np.abs(slopes[..., k]).max()


def test_response_is_proportional_to_the_drive_and_begins_with_it():
    epochs = epochs_by()
    p, one = expected_parameters(epochs.setting, *MATRICES), epochs.perturbations["pelvis"]
    response = responses(epochs.setting, p, one)[0]
    doubled = responses(epochs.setting, p, replace(one, drive=2.0 * one.drive))[0]
    assert doubled == pytest.approx(2.0 * response)
    assert not response[: epochs.setting.before + 1].any() and response[epochs.setting.before + 3].any()


def test_three_perturbations_identify_the_matrices_of_a_swaying_person():
    found = estimate(epochs_by(), THREE, LIMITS)
    assert found.known.all and not any(entry.refusal for entry in found.entries)
    truth, size = np.ravel(K), np.sqrt(np.outer(np.diag(K), np.diag(K))).ravel()
    values = np.array([entry.value for entry in found.entries[:9]])
    halves = np.array([entry.half_width for entry in found.entries[:9]])
    assert np.abs(values - truth).max() < 0.15 * size.max()
    assert np.all(np.abs(values - truth) < 0.15 * size)
    # 18 intervals of 95 %, correlated
    assert np.mean(np.abs(values - truth) <= halves) > 0.6
    # the scatter of the epochs confirms the Fisher information
    assert np.median(halves / size / (1.98 * found.known.errors[:9])) == pytest.approx(1.0, abs=0.25)
    assert found.fit.p_value > 1e-3


@pytest.mark.parametrize("chosen", [("belt",), ("pelvis",), ("belt", "pelvis"), ("shank", "thigh", "pelvis")])
def test_too_few_perturbations_have_no_values(chosen):
    found = estimate(epochs_by(), chosen, LIMITS)
    assert found.known.rank < found.known.unknowns == 24
    assert all(np.isnan(entry.value) and np.isnan(entry.half_width) for entry in found.entries)
    assert found.entries[1].refusal.startswith("K_ankle_knee is not determined")


def test_refusal_comes_from_the_data_not_from_noise():
    """Responses without noise fit perfectly; one belt perturbation is refused all the same."""
    epochs = exact(epochs_by())
    found = estimate(epochs, ("belt",), LIMITS)
    one = epochs.perturbations["belt"]
    left = one.response[0] - responses(epochs.setting, found.fit.parameters, one)[0]
    assert np.abs(left).max() < 1e-3 * np.abs(one.response).max()
    assert all(entry.refusal for entry in found.entries)


# ---- the plan ------------------------------------------------------------------------------------


@cache
def predictions(model=MODELS[0]):
    epochs = epochs_by(model)
    return {one.perturbations: one for one in predict(epochs, sets_of(list(PULSES)), MATRICES, LIMITS)}


def test_sets_of_one_to_three():
    assert len(sets_of(list(PULSES))) == 4 + 6 + 4
    assert {len(chosen) for chosen in sets_of(list(PULSES), 2)} == {1, 2}


def test_every_perturbation_adds_a_movement():
    known = {chosen: one.known for chosen, one in predictions().items()}
    for chosen, one in known.items():
        assert (one.direction_errors <= LIMITS.stiffness).sum() <= len(chosen)
        for further in set(PULSES) - set(chosen):
            larger = tuple(name for name in PULSES if name in (*chosen, further))
            if larger in known:
                assert np.all(known[larger].errors <= one.errors * (1.0 + 1e-6))
                assert known[larger].rank >= one.rank
    assert known[THREE].all and not any(one.all for chosen, one in known.items() if len(chosen) < 3)


def test_errors_fall_with_the_root_of_the_epochs_and_with_the_noise():
    epochs = epochs_by((False, EXACT))
    first = predict(epochs, [THREE], MATRICES, LIMITS)[0]
    four = {
        name: replace(one, response=np.concatenate(4 * [one.response]))
        for name, one in epochs.perturbations.items()
    }
    more = predict(Epochs(epochs.setting, four), [THREE], MATRICES, LIMITS)[0]
    assert more.known.errors == pytest.approx(0.5 * first.known.errors)
    assert more.known.condition == pytest.approx(first.known.condition)
    noisy = Epochs(replace(epochs.setting, weight=epochs.setting.weight / 9.0), epochs.perturbations)
    assert predict(noisy, [THREE], MATRICES, LIMITS)[0].known.errors == pytest.approx(
        3.0 * first.known.errors
    )


def test_belt_alone_never_shows_the_scale_without_the_inertia():
    """M, B, K and the belt's lever times a factor: the same response."""
    epochs = epochs_by((True, UNKNOWN))
    p, one = expected_parameters(epochs.setting, *MATRICES), epochs.perturbations["belt"]
    assert responses(epochs.setting, 1.7 * p, one)[0] == pytest.approx(responses(epochs.setting, p, one)[0])
    prediction = predictions((True, UNKNOWN))[("belt",)]
    assert prediction.scale_open and prediction.known.condition > 1e12 and not prediction.known.all
    pushed = epochs.perturbations["thigh"]
    assert (
        np.abs(responses(epochs.setting, 1.7 * p, pushed)[0] - responses(epochs.setting, p, pushed)[0]).max()
        > 0.1 * np.abs(responses(epochs.setting, p, pushed)[0]).max()
    )


def test_symmetry_of_a_person_who_lacks_it_is_a_number_that_looks_fine():
    """One belt perturbation fits symmetric matrices to a person without symmetry; three reject them."""
    odd = 80.0 * np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    general = exact(epochs_by((False, EXACT)), matrices=(MATRICES[0] + odd, MATRICES[1]))
    rng = np.random.default_rng(5)
    spread = np.linalg.cholesky(np.linalg.inv(general.setting.weight))

    def noisy(one: Perturbation) -> Perturbation:
        count, samples, joints = 40, *one.response.shape[1:]
        noise = (rng.standard_normal((count, samples * joints)) @ spread.T).reshape(count, samples, joints)
        return replace(one, response=one.response[:1] + noise)

    drawn = {name: noisy(one) for name, one in general.perturbations.items()}
    symmetric = Epochs(replace(general.setting, symmetric=True), drawn)
    alone, three = (estimate(symmetric, chosen, LIMITS) for chosen in (("belt",), THREE))
    assert alone.known.all and alone.fit.p_value > 0.001
    k = symmetric.setting.matrices(alone.fit.parameters)[0]
    assert np.abs(k - MATRICES[0] - odd).max() > 100.0
    assert three.fit.p_value < 1e-6
    assert estimate(Epochs(general.setting, drawn), THREE, LIMITS).fit.p_value > 0.001


def test_constants_of_the_inertia_are_as_uncertain_as_drawn_ones(rng):
    nominal = np.concatenate(CHAIN.constants)
    drawn = np.array([np.concatenate(CHAIN.drawn(rng, 0.01).constants) for _ in range(3000)]) / nominal - 1.0
    expected = CHAIN.relative_covariance(0.01)
    sizes = np.sqrt(np.diag(expected))
    assert np.cov(drawn.T) / np.outer(sizes, sizes) == pytest.approx(
        expected / np.outer(sizes, sizes), abs=0.08
    )


@pytest.mark.slow
def test_intervals_hold_errors_of_the_inertia_which_an_exact_one_hides(rng):
    """Without noise, the only errors are those of masses and centres of mass."""
    whole, tolerance, draws = epochs_of(recorded(), CHAIN, POINTS, tolerance=0.03), 0.03, 9
    truth, q = exact(whole, THREE), 18
    scale = whole.setting.scale(expected_parameters(whole.setting, *MATRICES))[:q]
    posture, errors = recorded().unperturbed.mean(axis=0), {EXACT: [], WITHIN: []}
    for _ in range(draws):
        body = linearised(CHAIN.drawn(rng, tolerance), posture)
        ones = [replace(truth.perturbations[name], push=POINTS[name].push(body)) for name in THREE]
        # as many epochs as were recorded weigh against the tolerance
        ones = [replace(one, response=np.repeat(one.response[:1], 40, axis=0)) for one in ones]
        for inertia in errors:
            setting = replace(whole.setting, body=body, inertia_known=inertia == EXACT)
            found = fit_matrices(setting, ones).parameters[:q]
            errors[inertia].append((found - np.r_[np.ravel(K), np.ravel(B)]) / scale)
    spread = {inertia: np.sqrt(np.mean(np.square(found), axis=0)) for inertia, found in errors.items()}
    neglected = neglected_inertia(whole, THREE, MATRICES)
    held = predict(whole, [THREE], MATRICES, LIMITS)[0].by_inertia[:q]
    assert np.median(spread[EXACT] / neglected) == pytest.approx(1.0, abs=0.45)
    assert np.median(spread[WITHIN] / held) == pytest.approx(1.0, abs=0.45)
    assert held[:9].max() < 0.5 * neglected[:9].max()


# ---- bad input -----------------------------------------------------------------------------------


def test_unusable_input_is_refused_in_one_sentence():
    sway = joint_angles(recorded().unperturbed)
    with pytest.raises(InputError, match="expected at least 1420 samples, 20 epochs, found 400"):
        unperturbed_covariance(sway[:400], 71)
    with pytest.raises(InputError, match="found one that is constant"):
        unperturbed_covariance(sway * [1.0, 0.0, 1.0], 71)
    epochs = epochs_by()
    one = epochs.perturbations["belt"]
    with pytest.raises(InputError, match="expected at least 2 of a perturbation, found 1"):
        fit_matrices(epochs.setting, [replace(one, response=one.response[:1])])
    with pytest.raises(InputError, match="expected 71 samples, as the drive is long, found 70"):
        fit_matrices(epochs.setting, [replace(one, response=one.response[:, :70])])
