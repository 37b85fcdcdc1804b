"""What the sentences of the reports are chosen by, where a run shows the opposite of the usual."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from tepsipe.reporting.numbers.abstract import _standing
from tepsipe.reporting.numbers.figure_findings import figure_findings_of
from tepsipe.reporting.numbers.position_manipulator import _raises
from tepsipe.reporting.numbers.shown_signals import muscle_signals
from tepsipe.reporting.numbers.treadmill import foot_data

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


@pytest.mark.parametrize(("reflex", "raises"), [([81.0, 91.0], True), ([81.0, 89.0], False)])
def test_reflex_raises_the_held_out_vaf_only_if_it_does_in_every_trial(reflex, raises):
    rows = {"regression": [80.0, 90.0]}
    assert _raises(lambda name, _: pd.Series(rows.get(name, reflex))) is raises


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


@pytest.mark.parametrize("lines", [[], ["1.6", "6.3"]])
def test_captions_of_a_treadmill_tell_its_lines_and_the_chosen_model(lines):
    cell = {"r2": "0.70", "less": "45.0"}
    t = {
        "rows": [{"model": "hnat2014", "cells": [{"r2": "0"}]}, {"model": "fir", "cells": [cell]}],
        "chosen": "fir", "cutoff": "6", "best_linear": "0.72", "tests": [{"limit": "0.75"}],
        "ripple": "0.77", "orders": lines,
    }  # fmt: skip
    found = figure_findings_of({"belt": t})
    assert "impulse response predicts the load with R² = 0.70" in found["belt_prediction"]
    assert ("no narrow line" in found["belt_ripple"]) is (not lines)
    assert "belt_ripple" not in figure_findings_of({"belt": t | {"ripple": None}})


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
