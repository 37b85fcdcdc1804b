"""Short-range stiffness, slow torque and what a record does not determine, on joints of known parts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from tepsipe.identification.cascade.fit import SlowModel, Structure, estimate_slow_model
from tepsipe.identification.cascade.normal_equations import (
    block_sums,
    solve_bounded,
    solve_drawn,
    solve_without_each,
)
from tepsipe.identification.cascade.options import ParallelCascadeOptions
from tepsipe.identification.cascade.parallel_cascade import identify_cascade
from tepsipe.identification.cascade.pathways import laguerre_responses, stop_deflection
from tepsipe.identification.cascade.record import make_record
from tepsipe.identification.cascade.selection import choose, choose_rows, cross_validated_tolerance
from tepsipe.signals.filters import butterworth_lowpass

RATE = 250.0
QUICK = ParallelCascadeOptions(
    reflex_poles_per_s=(25.0,), reflex_thresholds_rad_per_s=(0.0,), profiled_delays_s=(0.036, 0.044)
)


def held_angle(rng, seconds=40.0, amplitude=0.03):
    """Random steps, followed by an actuator of 15 Hz (rad)."""
    levels = amplitude * rng.uniform(-1.0, 1.0, round(seconds / 0.2))
    sections = signal.butter(2, 15.0, fs=RATE, output="sos")
    return signal.sosfilt(sections, np.repeat(levels, round(0.2 * RATE)))


def joint_torque(angle, rng, short_range=0.0, radius=0.004, slow=0.0, noise=0.02):
    """I, B, K of 0.015, 0.8 and 60 with one elastic-plastic element, slow torque and noise (Nm)."""
    velocity = np.gradient(angle) * RATE
    torque = 0.015 * np.gradient(velocity) * RATE + 0.8 * velocity + 60.0 * angle
    deflection = np.zeros(angle.size)
    for k in range(1, angle.size):
        deflection[k] = np.clip(deflection[k - 1] + angle[k] - angle[k - 1], -radius, radius)
    keep = np.exp(-1.0 / RATE)
    drift = signal.lfilter([1.0], [1.0, -keep], np.sqrt(1.0 - keep**2) * rng.standard_normal(angle.size))
    return torque + short_range * deflection + slow * drift + noise * rng.standard_normal(angle.size)


def fitted(angle, torque, options=QUICK, draws=100):
    kept = slice(250, angle.size - 250)
    training = (kept.stop - kept.start) // 2
    low = lambda x: butterworth_lowpass(x, RATE, 30.0, 4)  # noqa: E731
    record = make_record(angle, torque, RATE, kept, training, low, options)
    return identify_cascade(record, 250, draws, np.random.default_rng(1))


# ---- parts -------------------------------------------------------------------------------------


def test_stop_element_follows_the_angle_and_yields_at_its_radius():
    angle = np.array([0.0, 0.5, 3.0, 2.5, 1.0, 1.5, -9.0])
    assert stop_deflection(angle, 1.0) == pytest.approx([0.0, 0.5, 1.0, 0.5, -1.0, -0.5, -1.0])
    assert stop_deflection(angle, 100.0) == pytest.approx(angle - angle[0])


def test_loop_of_a_stop_element_dissipates_four_radii_times_what_lies_beyond():
    phase = np.linspace(0.0, 6.0 * np.pi, 30001)
    angle, radius = 0.02 * np.sin(phase), 0.006
    force = stop_deflection(angle, radius)
    last = phase >= 4.0 * np.pi
    work = np.sum(0.5 * (force[last][1:] + force[last][:-1]) * np.diff(angle[last]))
    assert work == pytest.approx(4.0 * radius * (0.02 - radius), rel=1e-3)


def test_laguerre_responses_are_orthonormal_and_hold_a_critically_damped_muscle():
    basis = laguerre_responses(2.0, 15.0, 5, 1000.0)
    assert basis[0] == pytest.approx(0.0, abs=1e-12)
    assert basis.T @ basis / 1000.0 == pytest.approx(np.eye(5), abs=1e-9)
    time = np.arange(basis.shape[0]) / 1000.0
    muscle = time * np.exp(-15.0 * time)
    left = muscle - basis @ np.linalg.lstsq(basis, muscle, rcond=None)[0]
    assert np.abs(left).max() < 1e-9 * muscle.max()


def test_bounded_solution_is_that_of_all_combinations_of_zeros(rng):
    x = rng.standard_normal((60, 5))
    y = x @ [1.0, -2.0, -1.0, 0.5, 3.0] + rng.standard_normal(60)
    bounded = np.array([False, False, True, True, False])
    found = solve_bounded((x.T @ x)[None], (x.T @ y)[None], bounded)[0]
    best = np.inf
    for free in ([0, 1, 4], [0, 1, 2, 4], [0, 1, 3, 4], [0, 1, 2, 3, 4]):
        p = np.zeros(5)
        p[free] = np.linalg.lstsq(x[:, free], y, rcond=None)[0]
        if (p[bounded] >= 0.0).all():
            best = min(best, np.sum((y - x @ p) ** 2))
    assert found[2] == 0.0
    assert np.sum((y - x @ found) ** 2) == pytest.approx(best, rel=1e-9)


def test_sums_of_blocks_give_folds_and_draws(rng):
    x, y = rng.standard_normal((40, 3)), rng.standard_normal(40)
    blocks = [slice(10 * k, 10 * k + 10) for k in range(4)]
    sums, none = block_sums(x.__getitem__, y, blocks), np.zeros(3, dtype=bool)
    without = solve_without_each(sums, np.zeros((3, 3)), none)[1]
    rest = np.r_[0:10, 20:40]
    assert without == pytest.approx(np.linalg.lstsq(x[rest], y[rest], rcond=None)[0])
    twice = np.r_[0:10, 0:10, 20:40]
    drawn = solve_drawn(sums, np.array([[2.0, 0.0, 1.0, 1.0]]), np.zeros((3, 3)), none)[0]
    assert drawn == pytest.approx(np.linalg.lstsq(x[twice], y[twice], rcond=None)[0])
    errors = sums.errors(np.tile(without, (4, 1)))
    assert errors[1] == pytest.approx(np.mean((y[10:20] - x[10:20] @ without) ** 2))


def test_reflex_must_lower_the_error_clearly_and_other_terms_by_the_tolerance():
    plain, other = np.array([1.0, 1.2, 0.9, 1.1]), np.array([1.0, 1.19, 0.9, 1.1])
    little, clear = plain - [0.3, -0.2, 0.2, -0.1], plain - [0.3, 0.25, 0.3, 0.35]
    reflex = np.array([False, False, True])
    tables = np.array([[plain, other, little], [plain, other, clear], [plain, 0.9 * other, 2.0 * plain]])
    assert choose_rows(tables, reflex, 0.01).tolist() == [0, 2, 1]


def test_average_over_structures_takes_each_of_those_within_the_tolerance_equally():
    simple, alike, worse = np.array([1.005, 1.005]), np.array([1.0, 1.0]), np.array([1.2, 1.2])
    tables = np.tile(np.array([simple, worse, alike]), (1000, 1, 1))
    among = (np.arange(1000) + 0.5) / 1000.0
    taken = choose_rows(tables, np.zeros(3, dtype=bool), 0.01, among)
    assert np.bincount(taken, minlength=3).tolist() == [500, 0, 500]


def test_weak_term_that_helps_in_every_block_is_taken():
    simple = np.array([1.0, 30.0, 2.0, 0.5, 1.5])
    assert cross_validated_tolerance(np.array([simple, 0.996 * simple])) == 0.003
    assert cross_validated_tolerance(np.array([simple, 0.9995 * simple])) == 0.0


def test_terms_that_help_in_one_block_by_chance_are_not_taken():
    simple = np.ones(6)
    lucky = np.where(np.eye(6, dtype=bool), 0.95, 1.005)
    assert lucky.mean(axis=1).max() < simple.mean()
    assert cross_validated_tolerance(np.vstack([simple, lucky])) == 0.03


def test_tolerance_of_equal_errors_leaves_the_fewest_terms():
    assert cross_validated_tolerance(np.ones((4, 5))) == 0.03


@pytest.mark.parametrize(
    ("term", "taken"), [("unloading", True), ("gain_slope", True), ("stiffening", False)]
)
def test_weak_term_is_taken_if_it_does_not_change_what_stiffness_means(term, taken):
    none, reflex = Structure(0, False, 0.0, 0.0), Structure(1, False, 0.04, 0.0)
    more, size = replace(reflex, **{term: True}), np.array([1.0, 1.2, 0.9, 1.1])
    errors = {none: 2.0 * size, reflex: size, more: 0.996 * size}
    assert choose(errors, 0.01) == (more if taken else reflex)


# ---- slow torque -------------------------------------------------------------------------------


def test_innovation_of_a_slow_torque_is_white_and_a_constant_stays(rng):
    model = SlowModel(0.2, 2.0)
    phi, rho = model.poles(RATE)
    white = rng.standard_normal(50_000)
    slow = signal.lfilter([1.0, -rho], [1.0, -phi], white)
    assert model.whiten(slow, RATE)[5000:] == pytest.approx(white[5000:], abs=1e-3)
    level = model.whiten(np.full(100, 3.0), RATE)
    assert level == pytest.approx(level[0])
    found = estimate_slow_model(slow, RATE)
    assert found.corner_hz == pytest.approx(0.2, rel=0.7)
    assert found.crossover_hz == pytest.approx(2.0, rel=0.5)


def test_noise_without_a_slow_torque_is_hardly_weighted(rng):
    assert estimate_slow_model(rng.standard_normal(8000), RATE).crossover_hz < 0.3


def test_prediction_of_the_slow_torque_uses_the_past_only(rng):
    model, residual = SlowModel(0.1, 1.0), rng.standard_normal(2000)
    horizon = 50
    before = model.predict(residual, RATE, horizon)
    changed = residual.copy()
    changed[1000:] += 100.0
    after = model.predict(changed, RATE, horizon)
    assert (after[: 1000 + horizon] == before[: 1000 + horizon]).all()
    assert after[1000 + horizon] != before[1000 + horizon]


def test_slow_torque_is_scored_apart_and_better_the_shorter_the_horizon(rng):
    angle = held_angle(rng)
    found = fitted(angle, joint_torque(angle, rng, slow=0.4))
    assert found.slow.vaf.held_out > found.vaf.held_out + 3.0
    assert (np.diff(found.slow.held_out_vaf) < 0.0).all()
    assert found.slow.sd_Nm == pytest.approx(0.4, rel=0.4)
    assert found.impedance[2] == pytest.approx(60.0, rel=0.03)


# ---- short-range stiffness ---------------------------------------------------------------------


def test_known_short_range_stiffness_is_recovered(rng):
    angle = held_angle(rng)
    found = fitted(angle, joint_torque(angle, rng, short_range=30.0))
    assert found.structure.stops
    assert found.structure.direction == 0
    assert found.impedance[2] == pytest.approx(60.0, rel=0.02)
    assert found.short_range.stiffness == pytest.approx(90.0, rel=0.03)
    assert found.short_range.yield_angle_rad == pytest.approx(0.004, rel=0.1)
    assert 60.0 < found.working_stiffness < 75.0
    low, high = np.percentile(found.short_range.stiffness_bootstrap, [2.5, 97.5])
    assert low < 90.0 < high


def test_joint_without_short_range_stiffness_has_none(rng):
    angle = held_angle(rng)
    found = fitted(angle, joint_torque(angle, rng))
    assert not found.structure.stops
    assert found.short_range.weights.size == 0
    assert found.short_range.stiffness == found.working_stiffness == found.impedance[2]
    assert np.isnan(found.short_range.yield_angle_rad)
    assert not found.stop_torque.any()


@pytest.mark.slow
def test_stiffness_does_not_depend_on_the_amplitude_of_the_recording(rng):
    stiffness = []
    for amplitude in (0.02, 0.06):
        angle = held_angle(rng, amplitude=amplitude)
        found = fitted(angle, joint_torque(angle, rng, short_range=30.0))
        stiffness.append((found.impedance[2], found.short_range.stiffness))
    assert stiffness[0] == pytest.approx(stiffness[1], rel=0.03)


def test_elements_beyond_the_recorded_movement_are_not_used(rng):
    angle = held_angle(rng, amplitude=0.005)
    found = fitted(angle, joint_torque(angle, rng, short_range=30.0, radius=0.002))
    assert found.short_range.radii_rad.tolist() == [0.002]


def test_structure_counts_its_terms():
    assert Structure(-1, True, 0.04, 0.0, stops=True, unloading=True).terms == 4
    assert Structure(0, False, 0.0, 0.0).terms == 0
