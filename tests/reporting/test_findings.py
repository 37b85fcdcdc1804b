"""Table of the report's findings: a run in which each sentence holds, and one in which it does not.

A finding is a sentence that compares. Its predicate reads the tables and fits of a run; the sources of the
report ask for it by name. Predicates in `PRESENCE` only say that something is there.
"""

import copy
import importlib
import re
from functools import cache
from itertools import chain

import numpy as np
import pandas as pd
import pytest
from reporting import test_dummy_chapter as dummy
from reporting import test_simulation_chapters as simulations
from reporting import test_standing_chapter as standing
from reporting import test_study_chapter as study
from reporting import test_weight_chapter as weight
from reporting import test_wristalyzer_chapter as wristalyzer
from typst_builders import MARK, REPORT, STUDY, chapter_words, evaluated, parts_of

from tepsipe.io.result import Result
from tepsipe.reporting.chapters import noise, simulation
from tepsipe.reporting.run import Run, predicates_of, report_content
from workflow.support.outputs import CHAPTERS

# what a study has: rows, fits, trials or values of the thesis; each is tested with its chapter
PRESENCE = {
    "dummy": "commanded recommended_specified",
    "noise": "figure_has_both",
    "simulation": "thesis_simulated first_shown second_shown force_compared",
    "standing": "free_reflex",
    "weight": "frame_scored scored foot_pathways",
    "wristalyzer": "bins_tried swept cross_validated resonant pooled",
}


# ---- runs


def simulated(scores):
    return simulations.simulated(scores)


def table_4_4(theta, both, tabulated, thesis, without=10.0):
    """K of Table 4-4 with noise on the angle, by two processings, and as the thesis printed it."""
    rows = [
        ("as-printed", 4.0, theta, both),
        ("as-tabulated", -2.0, tabulated, tabulated),
    ]
    frame = pd.DataFrame(rows, columns=["pathway", "none", "theta", "both"]).assign(
        estimator="K = 10 Nm/rad",
        quantity="K",
        unit="Nm/rad",
        tau=3.0,
        none_reported=without,
        tau_reported=3.0,
    )
    return frame.assign(theta_reported=thesis, both_reported=thesis)


def noisy(means, *cells):
    """Run of the noise study with means of K, and with Table 4-4 if there are cells of it."""
    run = simulations.noisy(**means)
    return Run(run.tables | ({"table_4_4": table_4_4(*cells)} if cells else {}), {}, run.settings, run.study)


def planned(both=0.01, torque=(-16.0, 1.1, -30.0), late=(-116.0, 418.0, -140.0), pulses=(0.4, 0.4)):
    """Plan with changes (%) of I, B and K by filters, and ratios of the best pulses to the sine."""
    changes = {"zero-lag, torque only": torque, "one-sided, torque only": late}
    changes |= dict.fromkeys(("zero-lag, all signals", "one-sided, all signals"), (both,) * 3)
    rows = [
        (design, "leg", quantity, "change", value)
        for design, values in changes.items()
        for quantity, value in zip("IBK", values, strict=True)
    ]
    for design, ratio in zip(("best, belt returns", "best, one way"), pulses, strict=True):
        rows.append((design, "joint-likelihood", "K", "u_over_reference", ratio))
        rows.append((design, "joint-likelihood", "K", "least_bound_over_reference", 0.9))
    for design, pathway in (("sine-0.3", "leg"), ("minjerk-0.3", "leg"), ("sine-0.3", "foot")):
        rows += [(design, pathway, "K", measure, 0.1) for measure in ("u_type_a", "u_type_b")]
    columns = ["design", "pathway", "quantity", "measure", "value"]
    joint = {"inertia_Nms2_per_rad": 0.015, "damping_Nms_per_rad": 0.1, "stiffness_Nm_per_rad": [10.0]}
    return Run({"planned": pd.DataFrame(rows, columns=columns)}, study=STUDY | {"planned_joint": joint})


def stood(**changes):
    return standing.run_of(tasks={"calm": standing.task(**changes)})


def in_windows(without, free):
    """A task with K of two windows without and with a free reflex torque."""
    own = standing.task()
    own.arrays["windows/length"] = np.array([0.04, 0.08])
    own.arrays["windows/K"] = np.array(without)[:, None]
    own.arrays["budget/gls/windows"] = np.array([[0.04, 8.0, free[0]], [0.08, 8.0, free[1]]])
    return standing.run_of(tasks={"calm": own})


def damped(covered):
    """Recovered B of a task by the estimator with an active torque."""
    own = standing.recovered()
    row = own[own.quantity == "K"].assign(estimator="twitch", quantity="B", covered=covered)
    return standing.run_of(recovery=pd.concat([own, row]))


def sensed(inertia):
    """Run of the noise study with the joint's sensor, which finds an inertia with noise on the torque."""
    run = noisy(simulations.TRUE_K, 4.0, 4.0, 0.1, 0.03)
    rows = [
        ("I", 0.015, 0.015, inertia, 0.039),
        ("B", 0.1, 0.1, 0.1, 0.031),
        ("K", 10.0, 10.0, 10.0, 2.963),
    ]
    columns = ["quantity", "none", "none_reported", "tau", "tau_reported"]
    own = pd.DataFrame(rows, columns=columns).assign(pathway="joint-sensor", estimator="K = 10 Nm/rad")
    tables = run.tables | {"table_4_4": pd.concat([run.tables["table_4_4"], own])}
    return Run(tables, {}, run.settings, run.study)


def printed_torque(stiffness):
    rows = [row for row in standing.ESTIMATES if row[1] != "printed"]
    return standing.run_of(estimates=[*rows, ("calm", "printed", "short", "K", stiffness)])


def of_thesis(stiffness=(10.012, 10.0), eigenfrequency_hz=4.6):
    """Usual run of the Wristalyzer with other numbers in the thesis."""
    run, reported = wristalyzer.usual(), wristalyzer.REPORTED
    cells = reported["tables"]["table_4_1"] | {"K": dict(zip("ab", stiffness, strict=True))}
    values = reported["values"] | {"eigenfrequency_hz": eigenfrequency_hz}
    changed = {"values": values, "tables": {"table_4_1": cells}}
    return Run(run.tables, run.fits, run.settings, run.study | {"reported": changed})


def of_periods(samples):
    """Usual run of the Wristalyzer with K by averages over periods, from records of this length."""
    estimates = wristalyzer.USUAL | {"spectral_fit_periods__K": (10.0, 10.0, 10.0)}
    return wristalyzer.run_of(estimates, samples=samples)


def pooled(friction=(0.1, 0.3), softening=True):
    """Usual run of the Wristalyzer with a fit to all trials: interval of its friction, with softening."""
    run, columns = of_periods(10240), ["quantity", "value", "ci_low", "ci_high"]
    rows = [("K", 10.0, 9.0, 11.0), ("friction", 0.2, *friction)]
    rows += [("K_softened", 5.0, 4.0, 6.0)] if softening else []
    own = pd.DataFrame(rows, columns=columns).assign(
        experiment="wristalyzer", condition="pooled", pathway="time", estimator="pooled", unit="1", flags=""
    )
    facts = {"conditions": list("abc"), "without_softening_Nm": 0.002, "systematic_torque_Nm": 0.001}
    arrays = {f"shares/{name}": np.ones((3, 3)) for name in ("small", "friction")}
    fit = Result(arrays | {"rms_angle": np.array([0.01, 0.02, 0.03])}, {}, facts)
    tables = run.tables | {"estimates": pd.concat([run.tables["estimates"], own])}
    fits = run.fits | {"wristalyzer_pooled": {"wristalyzer_pooled": fit}}
    return Run(tables, fits, run.settings, run.study)


def erring(fit, regression):
    """Usual run of the Wristalyzer with errors of I, B and K by the criterion and by the regression."""
    run, errors = wristalyzer.usual(), {"spectral-fit": fit, "period-regression": regression}
    rows = [(name, q, sign * x) for name, x in errors.items() for q in "IBK" for sign in (0.5, -1.0)]
    table = pd.DataFrame(rows, columns=["estimator", "quantity", "relative_error"])
    table = table.assign(experiment="wristalyzer", condition="a", pathway="frequency")
    return Run(run.tables | {"recovery": table}, run.fits, run.settings, run.study)


def unrelated(coherence):
    run = wristalyzer.usual()
    for fit in run.fits["wristalyzer"].values():
        fit.arrays["tapered/coherence"] = np.full(7, coherence)
    return run


def plain_thesis(quantity, *values):
    """Usual run of the dummy, in which the thesis printed other values of I, B or K."""
    tables = {name: dict(own) for name, own in dummy.REPORTED["tables"].items()}
    tables["table_4_2"][quantity] = dict(zip("ab", values, strict=False))
    tables["table_4_3"][quantity] = {"c": values[2]}
    return dummy.run_of(**dummy.USUAL | {"reported": dummy.REPORTED | {"tables": tables, "slips": []}})


def true_joints(*truths):
    """Recovered K of two trials, in whose windows these are the true joints."""
    run = study.compared()
    recovery = run.tables["recovery"].iloc[:2].assign(truth=truths, truth_of="the fitted windows")
    return Run(run.tables | {"recovery": recovery}, run.fits, run.settings, run.study, run.provenance)


def sized(peaks=None, **own):
    """Run of the weight, with other peaks of the force (N) if wanted."""
    run = weight.run_of(**own)
    if peaks:
        for fit, peak in zip(run.fits["weight"].values(), peaks, strict=True):
            fit.arrays["20 Hz/added_force"] = peak * np.sin(np.linspace(0.0, np.pi, 21))[None]
    return run


def refitted(usual, every):
    """Run with R² of the loaded frame under 60 kg, fitted without and with this weight."""
    trains = (("empty+weight only", usual), ("empty+weight", every))
    own = [weight.score("loaded-frame", train, "weight of 60 kg", r2) for train, r2 in trains]
    return weight.run_of(scores=(*weight.SCORES, *own))


def plates(misfit, error=(10, 64, 11)):
    """Run of the weight with misfits and errors (%) of the plate of the study and of two others."""
    names = (
        "misfit to the statements (sum of squares of the fit)",
        "largest error of K of the standing person over the tasks",
        "largest error of K from the foot (compensated), 0.3 m/s and above",
        "R² of the pitch moment, best frame, lowest over the loads",
        "laboratories (drawn clocks) in which the force rises with amplitude and is largest for M5",
    )
    rows = [(name, "", "", *(misfit if k == 0 else error)) for k, name in enumerate(names)]
    table = pd.DataFrame(rows, columns=["measure", "unit", "thesis", "shipped", "fitted", "damped"])
    run = weight.run_of()
    return Run(run.tables | {"plate_constants": table}, run.fits, run.settings, run.study)


def strobed(run):
    """The same run of the dummy, with markers that are sampled one after another."""
    own = run.settings["dummy"]
    printed = own["pathways"]["leg-thesis"]
    pathways = own["pathways"] | {"leg-thesis": printed | {"marker_instants": "as-sampled"}}
    pathways["leg-thesis-aligned"] = printed
    estimates = run.tables["estimates"]
    aligned = estimates[estimates.pathway == "leg-thesis"].assign(pathway="leg-thesis-aligned")
    settings = {"dummy": own | {"pathways": pathways, "ingest": {"marker_sampling_hz": 2500.0}}}
    tables = run.tables | {"estimates": pd.concat([estimates, aligned])}
    return Run(tables, run.fits, settings, run.study)


# ---- findings: name -> run in which the sentence holds, run in which it does not

THE_DUMMY = dummy.run_of(**dummy.USUAL), dummy.run_of(**dummy.CONTRARY)
THE_WRISTALYZER = wristalyzer.usual(), wristalyzer.contrary()
THE_SWEEP = (
    wristalyzer.swept(wristalyzer.FEW, wristalyzer.MANY),
    wristalyzer.swept(wristalyzer.FEW, wristalyzer.BOTH),
)
FINDINGS = {
    "dummy": dict.fromkeys(
        [
            "stiffness_falls",
            "inertia_above_zero",
            "signs_explain",
            "consistent_vaf_lower",
            "vaf_of_trial",
            "consistent_torque_smaller",
            "errors_of_stiffness_alike",
            "rest_matters",
            "vaf_does_not_separate",
        ],
        THE_DUMMY,
    )
    | {
        "signs_bridge_thesis": (THE_DUMMY[0], plain_thesis("K", 10.0, 10.0, 10.0)),
        "corrected_inertia_lower": (THE_DUMMY[0], plain_thesis("I", 0.1, 0.1, 0.1)),
        "thesis_stiffness_falls": (THE_DUMMY[0], plain_thesis("K", 5.0, 5.5, 6.0)),
        "thesis_damping_negative": (strobed(THE_DUMMY[0]), plain_thesis("B", -0.01, 0.02, 0.01)),
    },
    "wristalyzer": dict.fromkeys(wristalyzer.SENTENCES, THE_WRISTALYZER)
    | {
        "spectral_fit_nearer": (erring(0.01, 0.03), erring(0.03, 0.01)),
        "coherence_above_thesis": (wristalyzer.usual(), wristalyzer.usual(made=())),
        "unrelated_above_lowpass": (unrelated(0.1), unrelated(0.5)),
        "thesis_frequencies_differ": (of_thesis(), of_thesis(eigenfrequency_hz=4.1)),
        "thesis_stiffness_unchanged": (of_thesis(), of_thesis(stiffness=(10.0, 9.0))),
        "leaks": (of_periods(12288), of_periods(10240)),
        "softens": (pooled(), pooled(softening=False)),
        "friction_found": (pooled(), pooled(friction=(-0.1, 0.3))),
    }
    | dict.fromkeys(("bins_disagree", "averaging_dips", "sem_not_from_bins"), THE_SWEEP)
    | {"printed_sem_falls": (THE_SWEEP[0], wristalyzer.swept(wristalyzer.FEW, printed=wristalyzer.RISING))},
    "simulation": {
        "growth_is_a_beat": (
            simulations.of_thesis(simulations.OF_THESIS),
            simulations.of_thesis(simulations.OF_THESIS, last=4.1),
        ),
        "pattern_of_thesis": (simulated(simulations.USUAL), simulated(simulations.CONTRARY)),
        "printed_swing_grows": (simulated(simulations.USUAL), simulated(simulations.CONTRARY)),
        "pattern_with_its_numbers": (
            simulations.altered(),
            simulations.altered(**{"thesis-wristalyzer": -400.0}),
        ),
        "better_without_handle": (
            simulations.altered(),
            simulations.altered(**{"thesis-without-handle": 70.0}),
        ),
        "likelihood_predicts_best": (
            simulations.altered(),
            simulations.altered(**{"joint-likelihood": 85.0}),
        ),
        "amplifies_less_at_8_s": (simulations.altered(), simulations.altered(growth={"sine-0.1": 1.5})),
        "amplifies_by_resonance": (simulations.altered(), simulations.altered(state="grows")),
        "excess_by_negative_damping": (
            simulations.beyond_the_limit("grows"),
            simulations.beyond_the_limit("settles"),
        ),
    },
    "thesis_dummy": {
        "full_law_predicts_best": (dummy.returned(best=True), dummy.returned(best=False)),
        "copy_predicts_best": (dummy.returned(best=False), dummy.returned(best=True)),
        "lag_bounded": (dummy.returned(True), dummy.returned(True, lags=dummy.TIMING["lags"][:4])),
        "unlagged_unlikely": (dummy.returned(True), dummy.returned(True, lags=dummy.TIMING["lags"][:2])),
    },
    "noise": dict.fromkeys(simulations.SENTENCES, (noisy(simulations.TRUE_K), noisy(simulations.FALSE_K)))
    | {
        "thesis_stiffness_lost": (
            noisy(simulations.TRUE_K, 4.0, 4.0, 0.1, 0.03),
            noisy(simulations.TRUE_K, 4.0, 4.0, 0.1, 3.0),
        ),
        "relative_noise_keeps_stiffness": (
            noisy(simulations.TRUE_K, 4.0, 4.0, 0.1, 0.03),
            noisy(simulations.TRUE_K, 4.0, 0.1, 0.1, 0.03),
        ),
        "thesis_returns_simulated": (
            noisy(simulations.TRUE_K, 4.0, 4.0, 0.1, 0.03),
            noisy(simulations.TRUE_K, 4.0, 4.0, 0.1, 0.03, 6.0),
        ),
        "sensor_returns_first_column": (sensed(0.015), sensed(0.04)),
        "fixed_noise_loses_stiffness": (
            noisy(simulations.TRUE_K, 4.0, 4.0, 0.1, 0.03),
            noisy(simulations.TRUE_K, 4.0, 4.0, 2.0, 0.03),
        ),
    },
    "planning": {
        "filter_of_both_changes_nothing": (planned(), planned(both=0.6)),
        "filter_of_one_distorts": (planned(), planned(torque=(1.0, 1.0, 1.0))),
        "one_sided_filter_worst": (planned(), planned(late=(-116.0, 1.0, -140.0))),
        "no_returning_pulse_halves": (planned(pulses=(1.0, 0.4)), planned(pulses=(0.52, 0.4))),
        "best_one_way_pulse_halves": (planned(), planned(pulses=(0.4, 0.6))),
    },
    "weight": {
        "force_grows": (sized(), sized(peaks=weight.RISING[::-1])),
        "load_matters": (sized(), sized(size=10.5)),
        "linear_needs_load": (weight.with_linear([0.95], [0.53]), weight.with_linear([0.95], [0.94])),
        "mass_falls": (sized(), sized(masses=weight.RISING)),
        "one_set_fails": (refitted(0.95, 0.85), refitted(0.95, 0.96)),
        "plate_agrees_worst": (plates((42, 6, 7)), plates((5, 6, 7))),
        "plate_errs_least": (plates((42, 6, 7), (10, 64, 11)), plates((42, 6, 7), (12, 64, 11))),
        "mass_sd_largest_first": (sized(spreads=weight.WAVERING), sized(spreads=weight.RISING)),
    },
    "standing": {
        "visible": (
            standing.run_of({"a": standing.trial(3.1)}),
            standing.run_of({"a": standing.trial(2.9)}),
        ),
        "knee_turns": (stood(), stood(knee=0.05)),
        "printed_little": (printed_torque(-25.0), printed_torque(400.0)),
        "window_matters": (stood(), in_windows((400.0, 410.0), (400.0, 401.0))),
        "free_reflex_not_steadier": (
            in_windows((400.0, 401.0), (300.0, 400.0)),
            in_windows((300.0, 400.0), (400.0, 401.0)),
        ),
        "active_biased": (damped(False), damped(True)),
    },
    "study": {
        "null_ahead": (study.scored(), study.scored(SEM_K="not reproduced")),
        "truth_missed": (study.compared(), study.compared(covered=["true"] * 4)),
        "errors_share_draw": (study.alike(0.015), study.alike(-0.015)),
        "truth_differs": (true_joints(9.0, 10.0), true_joints(10.0, 10.0)),
    },
}
# content of report.json and tables of a run, by chapter
CONTENT = {
    "dummy": dummy.content,
    "wristalyzer": lambda run: plain_content(run, "wristalyzer"),
    "simulation": lambda run: simulations.content(run, simulation=simulation),
    "thesis_dummy": dummy.returned_content,
    "noise": lambda run: simulations.content(run, noise=noise),
    "planning": lambda run: plain_content(run, "planning"),
    "weight": weight.content,
    "standing": standing.content,
    "study": study.study_content,
}


def plain_content(run, chapter):
    tables = {name: rows.to_csv(index=False) for name, rows in run.tables.items()}
    return report_content(run, {chapter: module_of(chapter)}), tables


CASES = [(chapter, name) for chapter, own in FINDINGS.items() for name in own]


def module_of(chapter):
    return importlib.import_module(f"tepsipe.reporting.chapters.{chapter}")


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_every_predicate_of_the_report_is_in_the_table(chapter):
    known = {predicate.__name__ for predicate in predicates_of(module_of(chapter))}
    assert known == {*FINDINGS.get(chapter, ()), *PRESENCE.get(chapter, "").split()}


@pytest.mark.parametrize(("chapter", "name"), CASES)
def test_a_finding_holds_in_its_run_and_not_in_the_contrary_one(chapter, name):
    holds = getattr(module_of(chapter), name)
    assert [bool(holds(run)) for run in FINDINGS[chapter][name]] == [True, False]


def first_of(chapter, name):
    """The first finding of the chapter that holds in the same run."""
    run = FINDINGS[chapter][name][0]
    return next(other for other, (own, _) in FINDINGS[chapter].items() if own is run)


@cache
def content_where(chapter, first):
    """Content of report.json and tables of a run, made once for all findings that hold in it."""
    return CONTENT[chapter](FINDINGS[chapter][first][0])


@cache
def chapter_where(chapter, first):
    """Words of the chapter in that run."""
    return chapter_words(chapter, *content_where(chapter, first), struck=True)


@cache
def places_where(chapter, first, places):
    """Words of places of the findings in that run."""
    return words_of(places, *content_where(chapter, first))


def words_of(places, data, tables):
    return evaluated([f'told("{p}").map(plain)' for p in places], "findings.typ", data, tables)


def asking(chapter, name):
    """Whether the chapter asks for a predicate, and the places of the findings that do."""
    asked = f'"{chapter}.{name}"'
    parts = [REPORT / f"chapters/{part}.typ" for part in parts_of(chapter)]
    findings = (REPORT / "findings.typ").read_text(encoding="utf-8")
    _, *rows = re.split(r"^  (\w+): \(", findings, flags=re.MULTILINE)
    places = tuple(place for place, row in zip(rows[::2], rows[1::2], strict=True) if asked in row)
    return any(asked in part.read_text(encoding="utf-8") for part in parts), places


SAYS = re.compile(r'says\("(\w+)\.(\w+)"\)')
SAID = {found for path in sorted(REPORT.rglob("*.typ")) for found in SAYS.findall(path.read_text("utf-8"))}


def test_every_assertion_has_a_run_in_which_it_fails():
    assert {own for own in SAID if own[0] != "claims"} <= set(CASES)


def test_a_sentence_that_rests_on_a_claim_goes_with_its_verdict():
    verdicts = [("a", "pattern"), ("b", "not reproduced"), ("c", "not computed"), ("d", "fitted")]
    claims = pd.DataFrame(verdicts, columns=["measure", "verdict"]).to_csv(index=False)
    asked = [f'plain(says("claims.{name}")[S.])' for name in "abcde"]
    struck = f"S. {MARK}"
    assert evaluated(asked, "data.typ", {}, {"claims": claims}) == ["S.", struck, struck, "S.", struck]
    assert evaluated(asked[:1], "data.typ", {}) == [struck]


@pytest.mark.slow
@pytest.mark.parametrize(("chapter", "name"), CASES)
def test_an_assertion_that_fails_is_struck_through_and_another_finding_changes(chapter, name):
    first = first_of(chapter, name)
    data, tables = content_where(chapter, first)
    assert data["chapters"][chapter]["holds"][name] is True
    without = copy.deepcopy(data)
    without["chapters"][chapter]["holds"][name] = False
    in_chapter, places = asking(chapter, name)
    before, after = [], []
    if in_chapter:
        before.append(chapter_where(chapter, first))
        after.append(chapter_words(chapter, without, tables, struck=True))
    if places:
        before += chain(*places_where(chapter, first, places))
        after += chain(*words_of(places, without, tables))
    assert before, "no source asks for it"
    assert after != before
    marks = [" ".join(words).count(MARK) for words in (before, after)]
    assert (marks[1] > marks[0]) is ((chapter, name) in SAID)
