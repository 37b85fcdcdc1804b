"""TEP-SIPE from markers and belt to parameters, pathway by pathway."""

from dataclasses import fields, replace

import numpy as np
import pytest
from builders import LEG, RATE_HZ, Joint, assert_one_sentence, swing
from scipy.interpolate import CubicSpline

from tepsipe.errors import InputError
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, analyse_dummy
from tepsipe.experiments.dummy.options import Pathway
from tepsipe.experiments.dummy.results import cross_validate_dummy, dummy_result, fitted_dummy
from tepsipe.identification.estimators import ESTIMATORS, Estimator, Record
from tepsipe.io.trial import Signal, Trial
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.perturbations import WindowOptions

LAYOUT = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.63], [-0.012, 0.39], [0.012, 0.15]])
LABELS = ("ankle", "leg1", "leg2", "leg3", "leg4")
SAMPLING_HZ = 2500.0
OPTIONS = DummyOptions(
    leg=LEG,
    leg_markers=SegmentMarkers(LABELS, LAYOUT),
    lowpass_cutoff_hz=20.0,
    lowpass_order=4,
    window=WindowOptions(
        rest_before_s=2.0,
        rest_after_s=2.0,
        rest_margin_s=0.2,
        threshold_fraction=0.05,
        signal_to_noise=5.0,
        merge_s=0.06,
    ),
)
PATHWAYS = {
    "leg-thesis": Pathway("leg-thesis", "aligned", "windowed-least-squares-thesis"),
    "leg": Pathway("leg", "aligned", "windowed-least-squares"),
    "leg-as-sampled": Pathway("leg", "as-sampled", "windowed-least-squares"),
}
ONSETS_S = (2.0, 4.0, 6.0, 8.0)


def positions_at(moved, instants):
    """Markers on the leg, marker k at the instants of column k, shape (n, markers, 3)."""
    time = moved.motion.time
    ankle = CubicSpline(time, moved.belt_position)
    angle = CubicSpline(time, moved.motion.theta)
    positions = np.zeros((*instants.shape, 3))
    for k, (across, along) in enumerate(LAYOUT):
        theta = angle(instants[:, k])
        positions[:, k, 1] = ankle(instants[:, k]) + across * np.cos(theta) + along * np.sin(theta)
        positions[:, k, 2] = 0.055 - across * np.sin(theta) + along * np.cos(theta)
    return positions


def trial_of_swing(joint, peak_m_per_s=0.3, noise_m=0.0, seed=1):
    moved = swing(joint, ONSETS_S, peak_m_per_s, duration_s=14.0)
    time = moved.motion.time[:-1]
    together = np.tile(time[:, None], len(LABELS))
    strobed = together + np.arange(3, 3 + len(LABELS)) / SAMPLING_HZ
    rng = np.random.default_rng(seed)
    noise = noise_m * rng.standard_normal((time.size, len(LABELS), 3))
    markers = ("time", "marker", "axis")
    return Trial(
        rate_hz=RATE_HZ,
        axes={"time": time, "marker": np.array(LABELS), "axis": np.array(["x", "y", "z"])},
        signals={
            "belt_velocity": Signal(moved.belt_velocity[:-1], "m/s", ("time",), "belt"),
            "belt_command": Signal(moved.belt_velocity[:-1], "m/s", ("time",), "command"),
            "marker_position": Signal(positions_at(moved, together) + noise, "m", markers, "aligned"),
            "marker_position_as_sampled": Signal(
                positions_at(moved, strobed) + noise, "m", markers, "as strobed"
            ),
        },
    )


@pytest.fixture(scope="module")
def exact():
    return analyse_dummy(trial_of_swing(Joint(rest=0.005)), OPTIONS, PATHWAYS)


@pytest.fixture(scope="module")
def noisy():
    return analyse_dummy(trial_of_swing(Joint(), noise_m=5e-5), OPTIONS, PATHWAYS)


def test_recommended_pathway_gives_the_joint_and_the_printed_one_does_not(exact):
    leg, printed = exact.regressions["leg"], exact.regressions["leg-thesis"]
    assert len(leg.fits) == 4
    assert leg.mean == pytest.approx([0.0, 0.1, 10.0], rel=0.01, abs=2e-4)
    assert printed.mean[0] == pytest.approx(2.0 * 0.027, rel=0.05)
    assert printed.mean[2] < 8.0


def test_markers_taken_as_if_sampled_at_once_give_another_damping(exact):
    leg, strobed = exact.regressions["leg"], exact.regressions["leg-as-sampled"]
    assert abs(strobed.mean[1] - leg.mean[1]) > 0.005
    assert strobed.mean[2] == pytest.approx(leg.mean[2], rel=0.05)
    assert exact.marker_residual_rms_m > 1e-5


def test_damping_falls_when_position_is_taken_later_than_angle(exact):
    assert set(exact.damping_per_com_lag) == set(PATHWAYS)
    assert 30.0 < exact.damping_per_com_lag["leg"] < 100.0


def test_rows_hold_means_over_perturbations_and_their_intervals(noisy):
    fitted = fitted_dummy("sine-0.3", noisy, 500, 1)
    rows = {(row.pathway, row.quantity): row for row in fitted.estimates}
    assert len(rows) == 3 * 5
    for name, regression in noisy.regressions.items():
        row = rows[name, "K"]
        assert row.value == pytest.approx(regression.parameters[:, 2].mean())
        assert row.ci_low < row.value < row.ci_high
        assert row.n_perturbations == 4
        assert row.estimator == PATHWAYS[name].estimator
        assert rows[name, "VAF_trial"].value == regression.vaf_trial
        sem = np.mean([fit.sem_as_printed[2] for fit in regression.fits])
        assert row.sem_as_printed == pytest.approx(sem)


def test_noise_lowers_the_vaf_of_the_right_torque_below_that_of_the_wrong_one(noisy):
    right, wrong = noisy.regressions["leg"], noisy.regressions["leg-thesis"]
    assert wrong.vaf_per_perturbation.mean() > 99.5
    assert right.vaf_per_perturbation.mean() < wrong.vaf_per_perturbation.mean() - 0.5


def test_interval_of_a_pathway_does_not_depend_on_which_others_there_are(noisy):
    trial = trial_of_swing(Joint(), noise_m=5e-5)
    alone = analyse_dummy(trial, OPTIONS, {"leg": PATHWAYS["leg"]})

    def low(analysis, seed):
        rows = fitted_dummy("sine-0.3", analysis, 300, seed).estimates
        (vaf,) = (r for r in rows if (r.pathway, r.quantity) == ("leg", "VAF_perturbation"))
        return vaf.ci_low

    assert low(noisy, 7) == low(alone, 7) != low(alone, 8)


def test_cross_validation_predicts_the_torque_with_the_other_trials_parameters(exact):
    other = analyse_dummy(trial_of_swing(Joint(damping=0.2, stiffness=14.0)), OPTIONS, PATHWAYS)
    results = {name: dummy_result(analysis) for name, analysis in (("soft", exact), ("stiff", other))}
    matrix = cross_validate_dummy(results, "leg")
    own = [analysis.regressions["leg"].vaf_trial for analysis in (exact, other)]
    assert np.diag(matrix) == pytest.approx(own)
    assert matrix[0, 1] < matrix[1, 1] - 1.0
    assert matrix[1, 0] < matrix[0, 0] - 1.0
    with pytest.raises(InputError) as caught:
        cross_validate_dummy(results, "foot")
    assert_one_sentence(caught.value, "'foot'", "soft")


def test_trial_whose_rest_is_perturbed_is_refused():
    late = Joint()
    moved = swing(late, (2.0, 4.0, 12.2), duration_s=14.0)
    trial = trial_of_swing(late)
    signals = trial.signals | {"belt_velocity": Signal(moved.belt_velocity[:-1], "m/s", ("time",), "belt")}
    with pytest.raises(InputError) as caught:
        analyse_dummy(Trial(RATE_HZ, trial.axes, signals), OPTIONS, PATHWAYS)
    assert_one_sentence(caught.value, "rest")


def test_output_error_stands_beside_the_regressions_and_changes_none_of_them(noisy):
    trial = trial_of_swing(Joint(), noise_m=5e-5)
    pathways = PATHWAYS | {"simulated": Pathway("leg", "aligned", "output-error")}
    found = analyse_dummy(trial, replace(OPTIONS, belt_fixed_labels=("ankle",)), pathways)
    for name, regression in noisy.regressions.items():
        assert found.regressions[name].parameters.tolist() == regression.parameters.tolist()
    assert found.regressions["simulated"].mean == pytest.approx([0.0, 0.1, 10.0], rel=0.03, abs=3e-3)
    fitted = fitted_dummy("x", found, 200, 1)
    rows = {r.quantity: r for r in fitted.estimates if r.pathway == "simulated"}
    assert {"I", "B", "K", "VAF_perturbation", "VAF_trial", "VAF_theta_trial"} == set(rows)
    assert rows["K"].sem_as_printed is None
    assert rows["K"].standard_error < 0.1
    assert rows["VAF_theta_trial"].value > 98.0
    result = fitted.result
    assert result.arrays["simulated/simulated_angle"].shape == found.time.shape
    assert set(result.facts["output_error_delay_s"]) == {"simulated"}


def test_output_error_finds_the_leg_later_than_the_foot_if_the_strober_is_forgotten():
    pathways = {"simulated": Pathway("leg", "as-sampled", "output-error")}
    found = analyse_dummy(trial_of_swing(Joint()), replace(OPTIONS, belt_fixed_labels=("ankle",)), pathways)
    # the leg's angle is sampled 0.4 to 1.6 ms after the ankle: weighted by the lever, and opposite in sign
    assert 1e-4 < abs(found.simulating_fits["simulated"].delay_s) < 2e-3
    assert found.regressions["simulated"].mean[2] == pytest.approx(10.0, rel=0.01)


@pytest.mark.parametrize("part", [field.name for field in fields(Record)])
def test_an_estimator_gets_each_part_of_a_record_that_it_needs_alone(part, exact, monkeypatch):
    given = []

    def fit(record):
        given.append(getattr(record, part))
        return exact.regressions["leg"]

    monkeypatch.setitem(ESTIMATORS, "toy", Estimator("the joint, whatever is recorded", (part,), fit))
    options, toy = replace(OPTIONS, belt_fixed_labels=("ankle",)), {"toy": Pathway("leg", "aligned", "toy")}
    found = analyse_dummy(trial_of_swing(Joint(rest=0.005)), options, toy)
    assert given and given[0] is not None
    assert fitted_dummy("x", found, 200, 1).estimates[2].value == pytest.approx(10.0, rel=0.01)


@pytest.mark.parametrize("labels", [(), ("heel",)])
def test_output_error_without_markers_on_the_foot_is_refused(labels):
    pathways = {"simulated": Pathway("leg", "aligned", "output-error")}
    with pytest.raises(InputError) as caught:
        analyse_dummy(trial_of_swing(Joint()), replace(OPTIONS, belt_fixed_labels=labels), pathways)
    assert_one_sentence(caught.value, "belt_fixed_labels")


def test_fit_does_not_need_the_command():
    trial = trial_of_swing(Joint(stiffness=10.0))
    without = replace(trial, signals={k: s for k, s in trial.signals.items() if k != "belt_command"})
    found = analyse_dummy(without, OPTIONS, {"leg": PATHWAYS["leg"]})
    assert found.regressions["leg"].mean[2] == pytest.approx(10.0, rel=0.01)
    assert "belt_command" not in dummy_result(found).arrays
