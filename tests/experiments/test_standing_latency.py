"""Latency of a muscle's answer: found where it was made, and only where the muscle is stretched first."""

from dataclasses import replace

import numpy as np
import pytest
from builders import assert_one_sentence
from emg_builders import EMG_RATE_HZ, emg, ramp_burst
from standing_builders import RESPONSE_TIME, responses_with

from tepsipe.errors import InputError
from tepsipe.experiments.standing.thesis.latency import latency_estimates, lengthening_speed, muscle_latency
from tepsipe.signals.emg import EmgOptions, process_emg
from tepsipe.signals.onsets import DETECTORS, OnsetOptions

# those of the shipped configuration, with fewer draws
OPTIONS = OnsetOptions(search_s=(0.02, 0.12), bootstrap_draws=100)
ANKLE = {"ankle": 1.0}
LATENCY_S = 0.042
RESPONSES, TRIALS = 8, 4


def answers(rng, latency_s=LATENCY_S, burst=40.0, responses=RESPONSES, artefact=0.0, stretch=1.0):
    """Responses of SOL to a stretch (or its opposite): a burst (uV) after a latency, in noise of 3 uV.

    Skin moves under the electrode with the belt, by an artefact (uV) of 25 Hz. Every response is 0.4 s longer
    at both ends while it is filtered.
    """
    time = np.arange(-700, 1401) / EMG_RATE_HZ
    sizes = np.sign(stretch) * (1.0 + 0.1 * rng.standard_normal(responses))
    envelope = 3.0 + burst * ramp_burst(time, latency_s) * np.exp(0.3 * rng.standard_normal((responses, 1)))
    skin = np.sin(2.0 * np.pi * 25.0 * np.clip(time, 0.0, 0.12))
    raw = emg(envelope, rng) + artefact * sizes[:, None] * skin
    made = responses_with(0.0 * RESPONSE_TIME, {"SOL": 0.0 * RESPONSE_TIME}, sizes=sizes)
    band_passed = process_emg(raw.T, EMG_RATE_HZ, EmgOptions()).band_passed.T
    return replace(
        made,
        emg=band_passed[:, 400:1701, None],
        stretch={"ankle": stretch * np.abs(made.stretch["ankle"]), "knee": made.stretch["knee"]},
    )


def latency(trials, muscle="SOL", lengthening=ANKLE, options=OPTIONS, seed=1):
    return muscle_latency(trials, muscle, lengthening, options, np.random.default_rng(seed))


def onsets(found):
    return {detector: onset.latency_s for detector, onset in found.onsets.items()}


# ---- where it is --------------------------------------------------------------------------------


@pytest.mark.parametrize("latency_s", [0.035, 0.042, 0.0605])
def test_latency_is_found_within_3_ms(latency_s, rng):
    found = latency([answers(rng, latency_s) for _ in range(TRIALS)])
    assert found.responses == TRIALS * RESPONSES
    onset = found.onsets["changepoint"]
    assert onset.latency_s == pytest.approx(latency_s, abs=0.003)
    assert onset.interval_s[0] - 0.001 < latency_s < onset.interval_s[1] + 0.001
    assert 0.0 < onset.standard_error_s < 0.003
    # the others see what the band-pass smears ahead of a strong burst
    assert tuple(found.onsets) == DETECTORS
    for other in found.onsets.values():
        assert other.latency_s == pytest.approx(latency_s, abs=0.008)


def test_all_trials_together_tell_more_than_one(rng):
    trials = [answers(rng, burst=8.0) for _ in range(8)]
    errors = [latency(trials[:n]).onsets["changepoint"].standard_error_s for n in (2, 8)]
    assert errors[1] < 0.8 * errors[0]


def test_rectified_mean_reaches_over_baseline_and_searched_time(rng):
    early = latency([answers(rng)], options=replace(OPTIONS, baseline_until_s=-0.05))
    assert early.time[[0, -1]] == pytest.approx([-0.05 - 0.15, 0.12 + 0.02])
    found = latency([answers(rng)])
    assert found.time[[0, -1]] == pytest.approx([-0.15, 0.14])
    assert found.rectified.shape == found.time.shape
    active = (found.time > 0.05) & (found.time < 0.07)
    assert found.rectified[active].mean() > 5.0 * found.rectified[found.time < 0.03].mean()


def test_artefact_that_every_perturbation_repeats_does_not_count(rng):
    clean = latency([answers(np.random.default_rng(s)) for s in range(TRIALS)])
    moved = latency([answers(np.random.default_rng(s), artefact=100.0) for s in range(TRIALS)])
    for detector in ("threshold", "changepoint"):
        assert onsets(moved)[detector] == pytest.approx(onsets(clean)[detector], abs=0.002), detector


def test_artefact_that_turns_with_the_belt_does_not_count_either(rng):
    # a knee that both directions of the belt stretch first
    trials = [answers(rng, artefact=100.0) for _ in range(2)]
    turned = []
    for responses in [answers(rng, artefact=100.0, stretch=-1.0) for _ in range(2)]:
        turned.append(replace(responses, stretch=trials[0].stretch))
    found = latency(trials + turned)
    assert found.responses == 4 * RESPONSES
    assert found.onsets["changepoint"].latency_s == pytest.approx(LATENCY_S, abs=0.003)


# ---- which responses count -----------------------------------------------------------------------


def test_only_trials_that_stretch_the_muscle_first_count(rng):
    stretching = [answers(rng) for _ in range(TRIALS)]
    shortening = [answers(rng, latency_s=0.09, stretch=-1.0) for _ in range(TRIALS)]
    alone, both = latency(stretching), latency(shortening + stretching)
    assert both.responses == alone.responses == TRIALS * RESPONSES
    assert onsets(both) == onsets(alone)
    # for its antagonist it is the other way round
    other = latency(shortening + stretching, lengthening={"ankle": -1.0})
    assert other.onsets["changepoint"].latency_s == pytest.approx(0.09, abs=0.003)


def test_muscle_over_two_joints_is_stretched_by_both():
    responses = answers(np.random.default_rng(1))
    knee = -3.0 * responses.stretch["ankle"]
    bent = replace(responses, stretch={"ankle": responses.stretch["ankle"], "knee": knee})
    speed = lengthening_speed(bent, {"ankle": 1.0, "knee": 0.5})
    assert speed == pytest.approx(-0.5 * responses.stretch["ankle"])
    said = latency([bent], lengthening={"ankle": 1.0, "knee": 0.5})
    assert said == "expected trials that stretch SOL first and have a usable channel for it, found none"
    assert latency([bent], lengthening={"knee": -1.0}).responses == RESPONSES


@pytest.mark.parametrize(("turn_s", "counts"), [(0.01, True), (0.04, False), (0.052, False)])
def test_stretch_after_the_belt_has_turned_back_does_not_count(turn_s, counts):
    # shortened at first, then stretched twice as fast; the belt comes back after 50 ms
    responses = answers(np.random.default_rng(1))
    late = np.where(responses.time <= turn_s, -1.0, 2.0) * np.ones_like(responses.stretch["ankle"])
    found = latency([replace(responses, stretch={"ankle": late, "knee": 0.0 * late})])
    assert isinstance(found, str) is not counts


def test_clipped_responses_are_not_used(rng):
    trials = [answers(rng) for _ in range(TRIALS)]
    emg_of, usable = trials[0].emg.copy(), trials[0].usable.copy()
    usable[[1, 5], 0] = False
    marked = [replace(trials[0], usable=usable), *trials[1:]]
    emg_of[[1, 5]] = 1e4
    spoilt = [replace(trials[0], usable=usable, emg=emg_of), *trials[1:]]
    assert latency(marked).responses == TRIALS * RESPONSES - 2
    assert onsets(latency(spoilt)) == onsets(latency(marked))
    unmarked = latency([replace(trials[0], emg=emg_of), *trials[1:]])
    assert onsets(unmarked) != onsets(latency([trials[0], *trials[1:]]))


def test_trial_in_which_every_response_was_clipped_does_not_count(rng):
    trials = [answers(rng) for _ in range(2)]
    none = replace(trials[0], usable=np.zeros_like(trials[0].usable))
    found, alone = latency([none, trials[1]]), latency([trials[1]])
    assert found.responses == alone.responses
    assert onsets(found) == pytest.approx(onsets(alone), abs=1e-9)


def test_same_seed_gives_the_same_interval(rng):
    trials = [answers(rng)]
    first, again, other = (latency(trials, seed=s).onsets["changepoint"] for s in (1, 1, 2))
    assert first == again
    assert other.latency_s == first.latency_s
    assert other.interval_s != first.interval_s


# ---- nothing to be found -------------------------------------------------------------------------


def test_muscle_that_no_trial_holds_is_a_sentence(rng):
    said = latency([answers(rng)], muscle="TA")
    assert said == "expected trials that stretch TA first and have a usable channel for it, found none"
    assert latency([]).startswith("expected trials that stretch SOL first")
    empty = responses_with(0.0 * RESPONSE_TIME, {"SOL": 0.0 * RESPONSE_TIME}, sizes=[])
    assert latency([empty]).startswith("expected trials that stretch SOL first")


def test_fewer_than_5_responses_are_a_sentence(rng):
    few = [answers(rng, responses=2), answers(rng, responses=2)]
    assert latency(few) == "expected at least 5 responses that stretch SOL, found 4"
    assert latency([*few, answers(rng, responses=1)]).responses == 5


def test_muscle_that_does_not_answer_has_a_reason_and_no_row(rng):
    found = latency([answers(rng, burst=0.0) for _ in range(TRIALS)])
    onset = found.onsets["changepoint"]
    assert onset.latency_s is None
    assert "20 to 120 ms" in onset.reason
    assert "found none" in onset.reason
    assert "changepoint" not in [row.estimator for row in latency_estimates("relax", found)]


def test_rows_hold_what_was_found(rng):
    found = latency([answers(rng)])
    rows = {row.estimator: row for row in latency_estimates("relax", found)}
    onset = found.onsets["changepoint"]
    row = rows["changepoint"]
    assert (row.experiment, row.condition, row.pathway) == ("standing", "relax", "emg")
    assert (row.quantity, row.unit, row.value) == ("latency_SOL", "s", onset.latency_s)
    assert row.ci_high == onset.interval_s[1]
    # all pulses are alike, so a threshold of the stretch cannot be told
    assert row.ci_low < onset.interval_s[0] and row.flags == "stretch-threshold"
    assert row.n_perturbations == RESPONSES


# ---- what is refused ---------------------------------------------------------------------------


def test_joint_that_is_not_measured_is_refused(rng):
    with pytest.raises(InputError) as caught:
        latency([answers(rng)], lengthening={"hip": 1.0})
    assert_one_sentence(caught.value, "'hip'", "ankle or knee")


@pytest.mark.parametrize("search_s", [(0.02, 0.99), (0.02, 1.5)])
def test_search_beyond_the_responses_is_refused_and_not_extrapolated(search_s, rng):
    with pytest.raises(InputError) as caught:
        latency([answers(rng)], options=replace(OPTIONS, search_s=search_s))
    assert_one_sentence(caught.value, "SOL", f"{search_s[1] + 0.02:g} s")


def test_baseline_before_the_responses_is_refused_and_not_extrapolated(rng):
    responses = answers(rng)
    short = replace(responses, emg_time=responses.emg_time[200:], emg=responses.emg[:, 200:])
    with pytest.raises(InputError) as caught:
        latency([short])
    assert_one_sentence(caught.value, "SOL", "-0.15 s", "-0.1 s")
