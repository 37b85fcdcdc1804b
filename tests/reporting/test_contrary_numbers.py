"""What the sentences of the reports are chosen by, where a run shows the opposite of the usual."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from tepsipe.reporting.numbers.abstract import _standing
from tepsipe.reporting.numbers.dummy import _vaf_of_trial
from tepsipe.reporting.numbers.figure_findings import figure_findings_of
from tepsipe.reporting.numbers.position_manipulator import _raises
from tepsipe.reporting.numbers.shown_signals import belt_signals, muscle_signals, simulated_signals
from tepsipe.reporting.numbers.simulations import _of_noise

DASH = "\N{EN DASH}"


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


def forward(angle, torque):
    """VAF (%) of three sets of parameters in S1 and S52: of the angle and of the printed torque."""
    rows = []
    for condition in ("sine-0.1", "sine-0.5-8s"):
        for k, name in enumerate(("wristalyzer", "tep", "corrected")):
            for quantity, values in (("theta", angle), ("tau", torque), ("tau_consistent", angle)):
                vaf = {"vaf_trial": values[k], "vaf_perturbation": values[k]}
                rows.append({"condition": condition, "parameter_set": name, "quantity": quantity, **vaf})
    return {"signals": simulated_signals(pd.DataFrame(rows), {"4_7": "sine-0.1", "4_8": "sine-0.5-8s"})}


@pytest.mark.parametrize(
    ("angle", "best", "worst"),
    [
        ((90.0, -2000.0, 80.0), "the Wristalyzer", "TEP-SIPE as printed"),
        ((1.0, 99.0, 2.0), "TEP-SIPE as printed", "the Wristalyzer"),
    ],
)
def test_captions_of_simulations_name_the_parameters_that_predict_best(angle, best, worst):
    found = figure_findings_of({"simulation": forward(angle, angle[::-1])})
    assert f"best by the parameters of {best} in 2 of 2 conditions" in found["4_10"]
    assert f"the parameters of {best} predict the angle best" in found["4_8"] and "S52" in found["4_8"]
    assert f"those of {worst} worst" in found["4_7"]
    assert ("below \N{MINUS SIGN}1000 %" in found["4_7"]) is (min(angle) < -1000.0)
    assert figure_findings_of({"simulation": {"compared": None}}) == {}


@pytest.mark.parametrize("usual", [True, False])
def test_captions_of_a_joint_follow_its_records(usual):
    a = {
        "parts": {"differing": [] if usual else ["a", "b"], "drifting": ["a"] if usual else []},
        "residuals": {
            "white": [] if usual else ["a"],
            "count": 1,
            "mostly_slow": usual,
            "below": "84",
            "cutoff": "30",
        },
        "reflex_raises": usual,
        "reflexes": [{"there": usual, "gain": "46", "condition": "a"}],
    }
    found = figure_findings_of({"position_manipulator": a})
    told = found["position_manipulator_stationarity"]
    assert ("does not differ" in told, "drifts in a." in told) == (usual, usual)
    assert ("thirds of a and b" in told) is not usual
    assert ("is not white" in found["position_manipulator_residual"]) is usual
    assert ("84 %" in found["position_manipulator_residual"]) is usual
    assert ("46 N·m·s/rad (a)" in found["position_manipulator_responses"]) is usual
    assert ("predicts every" in found["position_manipulator_prediction"]) is usual


@pytest.mark.parametrize("delay", [0, 5])
def test_caption_of_the_pulses_measures_peak_and_delay_of_the_belt(delay):
    time = np.arange(0.0, 2.0, 0.004)
    command = -np.sin(2.0 * np.pi * (time - 1.0) / 0.1) * (np.abs(time - 1.05) < 0.05)
    belt = 0.8 * np.roll(command, delay)
    fit = SimpleNamespace(
        arrays={
            "time": time,
            "belt_velocity": belt,
            "belt_command": command,
            "windows": np.array([[250, 280]]),
        }
    )
    assert belt_signals({"S1": fit}) == {"peak": "80", "delay": f"{4 * delay}"}
    fit.arrays["belt_command"] = 0.0 * command
    assert belt_signals({"S1": fit}) is None


def test_muscles_without_an_onset_have_no_latency_in_a_caption():
    time = np.array([-0.1, 0.05, 0.1])
    activity = np.array([[9.0, 1.0, 4.0], [0.0, 0.0, 0.0]])
    trial = SimpleNamespace(arrays={"mean/time": time, "activity/TA": activity})

    def task(latency):
        onset = {"latency_s": latency, "interval_s": None}
        facts = {
            "latencies": {"TA": {"changepoint": onset, "threshold": {"latency_s": 0.05}, "responses": 3}}
        }
        arrays = {"windows/length": np.array([0.03, 0.3]), "windows/K": np.array([[400.0], [-50.0]])}
        return SimpleNamespace(facts=facts, arrays=arrays)

    found = muscle_signals({"a": trial}, {"relax": task(0.04)}, "changepoint")
    # the sample before the onset does not count
    assert found["largest"] == {"muscle": "TA", "condition": "a", "peak": "4.0", "at": "100"}
    assert (found["latency"], found["detectors"]) == ("40", "10")
    assert found["plain"]["relax"]["K"] == "\N{MINUS SIGN}50.0 to 400"
    silent = muscle_signals({}, {"relax": task(None)}, "changepoint")
    assert (silent["largest"], silent["latency"]) == (None, None)


@pytest.mark.parametrize("usual", [True, False])
def test_captions_tell_the_usual_findings_only_where_they_hold(usual):
    dummy = {
        "printed_stiffness": "5", "printed_inertia": "0.06", "falls": usual, "signs_explain": usual,
        "recommended_mean_stiffness": "9", "printed_mean_stiffness": "6", "vaf_lower": usual,
        "vaf_of_trial": usual,
    }  # fmt: skip
    noise = {
        "figure_stiffness": "15", "level": "20", "iv_error": "0.2", "method_sound": usual,
        "shown": {"as-printed": "1.0 to 9.9", "recommended": "15.0"} if usual else None,
    }  # fmt: skip
    found = figure_findings_of({"dummy": dummy, "noise": noise})
    for name in ("pathways", "torque", "noise"):
        assert (name in found) is usual, name
    assert ("more on the predicted trial" in found["dummy_cross_validation"]) is usual
    assert ("K falls" in found["4_4"]) is usual
    assert ("4_12" in found) is usual
    if usual:
        assert "K = 1.0 to 9.9 N·m/rad for a simulated K of 15 N·m/rad" in found["4_12"]
