"""A joint with a known reflex, one without, and the ankles of real people, told apart into two paths."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import assert_one_sentence, trial_of
from scipy import signal
from scipy.special import erf

from tepsipe.errors import InputError
from tepsipe.experiments.position_manipulator.analysis import (
    analyse_parallel_cascade,
    analyse_position_manipulator,
    parallel_cascade_estimates,
    position_manipulator_estimates,
    position_manipulator_result,
)
from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions
from tepsipe.identification.cascade.options import ParallelCascadeOptions
from tepsipe.identification.cascade.pathways import (
    delayed,
    knot_responses,
    lagged,
    muscle_response,
    rectified,
)
from tepsipe.ingest.manipulator_options import TableOptions
from tepsipe.ingest.manipulators import ingest_position_manipulator
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.signals.differentiation import derivative

RATE = 250.0
INERTIA, DAMPING, STIFFNESS = 0.015, 0.8, 60.0
GAIN, FREQUENCY_HZ, ZETA = 10.0, 2.0, 0.9
OPTIONS = PositionManipulatorOptions(
    lowpass_cutoff_hz=30.0,
    lowpass_order=4,
    cut_s=1.0,
    training_fraction=0.5,
    averaged_bins=16,
    block_s=1.0,
    bootstrap_draws=200,
)
# where nothing is said of intervals
FEW_DRAWS = replace(OPTIONS, bootstrap_draws=10)
REFLEX = ParallelCascadeOptions(
    intrinsic_lag_s=0.04,
    reflex_length_s=0.6,
    reflex_knot_s=0.025,
    reflex_delays_s=(0.03, 0.06),
    expected_delay_s=0.04,
    delay_tolerance=0.01,
    penalties=(1e-6, 1e-4, 1e-2, 1.0),
    folds=10,
)


class Steps:
    """A random train of smooth steps whose derivatives are known at any time."""

    def __init__(self, rng, seconds):
        self.at = np.cumsum(rng.uniform(0.2, 0.35, round(seconds / 0.25)))
        level = 0.02 * rng.uniform(-1.0, 1.0, self.at.size)
        self.height = np.diff(level, prepend=0.0)
        self.width = 0.009  # s, of the velocity's bell

    def angle(self, t, order=0):
        found = np.zeros(t.size)
        for at, height in zip(self.at, self.height, strict=True):
            first, last = np.searchsorted(t, [at - 8.0 * self.width, at + 8.0 * self.width])
            x = (t[first:last] - at) / self.width
            bell = np.exp(-0.5 * x**2) / (np.sqrt(2.0 * np.pi) * self.width)
            shape = (0.5 * (1.0 + erf(x / np.sqrt(2.0))), bell, -x * bell / self.width)[order]
            found[first:last] += height * shape
            found[last:] += height if order == 0 else 0.0
        return found


def joint_with_reflex(
    rng, gain=GAIN, delay=0.04, direction=1, growth=0.0, noise=0.02, drift=0.0, seconds=60.0
):
    """A trial of a joint with known constants, and its torque (Nm) without noise."""
    steps = Steps(rng, seconds)
    time = np.arange(round(seconds * RATE)) / RATE
    angle, velocity, acceleration = (steps.angle(time, order) for order in range(3))
    stretch = steps.angle(time - delay, 1)
    w = 2.0 * np.pi * FREQUENCY_HZ
    # straight between samples, as lsim takes it, without its loop over them
    muscle = signal.cont2discrete(([w**2], [1.0, 2.0 * ZETA * w, w**2]), 1.0 / RATE, method="foh")
    reflex = signal.lfilter(muscle[0][0], muscle[1], np.where(direction * stretch > 0.0, stretch, 0.0))
    torque = INERTIA * acceleration + DAMPING * velocity + STIFFNESS * angle + gain * reflex - 2.0
    torque = torque + 0.5 * growth * (angle - angle[: time.size // 2].mean()) ** 2
    level = np.cumsum(rng.standard_normal(time.size)) / np.sqrt(RATE)
    noisy = torque + noise * rng.standard_normal(time.size) + drift * level
    return trial_of(RATE, angle=(angle + 0.15, "rad"), torque=(noisy, "Nm")), torque


def analysed(trial, seed=1, reflex=REFLEX, options=FEW_DRAWS):
    return analyse_parallel_cascade(trial, options, reflex, np.random.default_rng(seed))


@pytest.fixture(scope="module")
def known():
    """A trial of a joint with a reflex, and what is found, once for all that must not matter."""
    trial, _ = joint_with_reflex(np.random.default_rng(20140612), noise=0.1)
    return trial, analysed(trial)


def plain(gain=GAIN, delay=0.04):
    """A trial with little noise, its torque (Nm) without noise, and what is found, with intervals."""
    return _plain(gain, delay)


@cache  # keeps calls with and without names of arguments apart
def _plain(gain, delay):
    trial, torque = joint_with_reflex(np.random.default_rng(20140612), gain=gain, delay=delay)
    return trial, torque, analysed(trial, options=OPTIONS)


def altered(trial, angle=lambda x: x, torque=lambda x: x):
    return trial_of(
        RATE,
        angle=(angle(trial.values("angle")), "rad"),
        torque=(torque(trial.values("torque")), "Nm"),
    )


# ---- the paths' parts --------------------------------------------------------------------------


def test_delayed_signal_is_held_before_its_start():
    x = np.array([1.0, 2.0, 4.0, 8.0])
    assert delayed(x, 2.0 / RATE, RATE) == pytest.approx([1.0, 1.0, 1.0, 2.0])
    assert delayed(x, 0.5 / RATE, RATE) == pytest.approx([1.0, 1.5, 3.0, 6.0])
    assert delayed(x, -1.0 / RATE, RATE) == pytest.approx([2.0, 4.0, 8.0, 8.0])
    columns = np.column_stack([x, -x])
    assert delayed(columns, 1.25 / RATE, RATE)[:, 1] == pytest.approx(-delayed(x, 1.25 / RATE, RATE))


def test_delay_that_is_a_whole_number_of_samples_but_for_rounding_is_exact():
    x = np.arange(50.0) ** 2
    assert (delayed(x, 0.1 + 0.2, 10.0) == delayed(x, 0.3, 10.0)).all()


def test_lagged_columns_are_the_signal_earlier_and_later(rng):
    x = rng.standard_normal(20)
    columns = lagged(x, np.arange(-2, 3), slice(0, x.size))
    for column, lag in zip(columns.T, range(-2, 3), strict=True):
        assert column == pytest.approx(delayed(x, lag / RATE, RATE))


@pytest.mark.parametrize("direction", [1, -1])
def test_rectified_velocity_keeps_one_direction(direction):
    time = np.arange(500) / RATE
    angle = 0.02 * np.sin(2.0 * np.pi * 2.0 * time)
    velocity = 0.02 * 2.0 * np.pi * 2.0 * np.cos(2.0 * np.pi * 2.0 * time)
    found = rectified(derivative(time, angle), direction, 0.0)
    expected = np.where(np.sign(velocity) == direction, velocity, 0.0)
    assert found == pytest.approx(expected, abs=1e-4)
    assert (direction * found >= 0.0).all()


def test_knot_responses_are_straight_and_end_in_nothing():
    responses = knot_responses(0.2, 0.04, RATE)
    assert responses.shape == (51, 4)
    assert (responses[[0, -1]] == 0.0).all()
    assert responses[[10, 20, 30, 40]] == pytest.approx(np.eye(4))
    assert responses[10:41].sum(axis=1) == pytest.approx(1.0)
    assert responses @ [1.0, 2.0, 3.0, 4.0] == pytest.approx(
        np.interp(np.arange(51), [0, 40, 50], [0.0, 4.0, 0.0])
    )


def test_muscle_passes_what_lasts_and_overshoots_by_its_damping():
    step = np.ones(2000)
    found = muscle_response(step, RATE, 2.0, 0.5)
    assert found[-1] == pytest.approx(1.0, abs=1e-6)
    assert found.max() - 1.0 == pytest.approx(np.exp(-np.pi * 0.5 / np.sqrt(0.75)), rel=0.01)
    slow = muscle_response(step, RATE, 2.0, 2.0)
    assert slow.max() <= 1.0 + 1e-9
    sine = np.sin(2.0 * np.pi * 2.0 * np.arange(5000) / RATE)
    # at its natural frequency a critically damped muscle halves the amplitude
    assert np.abs(muscle_response(sine, RATE, 2.0, 1.0)[2500:]).max() == pytest.approx(0.5, rel=0.01)


# ---- known joints ------------------------------------------------------------------------------


def test_steps_of_a_servo_need_no_threshold():
    # the low-pass lets the velocity ring around the steps, and rectified it would pass for stretch
    rng = np.random.default_rng(3)
    fine, seconds = 4.0 * RATE, 40.0
    time = np.arange(round(seconds * fine)) / fine
    level = np.repeat(rng.choice([-0.03, 0.03], time.size), round(0.15 * fine))[: time.size]
    servo = signal.butter(2, 8.0, fs=fine, output="sos")
    angle = signal.sosfilt(servo, signal.sosfilt(signal.butter(2, 60.0, fs=fine, output="sos"), level))
    velocity = derivative(time, angle, degree=5)
    w = 2.0 * np.pi * FREQUENCY_HZ
    late = np.maximum(np.interp(time - 0.04, time, velocity), 0.0)
    reflex = signal.lsim(([w**2], [1.0, 2.0 * ZETA * w, w**2]), late, time)[1]
    torque = INERTIA * derivative(time, velocity, degree=5) + DAMPING * velocity + STIFFNESS * angle
    torque = (torque + GAIN * reflex)[::4] + 0.02 * rng.standard_normal(time.size // 4)
    found = analysed(trial_of(RATE, angle=(angle[::4] + 0.15, "rad"), torque=(torque, "Nm")))
    assert (found.structure.threshold_rad_per_s, found.structure.unfiltered) == (0.0, True)
    assert found.impedance == pytest.approx([INERTIA, DAMPING, STIFFNESS], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.032, 0.04, 0.052])
def test_known_reflex_is_recovered(delay):
    found = plain(delay=delay)[2]
    assert found.structure.direction == 1
    assert found.structure.delay_s == pytest.approx(delay, abs=1.01 / RATE)
    assert found.gain == pytest.approx(GAIN, rel=0.05)
    assert found.impedance == pytest.approx([INERTIA, DAMPING, STIFFNESS], rel=0.05)
    assert found.vaf.held_out > 99.5
    assert found.muscle.constants == pytest.approx([GAIN, FREQUENCY_HZ, ZETA], rel=0.12)
    assert found.muscle.vaf.held_out > 99.5
    # delays are compared by their cross-validated VAF (%); the response that is shown lies around lag 0
    assert found.delay_vaf.max() == pytest.approx(found.vaf_cross_validated, abs=2.0)
    assert found.intrinsic_time.size == found.intrinsic_response.size
    assert found.intrinsic_time == pytest.approx(-found.intrinsic_time[::-1])


@pytest.mark.slow
def test_reflex_response_is_that_of_the_muscle():
    found = plain()[2]
    w = 2.0 * np.pi * FREQUENCY_HZ
    late = found.reflex_time - 0.04
    root = w * np.sqrt(1.0 - ZETA**2)
    known = GAIN * w**2 / root * np.exp(-ZETA * w * late) * np.sin(root * late)
    assert found.reflex_response == pytest.approx(known, abs=0.08 * known.max())
    assert found.muscle.response == pytest.approx(known, abs=0.05 * known.max())
    inside = (found.reflex_low <= found.reflex_response) & (found.reflex_response <= found.reflex_high)
    assert inside[1:-1].mean() > 0.95


@pytest.mark.slow
def test_part_of_the_torque_that_is_the_reflex():
    trial, torque, found = plain()
    without, silent, _ = plain(gain=0.0)
    kept = slice(250, -250)
    reflex = (torque - silent)[kept]
    assert np.ptp(reflex) > 0.3
    assert without.time.size == trial.time.size
    fitted = slice(0, found.predicted.size // 2)
    share = 100.0 * np.var(reflex[fitted]) / np.var(torque[kept][fitted])
    assert found.reflex_share == pytest.approx(share, rel=0.1)
    assert np.std(found.reflex_torque - reflex - np.mean(found.reflex_torque - reflex)) < 0.1 * np.std(reflex)


@pytest.mark.slow
def test_reflex_predicts_what_stiffness_alone_cannot(rng):
    trial, _ = joint_with_reflex(rng, noise=0.1, drift=0.02)
    alone = analyse_position_manipulator(trial, OPTIONS, rng)
    both = analysed(trial)
    assert both.vaf.held_out > alone.vaf.held_out + 2.0
    # the reflex holds up the torque, so stiffness alone comes out too high
    assert alone.fit.parameters[2] > 1.05 * STIFFNESS
    assert both.impedance[2] == pytest.approx(STIFFNESS, rel=0.1)


@pytest.mark.slow
def test_intervals_cover_the_joint_where_the_penalty_is_weak(rng):
    repeats, weak = 10, replace(REFLEX, reflex_delays_s=(0.04, 0.04), penalties=(1e-4,))
    known = {"K": STIFFNESS, "reflex_gain": GAIN, "reflex_frequency": FREQUENCY_HZ, "reflex_damping": ZETA}
    covered = dict.fromkeys(known, 0)
    for seed in range(repeats):
        trial, _ = joint_with_reflex(rng, noise=0.5)
        rows = parallel_cascade_estimates("position_manipulator", "a", analysed(trial, seed, weak, OPTIONS))
        of = {row.quantity: row for row in rows}  # gain: that of the muscle
        for quantity, value in known.items():
            covered[quantity] += of[quantity].ci_low <= value <= of[quantity].ci_high
    assert min(covered.values()) >= 0.7 * repeats


@pytest.mark.slow
def test_penalty_pulls_the_free_response_a_little_towards_none(rng):
    found = [analysed(joint_with_reflex(rng, noise=0.5)[0]) for _ in range(4)]
    assert 0.9 * GAIN < np.mean([fit.gain for fit in found]) < 1.02 * GAIN
    assert 0.98 * STIFFNESS < np.mean([fit.impedance[2] for fit in found]) < 1.03 * STIFFNESS


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "drift"), [(0.02, 0.0), (0.3, 0.02), (1.0, 0.05)])
def test_no_reflex_is_found_where_there_is_none(noise, drift):
    gains = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        trial, _ = joint_with_reflex(rng, gain=0.0, noise=noise, drift=drift)
        found = analysed(trial)
        alone = analyse_position_manipulator(trial, OPTIONS, rng)
        assert found.vaf.held_out > alone.vaf.held_out - 0.5
        gains.append(found.gain)
    assert np.median(np.abs(gains)) == 0.0
    assert np.abs(gains).max() < 0.15 * GAIN


@pytest.mark.slow
def test_stiffness_that_grows_with_the_angle_is_no_reflex(rng):
    trial, _ = joint_with_reflex(rng, gain=0.0, growth=800.0)
    found = analysed(trial, options=OPTIONS)
    assert found.structure.stiffening
    assert found.structure.direction == 0
    assert found.stiffening == pytest.approx(800.0, rel=0.05)
    assert found.impedance[2] == pytest.approx(STIFFNESS, rel=0.05)
    rows = {row.quantity: row for row in parallel_cascade_estimates("position_manipulator", "a", found)}
    assert rows["K_growth"].ci_low < 800.0 < rows["K_growth"].ci_high


@pytest.mark.slow
def test_weak_reflex_on_a_noisy_record_does_no_harm(rng):
    trial, _ = joint_with_reflex(rng, gain=1.0, noise=1.0, drift=0.05)
    found = analysed(trial)
    alone = analyse_position_manipulator(trial, OPTIONS, rng)
    assert found.vaf.held_out > alone.vaf.held_out - 0.5


# ---- what must not matter ----------------------------------------------------------------------


@pytest.mark.slow
def test_joint_that_is_turned_round_answers_the_other_direction(known):
    trial, found = known
    turned = analysed(altered(trial, np.negative, np.negative))
    assert (found.structure.direction, turned.structure.direction) == (1, -1)
    assert replace(turned.structure, direction=1) == found.structure
    assert turned.gain == pytest.approx(found.gain, rel=1e-6)
    assert turned.impedance == pytest.approx(found.impedance, rel=1e-6)
    assert turned.vaf.held_out == pytest.approx(found.vaf.held_out, abs=1e-6)
    assert found.gain == pytest.approx(GAIN, rel=0.05)


@pytest.mark.slow
def test_sign_of_the_torque_units_and_levels_scale_the_constants_and_nothing_else(known):
    trial, found = known
    other = analysed(altered(trial, lambda x: 3.0 * x - 0.4, lambda x: 30.0 - 0.5 * x))
    assert other.structure == found.structure
    assert other.gain == pytest.approx(-found.gain / 6.0, rel=1e-5)
    assert other.impedance == pytest.approx(-found.impedance / 6.0, rel=1e-5)
    assert other.vaf.held_out == pytest.approx(found.vaf.held_out, abs=1e-5)
    assert other.reflex_share == pytest.approx(found.reflex_share, rel=1e-5)


@pytest.mark.slow
def test_reflex_that_comes_later_is_found_later():
    early, late = (plain(delay=delay)[2] for delay in (0.032, 0.052))
    assert late.structure.delay_s - early.structure.delay_s == pytest.approx(0.02, abs=1.01 / RATE)
    assert late.gain == pytest.approx(early.gain, rel=0.05)


@pytest.mark.slow
def test_held_out_part_is_not_fitted():
    trial, _, found = plain()

    def spoil(torque):
        spoilt = torque.copy()
        spoilt[9000:] += 5.0 * np.random.default_rng(1).standard_normal(spoilt.size - 9000)
        return spoilt

    changed = analysed(altered(trial, torque=spoil))
    assert changed.structure == found.structure
    assert changed.gain == pytest.approx(found.gain, rel=1e-9)
    assert changed.vaf.held_out < 90.0


@pytest.mark.slow
def test_strong_penalty_leads_back_to_stiffness_alone(known, rng):
    trial, _ = known
    found = analysed(trial, reflex=replace(REFLEX, penalties=(1e9,), stop_radii_rad=()))
    alone = analyse_position_manipulator(trial, OPTIONS, rng)
    assert found.gain == pytest.approx(0.0, abs=1e-3)
    assert found.vaf.held_out == pytest.approx(alone.vaf.held_out, abs=0.5)


@pytest.mark.slow
def test_delay_that_the_record_does_not_tell_is_the_expected_one(rng):
    trial, _ = joint_with_reflex(rng, noise=0.5)
    found = analysed(trial, reflex=replace(REFLEX, delay_tolerance=1.0))
    assert found.structure.delay_s == pytest.approx(0.04)
    assert found.delay_range_s == pytest.approx((0.0, 24.0 / RATE))
    delay = found.assumptions[0]
    assert (delay.quantity, delay.value, delay.determined) == ("reflex_delay", 0.04, False)
    assert (delay.low, delay.high) == found.delay_range_s


@pytest.mark.slow
def test_same_seed_gives_the_same_intervals(known):
    trial, found = known
    first, again, other = (found.gain_bootstrap, *(analysed(trial, seed).gain_bootstrap for seed in (1, 2)))
    assert (first == again).all()
    assert (first != other).any()


def test_short_record_is_fitted_with_fewer_folds(rng):
    trial, _ = joint_with_reflex(rng, seconds=12.0)
    found = analysed(trial)
    assert found.gain == pytest.approx(GAIN, rel=0.2)
    assert found.vaf.held_out > 98.0


# ---- rows and arrays ---------------------------------------------------------------------------


@pytest.mark.slow
def test_rows_of_a_joint_with_and_without_a_reflex():
    rows = parallel_cascade_estimates("position_manipulator", "a", plain()[2])
    assert {row.pathway for row in rows} == {"impedance"}
    of = {(row.estimator, row.quantity): row for row in rows}
    assert of["parallel-cascade", "reflex_delay"].value == pytest.approx(0.04, abs=1.01 / RATE)
    assert of["parallel-cascade", "VAF_held_out"].value > 99.0
    assert of["parallel-cascade-muscle", "reflex_frequency"].unit == "Hz"
    without = parallel_cascade_estimates("position_manipulator", "a", plain(gain=0.0)[2])
    assert {row.estimator for row in without} == {"parallel-cascade"}
    quantities = {row.quantity: row.value for row in without}
    assert quantities["reflex_gain"] == 0.0
    assert quantities["reflex_share"] == 0.0
    assert "reflex_delay" not in quantities


@pytest.mark.slow
@pytest.mark.parametrize("gain", [GAIN, 0.0])
def test_result_names_the_unit_of_every_array(gain, rng):
    trial, _, found = plain(gain)
    alone = analyse_position_manipulator(trial, OPTIONS, rng)
    result = position_manipulator_result(alone, found)
    assert set(result.units) == set(result.arrays)
    assert result.arrays["reflex/predicted_torque"].shape == result.arrays["torque"].shape
    assert result.arrays["reflex/response"].size == (found.reflex_time.size if gain else 0)
    assert result.facts["reflex"]["direction"] == (1 if gain else 0)


@pytest.mark.parametrize("seconds", [2.0, 9.0])
def test_record_that_is_too_short_for_its_blocks_is_refused(seconds, rng):
    with pytest.raises(InputError) as caught:
        analysed(joint_with_reflex(rng, seconds=seconds)[0])
    assert_one_sentence(caught.value, "blocks")


def test_joint_that_does_not_move_is_refused(rng):
    still = trial_of(RATE, angle=(np.full(9000, 0.1), "rad"), torque=(rng.standard_normal(9000), "Nm"))
    with pytest.raises(InputError) as caught:
        analysed(still)
    assert_one_sentence(caught.value, "moving joint")


# ---- real people -------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["ankle_trial1", "ankle_trial3"])
def real_ankle(request, real_data, shipped_config):
    """One recorded ankle by both models, with the shipped configuration."""
    path = real_data(f"human-ankle/{request.param}.csv.gz")
    section = shipped_config["position_manipulator"]
    options = TableOptions(
        angle_unit=section["files"]["angle_unit"],
        torque_sign=section["files"]["torque_sign"],
        **section["ingest"],
    )
    table = read_text_table(path, section["files"]["columns"], ",")
    trial = ingest_position_manipulator(table, options, 60.0, str(path))
    choices = dict(section["analysis"])
    reflex = ParallelCascadeOptions(**choices.pop("parallel_cascade"))
    choices = replace(PositionManipulatorOptions(**choices), bootstrap_draws=200)
    rng = np.random.default_rng(1)
    alone = analyse_position_manipulator(trial, choices, rng)
    return alone, analyse_parallel_cascade(trial, choices, reflex, rng)


@pytest.mark.slow
def test_real_ankle_is_predicted_better_with_its_reflex(real_ankle):
    alone, both = real_ankle
    assert both.vaf.held_out > 94.2
    assert both.vaf.held_out > alone.vaf.held_out + 2.0
    assert both.muscle.vaf.held_out > alone.vaf.held_out + 2.0
    assert both.vaf_cross_validated > 88.0


@pytest.mark.slow
def test_real_ankle_has_the_reflex_of_an_ankle(real_ankle):
    alone, both = real_ankle
    assert both.structure.direction == 1
    assert 0.03 <= both.structure.delay_s <= 0.06
    # torque alone does not tell the delay from shorter ones
    assert both.delay_range_s[0] < 0.03
    assert not both.assumptions[0].determined
    low, high = np.percentile(both.gain_bootstrap, [2.5, 97.5])
    assert 0.0 < low < both.gain < high
    assert both.impedance[2] < alone.fit.parameters[2]
    assert (both.impedance_bootstrap > 0.0).all()


# ---- flags ---------------------------------------------------------------------------------------


def flags_of(fit):
    rows = parallel_cascade_estimates("position_manipulator", "a", fit)
    return {(row.estimator, row.quantity): row.flags.split(";") for row in rows}


def test_sound_record_has_no_flags_of_misfit_or_muscle():
    flags = {name for names in flags_of(plain()[2]).values() for name in names}
    assert not {"lack-of-fit", "slow-reflex", "reflex-outside-search"} & flags


@pytest.mark.slow
def test_torque_that_does_not_answer_the_angle_is_a_lack_of_fit(rng):
    trial, _ = joint_with_reflex(rng)
    noise = rng.standard_normal(trial.time.size)
    found = altered(trial, torque=lambda x: noise)
    for row in parallel_cascade_estimates("position_manipulator", "a", analysed(found)):
        assert "lack-of-fit" in row.flags
    regression = analyse_position_manipulator(found, FEW_DRAWS, rng)
    for row in position_manipulator_estimates("position_manipulator", "a", regression):
        assert "lack-of-fit" in row.flags


@pytest.mark.slow
def test_gain_of_a_muscle_that_is_too_slow_is_flagged(rng, monkeypatch):
    monkeypatch.setitem(globals(), "FREQUENCY_HZ", 1.5)
    flags = flags_of(analysed(joint_with_reflex(rng)[0]))
    assert "slow-reflex" in flags["parallel-cascade", "reflex_gain"]
    assert "slow-reflex" in flags["parallel-cascade-muscle", "reflex_gain"]
    assert "slow-reflex" not in flags["parallel-cascade", "K"]


@pytest.mark.slow
def test_delay_beyond_those_that_are_tried_is_flagged_and_never_assumed():
    found = analysed(joint_with_reflex(np.random.default_rng(8), delay=0.015)[0])
    # the early reflex is mistaken for less damping
    assert found.impedance[1] < 0.8 * DAMPING
    flags = flags_of(found)
    assert flags["parallel-cascade", "reflex_delay"] == ["reflex-outside-search"]
    assert all(
        "reflex-outside-search" in flags["parallel-cascade", name] for name in ("I", "B", "reflex_gain")
    )
