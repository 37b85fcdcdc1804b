"""Results' files of a standing person: what the report and the figures find in them."""

import numpy as np
import pytest
from standing_builders import (
    CUTTING,
    ONSETS_S,
    OPTIONS,
    RESPONSE_TIME,
    SIZES,
    bent,
    responses_with,
    standing_trial,
)

from tepsipe.experiments.standing.epochs import cut_standing_epochs, epochs_of
from tepsipe.experiments.standing.estimates import fit_rows, generator
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.muscle_torque import ActiveOptions
from tepsipe.experiments.standing.options import AS_PRINTED, StandingEstimator, TorquePathway
from tepsipe.experiments.standing.thesis.impedance import (
    fit_all,
    standing_result,
    stiffness_by_window,
    trial_epochs_result,
)
from tepsipe.experiments.standing.thesis.latency import MuscleLatency, latency_estimates
from tepsipe.io.result import read_result, write_result
from tepsipe.signals.onsets import DETECTORS, Onset

ANGLE, RATE, _ = bent(RESPONSE_TIME)
ACTIVE = ActiveOptions((0.04,), (0.044,), (0.112,), {"SOL": 1.0})
ESTIMATORS = {
    "pre-reflex-window": StandingEstimator(0.06, False, "none"),
    "long": StandingEstimator(0.3, False, "none"),
}
LATENCY = MuscleLatency(
    "SOL",
    {
        "threshold": Onset(None, None, None, 0.4, "expected activity, found none"),
        "teager-kaiser": Onset(0.047, 0.001, (0.045, 0.049), 1.0, None),
        "changepoint": Onset(0.042, 0.002, (0.038, 0.046), 1.0, None),
    },
    np.array([0.0, 0.001]),
    np.array([2.0, 3.0]),
    8,
)


@pytest.fixture(scope="module")
def trials():
    torque = 370.0 * ANGLE + 6.0 * RATE
    made = [
        responses_with(torque),
        responses_with(torque, sizes=-np.array(SIZES)),
        responses_with(torque, sizes=[]),
    ]
    for responses in made:
        for group in (responses.perturbed, responses.unperturbed):
            group |= dict.fromkeys(("knee", "shank", "thigh"), 0.0 * group["ankle"])
            group["torque/other"] = 2.0 * group["torque/ankle"]
    return made


@pytest.fixture(scope="module")
def fits(trials):
    return fit_all(trials, "standing/relax", ["ankle", "other"], ESTIMATORS, ACTIVE, 50, 1)[0]


def test_every_fit_draws_from_a_generator_of_its_own():
    names = [
        ("standing/relax", "ankle", "long"),
        ("standing/relax", "ankle", "short"),
        ("standing/stiff", "ankle", "long"),
    ]
    drawn = [generator(1, *name).random() for name in names]
    assert len(set(drawn)) == 3
    assert generator(1, *names[0]).random() == drawn[0]
    assert generator(2, *names[0]).random() != drawn[0]


def test_result_of_a_task_holds_its_trials_fits_and_latencies(trials, fits, tmp_path):
    facts = {"left_out": ("one", "two")}
    write_result(tmp_path / "task.h5", standing_result(trials, fits, "ankle", [LATENCY], facts))
    read = read_result(tmp_path / "task.h5")
    # the third trial has no responses
    assert read.arrays["mean/ankle"].shape == (2, RESPONSE_TIME.size)
    assert read.arrays["mean/ankle"][1] == pytest.approx(-np.mean(SIZES) * ANGLE)
    assert read.arrays["mean/time"] == pytest.approx(RESPONSE_TIME)
    assert read.units["mean/belt_velocity"] == "m/s"
    assert read.arrays["K/ankle/pre-reflex-window"] == pytest.approx(np.full(3, 370.0))
    assert read.arrays["K/other/long"] == pytest.approx(np.full(3, 740.0))
    assert read.units["K/other/long"] == "Nm/rad"
    curves = {key for key in read.arrays if key.startswith("curve/")}
    parts = ("torque", "intrinsic", "active", "ankle", "time")
    assert curves == {f"curve/{estimator}/{part}" for estimator in ESTIMATORS for part in parts}
    torque = read.arrays["curve/long/torque"]
    assert torque.shape == (2, read.arrays["curve/long/time"].size)
    assert torque[1] == pytest.approx(-torque[0])
    assert read.arrays["latency/SOL/rectified"].tolist() == [2.0, 3.0]
    told = read.facts["latencies"]["SOL"]
    assert set(told) == {*DETECTORS, "responses"}
    assert told["changepoint"]["interval_s"] == [0.038, 0.046]
    assert told["threshold"] == {
        "latency_s": None,
        "standard_error_s": None,
        "interval_s": None,
        "reason": "expected activity, found none",
    }
    assert read.facts["left_out"] == ["one", "two"]


def test_rows_of_a_task_are_those_of_its_fits_and_of_the_latencies_that_were_found(fits):
    rows, contributions = fit_rows("relax", fits, 555.0)
    # no budget of an estimate whose scatter alone is known
    assert contributions == []
    rows += latency_estimates("relax", LATENCY)
    values = {(row.pathway, row.estimator, row.quantity): row.value for row in rows}
    assert len(values) == len(rows)
    assert values["other", "long", "K"] == pytest.approx(740.0)
    assert values["ankle", "long", "K_over_mgh"] == pytest.approx(370.0 / 555.0)
    found = {row.estimator for row in rows if row.quantity == "latency_SOL"}
    assert found == {"teager-kaiser", "changepoint"}


def test_stiffness_of_every_window_is_kept(trials, tmp_path):
    lengths = [0.04, 0.1, 0.3]
    windows = stiffness_by_window(trials, "other", lengths, ACTIVE, 50, np.random.default_rng(1))
    assert windows == pytest.approx(np.column_stack([lengths, np.full((3, 3), 740.0)]))
    write_result(tmp_path / "task.h5", standing_result(trials, {}, "ankle", [], {}, windows))
    read = read_result(tmp_path / "task.h5")
    assert read.arrays["windows/length"].tolist() == lengths
    assert read.arrays["windows/K"] == pytest.approx(np.full((3, 3), 740.0))
    assert (read.units["windows/length"], read.units["windows/K"]) == ("s", "Nm/rad")
    nothing = stiffness_by_window(trials[2:], "other", lengths, ACTIVE, 50, np.random.default_rng(1))
    assert nothing.shape == (0, 4)


def test_result_without_a_usable_trial_is_empty_and_can_be_written(trials, tmp_path):
    write_result(tmp_path / "none.h5", standing_result(trials[2:], {}, "ankle", [], {"left_out": ("all",)}))
    read = read_result(tmp_path / "none.h5")
    assert read.arrays == {}
    assert read.facts == {"left_out": ["all"], "latencies": {}}
    assert fit_rows("relax", {}, 555.0) == ([], [])


def test_result_of_a_trial_holds_responses_and_what_figure_4_13_shows(tmp_path):
    trial = standing_trial()
    pathways = {name: TorquePathway(name, None) for name in ("ankle", *AS_PRINTED)}
    standing = process_standing(trial, "standing/x", OPTIONS, pathways, {})
    responses = cut_standing_epochs(standing, CUTTING)
    torques = {"as_printed": list(AS_PRINTED), "recommended": "ankle"}
    write_result(tmp_path / "trial.h5", trial_epochs_result(standing, responses, torques))
    read = read_result(tmp_path / "trial.h5")
    assert read.arrays["processed/time"] == pytest.approx(standing.time)
    assert read.arrays["processed/onsets_s"] == pytest.approx(ONSETS_S, abs=5e-4)
    assert read.arrays["processed/torque_recommended"] == pytest.approx(standing.torque["ankle"], rel=1e-6)
    printed = np.array([standing.torque[name] for name in AS_PRINTED])
    assert np.ptp(printed, axis=0).max() > 1.0  # two readings, two torques
    assert read.arrays["processed/torque_as_printed"] == pytest.approx(printed, rel=1e-6, abs=1e-6)
    assert read.units["processed/torque_as_printed"] == "Nm"
    assert read.units["processed/y_cop"] == "m"
    assert read.facts["fault"] is None
    assert read.facts["torques"] == torques
    again = epochs_of(read)
    assert again.count == 6
    assert set(again.perturbed) == set(responses.perturbed)
