"""Conditions and numbers of the standing person's chapter, and the sentences that they choose."""

import numpy as np
import pandas as pd
import pytest
from typst_builders import chapter_words, findings_of

from tepsipe.io.result import Result
from tepsipe.reporting.chapters import standing
from tepsipe.reporting.recovery import AT_WORK
from tepsipe.reporting.run import Run, report_content

PERSON = {"mass_kg": 64.0, "stature_m": 1.75}
ESTIMATORS = {
    "gls": {"active": "free", "inertia": False, "window_s": 0.08},
    "inert": {"active": "none", "inertia": True, "window_s": 0.1},
    "short": {"active": "none", "inertia": False, "window_s": 0.06},
    "twitch": {"active": "emg", "inertia": False, "window_s": 0.3},
}
PATHWAYS = {
    "vectors": {"torque": "ankle-thesis-vector", "treadmill_model": None},
    "printed": {"torque": "ankle-thesis", "treadmill_model": None},
    "plain": {"torque": "ankle", "treadmill_model": None},
    "best": {"torque": "ankle", "treadmill_model": "frame"},
}
BEST = {"pathway": "best", "estimator": "gls"}
SETTINGS = {
    "estimators": ESTIMATORS,
    "pathways": PATHWAYS,
    "recommended": BEST,
    "latency": {"detector": "changepoint"},
    "person": PERSON,
}
# task, pathway, estimator, quantity and value
ESTIMATES = (
    ("calm", "best", "gls", "K", 400.0),
    ("calm", "best", "gls", "B", 8.0),
    ("calm", "best", "gls", "K_over_mgh", 0.7),
    ("calm", "best", "short", "K", 500.0),
    ("calm", "plain", "short", "K", 350.0),
    ("calm", "printed", "short", "K", -25.0),
    ("calm", "best", "twitch", "VAF_response", 97.04),
    ("tense", "best", "twitch", "VAF_response", None),
    ("a", "best", "gls", "K", 420.0),
    ("calm", "vectors", "short", "K", 345.0),
)
WINDOWS = np.array([[0.04, 8.0, 398.0], [0.06, 8.2, 402.0], [0.08, 8.0, 400.0]])
TIME = np.array([-0.1, 0.0, 0.1, 0.2])


def trial(over_sway=50.0, responses=2):
    facts = {"perturbations": 3, "responses": responses, "left_out": []}
    facts |= {"angle_over_sway": over_sway, "torque_over_sway": 0.5 * over_sway}
    activity = np.array([[9.0, 1.0, 4.0, 2.0], [0.0] * 4])
    arrays = {"mean/time": TIME, "activity/TA": activity}
    return Result(arrays, {}, facts | {"critical_stiffness_Nm_per_rad": 550.0})


def onset(latency_s, interval_s=None):
    return {"latency_s": latency_s, "interval_s": interval_s}


def task(latency_s=0.04, knee=1.0, flags=(), free=True):
    found = {"threshold": onset(0.05), "teager-kaiser": onset(None), "responses": 3}
    found["changepoint"] = onset(latency_s, [0.038, 0.042] if latency_s else None)
    facts = {"muscles": ["TA", "SOL"], "latencies": {"TA": found}, "left_out": [], "responses": 2}
    facts["broadband_cutoff_hz"] = 60.0
    facts |= {"centre_used": True, "joint_centre_m": [0.0043, -0.0002], "skin_m": 0.0017}
    facts |= {"forefoot_share": [0.52, 0.014]}
    arrays = {
        "windows/length": np.array([0.03, 0.05, 0.06, 0.3]),
        "windows/K": np.array([[400.0], [540.0], [500.0], [-50.0]]),
    }
    turned = np.array([[np.nan, 0.0, 0.01, 0.005]])
    arrays |= {
        "mean/time": TIME,
        "mean/shank": turned,
        "mean/thigh": 0.8 * turned,
        "mean/knee": knee * turned,
    }
    if free:
        facts["budgets"] = {"gls": {"flags": list(flags)}}
        arrays["budget/gls/windows"] = WINDOWS
    return Result(arrays, {}, facts)


def recovered(latency=True, error=-0.031):
    """Truth of the recommended K, and of a latency that is found 1.9 ms late."""
    columns = ["condition", "pathway", "estimator", "quantity", "truth", "value", "covered"]
    rows = [("calm", "best", "gls", "K", 410.0, 400.0, True)]
    rows += [("calm", "emg", "changepoint", "latency_TA", 0.0381, 0.04, False)] if latency else []
    return pd.DataFrame(rows, columns=columns).assign(
        experiment="standing", relative_error=error, truth_of=AT_WORK
    )


def run_of(trials=None, tasks=None, estimates=ESTIMATES, recovery=None):
    """Run with two trials of one task, unless others are wanted."""
    columns = ["condition", "pathway", "estimator", "quantity", "value"]
    table = pd.DataFrame(estimates, columns=columns).assign(
        experiment="standing", unit="1", standard_error="", ci_low="", ci_high="", n_perturbations=2, flags=""
    )
    sources = pd.DataFrame(
        [
            ("calm", "best", "gls", "K", source, kind, u)
            for source, kind, u in (("scatter", "A", 20.0), ("skin_m", "B", 4.0), ("foot_mass", "B", 8.0))
        ],
        columns=["condition", "pathway", "estimator", "quantity", "source", "type", "u"],
    ).assign(experiment="standing")
    tables = {"estimates": table, "uncertainty": sources}
    fits = {
        "standing": trials or {"a": trial(), "b": trial(70.0)},
        "standing_tasks": {"calm": task()} if tasks is None else tasks,
    }
    study = {"title": "t", "recordings_source": None, "experiments": {"standing": list("ab")}, "made": {}}
    return Run(
        tables | ({} if recovery is None else {"recovery": recovery}),
        fits,
        {"standing": SETTINGS, "weight": {"weight": {"mass_kg": 20.0}}},
        study,
    )


def content(run):
    def text(rows):
        return rows.replace({True: "true", False: "false"}).to_csv(index=False)

    data = report_content(run, {"standing": standing})
    return data, {name: text(rows) for name, rows in run.tables.items()}


def chapter(run):
    return chapter_words("standing", *content(run), cells="|")


@pytest.mark.parametrize(
    ("trials", "holds"),
    [
        ({"a": trial(3.1)}, True),
        ({"a": trial(3.1), "b": trial(2.9)}, False),
        ({"a": trial(3.1), "b": trial(2.9, responses=0)}, True),
        ({"a": trial(3.1, responses=0)}, False),
    ],
)
def test_perturbations_are_visible_only_above_the_sway_of_every_usable_trial(trials, holds):
    assert standing.visible(run_of(trials)) is holds
    assert ("figure_4_13" in findings_of(["figure_4_13"], *content(run_of(trials)))) is holds


@pytest.mark.parametrize(("knee", "holds"), [(0.2, True), (0.05, False)])
def test_a_knee_that_hardly_turns_leaves_the_body_rigid(knee, holds):
    run = run_of(tasks={"calm": task(knee=knee)})
    assert standing.knee_turns(run) is holds
    assert ("does not rotate as one rigid body" in chapter(run)) is holds


@pytest.mark.parametrize(("stiffness", "holds"), [(-90.0, True), (90.0, True), (-110.0, False)])
def test_printed_torque_has_little_stiffness_only_if_it_has(stiffness, holds):
    run = run_of(estimates=(*ESTIMATES[:5], ("calm", "printed", "short", "K", stiffness)))
    assert standing.printed_little(run) is holds
    assert ("yields almost no stiffness" in chapter(run)) is holds
    assert not standing.printed_little(run_of(estimates=ESTIMATES[:5]))


def test_shares_of_torques_and_the_change_by_window_are_those_of_the_run():
    found = standing.numbers(run_of())
    assert found["pre_reflex"] == "short"
    shares = {"vectors": [69.0], "printed": [-5.0], "plain": [70.0], "best": [100.0]}
    assert found["share_percent"] == shares
    words = chapter(run_of())
    assert "yields almost no stiffness: −5.0 % of the K by" in words
    assert "vector products, it yields 69 %, because no belt-induced load is subtracted" in words
    # of the windows of 50 and 60 ms; that of 30 ms is too far from 60 ms
    assert "shorter or longer, its K changes by up to 8 %" in words
    assert "Over windows of 40 to 80 ms, B varies by 2.5 % with a free reflex torque" in words
    assert "The K of the estimator short differs from the recommended K by +25.0 %." in words
    assert "the mass of the feet (2.0 %) and the motion of soft tissue over bone (1.0 %)." in words
    assert "the ankle lies 4.3 mm in front of and 0.2 mm below the assumed point" in words


def test_warnings_of_a_task_are_told():
    assert "Warning:" not in chapter(run_of())
    run = run_of(tasks={"calm": task(flags=["skin-motion"])})
    assert "Warning: soft tissue of the shank moves over the bone" in chapter(run)


def test_omissions_are_told_in_one_sentence_and_feet_once():
    words = "marker 'foot2' was hidden while the belt moved: check what stood between it and the cameras"
    hidden = [
        f"standing/{c}: perturbation at {t} s left out: {words}" for c, t in (("a", "54.02"), ("b", "7.59"))
    ]
    trials = {"a": trial(), "b": trial()}
    trials["a"].facts["left_out"] = hidden
    trials["b"].facts["left_out"] = ["standing/b: muscle TA left out: clipped in every perturbation"]
    words = chapter(run_of(trials, {"calm": task(), "tense": task()}))
    assert (
        "We omitted 2 of the 6 perturbations, because a marker was hidden while the belt moved: a, 54.02 s "
        "(marker foot2); b, 7.59 s (marker foot2). We omitted unreliable data for the following reasons:"
        in words
    )
    assert "muscle TA left out: clipped in every perturbation." in words and "check what" not in words
    assert words.count("Soft tissue is estimated to move by 1.70 mm") == 1
    other = task()
    other.facts["skin_m"] = 0.002
    words = chapter(run_of(tasks={"calm": task(), "tense": other}))
    assert words.count("Soft tissue is estimated to move by") == 2
    assert "Omissions" not in words


def test_a_reflex_is_free_only_in_an_estimate_that_has_a_budget():
    assert standing.free_reflex(run_of())
    run = run_of(tasks={"calm": task(free=False)})
    assert not standing.free_reflex(run)
    assert "is independent of the length of the window only if" not in chapter(run)
    assert "figure_standing_window" not in findings_of(["figure_standing_window"], *content(run))


def test_the_reflex_torque_is_told_with_its_truth_and_what_is_not_determined():
    assert "Peak (N·m)" not in chapter(run_of())
    values = {"peak": 9.6, "impulse": 0.58, "gain": 41.9, "delay": 0.094}
    own = [("calm", "best", "gls", f"reflex_{name}", value) for name, value in values.items()]
    true = recovered()
    true.loc[len(true)] = {**true.iloc[0], "quantity": "reflex_peak", "truth": 9.95, "value": 9.6}
    run = run_of(estimates=(*ESTIMATES, *own), recovery=true)
    table = run.tables["estimates"]
    table.loc[table.quantity == "reflex_delay", "flags"] = "skin-motion;reflex-not-determined"
    words = chapter(run)
    assert "|Peak (N·m)|9.60|9.95||Impulse (N·m·s)|0.580|–||Gain (N·m·s/rad)|41.9|–|" in words
    assert "|Delay (s)|0.0940 †|–|" in words and "too wide to determine the value" in words


def test_a_trial_without_an_estimate_is_left_out_of_the_table():
    assert "|a|420|–|–|2||b|left out||||" in chapter(run_of())


def test_cells_of_latencies_have_a_dash_where_there_is_no_onset():
    assert "|calm|TA|50.0|–|40.0|3|–|" in chapter(run_of())
    words = chapter(run_of(recovery=recovered()))
    assert "|calm|TA|50.0|–|40.0|3|38|" in words
    assert "error of the latencies by the recommended detector is 1.9 ms" in words
    assert "the mean error is 1.9 ms; 0 of the 1 intervals of this detector cover" in words


def test_estimates_are_compared_with_the_truth_of_their_windows():
    words = chapter(run_of(recovery=recovered()))
    told = "recommended estimates is 3.1 % in K and – % in B; 1 of the 1 intervals cover the true value"
    assert told in words
    assert "|410|400|−3.1|yes|–|–|–|–|" in words


FIGURES = [f"figure_standing_{name}" for name in ("activity", "latency", "response", "window", "joints")]


def test_intervals_of_latencies_are_those_of_the_estimates():
    """The table has the interval whose coverage is counted, not the narrower one of the scatter alone."""
    run = run_of(estimates=(*ESTIMATES, ("calm", "emg", "changepoint", "latency_TA", 0.04)))
    table = run.tables["estimates"]
    table.loc[table.quantity == "latency_TA", ["ci_low", "ci_high"]] = ["0.0351", "0.0446"]
    words = chapter(run)
    assert "40.0 (35.1 to 44.6)" in words
    assert "38.0 to 42.0" not in words


def test_muscles_without_an_onset_have_no_latency_in_a_caption():
    found = findings_of(["figure_4_14", *FIGURES], *content(run_of()))
    assert "finds a response in 1 of 1 mean electromyograms" in found["figure_4_14"]
    # the sample before the onset does not count
    assert found["figure_standing_activity"] == (
        "The largest mean response, 4.0 µV, occurs in TA in the trial a, 100 ms after the belt starts."
    )
    assert found["figure_standing_latency"] == (
        "By the recommended detector, the muscles respond 40 ms after the start of the stretch; "
        "the three detectors differ by at most "
        "10.0 ms."
    )
    assert (
        "Over windows of 40 to 80 ms, K varies over a range of 1.0 % (calm) of the recommended "
        "K with a free reflex torque, and of 10.0 % (calm) without a reflex torque. Over all windows, K "
        "without a reflex torque is "
        "\N{MINUS SIGN}50.0 to 540 N·m/rad (calm)." in found["figure_standing_window"]
    )
    assert found["figure_standing_response"].endswith("explain 97.0 to 97.0 % of the mean torque.")
    assert found["figure_standing_joints"].endswith(
        "on average over the trials, the knee rotates by 10 mrad (calm) peak to peak."
    )
    silent = run_of(tasks={"calm": task(None)}, estimates=ESTIMATES[:5])
    for fit in silent.fits["standing"].values():
        fit.arrays.pop("activity/TA")
    assert standing.numbers(silent)["largest_response"] is None
    found = findings_of(["figure_4_14", *FIGURES], *content(silent))
    assert set(found) == {"figure_4_14", FIGURES[3], FIGURES[4]}
    assert "finds a response in 0 of 1 mean electromyograms" in found["figure_4_14"]
