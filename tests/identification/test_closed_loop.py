"""Impedance of two joints in a closed loop: known persons on a platform, by instruments and by regression."""

from dataclasses import replace

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.identification.several_joints.closed_loop import (
    MultiJointOptions,
    banded_spectra,
    fit_row,
    model_terms,
)
from tepsipe.identification.several_joints.quantities import joint_quantities, slow_mode
from tepsipe.virtual_lab.platform_person import PlatformPerson, PlatformProtocol, record_platform

OPTIONS = MultiJointOptions(
    band_hz=(0.05, 5.0), averaged_bins=20, taper_fraction=0.02, delays_s=(0.04, 0.24), delay_step_s=0.04
)
JOINTS = ("ankle", "hip")
RATE = 50.0
PERSON = PlatformPerson()
REFLEX = PlatformPerson().with_reflex()
PUSHED = PlatformProtocol(push_N=30.0)


@pytest.fixture(scope="module")
def record():
    return record_platform(PERSON, PlatformProtocol(), np.random.default_rng(3))


@pytest.fixture(scope="module")
def pushed():
    return record_platform(REFLEX, PUSHED, np.random.default_rng(3))


def spectra(record, *further, options=OPTIONS):
    return banded_spectra(
        np.column_stack([record.platform, *further]), record.angle, record.torque, RATE, options
    )


def truth(person, joint, model):
    values = {
        "K": person.stiffness_Nm_per_rad,
        "B": person.damping_Nms_per_rad,
        "D": person.reflex_stiffness_Nm_per_rad,
        "E": person.reflex_damping_Nms_per_rad,
    }
    return np.array([values[kind][joint][j] for kind, j in model_terms(model, joint, 2)])


def told(found, joint, model):
    fit = fit_row(found, joint, model, OPTIONS)
    return joint_quantities(fit, found, joint, JOINTS, 0.1, 0.5)


def errors(fit, true):
    """Of the estimates, in their standard errors."""
    q = fit.directions.strength.size
    u = [fit.directions.standard_error(row) for row in np.eye(q)[: true.size]]
    return (fit.parameters - true) / u


def test_quiet_person_and_noise_free_sensors_give_the_impedance():
    quiet = replace(PERSON, own_torque_Nm=(0.0, 0.0))
    exact = PlatformProtocol(duration_s=120.0, angle_noise_rad=0.0, torque_noise_Nm=0.0)
    found = spectra(record_platform(quiet, exact, np.random.default_rng(1)))
    for joint in range(2):
        fit = fit_row(found, joint, "intrinsic", OPTIONS)
        assert fit.parameters == pytest.approx(truth(PERSON, joint, "intrinsic"), rel=0.02)


def test_instrument_is_unbiased_where_feedback_biases_regression(record):
    found = spectra(record)
    for joint in range(2):
        true = truth(PERSON, joint, "intrinsic")
        fit = fit_row(found, joint, "intrinsic", OPTIONS)
        assert np.abs(errors(fit, true)).max() < 3.0
        # K of the row, as a whole, within 10 %
        assert np.linalg.norm((fit.parameters - true)[:2]) < 0.1 * np.linalg.norm(true[:2])
        # the same data, regressed: the person's own torque moves the body, and the fit takes it for stiffness
        assert np.abs((fit.direct - true)[:2] / true[:2]).max() > 0.35
        assert fit.p_value > 0.01


@pytest.mark.slow
def test_two_perturbations_identify_all_stiffness_and_the_reflexes(pushed):
    found = spectra(pushed, pushed.push)
    for joint, name in enumerate(JOINTS):
        q = told(found, joint, "all-reflex")
        static = np.array(REFLEX.stiffness_Nm_per_rad) + REFLEX.reflex_stiffness_Nm_per_rad
        for j, other in enumerate(JOINTS):
            one = q[f"K_static_{name}_{other}"]
            assert one.identified
            assert abs(one.value - static[joint, j]) < max(0.1 * static[joint, j], 2.5 * one.standard_error)
        assert q[f"K_static_{name}_{name}"].value == pytest.approx(static[joint, joint], rel=0.1)
        assert q[f"B_reflex_{name}_{name}"].value == pytest.approx(
            REFLEX.reflex_damping_Nms_per_rad[joint][joint], rel=0.2
        )
        assert q[f"delay_{name}"].value == pytest.approx(REFLEX.delay_s[joint], abs=0.015)


def test_one_perturbation_does_not_identify_reflexes_of_all_angles(record):
    found = spectra(record)
    mode = slow_mode(found, 0.5)
    for joint, name in enumerate(JOINTS[:1]):
        q = told(found, joint, "all-reflex")
        for kind in ("K", "K_reflex"):
            for other in JOINTS:
                label = f"{kind}_{name}_{other}"
                one = q[label]
                assert not one.identified
                assert np.isnan([one.value, one.standard_error, one.low, one.high]).all()
                assert one.refusal.startswith(f"{label} is not identified: ")
        # the combination that the platform moves slowly is near the truth, if it is quoted
        along = q[f"K_mode_{name}"]
        if along.identified:
            assert abs(along.value - PERSON.stiffness_Nm_per_rad[joint] @ mode) < 3.0 * along.standard_error


def test_joints_that_move_in_proportion_are_refused_and_their_sum_is_not(record, rng):
    angle = np.column_stack([record.angle[:, 0], 0.5 * record.angle[:, 0]])
    torque = angle @ np.array(PERSON.stiffness_Nm_per_rad).T + 2.0 * rng.standard_normal(angle.shape)
    noisy = replace(record, angle=angle + 2e-4 * rng.standard_normal(angle.shape), torque=torque)
    q = told(spectra(noisy), 0, "intrinsic")
    assert "does not separate it from K_ankle_hip" in q["K_ankle_ankle"].refusal
    assert "K_ankle_ankle" in q["K_ankle_hip"].refusal
    assert q["K_mode_ankle"].value == pytest.approx(1000.0 + 0.5 * 180.0, rel=0.03)


def test_torque_left_over_betrays_a_model_without_reflexes(pushed):
    found = spectra(pushed, pushed.push)
    for joint in range(2):
        assert fit_row(found, joint, "intrinsic", OPTIONS).p_value < 1e-6
        assert fit_row(found, joint, "own-reflex", OPTIONS).p_value > 1e-3


def test_units_scale_and_the_size_of_the_perturbation_does_not_matter(record):
    plain = fit_row(spectra(record), 0, "intrinsic", OPTIONS)
    kilo = replace(record, platform=-1e3 * record.platform, torque=1e-3 * record.torque)
    scaled = fit_row(spectra(kilo), 0, "intrinsic", OPTIONS)
    assert scaled.parameters == pytest.approx(1e-3 * plain.parameters, rel=1e-4)
    assert scaled.chi2 == pytest.approx(plain.chi2, rel=1e-6)


def test_coherence_of_unrelated_signals_is_below_its_threshold(rng):
    count = 15000
    noise = rng.standard_normal((count, 5))
    found = banded_spectra(noise[:, 0], noise[:, 1:3], noise[:, 3:], RATE, OPTIONS)
    above = (found.coherence > found.coherence_threshold()).mean()
    assert 0.01 < above < 0.1
    assert not any(q.identified for q in told(found, 0, "intrinsic").values())


def test_unusable_records_are_refused(record):
    short = replace(record, **{k: getattr(record, k)[:1000] for k in ("platform", "angle", "torque")})
    with pytest.raises(InputError, match="at least 8 bands of 20 frequencies"):
        spectra(short)
    with pytest.raises(InputError, match="perturbation to vary"):
        spectra(replace(record, platform=np.zeros_like(record.platform)))
    with pytest.raises(InputError, match="intrinsic, own-reflex, all-reflex, found 'reflex'"):
        model_terms("reflex", 0, 2)
