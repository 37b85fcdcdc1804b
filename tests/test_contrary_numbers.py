"""What the sentences of the reports are chosen by, where a run shows the opposite of the usual."""

from types import SimpleNamespace

import pandas as pd
import pytest

from tepsipe.reporting.numbers.abstract import _standing
from tepsipe.reporting.numbers.dummy import _vaf_of_trial
from tepsipe.reporting.numbers.figure_findings import figure_findings_of
from tepsipe.reporting.numbers.position_manipulator import _raises
from tepsipe.reporting.numbers.simulations import _of_noise
from tepsipe.reporting.numbers.treadmill import foot_data
from tepsipe.reporting.numbers.wristalyzer import _leaks

DASH = "\N{EN DASH}"


@pytest.mark.parametrize(
    ("amplitudes", "told"),
    [
        ({"a": 0.1, "b": 0.5}, "0.5"),
        ({"a": 0.1, "b": 0.2}, "0.1"),
        ({"a": None, "b": None}, DASH),
    ],
)
def test_velocities_of_the_foot_are_those_of_the_sheet(amplitudes, told):
    rows = [
        {"experiment": "dummy", "condition": c, "pathway": "leg", "quantity": q, "value": 1.0}
        for c in amplitudes
        for q in ("I", "B", "K", "VAF_perturbation")
    ]
    choices = {"recommended": "leg", "foot": {"pathways": {}}}
    found = foot_data(pd.DataFrame(rows), choices, None, amplitudes)
    assert found["clear_from"] == told


def noise(**means):
    """Mean K at one SNR by estimator and noisy signal; B without error, the apparent K 6."""
    rows = []
    for estimator, of_signal in means.items():
        for noise_on, value in zip(("tau", "theta", "both"), of_signal, strict=True):
            names = {"estimator": estimator.replace("_", "-"), "noise_on": noise_on}
            rows.append(names | {"quantity": "K", "mean": value, "apparent": 6.0})
            rows.append(names | {"quantity": "B", "mean": 0.1, "apparent": 0.1})
    return _of_noise(pd.DataFrame(rows), [0.015, 0.1, 10.0])


def test_noise_is_told_as_in_the_thesis_only_where_it_is_so():
    usual = noise(
        as_printed=(3.0, 9.0, 6.1), recommended=(10.0, 10.1, 10.1), recommended_regression=(10.0, 8.0, 8.0)
    )
    assert usual["iv_accurate"] and usual["ls_biased"] and usual["method_sound"]
    assert usual["near_apparent"] and usual["filter_dominates"]
    assert (usual["iv_error"], usual["ls_error"], usual["alone"]) == ("1.0", "20.0", "50")
    contrary = noise(
        as_printed=(10.0, 10.0, 10.0),
        recommended=(20.0, 20.0, 20.0),
        recommended_regression=(10.0, 10.0, 10.0),
    )
    for name in ("iv_accurate", "ls_biased", "method_sound", "near_apparent", "filter_dominates"):
        assert contrary[name] is False, name


def test_an_estimator_that_was_not_computed_proves_nothing():
    found = noise(as_printed=(3.0, 9.0, 6.1))
    assert (found["iv_error"], found["method_sound"], found["ls_biased"]) == (DASH, False, False)


@pytest.mark.parametrize(("reflex", "raises"), [([81.0, 91.0], True), ([81.0, 89.0], False)])
def test_reflex_raises_the_held_out_vaf_only_if_it_does_in_every_trial(reflex, raises):
    rows = {"regression": [80.0, 90.0]}
    assert _raises(lambda name, _: pd.Series(rows.get(name, reflex))) is raises


@pytest.mark.parametrize(("crossed", "told"), [([97.0, 98.0], True), ([60.0, 98.0], False)])
def test_vaf_depends_on_the_trial_only_if_parameters_matter_less(crossed, told):
    rows = [("VAF_trial", 90.0), ("VAF_trial", 99.0), *(("VAF_cross_validated", x) for x in crossed)]
    own = pd.DataFrame(rows, columns=["quantity", "value"]).assign(pathway="leg-thesis")
    assert _vaf_of_trial(own, "leg-thesis") is told
    assert _vaf_of_trial(own[own.quantity == "VAF_trial"], "leg-thesis") is False


@pytest.mark.parametrize(("samples", "leaks"), [(12288, True), (10240, False)])
def test_a_record_of_whole_periods_does_not_leak(samples, leaks):
    fit = SimpleNamespace(facts={"kept_samples": [1536, 1536 + samples], "rate_hz": 256.0})
    assert _leaks({"0.16": fit}, 10.0) is leaks


@pytest.mark.parametrize(
    ("latency", "told"), [("1.9", " and 1.9 ms in the latency of a muscle."), (DASH, ".")]
)
def test_latencies_without_an_onset_have_no_error(latency, told):
    person = {
        "stood": "2",
        "trials": "2",
        "recommended": {"estimator": "gls"},
        "tasks": [],
        "estimators": [],
        "recovery": {"stiffness": "3.1", "latency": latency},
    }

    words = "".join(piece for paragraph in _standing({"standing": person}) for _, piece in paragraph)
    assert words.endswith(f"the largest error is 3.1 % in stiffness{told}")


@pytest.mark.parametrize("usual", [True, False])
def test_captions_tell_the_usual_findings_only_where_they_hold(usual):
    manipulator = {
        "vaf": "90", "natural_frequency": "4.1", "cross_validated": "85", "one_minimum": usual,
        "modulus_depends": True, "periodic": {"shift_damping": "3.0" if usual else "30.0"},
    }  # fmt: skip
    dummy = {
        "printed_stiffness": "5", "printed_inertia": "0.06", "falls": usual, "signs_explain": usual,
        "recommended_mean_stiffness": "9", "printed_mean_stiffness": "6", "vaf_lower": usual,
        "vaf_of_trial": usual,
    }  # fmt: skip
    noise = {"figure_stiffness": "15", "level": "20", "iv_error": "0.2", "method_sound": usual}
    found = figure_findings_of({"wristalyzer": manipulator, "dummy": dummy, "noise": noise, "weight": None})
    for name in ("starting_values", "pathways", "torque", "dummy_cross_validation", "noise"):
        assert (name in found) is usual, name
    assert ("K falls" in found["4_4"]) is usual
    assert ("the same admittance" in found["averaging"]) is usual
    assert "K = 15 N·m/rad" in found["4_12"]
