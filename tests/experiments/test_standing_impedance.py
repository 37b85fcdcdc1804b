"""Impedance of ankles of known impedance comes back; what reflexes add to it is told apart or told."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from builders import assert_one_sentence
from emg_builders import ramp_burst
from standing_builders import RESPONSE_TIME, SIZES, bent, responses_with, twitched

from tepsipe.errors import InputError
from tepsipe.experiments.standing.estimates import fit_rows
from tepsipe.experiments.standing.muscle_torque import ACTIVE, ActiveOptions, MuscleTorque, twitch
from tepsipe.experiments.standing.options import StandingEstimator
from tepsipe.experiments.standing.thesis.impedance import DELAYS as NAMES
from tepsipe.experiments.standing.thesis.impedance import fit_all, fit_standing, of_draws, over_sway
from tepsipe.mechanics.impedance_model import PARAMETERS

K, B, INERTIA = 370.0, 6.0, 0.05
ANGLE, RATE, ACCELERATION = bent(RESPONSE_TIME)
INTRINSIC = K * ANGLE + B * RATE
OPTIONS = ActiveOptions(
    twitch_s=(0.02, 0.032, 0.04, 0.048),
    reflex_delay_s=(0.036, 0.044, 0.052),
    balance_delay_s=(0.092, 0.112, 0.132),
    action={"TA": -1.0, "SOL": 1.0, "GAS": 1.0},
)
SHORT = StandingEstimator(window_s=0.06, inertia=False, active="none")
WITH_INERTIA = StandingEstimator(window_s=0.15, inertia=True, active="none")
LONG = StandingEstimator(window_s=0.3, inertia=False, active="none")
VELOCITY = StandingEstimator(window_s=0.3, inertia=False, active="velocity")
EMG = StandingEstimator(window_s=0.5, inertia=False, active="emg")
DELAYS = {"T": 0.04, "L": 0.044, "D": 0.112}
GAINS = {"G_plus": 30.0, "G_minus": 10.0, "P": 80.0, "Q": 20.0}
FORCE = {"TA": 0.3, "SOL": 0.4, "GAS": 0.2}  # Nm/uV
BURSTS = {
    "TA": lambda t: 20.0 * ramp_burst(t, 0.044),
    "SOL": lambda t: 40.0 * ramp_burst(t, 0.09),
    "GAS": lambda t: 30.0 * ramp_burst(t, 0.13, 0.02, 0.08),
}
DRIVE = {muscle: burst(RESPONSE_TIME) for muscle, burst in BURSTS.items()}


def fit(trials, estimator=SHORT, options=OPTIONS, draws=50, seed=1):
    trials = trials if isinstance(trials, list) else [trials]
    return fit_standing(trials, "ankle", estimator, options, draws, np.random.default_rng(seed))


def found(result):
    """Name -> value of a fit."""
    joint = {name: result.quantities[name].value for name in PARAMETERS if name in result.quantities}
    return joint | result.gains


def values(result):
    """I, B, K and gains of a fit."""
    return list(found(result).values())


def numbers(result, name):
    """Value, standard error, and both ends of the interval of a quantity."""
    q = result.quantities[name]
    return q.value, q.standard_error, q.low, q.high


def delays(result):
    """T, L, D of a fit."""
    return {key: result.quantities[name] for key, name in NAMES.items() if name in result.quantities}


def values_of_delays(result):
    return {key: delay.value for key, delay in delays(result).items()}


def ranges(result):
    return {key: (delay.low, delay.high) for key, delay in delays(result).items()}


def at_bound(result):
    return [key for key, delay in delays(result).items() if delay.flags == ("at-bound",)]


def rows_of(result):
    return fit_rows("relax", {("ankle", "fit"): result}, 555.0)[0]


def within(window_s):
    """True for the samples of a window (s), and of the filter's width before the onset."""
    time = RESPONSE_TIME
    return (time >= -0.03) & (time <= window_s)


@cache
def by_reflexes():
    """Torque (Nm) of reflexes and balance, as the estimator's head describes it."""

    def drive(t):
        stretch, (angle, rate, _) = bent(t - DELAYS["L"])[1], bent(t - DELAYS["D"])
        reflex = GAINS["G_plus"] * np.maximum(stretch, 0.0) - GAINS["G_minus"] * np.maximum(-stretch, 0.0)
        return reflex + GAINS["P"] * angle + GAINS["Q"] * rate

    return twitched(drive, DELAYS["T"])


@cache
def by_muscles():
    """Torque (Nm) of the muscles' bursts."""
    return sum(OPTIONS.action[m] * FORCE[m] * twitched(BURSTS[m], DELAYS["T"]) for m in FORCE)


# ---- intrinsic impedance -----------------------------------------------------------------------


@pytest.mark.parametrize("estimator", [SHORT, LONG])
def test_stiffness_and_damping_come_back_exactly(estimator):
    result = fit(responses_with(INTRINSIC), estimator)
    assert found(result) == pytest.approx({"B": B, "K": K}, rel=1e-9)
    assert result.quantities["VAF_response"].value == pytest.approx(100.0)
    assert (result.curves[0]["active"] == 0.0).all()
    assert result.responses == len(SIZES)
    for name, value in (("B", B), ("K", K)):
        assert numbers(result, name) == pytest.approx((value, 0.0, value, value), rel=1e-9, abs=1e-9)


def test_inertia_comes_back_where_it_is_asked_for():
    responses = responses_with(INTRINSIC + INERTIA * ACCELERATION)
    result = fit(responses, WITH_INERTIA)
    assert found(result) == pytest.approx({"I": INERTIA, "B": B, "K": K}, rel=1e-9)
    assert abs(found(fit(responses, replace(WITH_INERTIA, inertia=False)))["K"] - K) > 50.0


def test_what_unperturbed_standing_shows_too_is_no_response():
    beside = 3.0 * np.sin(2.0 * np.pi * 2.0 * RESPONSE_TIME)
    result = fit(responses_with(INTRINSIC, beside=beside), LONG)
    assert values(result) == pytest.approx([B, K], rel=1e-9)
    kept = responses_with(INTRINSIC, beside=beside)
    kept.unperturbed["torque/ankle"][:] = 0.0
    assert abs(found(fit(kept, LONG))["K"] - K) > 10.0


@pytest.mark.parametrize("estimator", [SHORT, WITH_INERTIA, VELOCITY])
def test_torque_three_times_as_large_has_three_times_the_parameters(estimator):
    torque = INTRINSIC + by_reflexes()
    once, thrice = fit(responses_with(torque), estimator), fit(responses_with(3.0 * torque), estimator)
    assert delays(thrice) == delays(once)
    assert values(thrice) == pytest.approx(3.0 * np.array(values(once)), rel=1e-6)
    for name in set(PARAMETERS) & once.quantities.keys():
        assert numbers(thrice, name) == pytest.approx(3.0 * np.array(numbers(once, name)), rel=1e-6)
    explained = [result.quantities["VAF_response"].value for result in (once, thrice)]
    assert explained[1] == pytest.approx(explained[0])


def test_delay_that_all_signals_share_changes_nothing():
    angle, rate, _ = bent(RESPONSE_TIME, 0.012)
    late = fit(responses_with(K * angle + B * rate, start_s=0.012))
    assert values(late) == pytest.approx([B, K], rel=1e-9)
    # a delay of the torque alone does change something
    skewed = found(fit(responses_with(K * angle + B * rate)))
    assert abs(skewed["K"] - K) > 30.0


def test_instant_of_the_perturbations_does_not_matter():
    responses = responses_with(INTRINSIC + by_reflexes())
    later = replace(responses, onsets_s=responses.onsets_s + 100.0)
    assert fit(later).quantities == fit(responses).quantities


def test_rotation_is_that_of_the_mean_response_in_the_window():
    inside = within(0.06)
    result = fit(responses_with(INTRINSIC))
    assert result.quantities["rotation"].value == pytest.approx(np.mean(SIZES) * np.ptp(ANGLE[inside]))
    (curve,) = result.curves
    assert curve["time"][[0, -1]] == pytest.approx([-0.028, 0.06])
    assert curve["torque"] == pytest.approx(np.mean(SIZES) * INTRINSIC[inside])
    assert curve["intrinsic"] == pytest.approx(curve["torque"])
    assert curve["ankle"] == pytest.approx(np.mean(SIZES) * ANGLE[inside])


# ---- active torque -----------------------------------------------------------------------------


def test_twitch_is_critically_damped_and_of_second_order():
    step, time = 0.001, np.arange(400) * 0.001
    # of a step of drive: 1 - (1 + t / T) exp(-t / T)
    force = twitch(np.ones(400), step, 0.04)
    assert force == pytest.approx(1.0 - (1.0 + time / 0.04) * np.exp(-time / 0.04), abs=0.013)
    assert np.abs(force - (1.0 - np.exp(-time / 0.04))).max() > 0.2
    both = twitch(np.array([np.ones(400), np.zeros(400)]), step, 0.04)
    assert (both[0] == force).all()
    assert not both[1].any()
    # at the analysis's own rate it follows the drive of the reflexes
    drive = np.maximum(bent(RESPONSE_TIME - 0.044)[1], 0.0)
    dense = twitched(lambda t: np.maximum(bent(t - 0.044)[1], 0.0), 0.04)
    assert twitch(drive, 0.004, 0.04) == pytest.approx(dense, abs=0.005 * dense.max())


def test_window_before_the_reflex_is_blind_to_it_and_a_longer_one_is_not():
    late = twitched(lambda t: 30.0 * np.maximum(bent(t - 0.062)[1], 0.0), 0.04)
    assert np.abs(late).max() > 3.0
    assert not late[RESPONSE_TIME <= 0.06].any()
    responses = responses_with(INTRINSIC + late)
    assert values(fit(responses)) == pytest.approx([B, K], rel=1e-9)
    assert abs(found(fit(responses, LONG))["K"] - K) > 0.15 * K


def test_reflex_of_44_ms_changes_the_short_window_by_little():
    result = found(fit(responses_with(INTRINSIC + by_reflexes())))
    assert result["K"] == pytest.approx(K, rel=0.015)
    assert result["B"] == pytest.approx(B, rel=0.02)


@pytest.mark.parametrize("window_s", [0.2, 0.3, 0.5])
def test_reflexes_and_balance_are_told_from_intrinsic_impedance(window_s):
    result = fit(responses_with(INTRINSIC + by_reflexes()), replace(VELOCITY, window_s=window_s))
    assert values_of_delays(result) == DELAYS
    parameters = found(result)
    assert parameters["K"] == pytest.approx(K, rel=2e-3)
    assert parameters["B"] == pytest.approx(B, rel=2e-3)
    # samples of 4 ms and a model in steps of them: a few per cent of what is left for the gains
    assert [parameters[name] for name in GAINS] == pytest.approx(list(GAINS.values()), rel=0.05)
    assert result.quantities["VAF_response"].value > 99.999
    inside = within(window_s)
    share = np.abs(by_reflexes()[inside]).max() / np.abs(INTRINSIC[inside]).max()
    assert result.quantities["active_torque_share"].value == pytest.approx(share, rel=0.01)
    assert result.curves[0]["active"] == pytest.approx(np.mean(SIZES) * by_reflexes()[inside], abs=0.05)


def test_muscles_forces_are_told_from_intrinsic_impedance():
    result = fit(responses_with(INTRINSIC + by_muscles(), DRIVE), EMG)
    assert values_of_delays(result) == {"T": 0.04}
    parameters = found(result)
    assert parameters["K"] == pytest.approx(K, rel=2e-3)
    assert parameters["B"] == pytest.approx(B, rel=5e-3)
    assert [parameters[f"F_{m}"] for m in FORCE] == pytest.approx(list(FORCE.values()), rel=0.01)
    assert abs(found(fit(responses_with(INTRINSIC + by_muscles()), LONG))["K"] - K) > 0.05 * K


@pytest.mark.parametrize("estimator", [VELOCITY, EMG])
def test_delays_that_are_not_tried_cannot_be_found_but_the_nearest_is(estimator):
    options = replace(OPTIONS, twitch_s=(0.01, 0.036, 0.09), reflex_delay_s=(0.02, 0.04, 0.07))
    torque = by_reflexes() if estimator is VELOCITY else by_muscles()
    result = fit(responses_with(INTRINSIC + torque, DRIVE), estimator, options)
    nearest = {"T": 0.036} if estimator is EMG else {"T": 0.036, "L": 0.04, "D": 0.112}
    assert values_of_delays(result) == nearest
    # 4 ms too early cost 5 %
    assert found(result)["K"] == pytest.approx(K, rel=0.06)


def test_profile_holds_the_delays_and_says_which_the_responses_determine(rng):
    clean = fit(responses_with(INTRINSIC + by_reflexes()), VELOCITY)
    assert ranges(clean) == {key: (s, s) for key, s in values_of_delays(clean).items()}
    assert at_bound(clean) == []
    # outside of what is tried: the nearest value, and all others rejected
    early = replace(OPTIONS, twitch_s=(0.01, 0.02, 0.036))
    assert at_bound(fit(responses_with(INTRINSIC + by_muscles(), DRIVE), EMG, early)) == ["T"]
    # without a reflex nothing is said of its delays, wherever the best of them lies
    undetermined = fit(responses_with(INTRINSIC + 0.05 * rng.standard_normal(INTRINSIC.size)), VELOCITY)
    tried = {"T": OPTIONS.twitch_s, "L": OPTIONS.reflex_delay_s, "D": OPTIONS.balance_delay_s}
    assert ranges(undetermined) == {key: (min(s), max(s)) for key, s in tried.items()}
    assert at_bound(undetermined) == []


def test_estimate_without_a_muscle_that_acts_at_the_ankle_is_flagged():
    torque = INTRINSIC + by_muscles()
    whole = fit(responses_with(torque, DRIVE), EMG)
    lacking = fit(responses_with(torque, {m: DRIVE[m] for m in ("TA", "GAS")}), EMG)
    assert abs(found(lacking)["K"] - K) > 0.02 * K
    for result, flags in ((whole, ""), (lacking, "muscle-left-out")):
        assert {row.quantity: row.flags for row in rows_of(result) if row.quantity in "BK"} == {
            "B": flags,
            "K": flags,
        }


def test_muscles_cannot_push():
    # torque that only a pushing soleus could explain, beside a pulling tibialis
    pushed = INTRINSIC - 0.3 * twitched(BURSTS["TA"], 0.04) - 0.4 * twitched(BURSTS["SOL"], 0.04)
    result = fit(responses_with(pushed, DRIVE), EMG)
    assert "F_SOL" not in result.gains
    assert all(value > 0.0 for name, value in found(result).items() if name.startswith("F_"))
    # with the action that it has the other way round, it pulls
    turned = replace(OPTIONS, action={"TA": -1.0, "SOL": -1.0})
    assert found(fit(responses_with(pushed, DRIVE), EMG, turned))["F_SOL"] == pytest.approx(0.4, rel=0.01)


def test_muscle_that_does_not_act_at_the_ankle_is_not_fitted():
    result = fit(responses_with(INTRINSIC + by_muscles(), DRIVE | {"RF": DRIVE["SOL"]}), EMG)
    assert list(found(result)) == ["B", "K", "F_TA", "F_SOL", "F_GAS"]


def test_fit_without_a_usable_muscle_is_a_sentence():
    without = responses_with(INTRINSIC)
    said = fit(without, EMG)
    assert said.startswith("expected a muscle that acts at the ankle and has a usable channel in every trial")
    assert fit([responses_with(INTRINSIC, DRIVE), without], EMG) == said
    only_thigh = responses_with(INTRINSIC, {"RF": DRIVE["TA"]})
    assert fit(only_thigh, EMG) == said
    fits, notes = fit_all([without], "standing/relax", ["ankle"], {"emg-driven": EMG}, OPTIONS, 10, 1)
    assert fits == {}
    assert notes == [f"standing/relax: estimator emg-driven left out: {said}"]


def test_muscle_that_one_trial_lacks_is_fitted_in_none():
    trials = [responses_with(INTRINSIC, DRIVE), responses_with(INTRINSIC, {"TA": DRIVE["TA"]})]
    assert set(found(fit(trials, EMG))) <= {"B", "K", "F_TA"}


@pytest.mark.parametrize("group", ["drive", "unperturbed_drive"])
def test_clipped_electromyogram_is_not_averaged_in(group):
    good = responses_with(INTRINSIC + by_muscles(), DRIVE)
    usable = {"drive": "usable", "unperturbed_drive": "unperturbed_usable"}[group]
    marks, spoilt = getattr(good, usable).copy(), getattr(good, group).copy()
    marks[2, 1] = False
    spoilt[2, :, 1] = 1e6
    marked = fit(replace(good, **{usable: marks}), EMG)
    other = fit(replace(good, **{usable: marks, group: spoilt}), EMG)
    assert values(other) == pytest.approx(values(marked), rel=1e-9)  # numpy before 2.3 rounds otherwise
    # the mean of the other five is 0.98 of that of all six, so that as much torque needs more per uV
    force = found(fit(good, EMG))["F_SOL"] / (0.98 if group == "drive" else 1.0)
    assert found(marked)["F_SOL"] == pytest.approx(force, rel=1e-6)
    unmarked = fit(replace(good, **{group: spoilt}), EMG)
    assert abs(found(unmarked).get("F_SOL", 0.0) - 0.4) > 0.1


# ---- several trials, and their uncertainty -------------------------------------------------------


def swaying(rng):
    """Torque (Nm) of a person who sways by 0.5 to 5.5 Hz, from its baseline, by the row."""
    frequency = np.arange(1, 12)[:, None] * 0.5
    zero = (RESPONSE_TIME >= -0.1) & (RESPONSE_TIME <= -0.02)

    def noise(rows):
        phase = rng.uniform(0.0, 2.0 * np.pi, (rows, len(frequency), 1))
        height = 2.0 * rng.standard_normal((rows, len(frequency), 1)) / frequency
        torque = (height * np.sin(2.0 * np.pi * frequency * RESPONSE_TIME + phase)).sum(axis=1)
        return torque - torque[:, zero].mean(axis=1, keepdims=True)

    return noise


def noisy_trials(rng, trials, responses):
    sizes = 1.0 + 0.1 * rng.standard_normal((trials, responses))
    return [responses_with(INTRINSIC, sizes=row, noise=swaying(rng), quiet=10) for row in sizes]


def test_trials_share_their_parameters(rng):
    # a stretch and its mirror image, and one of another size
    trials = [
        responses_with(INTRINSIC),
        responses_with(INTRINSIC, sizes=-0.5 * np.array(SIZES)),
        responses_with(INTRINSIC, sizes=[2.0, 1.8]),
    ]
    result = fit(trials, LONG)
    assert values(result) == pytest.approx([B, K], rel=1e-9)
    assert result.responses == 14
    assert len(result.curves) == 3
    peaks = [np.abs(curve["torque"]).max() for curve in result.curves]
    assert peaks == pytest.approx(np.array([1.0, 0.5, 1.9]) * np.abs(INTRINSIC).max())
    assert result.quantities["rotation"].value == pytest.approx(np.ptp(ANGLE) * (1.0 + 0.5 + 1.9) / 3.0)
    many = noisy_trials(rng, 6, 6)
    apart = [numbers(fit(trial), "K")[1] for trial in many]
    assert numbers(fit(many), "K")[1] == pytest.approx(np.mean(apart) / np.sqrt(6.0), rel=0.4)


@pytest.mark.parametrize(
    ("trials", "responses", "wider", "quantile"),
    # sqrt(n / (n - k)) of n responses in k trials, and Student's t of n - k degrees of freedom
    [(1, 8, 1.069045, 2.364624), (3, 15, 1.118034, 2.178813)],
)
def test_interval_is_widened_for_few_responses(trials, responses, wider, quantile):
    draws = np.tile([9.0, 11.0], 50)
    q = of_draws(np.concatenate([[10.0], draws]), "N·m/rad", responses, responses - trials)
    assert q.value == 10.0
    assert q.standard_error == q.u_type_a == pytest.approx(wider, rel=1e-6)
    half = wider * quantile / 1.959964
    assert (q.low, q.high) == pytest.approx((10.0 - half, 10.0 + half), rel=1e-6)


@pytest.mark.slow
# of 60 intervals 57 should cover; fewer than 51 would, once in 1300 such tests
@pytest.mark.parametrize(("trials", "responses"), [(1, 8), (6, 5)])
def test_intervals_cover_the_stiffness(trials, responses):
    covered, values, errors = 0, [], []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        result = fit(noisy_trials(rng, trials, responses), draws=200, seed=seed)
        value, error, low, high = numbers(result, "K")
        covered += low <= K <= high
        values.append(value)
        errors.append(error)
    assert covered >= 51
    assert np.mean(values) == pytest.approx(K, abs=3.0 * np.std(values) / np.sqrt(60.0))
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(np.std(values), rel=0.25)


def test_same_seed_gives_the_same_numbers_and_other_fits_change_none(rng):
    trials = noisy_trials(rng, 2, 6)
    for responses in trials:
        for group in (responses.perturbed, responses.unperturbed):
            group["torque/other"] = 1.1 * group["torque/ankle"]

    def fits(pathways, estimators, seed=7):
        return fit_all(trials, "standing/relax", pathways, estimators, OPTIONS, 100, seed)[0]

    alone = fits(["ankle"], {"pre-reflex-window": SHORT})
    beside = fits(["other", "ankle"], {"long": LONG, "pre-reflex-window": SHORT})
    assert set(beside) == {(p, e) for p in ("other", "ankle") for e in ("long", "pre-reflex-window")}
    key = ("ankle", "pre-reflex-window")
    assert beside[key].quantities == alone[key].quantities
    other_seed = fits(["ankle"], {"pre-reflex-window": SHORT}, seed=8)[key]
    assert found(other_seed) == found(alone[key])
    own = {name: numbers(alone[key], name) for name in "BK"}
    assert all(
        x != y for name in "BK" for x, y in zip(numbers(other_seed, name)[1:], own[name][1:], strict=True)
    )
    # torque 1.1 times as large, redrawn on its own
    scaled = beside["other", "pre-reflex-window"]
    assert values(scaled) == pytest.approx(1.1 * np.array(values(alone[key])))
    assert numbers(scaled, "K")[1] != pytest.approx(1.1 * own["K"][1], rel=1e-6)


def test_trials_without_responses_do_not_count():
    empty = responses_with(INTRINSIC, sizes=[])
    with_empty = fit_all([empty, responses_with(INTRINSIC)], "x", ["ankle"], {"s": SHORT}, OPTIONS, 20, 1)
    assert with_empty[0]["ankle", "s"].responses == len(SIZES)
    fits, notes = fit_all([empty], "standing/stiff", ["ankle"], {"s": SHORT}, OPTIONS, 20, 1)
    assert fits == {}
    assert notes == ["standing/stiff: expected a trial with usable responses, found none: repeat the trials"]


# ---- rows, and what is refused -------------------------------------------------------------------


def test_rows_hold_parameters_their_share_of_toppling_and_delays():
    result = fit(responses_with(INTRINSIC + by_reflexes()), VELOCITY)
    rows = {row.quantity: row for row in rows_of(result)}
    assert set(rows) == {
        "B",
        "K",
        "K_over_mgh",
        "rotation",
        "VAF_response",
        "active_torque_share",
        "twitch_time",
        "reflex_lag",
        "balance_delay",
    }
    assert rows["K"].unit == "Nm/rad"
    assert rows["K_over_mgh"].value == pytest.approx(rows["K"].value / 555.0)
    assert rows["K_over_mgh"].ci_high == pytest.approx(rows["K"].ci_high / 555.0)
    assert (rows["twitch_time"].value, rows["reflex_lag"].value) == (0.04, 0.044)
    assert (rows["twitch_time"].ci_low, rows["twitch_time"].ci_high) == (0.04, 0.04)
    assert not any(row.flags for row in rows.values())
    one = replace(OPTIONS, reflex_delay_s=(0.044, 0.5))
    (late,) = (
        row for row in rows_of(fit(responses_with(INTRINSIC + by_reflexes()), VELOCITY, one)) if row.flags
    )
    assert (late.quantity, late.flags) == ("reflex_lag", "at-bound")
    assert {row.n_perturbations for row in rows.values()} == {len(SIZES)}
    plain = {row.quantity for row in rows_of(fit(responses_with(INTRINSIC)))}
    assert plain == {"B", "K", "K_over_mgh", "rotation", "VAF_response"}


FITTED = ", ".join(name for name, model in ACTIVE.items() if model.regressors is not None)


@pytest.mark.parametrize(
    ("changes", "names"),
    [({"active": "reflex"}, ["'reflex'", FITTED]), ({"window_s": 1.2}, ["1.2 s", "1 s"])],
)
def test_estimator_that_cannot_be_used_is_refused(changes, names):
    with pytest.raises(InputError) as caught:
        fit(responses_with(INTRINSIC), replace(SHORT, **changes))
    assert_one_sentence(caught.value, *names)


def test_model_in_the_registry_is_fitted_with_its_delays_and_gains(monkeypatch):
    def ramp(means, delays, options, muscles):
        return [np.maximum(means.time - delays["L"], 0.0) + 0.0 * means.signals["ankle"]]

    model = MuscleTorque("ramp after the delay", ramp, delays=("L",), gains=("ramp",))
    monkeypatch.setitem(ACTIVE, "ramp", model)
    assert model.separates and model.grid(OPTIONS) == [{"L": 0.036}, {"L": 0.044}, {"L": 0.052}]
    torque = INTRINSIC + 40.0 * np.maximum(RESPONSE_TIME - 0.044, 0.0)
    trials = [responses_with(torque)]
    result = fit_standing(
        trials, "ankle", StandingEstimator(0.3, False, "ramp"), OPTIONS, 20, np.random.default_rng(1)
    )
    expected = {"B": B, "K": K, "ramp": 40.0 * np.mean(SIZES)}
    assert found(result) == pytest.approx(expected, rel=1e-6) and values_of_delays(result) == {"L": 0.044}


# ---- pulses of both directions in one trial ------------------------------------------------------


def test_opposite_pulses_of_one_trial_are_no_mean_but_two_groups():
    """Their mean is zero, so K would follow from what is left; each direction alone returns K and B."""
    mixed = responses_with(INTRINSIC, sizes=(1.0, -0.9, 0.95, -1.05, 1.1, -1.0))
    forward, backward = mixed.by_direction()
    assert forward.onsets_s.tolist() == mixed.onsets_s[::2].tolist()
    assert backward.onsets_s.tolist() == mixed.onsets_s[1::2].tolist()
    assert forward.perturbed["ankle"].mean(axis=0) == pytest.approx(
        -backward.perturbed["ankle"].mean(axis=0), rel=0.1
    )
    assert backward.unperturbed == mixed.unperturbed
    for part in (forward, backward):
        values = found(fit(part))
        assert values["K"] == pytest.approx(K, rel=1e-3)
        assert values["B"] == pytest.approx(B, rel=1e-3)
    together = found(fit([forward, backward]))
    assert together["K"] == pytest.approx(K, rel=1e-3)


def test_responses_of_one_direction_stay_as_they_are():
    alike = responses_with(INTRINSIC, sizes=(-1.0, -0.9))
    assert alike.by_direction()[0] is alike
    nobody = responses_with(INTRINSIC, sizes=())
    assert nobody.by_direction() == [nobody]


def test_responses_are_compared_with_the_sway_of_the_same_signal():
    """The ankle's angle, as Figure 4-13 shows it, not its velocity."""
    quiet = np.array([[0.0, 9.0, 1.0, -1.0], [0.0, 9.0, -1.0, 1.0]])
    perturbed = np.array([[0.0, 9.0, -4.0, 2.0], [0.0, 9.0, 6.0, 0.0]])
    responses = SimpleNamespace(
        time=np.array([-0.1, -0.05, 0.1, 0.2]),
        count=2,
        perturbed={"ankle": perturbed, "ankle_d": 100.0 * perturbed, "torque/leg": 3.0 * perturbed},
        unperturbed={"ankle": quiet, "ankle_d": quiet, "torque/leg": 2.0 * quiet},
    )
    assert over_sway(responses, "leg") == {"angle_over_sway": 5.0, "torque_over_sway": 7.5}
