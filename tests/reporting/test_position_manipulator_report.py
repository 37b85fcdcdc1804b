"""What the report of a human joint says is chosen by its numbers: one or many trials, no reflex, a change."""

import pandas as pd
import pytest
from joint_builders import content_of, fit_of, joint_words, rows_of, run_of
from typst_builders import findings_of

from tepsipe.reporting.chapters import position_manipulator

ABSTRACT = """#import "findings.typ": told
Abstract:
#for part in ("", "_reflex", "_changes") { told("abstract_position_manipulator" + part).join([ ]) + [ ] }
"""
CHAPTER = '#include "chapters/position_manipulator.typ"'


def run_with(fits, joint=None, **rows):
    frames = [rows_of(c, fit.facts["reflex"]["direction"], **rows) for c, fit in fits.items()]
    return run_of(fits, pd.concat(frames), joint)


def abstract_of(run):
    return joint_words(ABSTRACT, run).partition("Abstract: ")[2]


def chapter_of(run):
    return joint_words(CHAPTER, run, cells=" | ")


def test_abstract_leads_with_the_stiffness_of_the_model_that_predicts():
    told = abstract_of(run_with({"a": fit_of(), "b": fit_of()}, {"name": "ankle"}))
    assert told.startswith(
        "The intrinsic stiffness of the human ankle is K = 50.0 N·m/rad (45.0 to 55.0) in a and"
    )
    assert "VAF of 90.0 % in a and 90.0 % in b" in told
    assert (
        "Its delay of 40 ms is assumed. The delays that predict the fitted parts best are 32 to 44 ms in a"
        in told
    )
    assert "more than the short-latency stretch reflex" in told
    assert "100 N·m/rad (90 to 110) in a" in told
    assert "80 %, lies below 1 Hz" in told


def test_short_range_stiffness_leads_with_the_stiffness_at_the_recorded_amplitude():
    told = abstract_of(run_with({"a": fit_of(short_range=True)}))
    assert told.startswith(
        "The intrinsic stiffness of the joint at the recorded amplitude is 60.0 N·m/rad (55.0"
    )
    assert (
        "For the smallest movements it is 80 N·m/rad (70 to 90). Beyond the short range it is K = 50.0"
        in told
    )


def test_relaxation_leads_with_the_stiffness_at_the_recorded_amplitude():
    told = abstract_of(run_with({"a": fit_of(relaxing=True)}))
    assert "at the recorded amplitude is 60.0 N·m/rad (55.0" in told
    assert "After relaxation, K = 50.0 N·m/rad (45.0 to 55.0) remains" in told


def test_a_delay_that_the_data_determine_is_not_called_assumed():
    assert "assumed" not in abstract_of(run_with({"a": fit_of(assumed=False)}))
    early = chapter_of(run_with({"a": fit_of(delays_s=(0.0, 0.02))}))
    assert "Its delay of 40 ms is assumed, although 0 to 20 ms would predict the fitted part better." in early
    assert "No reflex is that early" in early


def test_models_are_compared_with_their_numbers_of_coefficients():
    words = chapter_of(run_with({"a": fit_of(), "b": fit_of()}))
    assert "inertia, damping, stiffness and offset | 4 |" in words
    assert "linear intrinsic pathway | 22 | 80.0 | 79.0 | 80.0 | 79.0 |" in words
    assert "with all terms | 45 | 90.0 | 89.0 | 90.0 | 89.0 |" in words
    assert "selected terms | | \N{EN DASH} | 90.0 | \N{EN DASH} | 90.0 |" in words


def test_one_trial_without_reflex_is_told_as_one():
    data = run_with({"only": fit_of(direction=0, slow=20.0)}, alone=90.0, cascade=90.0)
    told = abstract_of(data)
    assert "does not improve the prediction" in told
    assert "This is no more than the VAF" in told
    for word in ("delay", "short-latency", "includes reflex torque", "below 1 Hz", " in only", "any record"):
        assert word not in told
    words = chapter_of(data)
    assert "A joint in a position-controlled manipulator" in words
    assert "A reflex does not improve the prediction of the fitted part of the trial." in words


def test_many_trials_are_told_as_a_range():
    data = run_with({f"trial{k}": fit_of(p=0.001 if k == 3 else 0.6) for k in range(7)})
    told = abstract_of(data)
    assert "K = 50.0 to 50.0 N·m/rad (median 50.0, 7 trials)" in told
    assert "The stiffness differs between the thirds of trial3." in told
    assert "found in all trials" in told
    words = chapter_of(data)
    assert "trial0 | trial1 | trial2 | trial3 |" in words and "trial4 | trial5 | trial6 |" in words
    assert "trial3 | trial4" not in words
    assert "show the first trials" in words


def test_short_response_is_not_said_to_be_more_than_the_stretch_reflex():
    data = run_with({"a": fit_of(lasting_s=0.1)})
    assert "Its response ends 100 ms after the stretch." in chapter_of(data)
    assert "short-latency" not in abstract_of(data)


@pytest.mark.parametrize(("flags", "star"), [("not-converged", True), ("", False)])
def test_star_marks_what_failed_a_check(flags, star):
    words = chapter_of(run_with({"a": fit_of()}, flags=flags))
    assert ("An asterisk marks an estimate that failed a check" in words) is star
    assert ("stiffness K | N·m/rad | 100* (90 to 110) |" in words) is star
    assert ("stiffness K | N·m/rad | 100 (90 to 110) |" in words) is not star


def test_white_residual_long_memory_and_low_coherence_are_said():
    data = run_with({"a": fit_of(white=0.4, memory_s=3.0, coherent=0.5), "b": fit_of(coherent=0.0)})
    words = chapter_of(data)
    assert not position_manipulator.white(data) and "The residual is not white" in words
    assert "In a the memory of the residual is longer than a block" in words
    assert "significant coherence | | 0.50 to 10 Hz | nowhere |" in words


def test_digits_follow_the_uncertainty():
    words = chapter_of(run_with({"a": fit_of()}))
    assert "stiffness K | N·m/rad | 50.0 (45.0 to 55.0) |" in words
    assert "50.0 ± 3.0 | 51.0 ± 3.0 | 52.0 ± 3.0 | 0.50 |" in words


# ---- conditions and captions


@pytest.mark.parametrize(("cascade", "raises"), [((81.0, 91.0), True), ((81.0, 89.0), False)])
def test_reflex_raises_the_held_out_vaf_only_if_it_does_in_every_trial(cascade, raises):
    rows = [
        rows_of(name, alone=before, cascade=after)
        for name, before, after in zip("ab", (80.0, 90.0), cascade, strict=True)
    ]
    run = run_of({"a": fit_of(), "b": fit_of()}, pd.concat(rows))
    assert position_manipulator.reflex_raises(run) is raises


def test_conditions_hold_in_a_usual_run_and_not_in_a_contrary_one():
    usual = run_with({"a": fit_of(short_range=True)})
    rows = rows_of("a", alone=-40.0, cascade=-60.0)
    rows.loc[rows.quantity == "VAF_held_out_with_slow_torque", "value"] = -70.0
    contrary = run_of({"a": fit_of(white=0.5, slow=10.0)}, rows)
    truth = [
        {predicate.__name__: predicate(run) for predicate in position_manipulator.PREDICATES}
        for run in (usual, contrary)
    ]
    for name in ("alone_predicts", "reflex_raises", "slow_raises", "short_range", "mostly_slow"):
        assert [own[name] for own in truth] == [True, False], name
    assert [own["white"] for own in truth] == [False, True]
    assert position_manipulator.more_than_shown(run_with({f"t{k}": fit_of() for k in range(4)}))
    assert not truth[0]["more_than_shown"] and not truth[0]["participants_named"]


@pytest.mark.parametrize("usual", [True, False])
def test_captions_of_a_joint_follow_its_records(usual):
    made = {"slow": 84.0} if usual else {"slow": 10.0, "p": 0.001, "white": 0.5, "direction": 0}
    fits = {"a": fit_of(**made)} if usual else {"a": fit_of(**made), "b": fit_of(**made)}
    run = run_with(fits, **({} if usual else {"alone": 90.0, "cascade": 80.0}))
    figures = ("stationarity", "residual", "prediction", "responses")
    found = findings_of([f"figure_position_manipulator_{name}" for name in figures], *content_of(run))
    stationarity, residual, prediction, responses = found.values()
    assert (
        "does not differ between the thirds of a record; the torque does not drift." in stationarity
    ) is usual
    assert ("thirds of a and b; the torque drifts in a and b." in stationarity) is not usual
    assert ("is not white" in residual) is usual
    assert ("; 84 % of its power lies below 1 Hz." in residual) is usual
    assert ("The reflex gain is 10.0 N·m·s/rad in a." in responses) is usual
    assert ("predicts every" in prediction) is usual
