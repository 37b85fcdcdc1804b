"""Further statements of the thesis, measured on hand-made results."""

from types import SimpleNamespace

import numpy as np
import pytest

from tepsipe.experiments.forward.scores import ForwardScore
from tepsipe.experiments.noise.rows import NoiseRow
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.mechanics.impedance_model import simulate_angle
from tepsipe.reporting.chapters.dummy import _cross_validated, _largest_step_of_sd
from tepsipe.reporting.claims import MEASURES, Findings
from tepsipe.reporting.thesis_tables import TableRow


def of_dummy(quantity, values, pathway="leg-thesis"):
    unit = "%" if quantity.startswith("VAF") else "-"
    estimator = "windowed-least-squares-thesis"
    return [Estimate("dummy", c, pathway, estimator, quantity, unit, v) for c, v in values.items()]


def measured(measure, estimates=(), fits=None, **more):
    return MEASURES[measure](Findings(list(estimates), fits or {}, "leg-thesis", **more))


FITS = {"dummy": {}}


def test_profiles_and_amplitudes_are_compared_by_what_they_leave_unexplained():
    vaf = {"sine-0.1": 99.0, "sine-0.5": 99.9, "minjerk-0.1": 98.0, "minjerk-0.5": 99.8, "sine-0.5-8s": 50.0}
    rows = of_dummy("VAF_trial", vaf)
    assert measured("printed_minjerk_over_sine", rows, FITS) == pytest.approx(np.log(2.0))
    assert measured("printed_small_over_large", rows, FITS) == pytest.approx(10.0)


def test_damping_and_stiffness_every_8_s_are_compared_with_every_4_s():
    rows = of_dummy("B", {"sine-0.5": -0.002, "sine-0.5-8s": 0.0138, "minjerk-0.5": 0.01})
    assert measured("printed_damping_change_sine_8s", rows, FITS) == pytest.approx(0.0158)
    assert measured("printed_negative_dampings", rows, FITS) == 1.0
    with pytest.raises(KeyError):
        measured("printed_damping_change_minjerk_8s", rows, FITS)
    rows = of_dummy("K", {"sine-0.5": 5.0, "sine-0.5-8s": 4.0})
    assert measured("printed_stiffness_ratio_sine_8s", rows, FITS) == pytest.approx(0.8)


def test_foot_is_noisier_only_if_it_is_so_in_every_trial():
    rows = of_dummy("VAF_perturbation", {"sine-0.1": 99.0, "sine-0.5": 99.0})
    rows += of_dummy("VAF_perturbation", {"sine-0.1": 90.0, "sine-0.5": 99.5}, "foot-thesis")
    assert measured("foot_over_leg", rows, FITS) == pytest.approx(0.5)


def test_cross_validation_is_judged_by_the_predicting_and_by_the_predicted_trial():
    rng = np.random.default_rng(1)
    joints = {"sine-0.1": [0.0, 0.0, 5.0], "sine-0.5": [0.0, 0.0, 6.0], "minjerk-0.1": [0.0, 0.0, 6.6]}
    fits = {}
    for name, joint in joints.items():
        regressors = rng.standard_normal((100, 3))
        arrays = {"parameters": np.array([joint]), "regressors": regressors, "torque": regressors @ joint}
        fits[name] = Result({f"leg-thesis/{key}": array for key, array in arrays.items()}, {}, {})
    # VAF of a scaled torque: 100 % times (1 - (1 - K of the predicting over K of the predicted trial)^2)
    means = [
        100.0 * np.mean([1.0 - (1.0 - k / own) ** 2 for k in (5.0, 6.0, 6.6) if k != own])
        for own in (5.0, 6.0, 6.6)
    ]
    assert measured("printed_lowest_predicted", fits={"dummy": fits}) == pytest.approx(min(means))
    run = SimpleNamespace(fits={"dummy": fits}, settings={"dummy": {"as_printed": "leg-thesis"}})
    crossed = _cross_validated(run)
    assert crossed["predicted_percent"] == pytest.approx(means)
    assert len(crossed["single_percent"]) == 6
    assert _largest_step_of_sd(run) == {}
    alone = SimpleNamespace(fits={"dummy": {"a": fits["sine-0.1"]}}, settings=run.settings)
    assert _cross_validated(alone) == {"single_percent": [], "predicted_percent": []}


def test_spread_counts_the_parameter_of_its_column():
    def fit(inertia, damping):
        return Result({"leg-thesis/parameters": np.array([[0.0, 0.0, 0.0], [inertia, damping, 1.0]])}, {}, {})

    fits = {f"{p}-0.1": fit(1.0, 1.0) for p in ("sine", "minjerk")}
    fits |= {f"{p}-0.5": fit(0.5, 3.0) for p in ("sine", "minjerk")}
    assert measured("printed_inertia_spread_ratio", fits={"dummy": fits}) == pytest.approx(0.5)
    assert measured("printed_damping_spread_ratio", fits={"dummy": fits}) == pytest.approx(3.0)


def test_spread_is_also_compared_from_each_amplitude_to_the_next():
    fits = {
        f"sine-0.{k}": Result({"leg-thesis/parameters": np.outer([0.0, 1.0], sizes)}, {}, {})
        for k, sizes in ((1, (4.0, 4.0, 4.0)), (2, (2.0, 5.0, 1.0)), (3, (1.0, 1.0, 2.0)))
    }
    run = SimpleNamespace(fits={"dummy": fits}, settings={"dummy": {"as_printed": "leg-thesis"}})
    assert _largest_step_of_sd(run) == pytest.approx({"I": 0.5, "B": 1.25, "K": 2.0})


def test_coherence_and_admittance_are_taken_from_their_bands():
    frequency = np.array([2.0, 4.0, 8.0, 12.0, 25.0])
    coherence = np.array([0.9, 0.7, 0.8, 0.1, 0.3])
    arrays = {
        "spectral-fit/frequency": frequency,
        "spectral-fit/coherence": coherence,
        "spectral-fit/response": np.array([1.0, 2.0, 3.0, 0.5j, 100.0]),
    }
    fits = {"wristalyzer": {"0.16": Result(arrays, {}, {})}}
    assert measured("wristalyzer_lowest_coherence", fits=fits) == 0.7
    assert measured("wristalyzer_frequency_of_lowest_coherence", fits=fits) == 4.0
    assert measured("wristalyzer_coherence_drop", fits=fits) == pytest.approx(0.625 - 0.3)
    assert measured("wristalyzer_above_9_hz", fits=fits) == pytest.approx(0.25)


def test_relative_sem_compares_stiffness_with_inertia():
    def of(quantity, value, sem):
        names = ("wristalyzer", "0.16", "admittance", "spectral-fit", quantity, "-")
        return Estimate(*names, value, sem_as_printed=sem)

    assert measured("wristalyzer_relative_sem", [of("I", 0.01, 0.02), of("K", 10.0, 10.0)]) == pytest.approx(
        0.5
    )


def noise(estimator, noise_on, condition, snr_db, sd):
    return NoiseRow(condition, noise_on, snr_db, estimator, "K", 1.0, sd, None, 9, "-", 10.0, None, None)


def test_spread_of_the_noise_study_by_snr_amplitude_and_target():
    rows = [
        noise("as-printed", "tau", "sine-0.1", snr, sd) for snr, sd in ((0.0, 6.0), (20.0, 1.0), (40.0, 2.0))
    ]
    rows += [
        noise("as-tabulated", "tau", "sine-0.1", 20.0, 6.0),
        noise("as-tabulated", "tau", "sine-0.5", 20.0, 2.0),
    ]
    rows += [
        noise("as-tabulated", "theta", "sine-0.1", 20.0, 1.0),
        noise("as-tabulated", "tau", "minjerk-0.1", 20.0, 99.0),
    ]
    assert measured("noise_spread_of_smallest", noise=rows) == pytest.approx(3.0)
    assert measured("noise_spread_by_target", noise=rows) == pytest.approx(0.25)


def test_signal_to_noise_ratio_has_an_effect_if_the_mean_of_the_estimates_depends_on_it():
    def rows(means):
        return [
            NoiseRow("sine-0.1", target, snr, "as-printed", "K", mean, 1.0, None, 9, "-", 10.0, None, None)
            for target in ("tau", "theta", "both")
            for snr, mean in zip((0.0, 60.0), means if target == "theta" else (9.0, 9.0), strict=True)
        ]

    assert measured("noise_snr_effect", noise=rows((9.0, 9.0))) == 0.0
    assert measured("noise_snr_effect", noise=rows((-19.0, 10.0))) == pytest.approx(2.9)


def test_noise_is_compared_with_the_truth_and_across_targets():
    def row(reading, quantity, values):
        return TableRow(reading, "K = 10 Nm/rad", quantity, "", values, [None] * 4)

    table = [
        row("as-tabulated", "I", [0.0, 0.03, 0.04, 0.05]),
        row("recommended-regression", "I", [0.02, 0.0, 0.0, 0.0]),
        row("as-tabulated", "VAF_cross_validated", [None, 72.0, 99.0, 71.0]),
    ]
    assert measured("noise_inertia_ratio", table_4_4=table) == pytest.approx(2.0)
    assert measured("noise_angle_validates_best", table_4_4=table) == pytest.approx(27.0)


def swing(condition, growth, vaf=0.0, parameter_set="thesis-tep"):
    names = {"condition": condition, "parameter_set": parameter_set, "quantity": "theta"}
    return SimpleNamespace(**names, vaf_trial=vaf, state="settles", growth=growth)


def test_printed_joint_amplifies_by_its_growth_not_by_its_vaf():
    scores = [swing("sine-0.5", 4.5, -20.0), swing("sine-0.5-8s", 1.5, 10.0)]
    scores += [swing("sine-0.5", 9.0, parameter_set="tep")]
    assert measured("simulated_amplifies", forward=scores) == 4.5
    assert measured("simulated_amplifies_less", forward=scores) == pytest.approx(3.0)
    with pytest.raises(KeyError):
        measured("simulated_amplifies", forward=scores[1:2])


def test_parameter_sets_are_compared_by_their_least_favourable_conditions():
    def score(condition, name, perturbation, trial):
        return ForwardScore(condition, name, "pybullet", "theta", perturbation, trial, "settles", 1.0)

    scores = [
        score("sine-0.1", "thesis-wristalyzer", 99.0, 80.0),
        score("sine-0.5", "thesis-wristalyzer", 95.0, 90.0),
        score("sine-0.1", "thesis-tep", 92.0, -10.0),
        score("sine-0.5", "thesis-tep", -50.0, 5.0),
    ]
    assert measured("simulated_angle_gap", forward=scores) == 75.0
    assert measured("simulated_angle_gap_in_perturbations", forward=scores) == 3.0


def test_largest_force_is_the_largest_of_all_profiles_and_amplitudes():
    force = {f"{p}-0.{k}": 10.0 * k for p in ("sine", "minjerk") for k in range(1, 6)}
    force |= {"sine-0.3": 60.0, "heavy-sine-0.5": 500.0}
    rows = [Estimate("weight", c, "force", "peak", "added_force_peak", "N", v) for c, v in force.items()]
    assert measured("weight_largest", rows, {"weight": {}}) == pytest.approx(50.0 / 60.0)


def test_low_sems_are_low_for_every_parameter_in_spite_of_a_negative_value():
    names = ("leg-thesis", "printed")
    rows = [
        Estimate("dummy", "sine-0.1", *names, quantity, "1", value, sem_as_printed=sem)
        for quantity, value, sem in (("I", 0.06, 0.0006), ("B", -0.002, 0.006), ("K", 6.0, 0.6))
    ]
    assert measured("printed_sem", rows, FITS) == pytest.approx(3.0)


def test_angle_matches_by_the_median_over_conditions():
    scores = [swing(c, 1.0, v, "thesis-wristalyzer") for c, v in zip("abc", (50.0, 80.0, 99.0), strict=True)]
    assert measured("simulated_angle_matched", forward=scores) == 80.0
    assert measured("simulated_angle_of_tep", forward=[swing("a", 1.0, 20.0), swing("b", 1.0, 40.0)]) == 40.0


def test_linear_equation_has_one_minimum_unless_its_regressors_depend_on_each_other():
    def fit(errors):
        sems = np.repeat(np.array(errors)[:, None], 3, axis=1)
        return {"dummy": {"a": Result({"leg-thesis/sem": sems}, {}, {})}}

    assert measured("printed_minima", fits=fit([[1e-4, 4e-3, 0.2], [3e-4, 6e-3, 0.4]])) == 0.0
    assert measured("printed_minima", fits=fit([[1e-4, 4e-3, 0.2], [np.inf, np.inf, 0.4]])) == 1.0


def test_transition_line_is_a_misfit_above_9_hz_that_exceeds_the_one_below():
    frequency = np.array([0.0, 2.0, 6.0, 12.0, 18.0, 30.0])
    omega = 2.0 * np.pi * frequency
    model = 1.0 / (10.0 - 0.015 * omega**2 + 0.1j * omega)

    def ratio(above):
        response = model * np.exp(np.where(frequency >= 9.0, above, 0.1))
        arrays = {"frequency": frequency, "response": response, "parameters": np.array([0.015, 0.1, 10.0])}
        fit = Result({f"spectral-fit/{name}": array for name, array in arrays.items()}, {}, {})
        return measured("wristalyzer_transition_line", fits={"wristalyzer": {"0.16": fit}})

    assert ratio(0.1) == pytest.approx(1.0)
    assert ratio(0.5) == pytest.approx(5.0)


def test_only_fits_with_a_high_vaf_count_for_what_other_bounds_lose():
    torque = np.random.default_rng(1).standard_normal(2560)
    joints = {"a": (0.015, 0.1, 10.0), "b": (0.015, 0.1, 10.5)}

    def lost(*of_a):
        fits = {}
        for name, joint in joints.items():
            arrays = {"torque": torque, "angle": simulate_angle(np.array(joint), torque, 256.0)}
            arrays["other_bounds/parameters"] = np.array(of_a if name == "a" else [joint])
            fits[name] = Result(arrays, {}, {"kept_samples": [256, 2304], "rate_hz": 256.0})
        return measured("wristalyzer_lost_with_other_bounds", fits={"wristalyzer": fits})

    little = lost(joints["a"])
    assert 0.0 < little < 10.0
    # it loses most, but its own VAF is low
    assert lost(joints["a"], (0.015, 0.1, 7.0)) == little
    joints["b"] = (0.015, 0.1, 20.0)
    assert lost(joints["a"]) > 10.0


def test_amplitudes_are_compared_by_the_noise_in_which_all_their_pulses_are_found():
    def row(condition, level, share):
        names = ("belt", level, "detection", "onsets_found")
        return NoiseRow(condition, *names, share, 0.0, None, 25, "%", 10.0, None, None)

    lowest = {"sine-0.1": 30.0, "sine-0.5": 20.0, "minjerk-0.1": 40.0, "minjerk-0.5": 10.0}
    rows = [
        row(c, level, 100.0 if level >= start else 60.0)
        for c, start in lowest.items()
        for level in (10.0, 20.0, 30.0, 40.0)
    ]
    assert measured("noise_of_amplitude", noise=rows) == 10.0


def test_noise_that_lowers_all_parameters_but_one_does_not_lower_all():
    def table(inertia):
        rows = {
            "I": [0.015, inertia, inertia, inertia],
            "B": [0.1] + 3 * [0.03],
            "K": [10.0, 3.0, 0.03, 0.01],
        }
        return [
            TableRow(reading, "K = 10 Nm/rad", quantity, "", values, [None] * 4)
            for quantity, values in rows.items()
            for reading in ("as-tabulated", "recommended-regression")
        ]

    assert measured("noise_largest_ratio", table_4_4=table(0.039)) == pytest.approx(2.6)
    assert measured("noise_largest_ratio", table_4_4=table(0.010)) < 1.0
