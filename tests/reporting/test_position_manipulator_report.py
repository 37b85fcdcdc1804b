"""Tables of the report of a human joint: one or many trials, marks, no reflex."""

import pandas as pd
import pytest
from joint_builders import content_of, fit_of, joint_words, rows_of, run_of
from typst_builders import findings_of

CHAPTER = '#include "chapters/position_manipulator.typ"'


def run_with(fits, joint=None, **rows):
    frames = [rows_of(c, fit.facts["reflex"]["direction"], **rows) for c, fit in fits.items()]
    return run_of(fits, pd.concat(frames), joint)


def chapter_of(run):
    return joint_words(CHAPTER, run, cells=" | ")


def test_reflex_is_listed_with_its_delays():
    words = chapter_of(run_with({"a": fit_of(), "none": fit_of(direction=0)}))
    assert "a | increasing angles | 10.0‡ (8.0 to 12.0) | 40 (assumed) | 32 to 44 ms | 500 |" in words
    assert "A reflex does not improve the prediction of the fitted part of none." in words
    known = chapter_of(run_with({"a": fit_of(assumed=False)}, {"positive": "dorsiflexion"}))
    assert "a | dorsiflexion | 10.0‡ (8.0 to 12.0) | 40 | 32 to 44 ms | 500 |" in known


def test_models_are_compared_with_their_numbers_of_coefficients():
    words = chapter_of(run_with({"a": fit_of(), "b": fit_of()}))
    assert "inertia, damping, stiffness and offset | 4 |" in words
    assert "linear intrinsic pathway | 22 | 80.0 | 79.0 | 80.0 | 79.0 |" in words
    assert "with all terms, including relaxation | 45 | 90.0 | 89.0 | 90.0 | 89.0 |" in words
    assert "selected terms | | \N{EN DASH} | 90.0 | \N{EN DASH} | 90.0 |" in words


def test_terms_and_kernels_are_those_of_the_trials():
    words = chapter_of(run_with({"a": fit_of(pole_per_s=30.0), "b": fit_of(relaxing=True)}))
    assert "In a, these are reflex. In b, these are reflex and relaxation." in words
    assert "and are linear between knots in b and sums of Laguerre functions in a." in words
    assert "beyond the short range and after relaxation." in words
    words = chapter_of(run_with({"a": fit_of()}))
    assert "and are linear between knots. The radii" in words
    assert "beyond the short range. The stiffness at the recorded amplitude adds" in words


def test_tables_of_many_trials_have_four_beside_each_other():
    words = chapter_of(run_with({f"trial{k}": fit_of() for k in range(7)}))
    assert "trial0 | trial1 | trial2 | trial3 |" in words and "trial4 | trial5 | trial6 |" in words
    assert "trial3 | trial4" not in words


@pytest.mark.parametrize("flags", ["not-converged", ""])
def test_marks_tell_what_failed_a_check_and_what_is_not_recommended(flags):
    words = chapter_of(run_with({"a": fit_of()}, flags=flags))
    failed = "†" if flags else ""
    assert f"stiffness K | N·m/rad | 100{failed}‡ (90 to 110) |" in words
    assert f"stiffness K | N·m/rad | 50.0{failed} (45.0 to 55.0) |" in words
    assert ("† A check failed. ‡ For comparison only" in words) is bool(flags)
    # why: K by the other model, and quantities of the recommended one
    why = "another estimate of the quantity is recommended, or the study recommends only K."
    assert f"‡ For comparison only: {why}" in words


def findings_in(trials, **kinds):
    places = [f"figure_position_manipulator_{name}" for name in ("prediction", "responses", "residual")]
    places.append("figure_position_manipulator_impedance")
    fits = {name: fit_of(**kinds) for name in trials}
    found = findings_of(places, *content_of(run_with(fits, cascade=94.56)))
    return [found[place] for place in places]


def test_captions_of_recordings_have_findings():
    prediction, responses, residual, impedance = findings_in("ab", coherent=0.5)
    assert (
        "reaches a VAF of 94.6 % (a, b), and inertia, damping and stiffness alone reach 80.0 %" in prediction
    )
    assert (
        responses
        == "K is 50.0 N·m/rad (a, b), and the stiffness of the smallest movements is 80‡ N·m/rad (a, b)."
    )
    assert "root mean square of 0.40 N·m (a, b). Power below 1 Hz makes up 80 % (a, b)" in residual
    assert impedance.endswith("coherent from 0.50 Hz to 10 Hz.")
    # the name of one trial says nothing, and those of many are too long
    assert findings_in("a", coherent=0.0)[1:] == [
        "K is 50.0 N·m/rad, and the stiffness of the smallest movements is 80‡ N·m/rad.",
        "The residual has a root mean square of 0.40 N·m. Power below 1 Hz makes up 80 % of its mean square.",
        "Angle and torque are nowhere significantly coherent.",
    ]
    assert findings_in("abcde")[1].startswith("K is 50.0 N·m/rad, and")


def test_residual_and_coherence_are_listed():
    long = fit_of(white=0.4, memory_s=3.0, coherent=0.5)
    words = chapter_of(run_with({"a": long, "b": fit_of(coherent=0.0)}))
    assert "a | 0.40 | 1.0 | 80 | 3 | 3.0 | 0.40 |" in words
    assert "significant coherence | Hz | 0.50 to 10 | nowhere |" in words


def test_digits_follow_the_uncertainty():
    words = chapter_of(run_with({"a": fit_of()}))
    assert "50.0 ± 3.0 | 51.0 ± 3.0 | 52.0 ± 3.0 | 0.50 |" in words
