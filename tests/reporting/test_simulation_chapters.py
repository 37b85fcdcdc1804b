"""Chapters on forward simulation and noise: conditions, numbers, and the sentences that they choose."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from typst_builders import STUDY, chapter_words, evaluated, findings_of

from tepsipe.experiments.forward.scores import engine_of
from tepsipe.io.result import Result
from tepsipe.reporting.chapters import noise, simulation
from tepsipe.reporting.run import Run, report_content

DASH, MINUS = "\N{EN DASH}", "\N{MINUS SIGN}"
SHOWN = {"4_7": "sine-0.1", "4_8": "sine-0.5-8s"}
JOINT = {"inertia_Nms2_per_rad": 0.015, "damping_Nms_per_rad": 0.1, "stiffness_Nm_per_rad": [10.0, 15.0]}
NOISE = {"table_snr_db": 20, "joint": JOINT, "draws": 6, "predicted_draws": 2}
NOISE |= {"table_estimators": ["as-printed", "recommended"]}


def content(run, **chapters):
    short = {"sine-0.1": "S1", "sine-0.2": "S2", "sine-0.5-8s": "S52"}
    own = report_content(run, chapters) | {"short_names": short, "cells": None}
    return own, {name: table.to_csv(index=False) for name, table in run.tables.items()}


# ---- forward simulation


CAPTIONS = {
    "every_condition": {
        "thesis-wristalyzer": {"I": 0.015, "B": 0.1, "K": 10},
        "thesis-without-handle": {"I": 0.007, "B": 0.1, "K": 10},
    },
    "captions": {"sine-0.5-8s": {"I": 0.061, "B": 0.0137, "K": 4.53}},
}
REPORTED = {
    "simulations": CAPTIONS,
    "tables": {"table_4_2": {"B": {"sine-0.5": -0.002}}},
    "slips": [{"quantity": "I", "printed": 0.614, "meant": 0.061}],
}


def simulated(scores, conditions=("sine-0.1", "sine-0.5-8s"), **study):
    """Run of forward simulations: set of parameters -> VAF of the angle and torque, and state."""
    rows = []
    for condition in conditions:
        for name, (angle, torque, state) in scores.items():
            for quantity, vaf in (("theta", angle), ("tau", torque), ("tau_consistent", angle)):
                row = {"condition": condition, "parameter_set": name, "quantity": quantity, "state": state}
                row["engine"] = engine_of(name, "mujoco")
                row["growth"] = GROWTH.get((name, condition), 1.0)
                rows.append(row | {"vaf_trial": vaf, "vaf_perturbation": vaf})
    study = STUDY | {"simulated": SHOWN, "step_s": 0.001, "engine": "mujoco", "reported": REPORTED, **study}
    return Run({"forward": pd.DataFrame(rows)}, study=study)


GROWTH = {("thesis-tep", "sine-0.1"): 4.2, ("thesis-tep", "sine-0.5-8s"): 1.6}
USUAL = {
    "wristalyzer": (90.0, 80.0, "settles"),
    "tep": (-2000.0, 90.0, "grows"),
    "corrected": (80.0, 5.0, "settles"),
}
CONTRARY = {
    "wristalyzer": (1.0, 2.0, "settles"),
    "tep": (99.0, 1.0, "settles"),
    "corrected": (2.0, 99.0, "settles"),
}


@pytest.mark.parametrize(
    ("scores", "best", "worst"),
    [(USUAL, "the Wristalyzer", "TEP-SIPE as printed"), (CONTRARY, "TEP-SIPE as printed", "the Wristalyzer")],
)
def test_captions_of_simulations_name_the_parameters_that_predict_best(scores, best, worst):
    names = [f"figure_{name}" for name in ("4_7", "4_8", "4_9", "4_10", "4_11", "b_13")]
    found = findings_of(names, *content(simulated(scores), simulation=simulation))
    assert set(found) == set(names)
    assert f"of {best} predict the angle best in 2 of 2 conditions" in found["figure_4_10"]
    assert f"the parameters of {best} predict the angle best" in found["figure_4_8"]
    assert "S52" in found["figure_4_8"] and f"and those of {worst} worst" in found["figure_4_7"]
    assert (f"below {MINUS}1000 %" in found["figure_4_7"]) is (scores is USUAL)


def test_trials_that_were_not_simulated_are_not_told():
    run = simulated({"tep": USUAL["tep"]}, conditions=["sine-0.2"])
    found = findings_of(
        [f"figure_{n}" for n in ("4_7", "4_8", "4_9", "b")], *content(run, simulation=simulation)
    )
    assert found == {}


def test_pattern_of_the_thesis_holds_only_in_every_condition():
    assert simulation.pattern_of_thesis(simulated(USUAL))
    assert not simulation.pattern_of_thesis(simulated(CONTRARY))
    assert simulation.printed_swing_grows(simulated(USUAL))
    assert not simulation.printed_swing_grows(simulated(CONTRARY))


def test_chapter_names_the_conditions_that_the_consistent_parameters_predict_best():
    scores = USUAL | {"corrected": (95.0, 5.0, "settles")}
    told = chapter_words("simulation", *content(simulated(scores), simulation=simulation))
    assert "dataset best in 2 of 2 conditions (S1, S52)." in told
    assert "one K is not enough" not in told
    assert "the swing grows in S1 and S52" in told
    other = chapter_words("simulation", *content(simulated(CONTRARY), simulation=simulation))
    assert "in 0 of 2 conditions." in other
    assert "show the same pattern over the full dataset" in told and "show the same pattern" not in other
    assert "small swings do not settle" in told and "small swings do not settle" not in other


# numbers of the thesis: Wristalyzer, the same without the handle, TEP-SIPE; and the recommended estimate
OF_THESIS = {
    "thesis-wristalyzer": (80.0, 30.0, "settles"),
    "thesis-without-handle": (90.0, 20.0, "settles"),
    "thesis-tep": (-300.0, 85.0, "settles"),
    "joint-likelihood": (99.9, 10.0, "settles"),
}


def swung(pulses, interval_s, last):
    """Arrays of a swing that grows to 4.2 times its first size in the middle of a trial, at 10 Hz."""
    starts = np.arange(pulses) * round(10 * interval_s)
    sizes = np.interp(np.arange(pulses), [0, pulses // 2, pulses - 1], [0.01, 0.042, 0.01 * last])
    theta = np.repeat(sizes, round(10 * interval_s)) * np.array([1.0, -0.5] * round(5 * interval_s) * pulses)
    windows = np.column_stack([starts, starts + 1])
    return {"windows": windows, "thesis-tep/theta": theta, "time": np.arange(theta.size) / 10.0}


def of_thesis(scores, last=1.3):
    """Run with numbers of the thesis, whose swing has 1.363 s: a pulse every 4 s, and every 8 s."""
    run = simulated(USUAL | scores)
    fits = {}
    for condition, interval, pulses in (("sine-0.1", 4.0, 14), ("sine-0.5-8s", 8.0, 7)):
        facts = {"periods_s": {"thesis-tep": 1.363}, "pulse_interval_s": interval, "measured_growth": 1.0}
        facts["engine_differences"] = None
        fits[condition] = Result(swung(pulses, interval, last), {}, facts)
    return replace(run, fits={"simulation": fits})


def altered(**changed):
    """The same run with other growth or state of the thesis's TEP-SIPE, or VAF of the angle (%) by set."""
    run = of_thesis(OF_THESIS)
    table = run.tables["forward"].copy()
    for name, value in changed.items():
        if name == "growth":
            for condition, growth in value.items():
                table.loc[(table.parameter_set == "thesis-tep") & (table.condition == condition), name] = (
                    growth
                )
        elif name == "state":
            table.loc[table.parameter_set == "thesis-tep", "state"] = value
        else:
            table.loc[(table.parameter_set == name) & (table.quantity == "theta"), "vaf_trial"] = value
    return replace(run, tables={"forward": table})


def beyond_the_limit(state):
    """The swing of the thesis's TEP-SIPE exceeds the limit of equal pulses, and then grows or settles."""
    run = of_thesis(OF_THESIS | {"thesis-tep": (-300.0, 85.0, state)})
    run.fits["simulation"]["sine-0.1"].facts["periods_s"]["thesis-tep"] = 4.0 / 2.5  # limit 1
    return run


def test_growth_is_explained_by_near_resonance():
    run = of_thesis(OF_THESIS)
    often, rarely = simulation.numbers(run)["swings"]
    assert often["periods"] == pytest.approx(2.9347, abs=1e-3)
    assert often["limit"] == pytest.approx(4.91, abs=0.02)  # 1 / sin(11.75 degrees)
    assert rarely["limit"] == pytest.approx(1.0 / np.sin(np.radians(2 * 11.75)), rel=0.01)
    told = chapter_words("simulation", *content(run, simulation=simulation))
    assert "the swing grows to 4.2 times the first one in S1 and to 1.6 times in S52" in told
    assert "is 2.93 periods" in told and "0.41 rad out of phase" in told
    assert "near-resonance" in told
    assert "In S1 this growth is a beat, not a lasting amplification." in told
    assert "largest after the pulse at 28 s, and after the last pulse it is 1.3 times the first one" in told
    (found,) = findings_of(["figure_b"], *content(run, simulation=simulation)).values()
    assert found.endswith("It fades again in S1.")
    assert "the swing grows to 4.2 times the first one in S1, and to 1.6 times in S52" in found


def test_growth_to_the_end_of_a_trial_is_no_beat():
    assert simulation.growth_is_a_beat(of_thesis(OF_THESIS))
    lasting = of_thesis(OF_THESIS, last=4.1)
    assert not simulation.growth_is_a_beat(lasting)
    told = chapter_words("simulation", *content(lasting, simulation=simulation))
    assert "beat" not in told and "cancel later" not in told
    run = of_thesis(OF_THESIS)
    run.fits["simulation"]["sine-0.1"].arrays["thesis-tep/theta"][-50:] = np.nan  # the leg falls
    assert simulation.numbers(run)["swings"][0]["last"] is None
    assert not simulation.growth_is_a_beat(run)


def test_match_of_the_angle_is_told_with_its_error_and_beside_that_of_the_run():
    """By hand: a VAF of 80 % that is not centred leaves sqrt(0.2) of the RMS, one of 90 % sqrt(0.1)."""
    told = chapter_words("simulation", *content(of_thesis(OF_THESIS), simulation=simulation))
    assert "The median, 80 %, corresponds to an RMS error of 45 % of the RMS angle." in told
    assert "this run itself estimates, the VAF is 90 % (median 90 %)" in told


def test_chapter_names_the_engine_of_every_set_and_how_much_engines_differ():
    run = of_thesis(OF_THESIS)
    told = chapter_words("simulation", *content(run, simulation=simulation))
    assert "Some sets of parameters are simulated with the multi-body engine MuJoCo, and the others" in told
    assert "in both ways" not in told
    run.fits["simulation"]["sine-0.5-8s"].facts["engine_differences"] = {
        "theta_percent": 0.0123,
        "tau_percent": 0.25,
        "vaf_points": 0.0071,
    }
    data, tables = content(run, simulation=simulation)
    told = chapter_words("simulation", data, tables, cells=" | ")
    assert "In S52 we simulated every set in both ways: they differ by at most 0.012 %" in told
    assert "0.25 % of its largest torque, and 0.0071 percentage points" in told
    for label, engine in (("TEP-SIPE (thesis)", "MuJoCo"), ("joint likelihood", "equations")):
        assert re.search(rf"\| {re.escape(label)} \|[^|]*\| {engine}\b", told), label
    run.tables["forward"]["engine"] = "equations"
    told = chapter_words("simulation", *content(run, simulation=simulation))
    assert "The dummy is simulated with a Runge-Kutta method for its equations of motion." in told
    assert "MuJoCo" not in told


def test_chapter_tells_how_much_of_the_measured_force_the_simulation_and_the_treadmill_explain():
    """By hand: the plate adds 2 N to simulated 4 N, so 1 - (2/6)^2 of 6 N is simulated.

    The model finds 1.9 N of the 2 N and leaves 0.05^2 of the power.
    """
    run = of_thesis(OF_THESIS)
    assert not simulation.force_compared(run)
    forward = run.tables["forward"]
    rows = forward[forward.quantity == "theta"].assign(
        quantity="f_y", vaf_perturbation=100.0 * (1.0 - 1.0 / 9.0)
    )
    rows.loc[rows.parameter_set == "tep", "vaf_perturbation"] = 80.0
    run = replace(run, tables={"forward": pd.concat([forward, rows])})
    for fit in run.fits["simulation"].values():
        size = fit.arrays["time"].size
        fit.arrays.update({"f_y": np.full(size, 6.0), "joint-likelihood/f_y": np.full(size, 4.0)})
    told = chapter_words("simulation", *content(run, simulation=simulation))
    assert "with the parameters of the joint likelihood is 89 %, depending on the condition." in told
    (found,) = findings_of(["figure_4_9"], *content(run, simulation=simulation)).values()
    assert "The simulated force of the belt on the foot has a VAF of 89 %." in found
    assert "treadmill model" not in told
    size = run.fits["simulation"]["sine-0.5-8s"].arrays["time"].size
    loads = {"loads/Fy/measured": np.full(size, 6.0), "loads/Fy/best-frame": np.full(size, 4.1)}
    run = replace(run, fits=run.fits | {"foot": {"sine-0.5-8s": Result(loads, {}, {})}})
    assert simulation.numbers(run)["belt_induced_vaf"] == pytest.approx([99.75])
    told = chapter_words("simulation", *content(run, simulation=simulation))
    assert "explains 99.8 % of the belt-induced force (VAF)." in told


def test_pulses_in_resonance_add_up_to_their_number():
    run = of_thesis(OF_THESIS)
    run.fits["simulation"]["sine-0.1"].facts["periods_s"]["thesis-tep"] = 1.0
    assert simulation.numbers(run)["swings"][0]["limit"] == 14
    run.fits["simulation"]["sine-0.1"].facts["periods_s"]["thesis-tep"] = None  # it does not swing
    assert [entry["condition"] for entry in simulation.numbers(run)["swings"]] == ["sine-0.5-8s"]


@pytest.mark.parametrize(
    ("changed", "gone"),
    [
        ({"growth": {"sine-0.1": 1.5}}, "near-resonance"),
        ({"state": "grows"}, "near-resonance"),
        ({"thesis-without-handle": 70.0}, "the VAF is higher than with the printed parameters"),
        ({"joint-likelihood": 85.0}, "predicts the angle best in every condition"),
        ({"thesis-wristalyzer": -400.0}, "As the thesis reports, its parameters"),
    ],
)
def test_sentences_on_numbers_of_the_thesis_go_with_the_table(changed, gone):
    usual = of_thesis(OF_THESIS)
    assert gone in chapter_words("simulation", *content(usual, simulation=simulation))
    told = chapter_words("simulation", *content(altered(**changed), simulation=simulation))
    assert gone not in told


def test_growth_beyond_the_limit_is_ascribed_to_damping_only_if_the_leg_is_unstable():
    run = beyond_the_limit("grows")
    told = chapter_words("simulation", *content(run, simulation=simulation))
    assert "In S1 the swing exceeds the limit" in told
    assert not simulation.excess_by_negative_damping(beyond_the_limit("settles"))


# ---- sensitivity to noise


def noisy(level=20, spread=0.0, **means):
    """Mean K at one noise level by estimator and noisy signal; B without error, the apparent K 6."""
    rows, without = [], {"tau": 3.1, "theta": 8.9, "both": 6.0}
    for estimator, of_signal in means.items():
        for noise_on, value in zip(("tau", "theta", "both"), of_signal, strict=True):
            own = {"condition": "sine-0.1", "estimator": estimator.replace("_", "-"), "noise_on": noise_on}
            own |= {"snr_db": level, "stiffness_Nm_per_rad": 10.0, "sd": spread}
            own |= {"without_noise": without[noise_on]}
            rows.append(own | {"quantity": "K", "mean": value, "apparent": 6.0})
            rows.append(own | {"quantity": "B", "mean": 0.1, "apparent": 0.1})
            rows.append(own | {"quantity": "I", "mean": 0.015, "apparent": 0.04})
    return Run({"noise": pd.DataFrame(rows), "table_4_4": TABLE}, settings={"noise": NOISE}, study=STUDY)


def table(*rows):
    """Table 4-4 without and with noise on the torque."""
    columns = ["pathway", "estimator", "quantity", "unit", "none", "tau", "none_reported", "tau_reported"]
    frame = pd.DataFrame(rows, columns=columns)
    empty = ("theta", "both", "theta_reported", "both_reported")
    return frame.assign(**dict.fromkeys(empty, float("nan")))


WITHOUT = [
    ("as-printed", "K = 10 Nm/rad", "K", "Nm/rad", 3.66, None, 10.0, 2.963),
    ("as-printed", "K = 15 Nm/rad", "K", "Nm/rad", 8.0, None, 10.0, 2.963),
    ("recommended", "K = 10 Nm/rad", "K", "Nm/rad", 10.0, 9.99, 10.0, 2.963),
    ("recommended", "K = 15 Nm/rad", "K", "Nm/rad", 15.0, 15.01, 10.0, 2.963),
]
TABLE = table(*WITHOUT)
TRUE_K = {
    "as_printed": (3.0, 9.0, 6.1),
    "recommended": (10.0, 10.1, 10.1),
    "recommended_regression": (10.0, 8.0, 8.0),
}
FALSE_K = {
    "as_printed": (10.0, 10.0, 10.0),
    "recommended": (20.0, 20.0, 20.0),
    "recommended_regression": (10.0, 10.0, 10.0),
}
SENTENCES = ("method_sound", "filter_dominates")


def test_noise_is_told_as_in_the_thesis_only_where_it_is_so():
    usual, contrary = noisy(**TRUE_K), noisy(**FALSE_K)
    for name in SENTENCES:
        assert (getattr(noise, name)(usual), getattr(noise, name)(contrary)) == (True, False), name
    told = chapter_words("noise", *content(usual, noise=noise))
    assert "is at most 1.0 % with the IV estimate and 20.0 % with least squares" in told
    assert "are off by at most 1.0 % with the IV estimate and 20.0 % with least squares" in told
    assert "only one side is filtered, and K differs from the apparent K by up to 50 %" in told
    other = chapter_words("noise", *content(contrary, noise=noise))
    for sentence in ("the filter has a larger effect", "more likely due to its torque equation"):
        assert sentence in told and sentence not in other, sentence


def test_an_estimator_that_was_not_computed_proves_nothing():
    run = noisy(as_printed=(3.0, 9.0, 6.1))
    assert not noise.method_sound(run)
    assert f"is at most {DASH} % with the IV estimate" in chapter_words("noise", *content(run, noise=noise))


def test_error_of_an_estimate_contains_its_scatter_over_the_draws():
    few, many = noisy(**TRUE_K), noisy(spread=0.6, **TRUE_K)
    errors = [noise.numbers(run)["largest_rms_percent"]["instruments"] for run in (few, many)]
    # B of 0.1 without error, and its standard deviation of 0.6
    assert errors == pytest.approx([1.0, 600.0])
    assert noise.numbers(few)["largest_error_percent"] == noise.numbers(many)["largest_error_percent"]
    assert noise.method_sound(few) and not noise.method_sound(many)


def test_numbers_of_other_noise_levels_do_not_count():
    run = noisy(**TRUE_K)
    other = noisy(level=0, **FALSE_K).tables["noise"]
    both = Run(
        run.tables | {"noise": pd.concat([run.tables["noise"], other])}, settings=run.settings, study=STUDY
    )
    errors = [noise.numbers(r)["largest_error_percent"] for r in (run, both)]
    assert errors[0] == errors[1]
    assert [noise.numbers(r)["combinations"] for r in (run, both)] == [9, 18]
    means = ['means("as-printed", "tau", "K")']
    assert evaluated(means, "noise_values.typ", *content(both, noise=noise)) == [["3.00", "70"]]


def test_table_of_the_noise_study_has_a_group_of_columns_for_each_processing():
    data, tables = content(noisy(**TRUE_K), noise=noise)
    words = chapter_words("noise", data, tables, cells=" | ")
    empty = f"{DASH} | {DASH} |"
    # of the thesis, then of the printed processing; K = 15 N·m/rad is in the figure only
    assert f"| K | N·m/rad | 10 | 2.963 | {empty} 3.66 | {DASH} | {empty}" in words
    head = "consistent, IV | | | Noise on | | none | τ | θ | both | | | | | |"
    assert f"{head} K | N·m/rad | 10.00 | 9.99 | {empty}" in words
    assert "8.00" not in words and "15.01" not in words


def test_caption_has_the_stiffness_of_the_figure_if_both_processings_were_computed():
    run = noisy(**TRUE_K)
    assert not noise.figure_has_both(run)  # nothing was computed with noise by the printed processing
    assert findings_of(["figure_4_12"], *content(run, noise=noise)) == {}
    rows = [row for row in WITHOUT if row[:2] != ("as-printed", "K = 15 Nm/rad")]
    rows.append(("as-printed", "K = 15 Nm/rad", "K", "Nm/rad", 8.0, -2.19, 10.0, 2.963))
    both = Run(run.tables | {"table_4_4": table(*rows)}, settings=run.settings, study=STUDY)
    (told,) = findings_of(["figure_4_12"], *content(both, noise=noise)).values()
    assert f"yields a mean K of {MINUS}2.2 N·m/rad, and the consistent IV estimate a mean of 15.0" in told


@pytest.mark.parametrize("usual", [True, False])
def test_caption_of_usable_noise_levels_needs_a_sound_method(usual):
    run = noisy(**(TRUE_K if usual else FALSE_K))
    found = findings_of(["figure_noise"], *content(run, noise=noise))
    assert set(found) == ({"figure_noise"} if usual else set())
    assert not usual or "consistent IV estimate is at most 1.0 %." in found["figure_noise"]
