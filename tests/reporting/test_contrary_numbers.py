"""What the sentences of the reports are chosen by, where a run shows the opposite of the usual."""

from types import SimpleNamespace

import numpy as np
import pytest

from tepsipe.reporting.numbers.abstract import _standing
from tepsipe.reporting.numbers.shown_signals import muscle_signals

DASH = "\N{EN DASH}"


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
