"""Sentences of the treadmill's chapter: they say what the numbers at hand show."""

import numpy as np
import pandas as pd
import pytest

from tepsipe.io.result import Result
from tepsipe.reporting.numbers.treadmill_sentences import (
    foot_sentences,
    force_sentence,
    frame_of,
    linear_sentence,
    mass_sentence,
    trend,
)
from tepsipe.treadmill.calibration import ModelScore

SPEEDS = [0.1, 0.2, 0.3, 0.4, 0.5]


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ([20.4, 20.3, 20.2, 20.1, 20.0], -1),
        ([20.0, 20.1, 20.2, 20.3, 20.41], 1),
        ([20.0, 20.4, 19.9, 20.3, 20.1], 0),
        ([20.0, 20.0, 20.0, 20.0, 20.0], 0),
    ],
)
def test_a_trend_is_one_only_if_its_slope_is_clear(values, found):
    assert trend(SPEEDS, values) == found
    assert trend(SPEEDS[:2], values[:2]) == 0


def test_mass_falls_only_if_it_falls():
    falling, rising = [20.4, 20.3, 20.2, 20.1, 20.0], [20.0, 20.1, 20.2, 20.3, 20.4]
    assert mass_sentence(SPEEDS, falling, falling) == (
        "The estimate and its standard deviation decrease with amplitude."
    )
    assert mass_sentence(SPEEDS, rising, falling) == (
        "The estimate increases with amplitude, its standard deviation decreases with amplitude."
    )
    assert "no trend" in mass_sentence(SPEEDS, [20.0, 20.4, 19.9, 20.3, 20.1], falling)


def test_linear_models_fail_only_if_they_do():
    before = "For this reason"
    assert "depends on the load" in linear_sentence([0.95, 0.97], [0.52, 0.54], before)
    assert "depends" not in linear_sentence([0.95, 0.97], [0.93, 0.96], before)
    assert linear_sentence([], [], before) == ""


def test_growth_of_the_force_is_that_of_the_run():
    results = {}
    for speed in SPEEDS:
        pulse = speed * np.sin(np.linspace(0.0, np.pi, 21))
        force = 10.0 * speed**0.5 * np.sin(np.linspace(0.0, np.pi, 21))
        arrays = {"20 Hz/belt_velocity": pulse[None], "20 Hz/added_force": force[None]}
        results[f"sine-{speed}"] = Result(arrays, {}, {})
    text = force_sentence(results, "20 Hz", [10.0 * speed**0.5 for speed in SPEEDS])
    assert "100 % of its peak speed" in text
    assert "to the power of 0.50" in text


def score(model, test, r2):
    return ModelScore(model, "empty+weight", test, 20.0, r2, 10.0, 1.0, 2, 0.99, "Fy", "N")


def test_frame_names_its_terms_and_no_resonance_that_nobody_sees():
    facts = {
        "terms": ["bristles", "lever"],
        "masses_kg": [0.0, 20.0, 60.0],
        "resonance_hz": [1e6, 48.7, 43.9],
        "resonance_sd_hz": [0.0, 0.2, 0.11],
    }
    scores = [score("bristle-frame", "weight", 0.99), score("loaded-frame", "weight", 0.86)]
    found = frame_of(facts, scores, 20.0)
    assert "bristles" in found["kept"]
    assert "lever" in found["kept"]
    assert found["resonances"].startswith("above 200 Hz at 0 kg, at 48.7 ± 0.20 Hz at 20 kg")
    assert found["rows"] == [
        {"test": "weight", "load": "Fy", "r2": "0.990", "limit": "0.990", "loaded": "0.860"}
    ]
    assert frame_of(facts | {"terms": []}, scores, 20.0)["kept"] == "no further term"
    assert frame_of(None, scores, 20.0) is None


def test_foot_pathways_are_compared_with_the_leg_and_the_gate_is_told():
    rows = [
        ("leg", "a", 10.0, ""),
        ("leg", "b", 9.0, ""),
        ("foot", "a", 3.0, ""),
        ("foot-compensated", "a", 10.5, ""),
        ("foot-compensated", "b", 8.1, "treadmill-model"),
    ]
    own = pd.DataFrame(rows, columns=["pathway", "condition", "value", "flags"]).assign(quantity="K")
    (sentence,) = foot_sentences(own, "leg")
    assert "−10.0 to 5.0 %" in sentence
    assert "in 1 of 2 conditions the gate rejects" in sentence
    (sentence,) = foot_sentences(own.assign(flags=np.nan), "leg")
    assert "accepts the treadmill model in all conditions" in sentence
