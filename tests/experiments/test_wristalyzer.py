"""The Wristalyzer's analysis from a trial to rows: known joints, honest intervals, fair prediction."""

from dataclasses import replace

import numpy as np
import pytest
from builders import assert_one_sentence, multisine_record, trial_of
from scipy import signal, stats

from tepsipe.errors import InputError
from tepsipe.experiments.wristalyzer.analysis import (
    ESTIMATORS,
    RECOMMENDED,
    Estimator,
    JointFit,
    analyse_wristalyzer,
    cross_validate_wristalyzer,
    validate_other_bounds,
    wristalyzer_record,
    wristalyzer_result,
    wristalyzer_rows,
)
from tepsipe.experiments.wristalyzer.averaging import sweep_averaging
from tepsipe.experiments.wristalyzer.names import IN_TABLE
from tepsipe.experiments.wristalyzer.options import Impedance, WristalyzerOptions
from tepsipe.experiments.wristalyzer.record import prepare
from tepsipe.identification.budgets.manipulator import period_budget, spectral_budget
from tepsipe.identification.regression.periods import PeriodicRecord, fit_periods
from tepsipe.identification.result import quantities_of
from tepsipe.mechanics.impedance_model import admittance
from tepsipe.statistics.uncertainty import Budget, Source

JOINT = np.array([0.015, 0.1, 8.0])
START = np.array([0.001, 0.1, 5.0])
OPTIONS = WristalyzerOptions(
    lowpass_cutoff_hz=20.0,
    lowpass_order=4,
    cut_s=4.0,
    averaged_bins=8,
    fit_band_hz=(1.0, 9.0),
    perturbation_period_s=10.0,
    excited_band_hz=(1.0, 20.0),
    start=Impedance(0.001, 0.1, 10.0),
    lower=Impedance(-10.0, 0.01, -20.0),
    upper=Impedance(10.0, 10.0, 20.0),
    random_starts=2,
    tried_stiffness_Nm_per_rad=(5.0, 15.0),
    profile_stiffness_Nm_per_rad=(6.0, 10.0),
    profile_points=21,
)


def trial_with(joint=JOINT, noise_rad=0.0, periods=3.3, seed=3):
    torque, angle = multisine_record(joint, periods, seed=seed)
    angle = angle + noise_rad * np.random.default_rng(seed).standard_normal(angle.size)
    return trial_of(256.0, torque=(torque, "Nm"), angle=(angle, "rad"))


def analyse(trial, options=OPTIONS):
    return analyse_wristalyzer(trial, options, np.random.default_rng(1))


def budget_of(analysis, estimator, sources=None):
    """Budget of a spectral fit, whose contributions have signs."""
    fit = analysis.fitted[estimator]
    band = fit.spectrum.band(*OPTIONS.fit_band_hz)
    return spectral_budget(fit.search, band, OPTIONS.bounds, sources or {})


def budget_of_periods(trial, sources):
    record = wristalyzer_record(trial, QUICK)[0]
    periods = trial.rate_hz, QUICK.perturbation_period_s, QUICK.excited_band_hz
    whole = PeriodicRecord(record.recorded("torque"), record.recorded("angle"), *periods)
    return period_budget(fit_periods(whole), sources)


@pytest.fixture(scope="module")
def noisy():
    return analyse(trial_with(noise_rad=0.003))


@pytest.fixture(scope="module")
def exact():
    return analyse(trial_with())


@pytest.fixture(scope="module")
def stiff_and_soft():
    """Two trials, one of a joint that is stiffer by 30 %."""
    return [analyse(trial_with(JOINT * [1.0, 1.0, k], seed=5)) for k in (1.3, 1.0)]


def rows_of(analysis, estimator):
    rows = wristalyzer_rows("0.16", analysis)[0]
    return {row.quantity: row for row in rows if row.estimator == estimator}


@pytest.mark.slow
def test_whole_periods_recover_the_joint_through_the_filter(exact):
    found = exact.fitted["spectral-fit-periods"]
    assert found.parameters == pytest.approx(JOINT, rel=1e-3)


def test_averaged_bins_recover_inertia_and_stiffness_and_bias_damping(exact):
    averaged, whole = (exact.fitted[name].parameters for name in ("spectral-fit", "spectral-fit-periods"))
    assert averaged[[0, 2]] == pytest.approx(JOINT[[0, 2]], rel=0.03)
    assert abs(averaged[1] / JOINT[1] - 1.0) > 10.0 * abs(whole[1] / JOINT[1] - 1.0)


@pytest.mark.slow
def test_rows_hold_every_quantity_of_every_estimator(noisy):
    rows = wristalyzer_rows("0.16", noisy)[0]
    assert list(noisy.fitted) == list(ESTIMATORS)
    searched = [name for name, found in noisy.fitted.items() if found.search is not None]
    assert {"spectral-fit", "spectral-fit-modulus", "spectral-fit-periods"} <= set(searched)
    names = [name for name in ESTIMATORS for _ in range(5 if name in searched else 4)]
    assert [row.estimator for row in rows] == names
    assert [row.quantity for row in rows[:5]] == ["I", "B", "K", "error", "VAF_trial"]
    assert {row.condition for row in rows} == {"0.16"}


@pytest.mark.parametrize("estimator", ["spectral-fit", "spectral-fit-periods"])
def test_intervals_have_the_freedom_of_the_frequencies_that_determine_a_parameter(estimator, noisy):
    fitted = noisy.fitted[estimator].spectrum.band(*OPTIONS.fit_band_hz).frequency_hz.size
    budget = budget_of(noisy, estimator)
    freedom = budget.freedom_a
    assert (freedom > 2.0).all()
    assert (freedom <= 2 * fitted - 3).all()
    quantile = stats.t.ppf(0.975, budget.effective_freedom[1])
    row = rows_of(noisy, estimator)["B"]
    assert (row.ci_high - row.ci_low) / 2.0 == pytest.approx(quantile * row.standard_error, rel=1e-6)


def test_interval_of_stiffness_over_periods_holds_the_joint_and_the_modulus_has_none(noisy):
    row = rows_of(noisy, "spectral-fit-periods")["K"]
    assert row.standard_error == pytest.approx(np.hypot(row.u_type_a, row.u_type_b))
    assert row.ci_low < JOINT[2] < row.ci_high
    for quantity in ("I", "B", "K"):
        none = rows_of(noisy, "spectral-fit-modulus")[quantity]
        assert none.sem_as_printed is not None
        assert (none.standard_error, none.ci_low, none.ci_high) == (None, None, None)


def test_error_is_the_sum_of_squares_that_the_fit_left(noisy):
    assert rows_of(noisy, "spectral-fit")["error"].value == noisy.fitted["spectral-fit"].search.cost
    assert rows_of(noisy, "spectral-fit")["error"].unit == "1"


def test_angle_is_predicted_from_the_torque_alone():
    prepared = prepare(trial_with(), OPTIONS)
    assert prepared.prediction_vaf(JOINT) > 99.9
    assert prepared.prediction_vaf(JOINT * [1.0, 1.0, 0.5]) < 50.0
    assert prepared.kept == slice(1024, 8448 - 1024)


def test_coherence_outside_the_root_weights_the_criterion_by_its_square(noisy):
    outside = analyse(trial_with(noise_rad=0.003), replace(OPTIONS, coherence_outside_root=True))
    inside, found = (analysis.fitted["spectral-fit"] for analysis in (noisy, outside))
    # the coherence itself is the same
    assert found.spectrum.coherence == pytest.approx(inside.spectrum.coherence)
    band = found.spectrum.band(*OPTIONS.fit_band_hz)
    ratio = np.log(band.response / admittance(found.parameters, band.frequency_hz))
    errors = np.sqrt(1.0 / band.frequency_hz) * band.coherence * np.abs(ratio)
    assert found.search.cost == pytest.approx(np.sum(errors**2))
    assert 0.0 < found.search.cost < inside.search.cost
    assert found.parameters != pytest.approx(inside.parameters, rel=1e-6)
    assert found.parameters == pytest.approx(inside.parameters, rel=0.1)


def test_trial_without_a_period_is_fitted_from_averaged_bins_only():
    found = analyse(trial_with(), replace(OPTIONS, perturbation_period_s=None))
    assert {"spectral-fit", "spectral-fit-modulus"} <= set(found.fitted)
    assert set(found.fitted) == {name for name, one in ESTIMATORS.items() if not one.needs_period}
    assert not {"spectral-fit-periods", "period-regression"} & set(found.fitted)
    assert found.profile.interval[0] < found.fitted["spectral-fit"].parameters[2]


def test_record_that_nothing_is_left_of_is_refused():
    with pytest.raises(InputError) as caught:
        analyse(trial_with(periods=0.85))
    assert_one_sentence(caught.value, "9 s")


@pytest.mark.parametrize("still", ["torque", "angle"])
def test_trial_without_perturbation_or_motion_is_refused(still, rng):
    signals = {"torque": rng.standard_normal(5000), "angle": rng.standard_normal(5000)}
    signals[still] = np.zeros(5000)
    trial = trial_of(256.0, torque=(signals["torque"], "Nm"), angle=(signals["angle"], "rad"))
    with pytest.raises(InputError) as caught:
        analyse(trial)
    assert_one_sentence(caught.value, "constant")


@pytest.mark.slow
def test_cross_validation_predicts_every_trial_with_every_trials_parameters(stiff_and_soft):
    stiff, soft = stiff_and_soft
    results = {"stiff": wristalyzer_result(stiff), "soft": wristalyzer_result(soft)}
    matrix = cross_validate_wristalyzer(results)
    own = [rows_of(a, "spectral-fit")["VAF_trial"].value for a in (stiff, soft)]
    assert np.diag(matrix) == pytest.approx(own)
    assert (matrix[~np.eye(2, dtype=bool)] < 80.0).all()
    crossed = soft.prepared.prediction_vaf(stiff.fitted["spectral-fit"].parameters)
    assert matrix[0, 1] == pytest.approx(crossed)


def test_fits_within_other_bounds_are_scored_in_their_own_trial_and_in_the_others(stiff_and_soft):
    stiff, soft = map(wristalyzer_result, stiff_and_soft)
    good, falling = JOINT * [1.0, 1.0, 1.3], np.array([0.015, -0.5, 8.0])
    for result, tried in ((stiff, [good, falling]), (soft, [good])):
        result.arrays["other_bounds/parameters"] = np.array(tried)
    found = validate_other_bounds({"stiff": stiff, "soft": soft})
    assert found[0, 0] > 99.0 and found[0, 1] < 80.0
    assert found[1].tolist() == [0.0, 0.0, 0.0]
    assert found[2, :2].tolist() == found[0, 1::-1].tolist()
    assert found[:, 2].tolist() == found[:, 1].tolist()  # one other trial


def test_fit_at_a_bound_flags_its_rows_and_no_others(exact):
    narrow = replace(OPTIONS, upper=Impedance(10.0, 10.0, 6.5), start=Impedance(*START))
    found = analyse(trial_with(), replace(narrow, tried_stiffness_Nm_per_rad=(5.0,)))
    flags = {row.flags for row in wristalyzer_rows("0.16", found)[0] if row.estimator == "spectral-fit"}
    assert flags == {"at-bound"}
    free = [row for row in wristalyzer_rows("0.16", exact)[0] if "modulus" not in row.estimator]
    assert {row.flags for row in free} == {""}


SOURCES = {
    "torque_scale": Source("torque_scale", 0.02),
    "angle_scale": Source("angle_scale", 0.01),
    "torque_delay_s": Source("torque_delay_s", 5e-4),
}


def shifted(trial, delay_s=0.0, torque_scale=1.0, angle_scale=1.0):
    """The trial as a rig records it whose torque, angle and delay are off."""
    torque, angle = trial.values("torque"), trial.values("angle")
    frequency = np.fft.rfftfreq(torque.size, 1.0 / trial.rate_hz)
    early = np.fft.irfft(np.fft.rfft(torque) * np.exp(2j * np.pi * frequency * delay_s), torque.size)
    return trial_of(trial.rate_hz, torque=(early / torque_scale, "Nm"), angle=(angle * angle_scale, "rad"))


QUICK = replace(
    OPTIONS,
    random_starts=0,
    tried_stiffness_Nm_per_rad=(10.0,),
    profile_stiffness_Nm_per_rad=(7.0, 9.0),
    profile_points=3,
)


def of_estimator(analysis, estimator):
    return analysis.fitted[estimator].parameters


@pytest.fixture(scope="module")
def with_sources():
    """A trial, its analysis with all sources, and the budget of every estimator."""
    trial = trial_with(noise_rad=1e-4)
    analysis = analyse_wristalyzer(trial, QUICK, np.random.default_rng(1), SOURCES)
    budgets = {e: budget_of(analysis, e, SOURCES) for e in ("spectral-fit", "spectral-fit-periods")}
    return trial, analysis, budgets | {"period-regression": budget_of_periods(trial, SOURCES)}


@pytest.mark.slow
@pytest.mark.parametrize("name", SOURCES)
def test_contribution_of_a_source_is_what_the_whole_analysis_returns_with_it(name, with_sources):
    (trial, analysis, budgets), u = with_sources, SOURCES[name].standard_uncertainty
    key, nominal = ("delay_s", 0.0) if name == "torque_delay_s" else (name, 1.0)
    above, below = (analyse(shifted(trial, **{key: nominal + sign * u}), QUICK) for sign in (1.0, -1.0))
    for estimator, budget in budgets.items():
        quantities = analysis.fitted[estimator].quantities
        values = {q: quantities[q].value for q in "IBK"}
        for q, stated in quantities_of(values, budget).items():
            assert quantities[q] == replace(stated, as_printed=quantities[q].as_printed)
        found = 0.5 * (of_estimator(above, estimator) - of_estimator(below, estimator))
        if estimator == "period-regression" and name == "torque_delay_s":
            assert name not in budget.contributions
            assert np.abs(found / JOINT).max() < 2e-3
        else:
            stated = budget.contributions[name][0]
            assert (np.abs(stated - found) < 1e-4 * JOINT + 0.03 * np.abs(found)).all()


@pytest.mark.slow
def test_regression_over_periods_is_recommended_and_the_spectral_fit_without_a_period(noisy):
    told = {(r.estimator, r.quantity) for r in wristalyzer_rows("0.16", noisy)[0] if r.recommended}
    assert told == {("period-regression", q) for q in "IBK"}
    alone = analyse(trial_with(), replace(QUICK, perturbation_period_s=None))
    told = {(r.estimator, r.quantity) for r in wristalyzer_rows("0.16", alone)[0] if r.recommended}
    assert told == {("spectral-fit", q) for q in "IBK"}


def test_budget_rows_hold_scatter_and_every_source_of_every_estimator():
    found = analyse_wristalyzer(trial_with(noise_rad=0.003), QUICK, np.random.default_rng(1), SOURCES)
    rows, table = wristalyzer_rows("0.16", found)
    of = {e: {c.source for c in table if c.estimator == e} for e in found.fitted}
    assert of["spectral-fit-modulus"] == set()
    assert of["spectral-fit"] == {"scatter", "frequency_resolution", *SOURCES}
    assert of["spectral-fit-periods"] == {"scatter", "fit_criterion", *SOURCES}
    assert of["period-regression"] == {"scatter", "fitted_band", "torque_scale", "angle_scale"}
    for row in rows:
        own = [c.u for c in table if (c.estimator, c.quantity) == (row.estimator, row.quantity)]
        if own:
            assert row.standard_error == pytest.approx(np.sqrt(np.sum(np.square(own))))


def test_estimator_in_the_registry_is_fitted_and_becomes_rows_with_its_budget(monkeypatch):
    half = JOINT / 2.0

    def function(record):
        assert record.recorded("torque").size == record.prepared.kept.stop - record.prepared.kept.start
        budget = Budget(0.1 * half, 10.0, {})
        return JointFit(quantities_of(dict(zip("IBK", half, strict=True)), budget), ("not-converged",))

    monkeypatch.setitem(ESTIMATORS, "half", Estimator("half of the joint", function))
    found = analyse(trial_with(), QUICK)
    rows = rows_of(found, "half")
    assert list(rows) == ["I", "B", "K", "VAF_trial"]
    assert [rows[q].value for q in "IBK"] == half.tolist()
    # half of the joint does not predict the angle either
    assert {row.flags for row in rows.values()} == {"not-converged;lack-of-fit"}
    assert not any(row.recommended for row in rows.values())
    table = [c for c in wristalyzer_rows("0.16", found)[1] if c.estimator == "half"]
    assert {row.source for row in table} == {"scatter"} and rows["K"].u_type_a == pytest.approx(
        0.05 * JOINT[2]
    )
    assert "half" not in wristalyzer_result(found).facts["converged"]


def test_registry_names_what_is_recommended_and_what_a_trial_without_a_period_allows():
    assert set(RECOMMENDED) <= set(ESTIMATORS)
    assert not ESTIMATORS[RECOMMENDED[-1]].needs_period
    assert IN_TABLE == ("spectral-fit", "spectral-fit-periods") and set(IN_TABLE) <= set(ESTIMATORS)
    assert all(one.meaning for one in ESTIMATORS.values())


# ---- number of averaged frequencies


@pytest.fixture(scope="module")
def swept():
    torque, angle = multisine_record(JOINT, 6.0)
    noise = 2e-3 * np.random.default_rng(5).standard_normal(angle.size)
    trial = trial_of(256.0, torque=(torque, "Nm"), angle=(angle + noise, "rad"))
    numbers = (1, 2, 8, 32, 64, 1000)
    return {row.averaged_bins: row for row in sweep_averaging(trial, "0.16", OPTIONS, numbers)}


def test_averaging_leaves_out_numbers_that_leave_too_few_frequencies(swept):
    assert list(swept) == [1, 2, 8, 32, 64]
    # 52 s are kept: 8 Hz are 416 lines and both ends
    assert [row.frequencies for row in swept.values()] == [417, 208, 52, 13, 6]


def test_single_frequencies_are_coherent_without_a_lowest_one(swept):
    assert swept[1].lowest_coherence == pytest.approx(1.0)
    assert swept[1].linear_coherence == pytest.approx(1.0)
    assert np.isnan(swept[1].lowest_coherence_Hz)


def test_averaging_across_the_resonance_lowers_the_coherence_of_a_linear_joint_there(swept):
    natural_hz = np.sqrt(JOINT[2] / JOINT[0]) / (2.0 * np.pi)
    assert swept[64].lowest_coherence_Hz == pytest.approx(natural_hz, rel=0.2)
    assert swept[64].linear_coherence < swept[8].linear_coherence - 0.1
    # noise takes its part beside the averaging
    assert swept[64].lowest_coherence <= swept[64].linear_coherence + 1e-3


def test_error_of_a_noisy_record_falls_when_frequencies_are_averaged(swept):
    assert swept[1].error > 5.0 * swept[2].error > 50.0 * swept[8].error


# ---- faults of the record ------------------------------------------------------------------------


def late(trial, samples):
    """The trial with an angle that is recorded late by whole samples."""
    angle = trial.signals["angle"]
    signals = trial.signals | {"angle": replace(angle, values=np.roll(angle.values, samples))}
    return replace(trial, signals=signals)


@pytest.mark.slow
@pytest.mark.parametrize("samples", [0, 3, -3, 8])
def test_late_trigger_is_measured_corrected_and_flagged(samples):
    found = analyse(late(trial_with(noise_rad=0.001), samples))
    row = rows_of(found, "period-regression")["K"]
    assert row.ci_low < JOINT[2] < row.ci_high
    assert ("log-delay" in row.flags) == (samples != 0)
    assert "lack-of-fit" not in row.flags


@pytest.mark.slow
def test_angle_without_a_response_is_never_quoted_without_a_flag():
    trial = trial_with()
    noise = 0.01 * np.random.default_rng(4).standard_normal(trial.time.size)
    trial = replace(trial, signals=trial.signals | {"angle": replace(trial.signals["angle"], values=noise)})
    for row in wristalyzer_rows("0.16", analyse(trial))[0]:
        assert "lack-of-fit" in row.flags


@pytest.mark.slow
def test_errors_of_the_stamps_that_ingest_measured_flag_every_estimate():
    trial = replace(trial_with(noise_rad=0.001), attributes={"stamp_jitter_s": 0.002})
    assert all("stamp-jitter" in row.flags for row in wristalyzer_rows("0.16", analyse(trial))[0])


def recorded(change, noise_rad=0.002):
    """Flags of a trial whose angle is changed as ``change`` returns it."""
    trial = trial_with(noise_rad=noise_rad, periods=4.9)
    angle = replace(trial.signals["angle"], values=change(trial.values("angle")))
    changed = replace(trial, signals=trial.signals | {"angle": angle})
    return wristalyzer_record(changed, QUICK)[1]


@pytest.mark.parametrize("cutoff_hz", [8.0, 12.0, 20.0])
def test_angle_that_was_filtered_before_is_flagged(cutoff_hz):
    sos = signal.butter(2, cutoff_hz, fs=256.0, output="sos")
    assert "filtered-signal" in recorded(lambda x: signal.sosfiltfilt(sos, x))
    assert recorded(lambda x: x) == ()


@pytest.mark.parametrize(
    ("gain", "flags"), [(1.02, ()), (1.15, ("halves-differ",)), (0.8, ("halves-differ",))]
)
def test_gain_that_changes_within_a_trial_is_flagged(gain, flags):
    assert recorded(lambda x: np.where(np.arange(x.size) > x.size // 2, gain, 1.0) * x) == flags


def test_faults_of_the_recording_are_flags_of_every_row():
    trial = replace(trial_with(noise_rad=0.003), attributes={"faults": "spikes;held-samples"})
    rows = wristalyzer_rows("0.16", analyse(trial))[0]
    assert all({"spikes", "held-samples"} <= set(row.flags.split(";")) for row in rows)
