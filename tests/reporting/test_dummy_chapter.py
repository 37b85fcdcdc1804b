"""Conditions and numbers of the ankle dummy's chapter, and the sentences that they choose."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from typst_builders import MARK, STUDY, chapter_words, evaluated, findings_of

from tepsipe.reporting.chapters import dummy, thesis_dummy
from tepsipe.reporting.run import Run, report_content

LIKELY, SIMULATED = "leg-joint-likelihood", "leg-output-error"
ESTIMATORS = {
    "leg-thesis": "least-squares",
    "leg": "least-squares",
    LIKELY: "joint-likelihood",
    SIMULATED: "output-error",
}
SETTINGS = {
    "dummy": {
        "as_printed": "leg-thesis",
        "recommended": "leg",
        "pathways": {
            name: {"torque": name, "marker_instants": "aligned", "estimator": estimator}
            for name, estimator in ESTIMATORS.items()
        },
        "geometry": {
            "leg_mass_kg": 0.4,
            "leg_com_m": 0.5,
            "leg_inertia_kgm2": 0.03,
            "gravity_m_per_s2": 10.0,
        },
        "ingest": {"marker_sampling_hz": 2500.0},
        "files": {"marker_labels": ["a", "b"]},
        "analysis": {"lowpass_cutoff_hz": 20.0},
    }
}
AMPLITUDES = {"a": 0.1, "b": 0.3, "c": 0.5}
TIME = np.arange(0.0, 2.0, 0.004)
COMMAND = -np.sin(2.0 * np.pi * (TIME - 1.0) / 0.1) * (np.abs(TIME - 1.05) < 0.05)
PRINTED_K = {"a": 6.7, "b": 5.9, "c": 4.5}
REPORTED = {
    "values": {"marker_accuracy_mm": 0.1},
    "slips": [{"table": "table_4_2", "quantity": "K", "condition": "b", "printed": 55.0, "meant": 5.5}],
    "tables": {
        "table_4_1": {"I": {"0.08": 0.015, "0.12": 0.015}},
        "table_4_2": {
            "I": {"a": 0.061},
            "B": {"a": -0.01, "b": -0.02},
            "K": {"a": 6.0, "b": 55.0},
            "SEM_I": {"a": 1e-4},
            "SEM_B": {"a": 0.004},
            "SEM_K": {"a": 0.2},
            "VAF_trial": {"a": 99.5},
        },
        "table_4_3": {
            "I": {"c": 0.063},
            "B": {"c": 0.01},
            "K": {"c": 5.0},
            "SEM_I": {"c": 2e-4},
            "SEM_B": {"c": 0.012},
            "SEM_K": {"c": 0.7},
            "VAF_trial": {"c": 99.9},
        },
    },
}


def fit(command=COMMAND, delay=0, consistent=1.0):
    arrays = {
        "time": TIME,
        "belt_velocity": 0.8 * np.roll(COMMAND, delay),
        "belt_command": command,
        "windows": np.array([[250, 280], [400, 430]]),
        "leg-thesis/torque": np.array([-1.0, 1.0]),
        "leg/torque": np.array([-0.1, 0.1]) * consistent,
    }
    facts = {
        "mean_window_s": 0.12,
        "marker_noise_m": 6e-6,
        "marker_residual_rms_m": 2e-4,
        "damping_per_com_lag_Nms_per_rad_per_s": {"leg-thesis": 79.0},
        "output_error_delay_s": {SIMULATED: -2e-4},
    }
    return SimpleNamespace(arrays=arrays, facts=facts)


def rows(**changes):
    """Estimates of the trials by pathway and quantity, those of ``changes`` by ``pathway__quantity``."""
    of_trials = {
        "leg-thesis__I": 0.067, "leg-thesis__K": PRINTED_K, "leg-thesis__B": 0.03,
        "leg-thesis__VAF_perturbation": {"a": 99.91, "b": 99.95, "c": 99.99},
        "leg-thesis__VAF_trial": {"a": 90.0, "b": 95.0, "c": 99.0},
        "leg-thesis__VAF_cross_validated": {"a": 97.0, "b": 97.5, "c": 98.0},
        "leg__I": 0.007, "leg__B": 0.03, "leg__K": {"a": 10.7, "b": 9.9, "c": 8.5},
        "leg__VAF_perturbation": 99.1, f"{SIMULATED}__VAF_theta_trial": 99.9,
        f"{SIMULATED}__I": 0.007, f"{SIMULATED}__B": 0.02, f"{SIMULATED}__K": 10.3,
        f"{LIKELY}__I": 0.007, f"{LIKELY}__B": 0.03, f"{LIKELY}__K": 9.6, f"{LIKELY}__B_small": 0.02,
        f"{LIKELY}__K_small": 10.3, f"{LIKELY}__delay": -2e-5, f"{LIKELY}__K_softened": 1.5,
    } | changes  # fmt: skip
    found = []
    for name, values in of_trials.items():
        pathway, _, quantity = name.partition("__")
        for k, condition in enumerate(AMPLITUDES):
            value = values[condition] if isinstance(values, dict) else values
            found.append(
                (condition, pathway, ESTIMATORS[pathway], quantity, value, value - 0.006, 0.01 + 0.01 * k)
            )
    columns = ["condition", "pathway", "estimator", "quantity", "value", "ci_low", "u_type_a"]
    return pd.DataFrame(found, columns=columns).assign(experiment="dummy", sem_as_printed=2.5, flags="")


def recovered(*errors, truth_of="the fitted windows"):
    """Recovered I, B, K of every trial: pathway, quantity, relative error, covered."""
    found = [
        (condition, *error, 10.0, 10.0 * (1.0 + error[2]), truth_of)
        for condition in AMPLITUDES
        for error in errors
    ]
    columns = ["condition", "pathway", "quantity", "relative_error", "covered", "truth", "value", "truth_of"]
    return pd.DataFrame(found, columns=columns).assign(experiment="dummy")


OF_LEG = [("leg", quantity, 0.02, "true") for quantity in "IBK"]
CURVE = pd.DataFrame(
    [
        ("leg", "all signals", "windowed-least-squares", "recommended", 10.0, 99.5),
        ("leg", "torque only", "windowed-least-squares", "", 10.4, 99.9),
        ("leg", "motion only", "windowed-least-squares", "", 14.0, 99.9),
        ("leg", "none", "windowed-least-squares", "", 10.0, 80.0),
        ("leg-thesis", "all signals", "windowed-least-squares-thesis", "as printed", 6.0, 99.9),
        ("foot", "all signals", "windowed-least-squares", "", 20.0, 70.0),
        ("foot", "all signals", "windowed-least-squares-thesis", "", -20.0, 70.0),
        ("none", "all signals", "output-error", "", 10.2, 50.0),
    ],
    columns=["torque", "filtered", "estimator", "role", "K_Nm_per_rad", "VAF_percent"],
).assign(condition="b", B_Nms_per_rad=0.1)  # fmt: skip


def run_of(estimates=None, recovery=None, reported=REPORTED, amplitudes=AMPLITUDES, curve=CURVE, **changes):
    tables = {"estimates": rows() if estimates is None else estimates, "specification": curve}
    if recovery is not None:
        tables["recovery"] = recovery
    study = STUDY | {"amplitudes": amplitudes, "reported": reported, "start_stiffness": 10.0}
    return Run(tables, {"dummy": {name: fit(**changes) for name in AMPLITUDES}}, SETTINGS, study)


def content(run, **further):
    own = report_content(run, {"dummy": dummy}) | {"budgets": {}, "slips": {}, "cells": None} | further
    return own, {name: table.to_csv(index=False) for name, table in run.tables.items()}


def told(run, *places):
    """Sentences of a place of the findings."""
    asked = [f'told("{place}").map(plain).join(" ")' for place in places]
    return [" ".join((text or "").split()) for text in evaluated(asked, "findings.typ", *content(run))]


USUAL = {
    "recovery": recovered(*OF_LEG, (SIMULATED, "K", 0.02, "true"), (LIKELY, "K", 0.015, "true")),
    "reported": REPORTED,
}
CONTRARY = {
    "estimates": rows(
        **{
            "leg__I": 0.0,
            "leg__VAF_perturbation": 99.999,
            "leg-thesis__K": 30.0,
            "leg-thesis__VAF_cross_validated": {"a": 10.0, "b": 50.0, "c": 90.0},
        }
    ),
    "recovery": recovered(*OF_LEG, (SIMULATED, "K", 0.02, "false"), truth_of="small movements"),
    "curve": CURVE.assign(role="", K_Nm_per_rad=CURVE.K_Nm_per_rad.abs()),
    "consistent": 9.0,
    "command": 0.0 * COMMAND,
    "reported": None,
}


@pytest.mark.parametrize("predicate", dummy.PREDICATES)
def test_conditions_hold_in_a_usual_run_and_not_in_a_contrary_one(predicate):
    assert (predicate(run_of(**USUAL)), predicate(run_of(**CONTRARY))) == (True, False)


@pytest.mark.parametrize(("crossed", "holds"), [((97.0, 97.0, 98.0), True), ((60.0, 97.0, 98.0), False)])
def test_vaf_depends_on_the_trial_only_if_parameters_matter_less(crossed, holds):
    own = rows(**{"leg-thesis__VAF_cross_validated": dict(zip(AMPLITUDES, crossed, strict=True))})
    assert dummy.vaf_of_trial(run_of(own)) is holds
    assert dummy.vaf_of_trial(run_of(own[own.quantity != "VAF_cross_validated"])) is False


@pytest.mark.parametrize(
    ("amplitudes", "falls", "clear"),
    [
        (AMPLITUDES, True, ["0.3", 2, " for pulses of 0.3 m/s and above"]),
        ({"a": 0.1, "b": 0.2, "c": 0.2}, True, ["0.1", 3, " for pulses of 0.1 m/s and above"]),
        (dict.fromkeys("abc", 0.5), False, ["0.5", 3, " for pulses of 0.5 m/s and above"]),
        (dict.fromkeys("abc"), False, [None, 3, None]),
    ],
)
def test_velocities_are_those_of_the_trial_sheet(amplitudes, falls, clear):
    run = run_of(amplitudes=amplitudes)
    assert dummy.stiffness_falls(run) is falls
    asked = ["clear-from()", "clear().len()", "at-clear()"]
    assert evaluated(asked, "dummy_values.typ", *content(run)) == clear


@pytest.mark.parametrize("delay", [0, 5])
def test_caption_of_the_pulses_measures_peak_and_delay_of_the_belt(delay):
    run = run_of(delay=delay)
    numbers = dummy.numbers(run)
    assert numbers["belt_peak_percent"] == pytest.approx([80.0] * 3)
    assert numbers["belt_delay_ms"] == pytest.approx([4.0 * delay] * 3)
    assert "reaches 80 % of the commanded peak velocity" in told(run, "figure_2_9")[0]
    still = run_of(command=0.0 * COMMAND)
    assert not dummy.commanded(still) and dummy.numbers(still)["belt_peak_percent"] == []


FIGURES = [
    f"figure_{name}"
    for name in (
        "2_9",
        "3_3",
        "4_4",
        "pathways",
        "torque",
        "dummy_cross_validation",
        "specification",
        "protocol",
    )
]


def test_captions_tell_the_usual_findings_only_where_they_hold():
    found, other = (findings_of(FIGURES, *content(run_of(**case))) for case in (USUAL, CONTRARY))
    assert set(found) == set(FIGURES)
    assert set(other) == {"figure_3_3", "figure_protocol"}
    assert "more on the predicted trial" in found["figure_dummy_cross_validation"]
    assert found["figure_4_4"] == (
        "The printed equation yields K = 4.50 to 6.70 N·m/rad and I = 0.0670 N·m·s²/rad. "
        "K is lower at the largest amplitude than at the smallest."
    )
    (struck,) = findings_of(["figure_4_4"], *content(run_of(**CONTRARY)), struck=True).values()
    assert struck.startswith(
        "The printed equation yields K = 30.0 N·m/rad and I = 0.0670 N·m·s²/rad. K is lower"
    )
    assert struck.endswith(MARK)
    both = (
        "a mean K of 9.20 N·m/rad and the printed equation a mean K of 5.20 N·m/rad "
        "for pulses of 0.3 m/s and above."
    )
    assert both in found["figure_pathways"]
    assert found["figure_specification"] == (
        "K is within 5 % of the recommended 10.0 N·m/rad in 50 % of the 8 combinations of choices."
    )
    assert found["figure_protocol"] == (
        "The study has 3 trials. Each trial of the dummy on the treadmill has 2 perturbations."
    )


def test_conclusion_tells_the_error_of_markers_as_sampled_where_the_truth_is_known():
    """By hand: the mean B of the fast pulses is 0.5 where 10 is true."""
    sampled = pd.concat([recovered(*OF_LEG), recovered(("leg-thesis", "B", -0.95, "false"))])
    for recovery, told_error in ((sampled, True), (recovered(*OF_LEG), False)):
        data, tables = content(run_of(recovery=recovery, reported=REPORTED))
        pathways = data["choices"]["dummy"]["pathways"]
        pathways["leg-thesis"] = pathways["leg-thesis"] | {"marker_instants": "as-sampled"}
        (error,) = evaluated(["unaligned-error()"], "dummy_values.typ", data, tables)
        assert error == ("\N{MINUS SIGN}95" if told_error else None)


def test_chapter_tells_the_usual_story_only_where_it_holds():
    curve = CURVE.assign(K_Nm_per_rad=CURVE.K_Nm_per_rad.abs(), VAF_percent=50.0)
    contrary = CONTRARY | {"reported": REPORTED, "curve": curve}
    usual, contrary = (chapter_words("dummy", *content(run_of(**case))) for case in (USUAL, contrary))
    for sentence in (
        "In this run, too, K is lower at the largest amplitude.",
        "Every 95 % interval of I lies above zero",
        "the VAF of the consistent torque is lower than the VAF of the printed torque in every",
        "All errors of K have the same sign and nearly the same size",
        "The torque from the foot is not zero at rest",
        "predict the printed torque of the other trials with a mean VAF of 97.00 to 98.00 %",
        "4 combinations have a mean VAF above 99 %, and 2 of them deviate",
    ):
        assert sentence in usual and sentence not in contrary, sentence
    assert "; we read the misprints 55 (K of b) as" in usual
    for sentence in (
        "The thesis reports I = 0.061 to 0.063 N·m·s2/rad and K = 5.0 to 6.0 N·m/rad. Its K is lower",
        "If the thesis mixed the signs, this error explains most of the difference in mean K between",
    ):
        assert sentence in usual, sentence
    assert (
        "This run agrees: on the same recordings" in usual
        and "differ by 0.0600 N·m·s2/rad in I and by 4.00 N·m/rad in K" in usual
    )
    assert "The printed SEM of B is 0.40 to 1.2 times the size of B, the SEM of I is at most 0.0032" in usual
    assert "but not the error of a wrong joint law" in usual


def test_markers_that_are_sampled_one_after_another_have_a_section():
    pathways = SETTINGS["dummy"]["pathways"]
    raw = {"leg-thesis": pathways["leg-thesis"] | {"marker_instants": "as-sampled"}}
    raw["leg-thesis-aligned"] = pathways["leg-thesis"]
    own = rows()
    aligned = own[own.pathway == "leg-thesis"].assign(pathway="leg-thesis-aligned")
    aligned.loc[aligned.quantity == "B", "value"] = 0.04
    aligned.loc[aligned.quantity == "K", "value"] *= 1.25
    run = run_of(pd.concat([own, aligned]))
    changed = SETTINGS["dummy"] | {"pathways": pathways | raw, "ingest": {"marker_sampling_hz": 2500.0}}
    data, tables = content(run)
    words = chapter_words("dummy", data | {"choices": {"dummy": changed}}, tables)
    assert (
        "at 2500 Hz (the thesis states no rate), the last marker of a frame is sampled 0.40 ms after" in words
    )
    assert "is 0.040 N·m·s/rad if the markers" in words and "0.030 N·m·s/rad if they are not" in words
    assert "changes I by at most 0 % and K by at most 20 %" in words


# ---- joint likelihood


@pytest.mark.parametrize(("low", "softens"), [(1.5, "in all 3 trials"), (-0.5, "in 0 of the 3 trials")])
def test_softening_is_counted_from_its_interval(low, softens):
    words = chapter_words("dummy", *content(run_of(rows(**{f"{LIKELY}__K_softened": low}))))
    assert softens in words and "No trial failed a check." in words
    assert "The delay between foot and leg is at most 0.020 ms." in words


def test_failed_checks_and_missed_truths_are_named():
    own, likely = rows(), {"a": "markers-slip;lack-of-fit", "b": "lack-of-fit"}
    of_stiffness = (own.pathway == LIKELY) & (own.quantity == "K")
    own.loc[of_stiffness, "flags"] = own.condition.map(likely).fillna("")
    errors = [
        (LIKELY, q, error, "false") for q, error in (("I", 0.2), ("B", -0.05), ("K", 0.01), ("K_small", 0.5))
    ]
    recovery = recovered(*OF_LEG, (SIMULATED, "K", 0.02, "true"), *errors)
    words = chapter_words("dummy", *content(run_of(own, recovery)))
    assert "Checks that failed: markers-slip (a); lack-of-fit (a, b)." in words
    told = "is 1.0 % in K, 5.0 % in B and 20.0 % in I; none of the 9 intervals cover the true value"
    assert told in words


# ---- dummy that the printed tables describe


def law(predicted, **constants):
    known = {
        "stiffness_Nm_per_rad": 10.0,
        "damping_Nms_per_rad": 0.02,
        "inertia_Nms2_per_rad": 0.007,
    } | constants
    return {
        "constants": {"half_softening_rad": None, "softened_damping_Nms_per_rad": 0.0} | known,
        "intervals": {name: [0.5, 2.0] for name in known},
        "fitted_rms": 1.0,
        "predicted_rms": predicted,
    }


def lag(lag_s, damping, rms, score):
    scores = {"vaf_wristalyzer": score, "vaf_without_handle": score + 10.0}
    scores |= {"unexplained_percent": 0.05, "standard_error_damping": 0.012}
    return {"lag_s": lag_s, "damping_Nms_per_rad": damping, "rms": rms, "rms_damping": 0.005} | scores


TIMING = {
    "percussion_height_m": 0.638,
    "pulse_rate_per_s": 51.0,
    "shift_Nms_per_rad": -0.088,
    "simulated_shift_Nms_per_rad": -0.082,
    "shift_per_ankle_lag_Nms_per_rad_per_s": 299.0,
    "printed": {"unexplained_percent": 0.012, "standard_error_damping": 0.005},
    "numbers": 36,
    "lags": [
        lag(-1e-4, 0.0979, 1.02, 85.0),
        lag(0.0, 0.0687, 0.96, 82.0),
        lag(1e-4, 0.0396, 0.89, 72.0),
        lag(2e-4, 0.0105, 0.82, 50.0),
        lag(2.5e-4, 0.0, 1.0, 39.0),
    ],
}


def returned(best, **timing):
    """Run of the dummy that the printed tables describe, whose full law predicts best, or worst."""
    softening = law(0.8 if best else 3.0, half_softening_rad=0.02, softened_damping_Nms_per_rad=0.1)
    facts = {"laws": {"linear": law(2.0), "full": softening}, "marker_noise_m": 6.8e-6}
    facts["scatter"] = {"I": 5e-4, "B": 5e-3, "K": 0.3}
    facts |= {"null_rms": 1.0, "timing": TIMING | timing}
    cells = pd.DataFrame(
        [
            ("b", "I", "fitted", 0.061, 0.0609, "fitted", "implied"),
            ("b", "SEM_I", "predicted", 0.0008, 1.49e-4, "not reproduced", "not reproduced"),
            ("c", "SEM_K", "predicted", 0.5, 0.4, "interpretation", "implied"),
            ("c", "VAF_trial", "predicted", 99.94, 99.98, "not reproduced", "implied"),
        ],
        columns=["condition", "quantity", "role", "printed", "value", "verdict", "null_verdict"],
    )
    # the one verdict on a number is that of the whole laboratory
    judged = cells.rename(columns={"condition": "column", "quantity": "row", "printed": "reported"})
    judged = judged.drop(columns="role").assign(table="table_4_2", tolerance="1", reason="r", null_value=1.0)
    cells = cells.drop(columns=["verdict", "null_verdict"])
    run = run_of()
    return Run(
        run.tables | {"thesis_dummy": cells, "cells": judged},
        run.fits | {"thesis_dummy": {"thesis_dummy": SimpleNamespace(facts=facts, arrays={})}},
        run.settings,
        run.study,
    )


def returned_content(run):
    data, tables = content(run)
    data["chapters"] |= report_content(run, {"thesis_dummy": thesis_dummy})["chapters"]
    return data, tables


@pytest.mark.parametrize("best", [True, False])
def test_printed_numbers_are_counted_by_their_role(best):
    run = returned(best)
    assert thesis_dummy.full_law_predicts_best(run) is best
    data, tables = returned_content(run)
    words = chapter_words("thesis_dummy", data, tables, cells=" | ")
    assert "In this laboratory, 1 of the 1 fitted numbers are within their tolerance" in words
    assert "Of the 3 predicted numbers, 1 are within their tolerance" in words
    assert "compared with 2 for the null model" in words
    assert "| SEM of I, B and K | – | 1 of 2 (1) |" in words and "| K | – | – |" in words
    assert ("Among the laws, softening with losses" in words) is best
    # a copy of the other table is better than 2.0 and 3.0, and worse than 0.8
    assert thesis_dummy.copy_predicts_best(run) is not best
    assert ("No law predicts one table from the other better than this copy" in words) is not best
    assert "Copying the other table, without any dummy, gives a distance of 1.00." in words
    assert "@timing-shift gives −0.0880 N·m·s/rad" in words or "gives −0.0880 N·m·s/rad" in words
    assert "raises the B of the printed equation by 0.299 N·m·s/rad" in words
    assert "lags of the ankle from −0.10 to 0.25 ms relative to the markers of this laboratory" in words
    assert "It is smallest for a lag of 0.20 ms, where B is 0.011 N·m·s/rad." in words
    # chi^2 is 36 rms^2: 24.2 at the best lag, 3.84 more at 0.11 and 0.22 ms
    assert "the lag is 0.11 to 0.22 ms and B is 0.0071 to 0.036 N·m·s/rad." in words
    assert (
        "Without a lag, as in this laboratory, χ2 is 9.0 above its minimum" in words
        and "do not support this B" in words
    )
    # between lags of 0 and 0.1 ms, where the VAF is 82 and 72 %
    assert "Beyond a lag of 0.07" in words and "simulated angle is below 75 %" in words
    unmatched = returned(best, lags=[lag(0.0, 0.07, 1.0, 70.0), lag(1e-4, 0.04, 0.9, 60.0)])
    assert "Beyond a lag" not in chapter_words("thesis_dummy", *returned_content(unmatched))
    (caption,) = findings_of(["figure_thesis_dummy"], data, tables).values()
    assert caption == (
        "The fitted joint returns the printed I, B and K with a root mean square distance of 1.00 times the "
        "scatter that we assume for them."
    )
    # softening lowers K with amplitude
    stiffness = [own["K_Nm_per_rad"] for own in data["chapters"]["thesis_dummy"]["numbers"]["at_work"]]
    assert stiffness == sorted(stiffness, reverse=True) and stiffness[0] < 10.0


# ---- other laws of the joint


def under(law, condition, flags, *errors, pathway=LIKELY, recommended="false"):
    """Recovered I, B, K of one trial under another law: relative error and whether the interval covers."""
    columns = ["quantity", "relative_error", "covered"]
    found = pd.DataFrame([(q, *own) for q, own in zip("IBK", errors, strict=True)], columns=columns)
    own = {"law": law, "condition": condition, "flags": flags, "pathway": pathway}
    own["estimator"] = ESTIMATORS[pathway]
    return found.assign(**own, recommended=recommended, truth=10.0, value=10.0, experiment="dummy")


def test_errors_under_other_laws_stand_beside_those_of_the_shared_law():
    run = run_of(**USUAL)
    own = [
        under("power-law", "a", "", (0.03, "true"), (0.02, "true"), (-0.011, "true")),
        under("friction", "a", "lack-of-fit", (-0.5, "false"), (0.7, "false"), (0.2, "false")),
        under("friction", "c", "", (0.04, "true"), (0.05, "false"), (-0.01, "true")),
        under("friction", "a", "", *[(0.09, "true")] * 2, (0.08, "false"), pathway="leg", recommended="true"),
        under("friction", "c", "", *[(0.05, "true")] * 3, pathway="leg"),
    ]
    laws = Run(run.tables | {"other_laws": pd.concat(own)}, run.fits, run.settings, run.study)
    words = chapter_words("dummy", *content(laws), cells=";")
    assert (
        "The largest errors of the joint likelihood are then 20.0 % in K, 70.0 % in B and 50.0 % in I"
        in words
    )
    assert (
        "Checks flag 3 of the 4 estimates of I, B or K whose intervals miss the true value. In 1 of the 3"
        in words
    )
    assert (
        "because only this fit passes its checks there. Its error of K is 8.0 %. Of its 3 intervals, "
        "the interval of K misses the truth without a flag." in words
    )
    assert (
        "In the same trials its errors are at most 8.0 % in K, 9.0 % in B and 9.0 % in I, and 5 of its 6 "
        "intervals" in words
    )
    assert "With friction, half of the stiffness" in words and "With power law, the stiffness falls" in words
    row = words.partition("power law;")[2]
    assert row.startswith("a;10.0000;10.0000;3.0;10.0000;10.0000;2.0;10.000;10.000;−1.1;3 of 3;no;")
    # a law of one's own has no words
    custom = laws.tables["other_laws"].replace("power-law", "own-law")
    other = Run(laws.tables | {"other_laws": custom}, run.fits, run.settings, run.study)
    assert "All laws have" in words and "All laws have" not in chapter_words("dummy", *content(other))
    # without another law there is nothing to say
    none = Run(run.tables | {"other_laws": pd.concat(own)[:0]}, run.fits, run.settings, run.study)
    for alone in (run, none):
        assert "best case" not in chapter_words("dummy", *content(alone))
