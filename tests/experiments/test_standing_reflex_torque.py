"""Numbers of the reflex torque: simulated responses whose reflex is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from free_reflex_builders import FREE, OPTIONS, B, K, fitted, group

from tepsipe.experiments.standing.free_reflex.fit import DISCREPANCY, OWN_DISCREPANCY, WINDOW
from tepsipe.experiments.standing.free_reflex.reflex import (
    REFLEX,
    YIELD,
    Change,
    estimate_reflex,
    mean_reflex,
    yielding,
)
from tepsipe.experiments.standing.free_reflex.results import (
    UNDETERMINED,
    FreeReflexChoices,
    fit_free,
    quoted,
)
from tepsipe.experiments.standing.options import TorquePathway
from tepsipe.io.estimates import Estimate
from tepsipe.reporting.recovery import TrueMotion, compare_with_truth, true_reflex
from tepsipe.statistics.uncertainty import Source

# torque at a pulse of 0.5 m/s (N·m), its start and length (s)
SIZE, START, LENGTH = 12.0, 0.06, 0.12
SIZES = np.array([0.2, 0.3, 0.4, 0.5])
# peak, impulse, gain per 0.04 rad at 1 m/s, instant at which the squared sine is a fifth of its peak
PEAK = SIZE * SIZES.mean() / 0.5
IMPULSE = 0.5 * PEAK * LENGTH
TRUTH = (
    PEAK,
    IMPULSE,
    IMPULSE / (0.04 * SIZES.mean()),
    START + LENGTH / np.pi * np.arcsin(np.sqrt(0.2)),
)
TOLERANCE = {"rel": 0.01}


def reflex(time, size=SIZE):
    """A squared sine of so many N·m."""
    return size * np.sin(np.pi * np.clip((time - START) / LENGTH, 0.0, 1.0)) ** 2


def answering(trials, early_s=0.0):
    """The trials with a torque that resists the stretch in either direction, in proportion to the speed."""
    answered = []
    for trial in trials:
        angle = trial.perturbed[..., 1].mean(axis=0)
        way = np.sign(angle[np.abs(angle).argmax()])
        torque = way * trial.peak_m_per_s / 0.5 * reflex(trial.time + early_s)
        torque = np.column_stack([torque, np.zeros((torque.size, 2))])
        scaled = trial.slopes["force_scale"] + torque
        slopes = trial.slopes | {"force_scale": scaled}
        answered.append(replace(trial, perturbed=trial.perturbed + torque, slopes=slopes))
    return answered


def without_rig(trials):
    """The trials on a treadmill whose model has no draws."""
    return [replace(trial, draws=trial.draws[:0]) for trial in trials]


def test_the_numbers_of_a_known_torque_come_back_from_both_directions():
    found = fitted(answering(group(noise=1e-6))).reflex
    assert found.values == pytest.approx(TRUTH, rel=0.03)
    assert found.undetermined == ()
    # each direction alone answers alike, and the torque is positive against the stretch
    one, other = (fitted(answering(group(noise=1e-6))[k::2]).reflex.values for k in (0, 1))
    assert one == pytest.approx(other, rel=1e-3)


@pytest.mark.parametrize("rate_hz", [100.0, 120.0, 128.0, 150.0, 200.0, 250.0])
def test_the_numbers_depend_neither_on_the_rate_nor_on_the_precision_of_the_times(rate_hz):
    """A torque that is largest near the end of the window, where the last sample may lie outside."""
    exact = np.arange(round(-0.12 * rate_hz), round(0.2 * rate_hz) + 1) / rate_hz
    rising = np.pi / 0.25
    for time in (exact, exact.astype(np.float32).astype(float)):
        torque = SIZE * np.sin(rising * np.maximum(time - 0.06, 0.0)) ** 2
        angle = 0.005 * (1.0 - np.cos(20.0 * np.pi * np.clip(time - 0.003, 0.0, 0.1)))
        values = mean_reflex(time, np.stack([torque, -torque]), np.stack([angle, -angle])).values
        impulse = SIZE * (0.07 - np.sin(2.0 * rising * 0.14) / (4.0 * rising))
        expected = SIZE, impulse, impulse / 0.01, 0.06 + np.arcsin(np.sqrt(0.2)) / rising
        assert values == pytest.approx(expected, rel=0.005)


def test_errors_of_stiffness_and_damping_count_with_the_errors_of_the_signals():
    sources = [Source("force_scale", 0.01), Source("marked_rotation", 0.02), Source(DISCREPANCY, 0.01)]
    found = fitted(answering(group(noise=1e-6)), sources=sources).reflex
    rows, values = found.budget.contributions, found.values
    # all torques grow alike: so does r, and its start remains
    assert rows["force_scale"][0] == pytest.approx([*(0.01 * values[:3]), 0.0], rel=0.02, abs=1e-6)
    # a larger angle has smaller B and K, which leaves the same torque, per a larger stretch
    gain = rows["marked_rotation"][0]
    assert gain[2] == pytest.approx(-0.02 * values[2], rel=0.02)
    assert abs(gain[:2] / values[:2]).max() < 2e-4
    assert {WINDOW, DISCREPANCY, OWN_DISCREPANCY} < rows.keys()
    # an error of all trials does not shrink with their number, one of each trial does
    own, shared = (found.budget.of_source(name)[1] for name in (OWN_DISCREPANCY, DISCREPANCY))
    assert own / OPTIONS.discrepancy == pytest.approx(shared / 0.01 / np.sqrt(8.0), rel=0.15)


@pytest.mark.parametrize("noise", [0.1, 0.3])
def test_intervals_cover_the_known_torque_and_are_not_wide(noise):
    covered, halves = [], []
    for seed in range(1, 21):
        found = fitted(without_rig(answering(group(seed, noise=noise)))).reflex
        low, high = found.budget.interval(found.values)
        covered.append((low <= TRUTH) & (high >= TRUTH))
        halves.append(0.5 * (high - low) / TRUTH)
    assert np.mean(covered) >= 0.9 and np.mean(covered, axis=0).min() >= 0.8
    assert np.median(halves, axis=0).max() < 0.25


def test_responses_without_a_reflex_determine_nothing():
    undetermined = [fitted(group(seed, noise=0.1)).reflex.undetermined for seed in range(1, 21)]
    assert undetermined.count(REFLEX) >= 18


def test_a_torque_that_has_risen_before_the_window_has_no_delay():
    trials = answering(group(noise=1e-6), early_s=0.04)
    assert fitted(trials, reflex_onset_s=0.02).reflex.undetermined == ("reflex_delay",)


@pytest.mark.parametrize(("size", "undetermined"), [(1.0, ()), (8.0, ("reflex_delay",))])
def test_a_delay_whose_interval_begins_before_the_window_is_not_determined(size, undetermined):
    time = np.arange(-30, 51) / 250.0
    angle = 0.005 * (1.0 - np.cos(20.0 * np.pi * np.clip(time, 0.0, 0.1)))
    means = np.stack([reflex(time), angle, np.gradient(angle, time)], axis=-1)[None]
    signals = np.zeros((1, *means.shape))
    # an error of so many N·m around the rise, almost none at the start of the window
    signals[..., 0] = size * np.exp(-0.5 * ((time - 0.07) / 0.01) ** 2)
    error = {"force_scale": Change(np.zeros((1, 2)), signals)}
    found = estimate_reflex(time, means, np.zeros(2), [Change(np.zeros((1, 2)))], np.inf, error, {})
    assert found.undetermined == undetermined


def test_only_numbers_that_are_determined_are_recommended():
    choices = FreeReflexChoices("ankle-compensated", OPTIONS, {})
    for trials, clear in ((answering(group()), True), (group(noise=0.1), False)):
        fits = fit_free(trials, "task", FREE, choices, 80)
        quantities = fits["ankle-compensated", "free"].quantities
        assert [quantities[name].unit for name in REFLEX] == ["N·m", "N·m·s", "N·m·s/rad", "s"]
        rows = [
            Estimate("standing", "t", *key, name, q.unit, q.value, flags=";".join(q.flags))
            for key, fit in fits.items()
            for name, q in fit.quantities.items()
        ]
        chosen = {"pathway": "ankle-compensated", "estimator": "free"}
        named = {row.quantity: row for row in quoted(rows, trials, fits, chosen, TorquePathway("ankle", "m"))}
        assert {named[name].recommended for name in REFLEX} == {clear} and named["K"].recommended
        assert {UNDETERMINED in named[name].flags for name in REFLEX} == {not clear}
        bare = quoted(rows, trials, fits, chosen, TorquePathway("ankle", None))
        assert all("uncompensated" in row.flags for row in bare if row.quantity in REFLEX)


def test_a_joint_that_yields_leaves_the_line_after_the_turn_and_remembers_later_turns():
    time = np.linspace(0.0, 0.2, 201)
    angle = 0.01 * np.sin(10.0 * np.pi * time)
    torque = yielding(np.stack([angle, -2.0 * angle]), K)
    assert not torque[:, :51].any()
    below = K * 0.01 * (2.0 ** (1.0 / 3.0) - 1.0)
    # back at 0, as far to the other side, and at 0 once more: a closed loop
    assert torque[0, [100, 150, 200]] == pytest.approx([-below, 0.0, below], rel=0.02, abs=1e-9)
    assert torque[1] == pytest.approx(-2.0 * torque[0])
    # after a turn half way, the torque rises by the law of a travel since that turn
    angle = np.interp(time, [0.0, 0.05, 0.1, 0.2], [0.0, 0.01, 0.0, 0.005])
    torque = yielding(angle[None], K)[0] + K * angle
    travel = 2.0 ** (1.0 / 3.0) * 0.5 ** (2.0 / 3.0)
    assert torque[200] - torque[100] == pytest.approx(K * 0.01 * travel, rel=0.02)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_the_interval_covers_the_reflex_of_a_joint_that_yields(share):
    trials = without_rig(answering(group(noise=0.05)))
    for trial in trials:
        angles = trial.perturbed[..., 1].mean(axis=0, keepdims=True)
        trial.perturbed[..., 0] += share * yielding(angles, K)[0]
    plain = fitted(trials, sources=[]).reflex
    low, high = plain.budget.interval(plain.values)
    assert bool(low[1] <= IMPULSE <= high[1]) is (share == 0.0)
    found = fitted(trials, sources=[Source(YIELD, 0.289)]).reflex
    low, high = found.budget.interval(found.values)
    assert low[1] <= IMPULSE <= high[1]
    # without the source the joint is linear; with it the impulse is right for half of the hysteresis
    if share == 0.5:
        assert found.values[1] == pytest.approx(IMPULSE, rel=0.02)


def motions(delay_s=0.0):
    """True motions of two trials, of opposite directions, with three pulses each."""
    time = np.arange(0.0, 8.0, 0.002)
    onsets = np.array([1.0, 3.1, 5.3])
    found = []
    for way in (1.0, -1.0):
        angle, active = np.full(time.size, 0.3), np.full(time.size, -4.0)
        for onset in onsets:
            t = time - onset
            moved = np.clip(t, 0.0, 0.1)
            angle += way * 0.01 * (1.0 - np.cos(20.0 * np.pi * moved)) / 2.0
            active += way * reflex(t - delay_s, PEAK)
        rate = np.gradient(angle, time)
        found.append(TrueMotion(time, angle, rate, np.gradient(rate, time), B * rate + K * angle, active))
    return found, [onsets, onsets]


def test_the_truth_has_the_same_definition():
    true = true_reflex(*motions(), (-0.1, -0.02))
    known = dict(zip(REFLEX, (PEAK, IMPULSE, IMPULSE / 0.01, TRUTH[3]), strict=True))
    assert true == pytest.approx(known, **TOLERANCE)
    later = true_reflex(*motions(0.01), (-0.1, -0.02))
    assert later["reflex_delay"] - true["reflex_delay"] == pytest.approx(0.01, abs=1e-4)
    # pulses of both directions in one trial do not cancel
    (one, other), _ = motions()
    shifted = {name: getattr(other, name) for name in ("angle", "rate", "acceleration", "torque", "active")}
    both = TrueMotion(
        np.r_[one.time, one.time + 8.0],
        **{name: np.r_[getattr(one, name), x] for name, x in shifted.items()},
    )
    onsets = np.array([1.0, 3.1, 9.0, 11.1])
    assert true_reflex([both], [onsets], (-0.1, -0.02)) == pytest.approx(true, rel=1e-6)


def test_estimates_stand_beside_their_truth():
    true = true_reflex(*motions(), (-0.1, -0.02))
    names = ("standing", "relax", "ankle-compensated", "free")
    rows = [
        Estimate(*names, "reflex_peak", "Nm", PEAK * 1.1, 0.1, PEAK, 1.2 * PEAK, recommended=True),
        Estimate(*names, "reflex_delay", "s", 0.09, 0.001, 0.088, 0.092, flags=UNDETERMINED),
    ]
    peak, delay = compare_with_truth(rows, {}, {"free": true})
    assert peak.relative_error == pytest.approx(0.1, abs=0.002) and peak.recommended
    assert delay.covered is False and delay.flags == UNDETERMINED


def test_a_torque_along_the_stretch_has_no_delay():
    time = np.arange(0.0, 0.201, 0.004)
    angle = 0.01 * np.sin(np.pi * np.clip(time / 0.1, 0.0, 1.0))
    values = mean_reflex(time, -reflex(time)[None] - 1.0, angle[None]).values
    assert values[1] < 0.0 and np.isnan(values[3])
