"""Chapters on a human joint and on a recorded treadmill, of data that show the opposite of the usual."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from joint_builders import fit_of, rows_of
from typst_builders import typeset_words

from tepsipe.reporting.numbers.position_manipulator import manipulator_data
from tepsipe.reporting.numbers.treadmill import treadmill_data
from tepsipe.reporting.numbers.treadmill_sentences import resonance_sentence
from tepsipe.treadmill.calibration import ModelScore

CHOICES = {
    "ingest": {"resample_rate_hz": 250.0},
    "analysis": {
        "lowpass_cutoff_hz": 30.0,
        "cut_s": 1.0,
        "block_s": 1.0,
        "training_fraction": 0.5,
        "parallel_cascade": {
            "intrinsic_lag_s": 0.04,
            "reflex_length_s": 0.6,
            "relaxation_times_s": [0.05, 0.2],
        },
    },
}
MODELS = ("fir-causal", "fir", "ripple-tracking")


def manipulator(usual):
    """Two trials; a clear reflex that raises the VAF, or none that could be seen."""
    vafs = [(80.0, 93.0), (90.0, 95.0)] if usual else [(-40.0, -60.0), (20.0, 30.0)]
    made = (
        {"delays_s": (0.04, 0.05), "lasting_s": 0.5, "short_range": True}
        if usual
        else {"delays_s": (0.04, 0.04), "lasting_s": 0.1, "assumed": False, "relaxing": True}
    )
    made |= {} if usual else {"p": 0.001, "white": 0.5, "memory_s": 4.0, "slow": 10.0, "coherent": 0.5}
    gain = (8.0, 12.0) if usual else (-2.0, 12.0)
    frames = [
        rows_of(condition, alone=alone, cascade=cascade, gain=gain, flags="" if usual else "at-bound")
        for condition, (alone, cascade) in zip("ab", vafs, strict=True)
    ]
    joint = {"name": "ankle", "positive": "dorsiflexion", "negative": "plantarflexion"} if usual else None
    return manipulator_data({"a": fit_of(**made), "b": fit_of(**made)}, pd.concat(frames), joint)


def belt(usual):
    """One held-out recording; models with a limit of 0.9, or none that predicts anything."""
    values = (0.5, 0.7, 0.8) if usual else (-3.0, -3.001, -5.0)
    scores = [
        ModelScore(model, "one", "two", hz, r2, 10.0, 5.0, 2, 0.9, "load", "N")
        for model, r2 in zip(MODELS, values, strict=True)
        for hz in (6.0, 20.0)
    ]
    ingested = {
        "recorded_rate_hz": 100.0,
        "clock": "kept",
        "largest_stamp_deviation_s": 0.0,
        "repeated_stamps": 0,
        "repeated_velocity_fraction": 0.0,
        "missing_samples": 0,
    }
    told = {
        "coefficients": {"mass-spring-damper": {"m": [2.8, 2.68, 2.92]}} if usual else {},
        "calibrated": {"velocity": [0.9, 1.5], "acceleration": [-3.0, 3.0]},
        "beyond": {"two": 0.01},
        "crossed": {"fir": {"one": {"one": 0.8, "two": 0.7}}} if usual else {},
    }
    named = {"recordings": ["two"], "models": list(MODELS), "unit": "N", "ingested": {"two": ingested}}
    result = SimpleNamespace(
        facts=named | told,
        arrays={"ripple/tracked_orders": np.array([1.0, 2.0] if usual else [1.0])},
    )
    models = {"ripple": {"memory_s": 20.0}, "fir_lead_s": 0.1}
    return treadmill_data(
        result, scores, {"analysis": {"shown_cutoff_hz": 6}, "models": models}, {"two": "validate"}
    )


@pytest.fixture(scope="module", params=[True, False], ids=["usual", "contrary"])
def told(request):
    """Whether the data are usual, and words of both chapters, typeset without figures."""
    data = {"belt": belt(request.param), "position_manipulator": manipulator(request.param)}
    data |= {"title": "t", "names": {}, "choices": {"position_manipulator": CHOICES}}
    source = (
        '#set heading(numbering: "1.1")\n'
        '#include "chapters/belt.typ"\n#include "chapters/position_manipulator.typ"\n'
        '#include "chapters/position_manipulator_methods.typ"\n'
        '#bibliography("references.bib", style: "ieee")\n'
    )
    return request.param, typeset_words(source, data)


USUAL = (
    "A human ankle in a",
    "responds to dorsiflexion",
    "predicts every held-out part better than inertia",
    "with 40 to 50 ms the fitted part is predicted as well",
    "in both trials): K is the stiffness beyond the yield angle",
    "is not the gain of the short-latency stretch reflex alone",
    "The residual is not white",
    "Its memory is shorter than a block",
    "does not differ between the thirds of any record",
    "lies below 1 Hz: slow changes",
    "The best linear model of the acceleration reaches",
    "shows how well a calibration on one recording serves another",
    "2.80 (2.68 to 2.92)",
    "A lead of 100 ms increases",
    "narrow lines",
)
CONTRARY = (
    "A joint in a",
    "responds to increasing angles",
    "do not predict the torque of the held-out part of every trial",
    "does not predict every held-out part better",
    "The interval holds 0",
    "all but 40 ms predict the fitted part worse",
    "Its response has ended",
    "The residual is white up to",
    "so the intervals there are too narrow",
    "differs between the thirds of a and b",
    "voluntary torque drifted",
    "A check of this estimate failed",
    "No linear model of the acceleration predicts more than the mean",
    "not more than the best model without",
    "a narrow line",
)


def test_chapters_tell_what_their_data_show_and_nothing_else(told):
    usual, words = told
    for sentence in USUAL:
        assert (sentence in words) is usual, sentence
    for sentence in CONTRARY:
        assert (sentence in words) is not usual, sentence


@pytest.mark.parametrize(
    ("empty_hz", "loaded_hz", "words"),
    [
        (52.0, 48.0, "locates it at 52.0 Hz without and at 48.0 Hz with the weight"),
        (5e7, 48.0, "locates it at 48.0 Hz with the weight and shows none below 200 Hz without it"),
        (52.0, float("inf"), "locates it at 52.0 Hz without the weight and shows none below 200 Hz with it"),
        (5e7, float("inf"), "shows none below 200 Hz, neither without nor with the weight"),
    ],
)
def test_a_resonance_that_is_not_seen_is_not_located(empty_hz, loaded_hz, words):
    assert resonance_sentence(empty_hz, loaded_hz) == words
