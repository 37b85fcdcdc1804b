"""Generalised least squares with a free reflex torque: responses whose K, B and reflex are known."""

from dataclasses import replace

import numpy as np
import pytest
from free_reflex_builders import FREE, OPTIONS, RATE_HZ, B, K, fitted, group, responses

from tepsipe.errors import InputError
from tepsipe.experiments.standing.free_reflex.broadband import broadband_of, broadband_result
from tepsipe.experiments.standing.free_reflex.fit import (
    DISCREPANCY,
    REFLEX_ONSET,
    RESIDUAL,
    TREADMILL,
    WINDOW,
    effect_of_window,
    inside_window,
    sway_moments,
)
from tepsipe.experiments.standing.free_reflex.free_body import JointCentre
from tepsipe.experiments.standing.free_reflex.results import (
    FreeReflexChoices,
    difference_from_window,
    failed_checks,
    fit_free,
    quotable,
    quoted,
    task_difference,
    with_budgets,
    with_common_centre,
)
from tepsipe.experiments.standing.options import StandingEstimator, TorquePathway
from tepsipe.identification.regression.generalised import (
    Record,
    generalised_least_squares,
    integrated_wiener,
    sensitivity,
    squared_exponential,
)
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.statistics.uncertainty import Budget, Source
from tepsipe.treadmill.frame_peak import FramePeak
from tepsipe.treadmill.held_out import UNKNOWN


def centre_of(offset_m, error_m):
    """A centre that quiet sway shows (m), of a foot that does not turn."""
    place, error = np.array(offset_m), np.full(2, error_m)
    return JointCentre(place, place, place, error, sway_rad=0.004, foot_rad=0.0, stretches=8)


def noisy_angle(trial, noise_rad, seed):
    """The trial with low-passed noise of the angle (rad) and its rate, in quiet standing, too."""
    rng = np.random.default_rng(seed)
    changed = {}
    for name in ("perturbed", "quiet"):
        signals = getattr(trial, name).copy()
        noise = noise_rad * rng.standard_normal(signals.shape[:2])
        noise = butterworth_lowpass(noise, RATE_HZ, trial.cutoff_hz, trial.order, axis=1)
        signals[..., 1] += noise
        signals[..., 2] += np.gradient(noise, 1.0 / RATE_HZ, axis=1)
        changed[name] = signals
    zero = trial.baseline
    changed["perturbed"] -= changed["perturbed"][:, zero].mean(axis=1, keepdims=True)
    return replace(trial, **changed)


def attenuated(trials, window_s=0.08):
    """B and K of weighted least squares in the window, without a word on noise."""
    inside = (trials[0].time >= 0.0) & (trials[0].time <= window_s)
    means = [t.perturbed[:, inside].mean(axis=0) for t in trials]
    return generalised_least_squares(
        [Record(m[:, 0], m[:, [2, 1]], np.eye(inside.sum())) for m in means]
    ).parameters


@pytest.mark.parametrize("window_s", [0.05, 0.06, 0.08, 0.1])
def test_stiffness_does_not_depend_on_the_window_where_a_reflex_begins(window_s):
    fit = fitted(group(reflex=1.0), window_s)
    assert fit.parameters == pytest.approx([B, K], rel=0.025)


def test_least_squares_in_the_same_window_takes_the_reflex_for_stiffness():
    trials = group(reflex=1.0)
    inside = (trials[0].time >= 0.0) & (trials[0].time <= 0.1)
    means = [t.perturbed[:, inside].mean(axis=0) for t in trials]
    plain = generalised_least_squares([Record(m[:, 0], m[:, [2, 1]], np.eye(inside.sum())) for m in means])
    free = fitted(trials, 0.1).parameters
    # the reflex pushes one way whatever the direction of the belt: it spoils B or K of any one direction
    one_way = generalised_least_squares(
        [Record(m[:, 0], m[:, [2, 1]], np.eye(inside.sum())) for m in means[::2]]
    )
    assert abs(one_way.parameters[1] / K - 1.0) > 0.05 > 5.0 * abs(free[1] / K - 1.0)
    assert fitted(trials[::2], 0.1).parameters[1] == pytest.approx(K, rel=0.02)
    assert plain.parameters.shape == (2,)


def test_without_noise_and_reflex_the_truth_comes_back():
    fit = fitted(group(noise=1e-6))
    assert fit.parameters == pytest.approx([B, K], rel=1e-3)
    assert fit.vaf == pytest.approx(100.0, abs=1e-3)
    assert np.ptp(fit.windows[:, 2]) < 1e-3 * K


def test_contributions_are_those_of_the_sources():
    sources = [
        Source("force_scale", 0.01),
        Source("marked_rotation", 0.02),
        Source(REFLEX_ONSET, 0.004),
        Source(DISCREPANCY, 0.01),
    ]
    fit = fitted(group(noise=1e-6), sources=sources)
    values, budget = fit.parameters, fit.budget
    assert budget.contributions["force_scale"][0] == pytest.approx(0.01 * values, rel=1e-3)
    assert budget.contributions["marked_rotation"][0] == pytest.approx(-0.02 * values, rel=1e-3)
    # three draws of 1, -1 and 0 % of the torque: a standard deviation of 1 %
    assert budget.of_source(TREADMILL) == pytest.approx(0.01 * values, rel=1e-3)
    assert (budget.of_source(DISCREPANCY) > 0.0).all() and (budget.of_source(WINDOW) < 0.01 * values).all()
    assert {REFLEX_ONSET, WINDOW} < set(budget.contributions)


def test_what_the_treadmill_model_leaves_under_a_weight_counts_beyond_its_noise():
    def source(left, noise):
        trials = group(noise=0.05)
        torque = [left * trial.perturbed[..., 1].mean(axis=0) for trial in trials]
        error = [noise * trial.perturbed[..., 1].mean(axis=0) for trial in trials]
        shown = zip(trials, torque, error, strict=True)
        trials = [replace(trial, misfit=np.stack([mean, rows])) for trial, mean, rows in shown]
        fit = fitted(trials)
        assert fit.parameters == pytest.approx(fitted(group(noise=0.05)).parameters)
        (row,) = fit.budget.contributions[RESIDUAL]
        return row

    # a torque like that of 20 N m/rad, of which the noise of the weights explains nothing, a part, or all
    assert source(20.0, 0.0) == pytest.approx([0.0, 20.0], abs=0.05)
    assert source(-20.0, 0.0) == pytest.approx([0.0, -20.0], abs=0.05)
    noise = 20.0 * np.sqrt(8.0)  # of eight trials
    assert 12.0 < source(20.0, 0.5 * noise)[1] < 19.0
    assert source(20.0, 3.0 * noise) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert RESIDUAL not in fitted(group(noise=0.05)).budget.contributions


def test_windows_count_only_as_far_as_nothing_else_explains_their_spread():
    known = [Source(DISCREPANCY, 0.01), Source("force_scale", 0.05)]
    chance, wrong = group(5), group(5)
    late = np.clip(chance[0].time - 0.055, 0.0, None) / 0.02
    for trial in wrong:  # late torque that is not of a reflex: against the rotation in both directions
        angle = trial.perturbed[..., 1].mean(axis=0)
        trial.perturbed[..., 0] -= 12.0 * np.sign(angle[np.abs(angle).argmax()]) * late
    own, other = fitted(chance, sources=known), fitted(wrong, 0.06, known, reflex_onset_s=0.12)
    spread = [
        fit.budget.of_source(WINDOW)[1] / np.sqrt(np.mean((fit.windows[:, 2] - fit.parameters[1]) ** 2))
        for fit in (own, other)
    ]
    assert spread[0] < 0.8 and 0.95 < spread[1] <= 1.0


def test_effect_of_the_window_does_not_jump():
    variances, whole = np.array([[4.0, 4.0], [1.0, 1.0], [0.0, 0.0]]), np.array([9.0, 9.0])
    shape = np.array([[2.0, 2.0], [1.0, 1.0], [0.0, 0.0]])
    sizes = np.linspace(0.0, 4.0, 401)
    found = [np.sqrt((effect_of_window(size * shape, variances, whole)[:, 0] ** 2).sum()) for size in sizes]
    rms = np.sqrt((np.array([9 / 13, 9 / 10, 1.0]) @ shape[:, 0] ** 2) / (9 / 13 + 9 / 10 + 1.0))
    # steady: never more than 1.15 per unit of the spread, with 0 at first and all of it in the end
    steps = np.diff(found) / np.diff(sizes) / rms
    assert (steps >= 0.0).all() and steps.max() < 1.15
    assert found[50] < 0.25 * sizes[50] * rms and found[-1] > 0.9 * sizes[-1] * rms
    # by chance alone as much variance as the positive part
    chance = np.random.default_rng(1).standard_normal(20000)
    squares = chance**2 * rms**2
    drawn = np.interp(np.abs(chance), sizes, found) ** 2
    assert drawn.mean() == pytest.approx(np.maximum(0.0, squares - rms**2).mean(), rel=0.1)
    # a window of noise, ten times as uncertain as the estimate, hardly counts
    noisy = effect_of_window(
        np.array([[30.0, 30.0], [0.0, 0.0]]), np.array([[900.0, 900.0], [0.0, 0.0]]), np.array([9.0, 9.0])
    )
    assert np.abs(noisy).max() < 0.06 * 30.0


def named(trials, of_each):
    """The trials as epochs of recordings with so many directions each."""
    return [replace(trial, recording=f"trial-{k // of_each}") for k, trial in enumerate(trials)]


def test_trials_with_pulses_of_both_directions_count_once():
    alone, four, two = (fitted(trials) for trials in (group(), named(group(), 2), named(group(), 4)))
    assert np.array_equal(fitted(named(group(), 1)).budget.type_a, alone.budget.type_a)
    # eight means are four trials, whose pairs are left out in turn
    assert (alone.budget.freedom_a, four.budget.freedom_a) == (7.0, 3.0)
    left = np.array(
        [fitted([t for k, t in enumerate(group()) if k // 2 != out]).parameters for out in range(4)]
    )
    expected = np.sqrt(0.75 * ((left - left.mean(axis=0)) ** 2).sum(axis=0))
    assert four.budget.type_a == pytest.approx(expected, rel=0.1)
    # two trials say nothing on the scatter between trials, their 80 responses do
    assert two.budget.freedom_a == 72.0


def test_quiet_standing_of_a_trial_counts_once():
    loud, calm = responses(1, noise=0.3), responses(2, noise=0.1)
    inside = inside_window(loud.time, 0.08)
    both = [replace(loud, recording="a"), replace(loud, recording="a"), replace(calm, recording="b")]
    assert np.array_equal(sway_moments(both, inside), sway_moments([loud, calm], inside))


def test_epochs_from_a_file_keep_the_samples_at_the_edges():
    made = responses()
    # a file keeps the times in single precision, which moves some of them beyond an edge
    read = broadband_of(broadband_result(made))
    assert not np.array_equal(read.time, made.time)
    assert np.array_equal(read.baseline, made.baseline)
    assert read.time[read.baseline][[0, -1]] == pytest.approx(made.baseline_s)
    for window_s in (0.06, 0.1, 0.16):
        inside = inside_window(read.time, window_s)
        assert np.array_equal(inside, inside_window(made.time, window_s))
        assert read.time[inside][-1] == pytest.approx(window_s)
    shorter = made.time <= 0.16 + 1e-9
    cut = {name: getattr(read, name)[:, shorter] for name in ("perturbed", "draws")}
    cut |= {"time": read.time[shorter], "belt": read.belt[shorter]}
    cut["slopes"] = {name: slope[shorter] for name, slope in read.slopes.items()}
    assert fitted([replace(read, **cut)], 0.16).parameters[1] == pytest.approx(K, rel=0.1)


@pytest.mark.slow
def test_type_a_is_the_scatter_between_trials():
    spread = [fitted(group(seed)).parameters for seed in range(1, 13)]
    stated = np.mean([fitted(group(seed)).budget.type_a for seed in range(1, 5)], axis=0)
    assert stated == pytest.approx(np.std(spread, axis=0, ddof=1), rel=0.7)
    alone = fitted(group()[:1])
    assert alone.budget.freedom_a == 9.0 and alone.budget.type_a[1] > stated[1]


def test_window_beyond_the_epochs_is_refused():
    with pytest.raises(InputError, match=r"at most 0\.2 s .* found 0\.3 s: shorten it"):
        fitted(group(), 0.3)


# ---- among the other fits, and between tasks ---------------------------------------------------------


def choices(**sources):
    found = {name: Source(name, u) for name, u in sources.items()}
    return FreeReflexChoices("ankle", OPTIONS, found)


def task(trials, **sources):
    fits = fit_free(trials, "standing/x", FREE, choices(**sources), 10 * len(trials))
    return fits["ankle", "free"], with_budgets(Result({}, {}, {}), fits)


def test_difference_of_two_tasks_is_sharper_than_either():
    relaxed, less = task(group(1), force_scale=0.05)
    stiff, more = task(group(7, stiffness=600.0, damping=12.0), force_scale=0.05)
    rows, contributions = task_difference("stiff-relax", more, less, 555.0)
    found = {row.quantity: row for row in rows}
    assert found["K"].value == pytest.approx(230.0, rel=0.05)
    assert found["K"].u_type_b < 0.75 * min(stiff.budget.type_b[1], 2.0 * relaxed.budget.type_b[1])
    assert found["K"].standard_error < stiff.budget.combined[1]
    scale = [c for c in contributions if (c.source, c.quantity) == ("force_scale", "K")]
    assert scale[0].u == pytest.approx(0.05 * found["K"].value, rel=0.02)
    assert found["K_over_mgh"].value == pytest.approx(found["K"].value / 555.0)


def test_palpated_centre_counts_where_sway_shows_none():
    known = {"joint_centre_anterior_m": 0.002, "joint_centre_height_m": 0.002, "palpated_centre_m": 0.01}
    trials = group()
    for trial in trials:
        trial.slopes["joint_centre_anterior_m"][:, 0] = 50.0 * trial.perturbed[..., 1].mean(axis=0)
    shown = centre_of((0.0, 0.0), 1e-5)
    seen, felt = (
        task([replace(t, centre=centre, centre_used=centre is not None) for t in trials], **known)[
            0
        ].budget.of_source("joint_centre_anterior_m")
        for centre in (shown, None)
    )
    # felt with 10 mm, and 2 mm that sway leaves in any case
    assert felt == pytest.approx(np.hypot(1.0, 5.0) * seen, rel=1e-3)


def test_centre_of_all_trials_is_weighed_against_the_one_that_was_felt():
    known = {name: Source(name, 0.002) for name in ("joint_centre_anterior_m", "joint_centre_height_m")}
    known |= {"palpated_centre_m": Source("palpated_centre_m", 0.01)}
    centres = [centre_of((0.006 + k * 1e-4, -0.004), 0.02) for k in (-2, -1, 1, 2)]
    trials = [
        replace(t, centre=centre, centre_used=False) for t, centre in zip(group(), centres, strict=False)
    ]
    for trial in trials:
        trial.slopes["joint_centre_anterior_m"][:, 0] = 50.0
    # four trials of 20 mm each say as much as one of 10 mm, which is as much as was felt
    moved, sources = with_common_centre(trials, known, trials)
    assert moved[0].perturbed[..., 0] - trials[0].perturbed[..., 0] == pytest.approx(50.0 * 0.003)
    expected = np.hypot(0.002, 0.01 / np.sqrt(2.0))
    assert [source.standard_uncertainty for source in sources] == pytest.approx([expected, expected])
    # responses to the opposite perturbations of the same trials say nothing more
    assert [
        s.standard_uncertainty for s in with_common_centre(trials * 2, known, trials)[1]
    ] == pytest.approx([expected, expected])
    # trials of another task show the same centre, and count by their sway: here a quarter
    other = [
        replace(t, centre=replace(t.centre, offset_m=np.full(2, 0.016), sway_rad=0.002)) for t in trials[:1]
    ]
    moved, sources = with_common_centre(other, known, [*trials, *other])
    s2 = (4 * 0.02**2 + (0.25 * 0.02) ** 2) / 4.25**2
    mean, weight = (4 * 0.006 + 0.25 * 0.016) / 4.25, 1e-4 / (1e-4 + s2)
    assert moved[0].perturbed[..., 0] - other[0].perturbed[..., 0] == pytest.approx(50.0 * weight * mean)
    assert sources[0].standard_uncertainty == pytest.approx(np.sqrt(0.002**2 + (1.0 - weight) * 1e-4))
    # a foot that tilts moves the centre by 50 mm as its rotation doubles, by 10 mm where that is known to 0.2
    turning = [
        replace(
            t, turned=tuple((replace(t.centre, offset_m=t.centre.offset_m + x), 0.0) for x in (-0.02, 0.02))
        )
        for t in trials
    ]
    moved, sources = with_common_centre(
        turning, known | {"foot_rotation": Source("foot_rotation", 0.2)}, turning
    )
    assert moved[0].perturbed[..., 0] - trials[0].perturbed[..., 0] == pytest.approx(50.0 * 0.002)
    expected = np.sqrt(0.002**2 + (0.01 / 3.0) ** 2 + (0.02 / 3.0) ** 2)
    assert sources[0].standard_uncertainty == pytest.approx(expected)
    assert moved[0].slopes["foot_rotation"][:, 0] == pytest.approx(0.05 / 3.0 * 50.0)


@pytest.mark.parametrize("noise_rad", [1e-4, 4e-3])
def test_noise_of_the_angle_does_not_bias(noise_rad):
    def noisy(seed):
        return [noisy_angle(t, noise_rad, seed + k) for k, t in enumerate(group(seed))]

    found = np.array([fitted(noisy(seed)).parameters for seed in range(1, 13)])
    error = found.std(axis=0, ddof=1) / np.sqrt(len(found))
    assert (np.abs(found.mean(axis=0) - (B, K)) < 3.0 * error + 0.01 * np.array([B, K])).all()
    # as much noise in the regressors without instruments attenuates
    uncorrected = np.array([attenuated(noisy(seed)) for seed in range(1, 13)])
    if noise_rad == 4e-3:
        assert (uncorrected.mean(axis=0) < found.mean(axis=0) - 3.0 * error)[0]


def test_origin_of_the_plate_counts_more_where_no_weight_shows_it():
    """K is off by 600 N·m/rad per metre of the origin, which is known to 0.002 m or to 0.01 m."""
    known = {"origin_anterior_m": 0.002, "unknown_origin_m": 0.01}
    trials = group()
    for trial in trials:
        trial.slopes["origin_anterior_m"][:, 0] = 600.0 * trial.perturbed[..., 1].mean(axis=0)
    shown, unknown = (
        task([replace(t, origin_known=state) for t in trials], **known)[0].budget.of_source(
            "origin_anterior_m"
        )
        for state in (True, False)
    )
    assert shown[1] == pytest.approx(600.0 * 0.002, rel=0.05)
    assert unknown == pytest.approx(5.0 * shown)


COMPENSATED = TorquePathway("ankle", "bristle-frame")


def rows_of_task(**values):
    names = ("standing_tasks", "relax", "ankle", "free")
    return [Estimate(*names, name, "unit", value) for name, value in values.items()]


def test_torque_that_is_not_compensated_is_flagged_and_not_quoted():
    chosen = {"pathway": "ankle", "estimator": "free"}
    rows = rows_of_task(B=9.0, K=420.0, VAF=90.0)
    assert [r.recommended for r in quoted(rows, [], {}, chosen, COMPENSATED)] == [True, True, False]
    found = quoted(rows, [], {}, chosen, TorquePathway("ankle", None))
    assert [r.flags for r in found] == ["uncompensated", "uncompensated", ""]
    assert not any(r.recommended for r in found)
    assert quoted(rows, [], {}, chosen, TorquePathway("single-joint", None))[0].recommended


@pytest.mark.parametrize("values", [{"B": -0.5, "K": 420.0}, {"B": 9.0, "K": -3.0}])
def test_negative_damping_or_stiffness_is_never_quoted(values):
    found = quoted(rows_of_task(**values), [], {}, {"pathway": "ankle", "estimator": "free"}, COMPENSATED)
    assert [r.flags for r in found] == ["negative", "negative"]
    assert not any(r.recommended for r in found)


def test_inertia_is_refused():
    with pytest.raises(InputError, match="inertia: true for free"):
        fit_free(group(), "x", {"free": StandingEstimator(0.08, True, "free")}, choices(), 80)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "flag"),
    [
        ({}, None),
        ({"skin_m": 0.004}, "skin-motion"),
        ({"skin_m": 0.0015}, None),
        # the interval has the uncertainty of the palpated centre
        ({"centre_used": False}, None),
        ({"calibrated_kg": 20.0}, "beyond-calibrated-mass"),
        ({"calibrated_kg": None}, None),
        ({"treadmill_error": (0.2 * K, 0.03 * K)}, "treadmill-model"),
        # perhaps, not clearly, beyond a tenth of K
        ({"treadmill_error": (0.12 * K, 0.03 * K)}, None),
        # a model below its limit: the error is not known
        ({"treadmill_error": (0.0, UNKNOWN)}, "treadmill-model"),
        (
            {"treadmill_error": (0.0, UNKNOWN), "treadmill_flag": "treadmill-not-converged"},
            "treadmill-not-converged",
        ),
        ({"plate_flags": ("plate-transducer",)}, "plate-transducer"),
        ({"frame": FramePeak(29.0, 60.0), "empty_frame": FramePeak(35.0, 60.0)}, "frame-resonance"),
        ({"frame": FramePeak(34.0, 60.0), "empty_frame": FramePeak(35.0, 60.0)}, None),
        ({"frame": FramePeak(29.0, 60.0), "empty_frame": FramePeak(None, 40.0)}, None),
    ],
)
def test_what_the_trials_show_is_flagged(changes, flag):
    trials = [replace(trial, **changes) for trial in group()]
    assert failed_checks(fitted(trials), trials, 80, None) == ((flag,) if flag else ())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "flags", "good"),
    [(1.0, (), True), (1.15, (), True), (1.33, ("trials-differ",), True), (0.5, ("trials-differ",), False)],
)
def test_trial_of_another_stiffness_is_named(factor, flags, good):
    for seed, place in ((3, 6), (9, 1)):
        trials = named(group(seed), 1)
        own = trials[place]
        sign = float(np.sign(own.belt[34, 0]))
        other = responses(500 + seed, stiffness=factor * K, peak=own.peak_m_per_s, sign=sign)
        trials[place] = replace(other, recording="standing/other")
        fits = fit_free(trials, "standing/relax", FREE, choices(), 80)
        (found,) = fits.values()
        kept = [flag for flag in found.quantities["K"].flags if flag == "trials-differ"]
        assert (tuple(kept), found.quotable) == (flags, good)
        assert [sentence.split(":")[0] for sentence in found.apart] == ["standing/other"] * bool(flags)
        (pathway, estimator), chosen = next(iter(fits)), rows_of_task(B=9.0, K=420.0)
        rows = quoted(chosen, trials, fits, {"pathway": pathway, "estimator": estimator}, COMPENSATED)
        assert all(row.recommended for row in rows) == good


@pytest.mark.parametrize(("gain", "flags"), [(1.0, []), (1.1, []), (1.5, ["halves-differ"])])
def test_late_responses_that_differ_from_early_ones_are_flagged(gain, flags):
    for seed in (2, 7):
        trials = group(seed)[:4]
        for trial in trials:
            trial.perturbed[trial.count // 2 :, :, 0] *= gain
        assert [f for f in failed_checks(fitted(trials), trials, 1, None) if f == "halves-differ"] == flags


@pytest.mark.parametrize(("flag", "good"), [("calibration-differs", True), ("other-calibration", False)])
def test_nothing_is_quoted_with_a_force_plate_of_another_calibration(flag, good):
    trials = [replace(trial, plate_flags=(flag,)) for trial in group()]
    fits = fit_free(trials, "standing/relax", FREE, choices(), 80)
    (pathway, estimator), rows = next(iter(fits)), rows_of_task(B=9.0, K=420.0)
    found = quoted(rows, trials, fits, {"pathway": pathway, "estimator": estimator}, COMPENSATED)
    assert flag in fits[pathway, estimator].quantities["K"].flags
    assert [row.recommended for row in found] == [good, good]


def test_estimate_is_not_to_be_quoted_where_the_treadmill_certainly_makes_half_of_it():
    for error, good in ((0.4, True), (0.52, True), (0.7, False), (-0.7, False)):
        assert quotable([replace(group()[0], treadmill_error=(300.0 * error, 30.0))], 300.0) == good
    assert quotable(group(), 300.0)


def test_few_perturbations_windows_and_another_stiffness_are_flagged():
    trials = group()
    fit = fitted(trials)
    certain = Budget(np.zeros(2), np.inf)
    assert failed_checks(fit, trials, 130, None) == ("few-perturbations",)
    assert failed_checks(fit, trials, 80, (np.array([0.0, 0.04 * K]), certain)) == ()
    assert failed_checks(fit, trials, 80, (np.array([0.0, -0.1 * K]), certain)) == ("pre-reflex-differs",)
    spread = replace(fit, windows=fit.windows * [1.0, 1.0, 1.0] + [[0.0, 0.0, 30.0 * k] for k in range(5)])
    assert failed_checks(spread, trials, 80, None) == ("window-sensitive",)


def test_difference_from_a_short_window_counts_common_sources_once():
    sources = [Source("force_scale", 0.05), Source("marked_rotation", 0.05)]
    trials = group()
    fit = fitted(trials, sources=sources)
    _, budget = difference_from_window(trials, fit, 0.06, OPTIONS, sources)
    assert budget.of_source("force_scale")[1] < 0.1 * fit.budget.of_source("force_scale")[1]


# ---- generalised least squares ----------------------------------------------------------------------


def test_covariance_of_an_integrated_wiener_process(rng):
    time = np.linspace(0.0, 0.1, 101)
    steps = rng.standard_normal((4000, 100)) * np.sqrt(0.001)
    rate = np.cumsum(steps, axis=1)
    drawn = np.cumsum(rate, axis=1) * 0.001
    expected = integrated_wiener(time, 0.0)[1:, 1:]
    assert np.cov(drawn.T)[[99, 49], [99, 99]] == pytest.approx(expected[[99, 49], [99, 99]], rel=0.1)
    assert not integrated_wiener(time, 0.05)[:51].any()


def test_generalised_least_squares_is_aitkens(rng):
    x, y = rng.standard_normal((20, 2)), rng.standard_normal(20)
    c = squared_exponential(np.arange(20.0), 1.0) + 0.1 * np.eye(20)
    fit = generalised_least_squares(
        [Record(y[:12], x[:12], c[:12, :12]), Record(y[12:], x[12:], c[12:, 12:])]
    )
    block = np.zeros((20, 20))
    block[:12, :12], block[12:, 12:] = c[:12, :12], c[12:, 12:]
    root = np.linalg.inv(np.linalg.cholesky(block))
    assert fit.parameters == pytest.approx(np.linalg.lstsq(root @ x, root @ y, rcond=None)[0])
    alone = generalised_least_squares([Record(y[12:], x[12:], c[12:, 12:])])
    assert fit.without_each()[0] == pytest.approx(alone.parameters)


def test_sensitivity_is_the_derivative(rng):
    x, y, dx, dy = (rng.standard_normal(shape) for shape in ((20, 2), 20, (20, 2), 20))
    record = Record(y, x, np.eye(20))
    fit = generalised_least_squares([record])
    h = 1e-6
    moved = [generalised_least_squares([Record(y + s * h * dy, x + s * h * dx, np.eye(20))]) for s in (1, -1)]
    slope = (moved[0].parameters - moved[1].parameters) / (2.0 * h)
    assert sensitivity(fit, [record], [dy], [dx]) == pytest.approx(slope, rel=1e-5)
