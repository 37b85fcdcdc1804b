"""Impedance of the ankle in walking: strides, moments, matching and the estimator on synthetic strides."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from tepsipe.errors import InputError
from tepsipe.experiments.walking.analysis import analyse_walking
from tepsipe.experiments.walking.deviations import fit_matching, left_out_residuals
from tepsipe.experiments.walking.fit import begin
from tepsipe.experiments.walking.fit import fit as fit_walking
from tepsipe.experiments.walking.needed_strides import needed_strides
from tepsipe.experiments.walking.options import ExpectedPulse, WalkingOptions
from tepsipe.experiments.walking.strides import (
    WalkingRecording,
    agreement,
    ankle_moment,
    bandwidth_hz,
    locate_pulses,
    segment_strides,
)
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.statistics.uncertainty import Source
from tepsipe.virtual_lab.walker import Joint, Walk, perturb, resample_walk

RATE = 100.0
STANCE, STRIDE = 0.9, 1.3


def synthetic_walk(strides=40, scatter=1.0, seed=1):
    """Strides whose moment scatters smoothly: level and slow drift within each stance."""
    rng = np.random.default_rng(seed)
    time = np.arange(round((strides + 1) * STRIDE * RATE)) / RATE
    heel = 0.3 + STRIDE * np.arange(strides)
    number = np.clip(((time - 0.3) // STRIDE).astype(int), 0, strides - 1)
    within = np.clip((time - heel[number]) / STANCE, 0.0, 1.0)
    level, drift = scatter * rng.normal(0.0, [[0.02], [0.01]], (2, strides))
    stance = (within > 0.0) & (within < 1.0)
    vertical = np.where(stance, 750.0 * np.minimum(1.0, 12.0 * np.minimum(within, 1.0 - within)), 0.0)
    lever = -0.03 + 0.18 * within + (level[number] + drift[number] * within) * np.sin(np.pi * within)
    angle = -0.15 * np.sin(np.pi * within) + 0.3 * level[number] * np.sin(np.pi * within)
    ankle = 0.4 - 0.6 * within
    signals = {
        "angle": angle,
        "vertical": vertical,
        "anterior": 100.0 * np.sin(2.0 * np.pi * within) * stance,
        "cop": np.where(stance, ankle + lever, 0.0),
        "ankle_x": ankle,
        "ankle_y": np.full(time.size, 0.11),
        "other_vertical": np.where(stance, 0.0, 780.0),
    }
    return Walk(RATE, signals, heel, heel[:-1] + STANCE)


def recorded(walk, **changes):
    time = np.arange(walk.signals["angle"].size) / walk.rate_hz
    return WalkingRecording("trial", walk.rate_hz, time, **(dict(walk.signals) | changes))


def pulsed(walk, phases=(40.0, 80.0), every=3, degrees=2.0, joint=None, seed=5):
    rng = np.random.default_rng(seed)
    chosen = range(3, len(walk.heel_strikes) - 3, every)
    strides = {k: phases[i % len(phases)] for i, k in enumerate(chosen)}
    return perturb(walk, joint or Joint(), strides, np.deg2rad(degrees), 0.06, 0.0, rng)


def analysed(walk, options=None, sources=None):
    strides = segment_strides(walk.heel_strikes, walk.toe_offs)
    return analyse_walking(recorded(walk), strides, walk.onsets, options, sources)


WALK = synthetic_walk(90)


def test_strides_with_hardly_any_scatter_give_the_impedance_at_the_phase_that_is_stated():
    joint = Joint(reflex_Nms_per_rad=0.0)
    walk = pulsed(synthetic_walk(90, scatter=0.001), joint=joint)
    found = analysed(walk, WalkingOptions(inertia_kgm2=joint.inertia_kgm2))
    for phase, fit in found.phases.items():
        at = found.at_percent[phase]
        assert fit.values[2] == pytest.approx(joint.stiffness(at), rel=0.03)
        assert fit.values[1] == pytest.approx(joint.damping(at), rel=0.15)
        assert phase < at < phase + 12.0


def test_scatter_of_strides_is_in_the_interval():
    found = analysed(pulsed(WALK), WalkingOptions(inertia_kgm2=0.012))
    for phase, fit in found.phases.items():
        truth = Joint().stiffness(found.at_percent[phase])
        assert fit.low[2] < truth < fit.high[2]
        assert fit.flags == ""
    calm = analysed(pulsed(synthetic_walk(90, scatter=0.2)), WalkingOptions(inertia_kgm2=0.012))
    assert all(calm.phases[p].budget.type_a[2] < 0.5 * found.phases[p].budget.type_a[2] for p in calm.phases)


def test_a_stronger_reflex_hardly_changes_the_stiffness():
    once, twice = (
        analysed(pulsed(WALK, joint=Joint(reflex_Nms_per_rad=gain)), WalkingOptions(inertia_kgm2=0.012))
        for gain in (25.0, 50.0)
    )
    for phase in once.phases:
        assert twice.phases[phase].values[2] == pytest.approx(once.phases[phase].values[2], rel=0.05)


def test_pulses_of_no_size_say_nothing():
    found = analysed(pulsed(WALK, degrees=0.0))
    for fit in found.phases.values():
        assert fit.flags == "no-response"
        assert np.isneginf(fit.low[2]) and np.isposinf(fit.high[2])


def test_type_b_scales_with_what_is_not_known_and_a_gain_of_the_angle_is_one_of_the_stiffness():
    walk = pulsed(WALK)
    names = ("joint_centre_anterior_m", "joint_centre_vertical_m", "foot_mass_kg", "belt_load_kgm", "sync_s")
    small = {name: Source(name, 0.001) for name in names} | {"angle_gain": Source("angle_gain", 0.02)}
    large = {name: Source(name, 2.0 * source.standard_uncertainty) for name, source in small.items()}
    one, two = (analysed(walk, None, sources).phases[40.0] for sources in (small, large))
    for name in small:
        assert two.budget.of_source(name) == pytest.approx(2.0 * one.budget.of_source(name))
    # 2 % of the gain is 2 % of B and K
    assert one.budget.of_source("angle_gain")[1:] == pytest.approx(0.02 * one.values[1:], rel=0.05)
    # a centre that is 1 mm off: the estimate with a moved centre differs by the contribution
    moved = recorded(walk, ankle_x=walk.signals["ankle_x"] + 0.001)
    strides = segment_strides(walk.heel_strikes, walk.toe_offs)
    shifted = analyse_walking(moved, strides, walk.onsets).phases[40.0].values - one.values
    budget = one.budget.contributions["joint_centre_anterior_m"][0]
    assert shifted[2] == pytest.approx(budget[2], rel=0.3, abs=0.05)


def test_left_out_residuals_are_those_of_fits_without_the_stride():
    rng = np.random.default_rng(3)
    signals = rng.normal(size=(20, 4))
    found = left_out_residuals(fit_matching(np.zeros((20, 0)), signals, 1.0), np.zeros((20, 0)), signals)
    for k in range(20):
        others = np.delete(signals, k, axis=0).mean(axis=0)
        assert found[k] == pytest.approx(signals[k] - others)


def test_matching_foretells_what_the_state_foretells():
    rng = np.random.default_rng(4)
    state = rng.normal(size=(60, 2))
    signals = state @ rng.normal(size=(2, 5)) + 0.1 * rng.normal(size=(60, 5))
    plain = left_out_residuals(fit_matching(state[:, :0], signals, 0.01), state[:, :0], signals)
    matched = left_out_residuals(fit_matching(state, signals, 0.01), state, signals)
    assert matched.std() < 0.2 * plain.std()


def test_bandwidth_of_a_moment_is_that_of_its_filter():
    rng = np.random.default_rng(2)
    wide = rng.normal(size=6000)
    for cutoff in (6.0, 20.0):
        found = bandwidth_hz(butterworth_lowpass(wide, RATE, cutoff), wide, RATE)
        # -3 dB of a filter whose gain at the cutoff is 1/2
        assert found == pytest.approx(cutoff * (np.sqrt(2.0) - 1.0) ** 0.25, rel=0.06)


def test_moment_is_force_times_lever():
    walk = synthetic_walk(5)
    record = recorded(walk, supplied_moment=None)
    k = np.argmax(walk.signals["vertical"])
    lever = walk.signals["cop"][k] - walk.signals["ankle_x"][k]
    expected = walk.signals["vertical"][k] * lever + walk.signals["anterior"][k] * 0.11
    assert ankle_moment(record)[k] == pytest.approx(expected)
    whole = replace(record, supplied_moment=ankle_moment(record) + 3.0)
    stance = walk.signals["vertical"] > 700.0
    assert agreement(whole, stance) == pytest.approx(3.0, rel=0.02)


# ---- what cannot be used ------------------------------------------------------------------------


def test_a_stride_without_toe_off_and_a_missing_heel_strike_are_left_out():
    heel, toe = np.delete(WALK.heel_strikes, 20), np.delete(WALK.toe_offs, 5)
    found = segment_strides(heel, toe)
    assert len(found) == len(WALK.heel_strikes) - 1 - 3
    assert "expected one toe-off" in found.dropped[0] and "found 0" in found.dropped[0]
    assert "found 2" in found.dropped[1]


def test_missing_events_are_refused():
    with pytest.raises(InputError, match=r"expected heel strikes and toe-offs.*found 0 heel"):
        segment_strides([], WALK.toe_offs)


def test_a_pulse_over_a_heel_strike_is_left_out():
    strides = segment_strides(WALK.heel_strikes, WALK.toe_offs)
    good, late = strides.start[4] + 0.4, strides.start[5] - 0.04
    found = locate_pulses(strides, [good, late, 1e4], 0.1)
    assert found.onset == pytest.approx([good])
    assert "before the next heel strike, found one after 40 ms" in found.dropped[0]
    assert "within a usable stride" in found.dropped[1]


def test_a_phase_with_too_few_strides_is_left_out_and_the_others_are_kept():
    walk = perturb(
        WALK,
        Joint(),
        dict.fromkeys(range(3, 40, 3), 60.0) | dict.fromkeys(range(43, 52, 3), 20.0),
        np.deg2rad(2.0),
        0.06,
        0.0,
        np.random.default_rng(0),
    )
    found = analysed(walk)
    assert list(found.phases) == [60.0]
    assert any("6 perturbed strides at 20 % of stance, found 3" in text for text in found.dropped)
    few = replace(walk, onsets=walk.onsets[-3:])
    with pytest.raises(InputError, match="at one of the phases 20, 40, 60, 80 % of stance, found fewer"):
        analysed(few)


def test_swapped_belts_are_refused():
    walk = pulsed(WALK)
    signals = dict(walk.signals)
    signals["vertical"], signals["other_vertical"] = signals["other_vertical"], signals["vertical"]
    with pytest.raises(InputError, match=r"own belt unloaded in its swing.*swap the belts"):
        analysed(replace(walk, signals=signals))


def test_too_few_unperturbed_strides_are_refused():
    walk = pulsed(synthetic_walk(24), every=2)
    with pytest.raises(InputError, match="at least 12 unperturbed strides, found"):
        analysed(walk)


def planned(walk, factor=1.0, **changes):
    """Strides that a walk needs, with its events scaled and some of its signals replaced."""
    strides = segment_strides(factor * walk.heel_strikes, factor * walk.toe_offs)
    pulse = ExpectedPulse(2.0, 0.06, [300.0, 200.0, 150.0, 100.0], 1.0)
    return needed_strides("trial", recorded(walk, **changes), strides, pulse, WalkingOptions())


def test_strides_are_planned_from_12_strides_of_a_plausible_walk():
    signals = WALK.signals
    assert planned(synthetic_walk(13))
    with pytest.raises(InputError, match="trial: expected at least 12 unperturbed strides, found 11"):
        planned(synthetic_walk(12))
    with pytest.raises(InputError, match="trial: expected the foot's own belt unloaded in its swing"):
        planned(WALK, vertical=signals["other_vertical"], other_vertical=signals["vertical"])
    with pytest.raises(InputError, match="trial: expected an angle of the ankle in rad"):
        planned(WALK, angle=np.degrees(signals["angle"]))


def test_a_walk_shorter_than_the_trial_sheet_says_is_refused():
    strides = segment_strides(WALK.heel_strikes, WALK.toe_offs)
    walk = recorded(WALK), strides, {"pulse": pulsed(WALK).onsets}
    assert begin(walk, {"analysis": {}}, 1, 118.0)[0].size
    with pytest.raises(InputError, match=r"trial: .* 119 s"):
        begin(walk, {"analysis": {}}, 1, 119.0)


def test_a_walk_without_pulses_has_no_perturbations(root):
    text = (root / "config/walking/config.yaml").read_text(encoding="utf-8")
    section = yaml.safe_load(text)["walking"]
    walk = recorded(WALK), segment_strides(WALK.heel_strikes, WALK.toe_offs), {"pulse": np.empty(0)}
    fitted = fit_walking(walk, section, "slow", 1)
    numbers = [row.n_perturbations for row in fitted.estimates]
    assert fitted.result.facts["pulses"] == 0 and set(numbers) == {0}


def test_what_cannot_be_compared_is_refused():
    noise = np.random.default_rng(2).standard_normal(round(20.0 * RATE))
    assert bandwidth_hz(noise, noise, RATE) == 0.5 * RATE
    with pytest.raises(InputError, match=r"moment: expected at least 20 s .*, found 20 s"):
        bandwidth_hz(noise[1:], noise[1:], RATE)
    with pytest.raises(InputError, match="trial: expected a supplied moment of the ankle"):
        agreement(recorded(WALK), WALK.signals["vertical"] > 0.0)


def test_resampled_walk_has_the_moments_of_the_real_one():
    walk = resample_walk(WALK, 200, np.random.default_rng(8))
    strides = segment_strides(walk.heel_strikes, walk.toe_offs)
    assert len(strides) == 200
    assert strides.stance == pytest.approx(STANCE, abs=0.011)
    middle = strides.start + 0.5 * STANCE
    time = np.arange(walk.signals["angle"].size) / RATE
    real = np.arange(WALK.signals["angle"].size) / RATE
    drawn, own = (
        np.interp(at, clock, ankle_moment(recorded(w)))
        for at, clock, w in ((middle, time, walk), (WALK.heel_strikes[:-1] + 0.5 * STANCE, real, WALK))
    )
    assert drawn.mean() == pytest.approx(own.mean(), rel=0.1)
    assert drawn.std() == pytest.approx(own.std(), rel=0.2)
