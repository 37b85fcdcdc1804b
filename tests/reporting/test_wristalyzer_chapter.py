"""Conditions and numbers of the Wristalyzer's chapter, and the sentences that they choose."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from typst_builders import evaluated, findings_of

from tepsipe.reporting.chapters import wristalyzer
from tepsipe.reporting.run import Run, raw, report_content

FIGURES = [f"figure_{name}" for name in ("2_4", "3_1", "4_1", "4_2", "4_3", "starting_values", "averaging")]
COLUMNS = (
    "averaged_bins",
    "error",
    "K_sem_as_printed",
    "lowest_coherence",
    "lowest_coherence_Hz",
    "linear_coherence",
)
PRINTED = {"error": {"a": 1.2, "b": 1.5, "c": 1.9}, "SEM_K": {"a": 14.0, "b": 12.0, "c": 8.0}}

ANALYSIS = {"fit_band_hz": [1.0, 9.0], "lowpass_cutoff_hz": 20.0, "perturbation_period_s": 10.0}
SETTINGS = {"wristalyzer": {"analysis": ANALYSIS | {"averaged_bins": 5}}}
REPORTED = {
    "values": {"coherence_minimum": 0.8, "eigenfrequency_hz": 4.6},
    "tables": {
        "table_4_1": {
            "I": {"a": 0.015, "b": 0.015},
            "K": {"a": 10.012, "b": 9.967},
            "VAF_trial": {"a": 93.0, "b": 90.0},
        }
    },
}


def fit(spread=1e-8, modulus=(10.0, 5.0), samples=10240):
    """Fit of a trial: lowest coherence 0.9 at 4 Hz, a torque of 2 mN·m."""
    frequency = np.array([0.5, 2.0, 4.0, 8.0, 12.0, 24.0, 30.0])
    arrays = {
        "spectral-fit/frequency": frequency,
        "spectral-fit/coherence": np.array([0.1, 0.99, 0.9, 0.95, 0.2, 0.1, 0.1]),
        "tapered/frequency": frequency,
        "tapered/coherence": np.array([0.1, 0.99, 0.9, 0.95, 0.2, 0.1, 0.14]),
        "spectral-fit/parameters": np.array([0.01, 0.1, 10.0]),
        "other_bounds/parameters": np.array([[0.01, 0.1, 10.001], [0.01, 0.1, 8.0], [0.01, 0.2, 10.0]]),
        "many_starts/start": np.zeros((2, 3)),
        "tried/stiffness": np.array([10.0, 5.0]),
        "tried/smooth": np.full((2, 3), 10.0),
        "tried/modulus": np.array([[0.01, 0.1, K] for K in modulus]),
        "torque": np.tile([2e-3, -2e-3], (1536 + samples) // 2),
        "angle": np.tile([1e-4, -1e-4], (1536 + samples) // 2),
    }
    facts = {
        "many_starts_stiffness_spread_Nm_per_rad": spread,
        "many_starts_converged": 2,
        "converged": {"spectral-fit-modulus": False},
        "tried_modulus_cost": [2.0, 3.0],
        "tried_smooth_cost": [1.0, 1.0],
        "tried_modulus_vaf_percent": [50.0, 40.0],
        "kept_samples": [1536, 1536 + samples],
        "rate_hz": 256.0,
    }
    return SimpleNamespace(arrays=arrays, facts=facts)


def rows(**quantities):
    """Estimates of the trials a, b and c by ``estimator__quantity``."""
    found = []
    for name, values in quantities.items():
        estimator, quantity = name.split("__")
        for condition, value in zip("abc", values, strict=False):
            found.append((condition, "admittance", estimator.replace("_", "-"), quantity, value))
    columns = ["condition", "pathway", "estimator", "quantity", "value"]
    return pd.DataFrame(found, columns=columns).assign(
        experiment="wristalyzer", unit="1", ci_low="", ci_high="", flags=""
    )


USUAL = {
    "spectral_fit__I": (0.01, 0.01, 0.01),
    "spectral_fit__B": (0.1, 0.102, 0.1),
    "spectral_fit__K": (10.0, 10.5, 11.0),
    "spectral_fit__VAF_trial": (94.0, 95.0, 93.0),
    "spectral_fit__VAF_cross_validated": (84.0, 85.0, 83.0),
    "spectral_fit_modulus__VAF_trial": (40.0, 50.0, 45.0),
    "spectral_fit_periods__B": (0.1, 0.1, 0.1),
}
CONTRARY = USUAL | {
    "spectral_fit__K": (10.0, -10.5, 11.0),
    "spectral_fit__VAF_trial": (96.0, 50.0, 30.0),
    "spectral_fit__VAF_cross_validated": (84.0, np.nan, 83.0),
    "spectral_fit_modulus__VAF_trial": (95.0, 50.0, 45.0),
    "spectral_fit_periods__B": (0.1, 0.1, 0.05),
}


def run_of(estimates, made=("a",), **changes):
    fits = {"wristalyzer": {condition: fit(**changes) for condition in "abc"}}
    study = {"best": "b", "start_stiffness": 10.0, "made": {"wristalyzer": list(made)}, "reported": REPORTED}
    study |= {"title": "t", "recordings_source": None, "experiments": {"wristalyzer": list("abc")}}
    return Run({"estimates": rows(**estimates)}, fits, SETTINGS, study)


def usual(**changes):
    return run_of(USUAL, **changes)


def contrary():
    return run_of(CONTRARY, spread=5.0, modulus=(10.0, 10.0))


def swept(*rows, printed=PRINTED):
    """Usual run with rows of `COLUMNS`, the same for every trial, and printed errors and SEM."""
    run = usual()
    tables = [
        pd.DataFrame(rows, columns=COLUMNS).assign(condition=condition, K_Nm_per_rad=10.0)
        for condition in "abc"
    ]
    reported = REPORTED | {"tables": {"table_4_1": REPORTED["tables"]["table_4_1"] | printed}}
    tables = run.tables | {"averaging": pd.concat(tables, ignore_index=True)}
    return Run(tables, run.fits, run.settings, run.study | {"reported": reported})


# natural frequency: 5.2 Hz; printed coherence: 0.8
FEW, MANY = (4, 1.4, 2.0, 0.5, 3.0, 0.98), (64, 0.01, 3.0, 0.82, 5.0, 0.83)
BOTH = (16, 1.5, 9.0, 0.81, 3.0, 0.97)  # gives the printed error and coherence, and a SEM as large
RISING = PRINTED | {"SEM_K": {"a": 8.0, "b": 12.0, "c": 14.0}}


def test_no_number_of_averaged_frequencies_gives_printed_error_and_coherence():
    run = swept((1, 100.0, 3.0, 1.0, np.nan, 1.0), FEW, MANY)
    assert wristalyzer.numbers(run)["nearest_bins"] == {"error": 4, "coherence": 64}
    held = truth(run)
    assert held["swept"] and held["bins_disagree"] and held["averaging_dips"]
    assert held["sem_not_from_bins"] and held["printed_sem_falls"]


def test_a_number_that_gives_both_or_a_sem_as_large_as_printed_ends_the_sentence():
    held = truth(swept(FEW, BOTH))
    assert held["swept"] and not held["bins_disagree"]
    assert not held["averaging_dips"] and not held["sem_not_from_bins"]
    assert not truth(swept(FEW, printed=RISING))["printed_sem_falls"]


def test_averaged_frequencies_are_compared_with_the_thesis_only_if_it_prints_them():
    assert not any(
        truth(usual())[name] for name in ("swept", "bins_disagree", "sem_not_from_bins", "averaging_dips")
    )
    assert not truth(swept(FEW, MANY, printed={}))["swept"]
    places, run = ["figure_averaged_bins"], swept(FEW, MANY)
    tables = {"averaging": run.tables["averaging"].to_csv(index=False)}
    found = findings_of(places, report_content(run, {"wristalyzer": wristalyzer}), tables)
    sentence = "No number of averaged frequencies that we tried yields both the printed error and the printed"
    assert found == {"figure_averaged_bins": f"{sentence} coherence."}
    assert findings_of(places, report_content(usual(), {"wristalyzer": wristalyzer})) == {}
    run = swept(FEW, BOTH)
    tables = {"averaging": run.tables["averaging"].to_csv(index=False)}
    found = findings_of(places, report_content(run, {"wristalyzer": wristalyzer}), tables)
    assert found == {}


def truth(run):
    return {predicate.__name__: predicate(run) for predicate in wristalyzer.PREDICATES}


SENTENCES = (
    "one_minimum",
    "modulus_depends",
    "only_modulus_depends",
    "modulus_worse",
    "vaf_peaks",
    "last_vaf_above_thesis",
    "averages_alike",
)


@pytest.mark.parametrize("name", [*SENTENCES, "cross_validated", "resonant"])
def test_conditions_hold_in_a_usual_run_and_not_in_a_contrary_one(name):
    assert (truth(usual())[name], truth(contrary())[name]) == (True, False)


def test_nothing_is_compared_with_the_thesis_in_recorded_trials():
    assert truth(usual())["coherence_above_thesis"]
    recorded = truth(usual(made=()))
    assert not recorded["coherence_above_thesis"] and not recorded["last_vaf_above_thesis"]


@pytest.mark.parametrize(("samples", "leaks"), [(12288, True), (10240, False)])
def test_a_record_of_whole_periods_does_not_leak(samples, leaks):
    assert wristalyzer.leaks(usual(samples=samples)) is leaks


@pytest.mark.parametrize(("interval", "found"), [((0.1, 0.3), True), ((-0.1, 0.3), False), ((-2, -1), False)])
def test_friction_is_found_where_its_interval_is_above_zero(interval, found):
    row = {"experiment": "wristalyzer", "condition": "pooled", "quantity": "friction"}
    run = Run({"estimates": pd.DataFrame([row | dict(zip(("ci_low", "ci_high"), interval, strict=True))])})
    assert wristalyzer.friction_found(run) is found
    assert not wristalyzer.softens(run)


def test_loss_in_one_trial_counts_fits_whose_own_vaf_is_high():
    scores = np.array([[95.0, 90.0, 80.0], [90.0, 88.0, 85.0], [86.0, 50.0, 10.0]])
    assert wristalyzer._largest_loss(scores) == 15.0
    assert wristalyzer._largest_loss(scores[2:]) is None


def test_numbers_are_those_of_the_signals():
    numbers = wristalyzer.numbers(usual())
    losses = ("largest_loss_in_one_trial_percent", "printed_bounds_loss_in_one_trial_percent")
    assert numbers["other_bounds"] == {"fits": 9, "usual": 3, "kept": 0} | dict.fromkeys(
        losses
    )  # no fit has a high VAF
    assert (numbers["coherence"], numbers["coherence_at_Hz"]) == (0.9, 4.0)
    assert numbers["torque_rms_Nm"] == pytest.approx([2e-3] * 3)
    assert numbers["coherence_above_lowpass"] == pytest.approx(0.12)
    assert numbers["natural_frequency_Hz"] == pytest.approx(np.sqrt(1050.0) / 2 / np.pi)
    assert numbers["damping_shift_percent"] == pytest.approx(2.0)
    assert wristalyzer.numbers(contrary())["natural_frequency_Hz"] is None


def told(run):
    """First sentences of the captions, from the content that a run writes."""
    content = report_content(run, {"wristalyzer": wristalyzer})
    return findings_of(FIGURES, content, {"estimates": run.tables["estimates"].to_csv(index=False)})


def test_captions_tell_the_usual_findings_only_where_they_hold():
    found, other = told(usual()), told(contrary())
    assert set(found) == set(FIGURES)
    assert set(other) == {"figure_2_4", "figure_3_1", "figure_4_2"}
    assert found["figure_2_4"] == "The torque has an RMS of 2.0 mN·m, depending on the scale factor."
    assert "the mean coherence of the tapered estimate is 0.12." in found["figure_3_1"]
    assert found["figure_4_1"] == "The fitted joint has a natural frequency of 5.2 Hz."
    assert found["figure_4_2"].endswith("with a VAF of 93.0 to 95.0 % over the scale factors.")
    assert found["figure_4_3"].endswith("with a mean VAF of 83.0 to 85.0 %.")
    assert found["figure_averaging"].startswith("Both ways of averaging yield nearly the same")
    assert found["figure_averaging"].endswith("B differs by at most 2.0 %.")


def test_a_study_without_the_chapter_tells_nothing_of_it():
    assert findings_of(FIGURES, {}) == {}
    asked = ['holds("wristalyzer")', 'holds("wristalyzer.vaf_peaks")']
    assert evaluated(asked, "data.typ", {"chapters": {}}) == [False, False]


def test_raw_values_are_what_json_has():
    content = raw({"a": np.array([1.0, np.nan]), 2: (np.float64("inf"), np.bool_(True)), "b": {"c": None}})
    assert content == {"a": [1.0, None], "2": ["inf", True], "b": {"c": None}}
