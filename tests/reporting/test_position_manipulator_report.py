"""What the report of a human joint says is chosen by its numbers: one or many trials, no reflex, a change."""

import pandas as pd
import pytest
from joint_builders import fit_of, rows_of

from tepsipe.reporting.numbers.abstract import pieces
from tepsipe.reporting.numbers.position_manipulator import manipulator_data


def data_of(fits, joint=None, **rows):
    frames = [rows_of(c, fit.facts["reflex"]["direction"], **rows) for c, fit in fits.items()]
    return manipulator_data(fits, pd.concat(frames), joint)


def abstract_of(data):
    return " ".join(
        "".join(words for _, words in pieces(template, **values)) for template, values in data["abstract"]
    )


def test_abstract_leads_with_the_stiffness_of_the_model_that_predicts():
    told = abstract_of(data_of({"a": fit_of(), "b": fit_of()}, {"name": "ankle"}))
    assert told.startswith(
        "The intrinsic stiffness of the human ankle is K = 50.0 N·m/rad (45.0 to 55.0) in a and"
    )
    assert "VAF of 90.0 % in a and 90.0 % in b" in told
    assert "Its delay of 40 ms is assumed: the fitted parts are predicted best with 32 to 44 ms in a" in told
    assert "more than the short-latency stretch reflex" in told
    assert "100 N·m/rad (90 to 110) in a" in told
    assert "80 % lies below 1 Hz" in told


def test_short_range_stiffness_leads_with_the_stiffness_at_the_recorded_amplitude():
    told = abstract_of(data_of({"a": fit_of(short_range=True)}))
    assert told.startswith(
        "The intrinsic stiffness of the joint at the recorded amplitude is 60.0 N·m/rad (55.0"
    )
    assert "from 80 N·m/rad (70 to 90) for the smallest movements to K = 50.0 N·m/rad" in told


def test_relaxation_leads_with_the_stiffness_at_the_recorded_amplitude():
    told = abstract_of(data_of({"a": fit_of(relaxing=True)}))
    assert "at the recorded amplitude is 60.0 N·m/rad (55.0" in told
    assert "K = 50.0 N·m/rad (45.0 to 55.0) remains after relaxation" in told


def test_a_delay_that_the_data_determine_is_not_called_assumed():
    data = data_of({"a": fit_of(assumed=False)})
    assert "assumed" not in abstract_of(data)
    early = data_of({"a": fit_of(delays_s=(0.0, 0.02))})["reflexes"][0]
    assert early["delay_assumed"] and early["too_early"] and not early["delay_within"]


def test_models_are_compared_with_their_numbers_of_coefficients():
    rows = data_of({"a": fit_of(), "b": fit_of()})["comparison"]
    assert [row["coefficients"] for row in rows[:3]] == ["4", "22", "45"]
    assert rows[1]["label"] == "linear intrinsic pathway"
    assert rows[2]["held_out"] == ["89.0", "89.0"]
    assert rows[3]["held_out"] == ["90.0", "90.0"]


def test_one_trial_without_reflex_is_told_as_one():
    data = data_of({"only": fit_of(direction=0, slow=20.0)}, alone=90.0, cascade=90.0)
    told = abstract_of(data)
    assert "does not improve the prediction" in told
    assert "not in every trial more" in told
    for word in ("delay", "short-latency", "includes reflex torque", "below 1 Hz", " in only", "any record"):
        assert word not in told
    assert data["joint"]["of"] == "joint"
    assert not data["reflexes"][0]["there"]


def test_many_trials_are_told_as_a_range():
    data = data_of({f"trial{k}": fit_of(p=0.001 if k == 3 else 0.6) for k in range(7)})
    told = abstract_of(data)
    assert "K = 50.0 to 50.0 N·m/rad (median 50.0, 7 trials)" in told
    assert "The stiffness differs between the thirds of trial3." in told
    assert "found in all trials" in told
    assert [len(group) for group in data["groups"]] == [4, 3]


def test_short_response_is_not_said_to_be_more_than_the_stretch_reflex():
    data = data_of({"a": fit_of(lasting_s=0.1)})
    assert not data["reflexes"][0]["late"]
    assert "short-latency" not in abstract_of(data)


@pytest.mark.parametrize(("flags", "star"), [("not-converged", True), ("", False)])
def test_star_marks_what_failed_a_check(flags, star):
    data = data_of({"a": fit_of()}, flags=flags)
    assert data["starred"] is star
    assert data["models"][0]["rows"][0]["values"][0].endswith("*") is star


def test_white_residual_long_memory_and_low_coherence_are_said():
    data = data_of({"a": fit_of(white=0.4, memory_s=3.0, coherent=0.5), "b": fit_of(coherent=0.0)})
    assert data["residuals"]["white"] == ["a"]
    assert data["residuals"]["longer_than_block"] == ["a"]
    assert data["recordings"][-1]["values"][0] == "0.50 to 10 Hz"
    assert data["recordings"][-1]["values"][1] == "nowhere"


def test_digits_follow_the_uncertainty():
    data = data_of({"a": fit_of()})
    cells = {row["label"]: (row["values"][0], row["intervals"][0]) for row in data["models"][1]["rows"]}
    assert cells["stiffness $K$"] == ("50.0", "45.0 to 55.0")
    assert data["parts"]["rows"][0]["stiffness"][0] == "50.0 ± 3.0"
