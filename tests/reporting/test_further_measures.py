"""Further statements of the thesis, measured on hand-made results."""

import numpy as np
import pytest

from tepsipe.experiments.forward.scores import ForwardScore
from tepsipe.experiments.noise.rows import NoiseRow
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.reporting.claims import Findings
from tepsipe.reporting.further_measures import MEASURES
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


def test_spread_counts_the_parameter_of_its_column():
    def fit(inertia, damping):
        return Result({"leg-thesis/parameters": np.array([[0.0, 0.0, 0.0], [inertia, damping, 1.0]])}, {}, {})

    fits = {f"{p}-0.1": fit(1.0, 1.0) for p in ("sine", "minjerk")}
    fits |= {f"{p}-0.5": fit(0.5, 3.0) for p in ("sine", "minjerk")}
    assert measured("printed_inertia_spread_ratio", fits={"dummy": fits}) == pytest.approx(0.5)
    assert measured("printed_damping_spread_ratio", fits={"dummy": fits}) == pytest.approx(3.0)


def test_coherence_and_admittance_are_taken_from_their_bands():
    frequency = np.array([2.0, 4.0, 8.0, 12.0, 25.0])
    coherence = np.array([0.9, 0.7, 0.8, 0.1, 0.3])
    arrays = {
        "spectral-fit/frequency": frequency,
        "spectral-fit/coherence": coherence,
        "spectral-fit/response": np.array([1.0, 2.0, 3.0, 0.5j, 100.0]),
        "tapered/frequency": frequency,
        "tapered/coherence": coherence,
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
    assert measured("noise_snr_effect", noise=rows) == pytest.approx(3.0)
    assert measured("noise_spread_of_smallest", noise=rows) == pytest.approx(3.0)
    assert measured("noise_spread_by_target", noise=rows) == pytest.approx(0.25)


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


def test_simulated_angle_is_compared_between_intervals():
    scores = [
        ForwardScore("sine-0.5", "tep", "theta", 0.0, -20.0, "grows", 1.0),
        ForwardScore("sine-0.5-8s", "tep", "theta", 0.0, 10.0, "grows", 1.0),
        ForwardScore("sine-0.5-8s", "corrected", "theta", 0.0, 90.0, "settles", 1.0),
    ]
    assert measured("simulated_angle_at_8s", forward=scores) == pytest.approx(30.0)
