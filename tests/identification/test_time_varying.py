"""Stiffness that changes: a joint with known K(t), whose torque is written down from its derivatives."""

import numpy as np
import pytest
import scipy
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.identification.time_varying import (
    MovedJoint,
    impedance_by_schedule,
    impedance_in_windows,
    impedance_of_ensemble,
)
from tepsipe.signals.resampling import rising_edges

RATE = 250.0
INERTIA, DAMPING = 0.015, 0.8
WINDOWS = {"window_s": 5.0, "step_s": 2.5, "block_s": 2.0, "draws": 100}
ENSEMBLE = {"length_s": 1.0, "segment_s": 0.2, "step_s": 0.1, "draws": 100}
SCHEDULE = {"bins": 5, "piece_s": 2.0, "draws": 100}


def doubling(x):
    """K (Nm/rad) that doubles from 0 to 1."""
    return 50.0 * (1.0 + x)


def imposed(seconds, rng):
    """Time, and a random angle with its exact first and second derivatives (s, rad)."""
    time = np.arange(round(seconds * RATE)) / RATE
    frequency = rng.uniform(0.3, 20.0, 60)
    phase = rng.uniform(0.0, 2.0 * np.pi, 60)
    size = 0.006 / np.hypot(1.0, frequency / 4.0)
    waves = size * np.exp(1j * (2.0 * np.pi * frequency * time[:, None] + phase))
    return time, *((waves * (2j * np.pi * frequency) ** order).sum(axis=1).imag for order in range(3))


def torque_of(stiffness, angle, velocity, acceleration):
    return INERTIA * acceleration + DAMPING * velocity + stiffness * angle


def voluntary(samples, rms, rng):
    """Slow and fast torque (Nm) of a person who does not keep still."""
    found = np.zeros(samples)
    for cutoff in (0.5, 10.0):
        sos = scipy.signal.butter(2, cutoff, fs=RATE, output="sos")
        part = scipy.signal.sosfilt(sos, rng.standard_normal(samples + 2500))[2500:]
        found += part / part.std() * rms / np.sqrt(2.0)
    return found


def reflex(velocity):
    """Torque (Nm) of a delayed, rectified, smoothed velocity; smoothing by a running mean of 0.1 s."""
    stretched = np.concatenate([np.zeros(10), np.maximum(velocity, 0.0)[:-10]])
    return scipy.signal.lfilter(np.full(25, 1.0 / 25.0), 1.0, stretched)


def covered(found, truth, name="K"):
    k = found.names.index(name)
    return np.mean((found.low[:, k] <= truth) & (truth <= found.high[:, k]))


def test_stiffness_that_doubles_over_a_record_is_followed(rng):
    time, *motion = imposed(60.0, rng)
    torque = torque_of(doubling(time / 60.0), *motion) - 4.0 + voluntary(time.size, 0.2, rng)
    found = impedance_in_windows(MovedJoint(motion[0] + 0.1, torque, RATE), **WINDOWS, rng=rng)
    truth = doubling(found.at / 60.0)
    assert found.over == "time"
    assert found.values[:, 2] == pytest.approx(truth, rel=0.10)
    assert found.values[-1, 2] / found.values[0, 2] > 1.7
    assert found.values[:, 0] == pytest.approx(INERTIA, rel=0.1)
    assert found.values[:, 1] == pytest.approx(DAMPING, rel=0.1)
    assert found.angle == pytest.approx(0.1, abs=0.02)
    assert covered(found, truth) >= 0.8


def test_without_noise_windows_return_the_mean_of_their_stiffness(rng):
    _, *motion = imposed(30.0, rng)
    found = impedance_in_windows(MovedJoint(motion[0], torque_of(60.0, *motion), RATE), **WINDOWS, rng=rng)
    assert found.values[:, 2] == pytest.approx(60.0, rel=1e-3)
    assert (found.vaf > 99.9).all()
    assert (found.high - found.low)[:, 2].max() < 0.3


def test_windows_without_perturbation_are_left_out(rng):
    time, *motion = imposed(60.0, rng)
    still = np.where((time > 20.0) & (time < 40.0), 0.0, 1.0)
    torque = torque_of(60.0, *motion) * still + voluntary(time.size, 0.1, rng)
    found = impedance_in_windows(MovedJoint(motion[0] * still, torque, RATE), **WINDOWS, rng=rng)
    assert not ((found.at > 22.5) & (found.at < 37.5)).any()
    assert found.at.min() < 5.0
    assert found.at.max() > 55.0


@pytest.mark.slow
def test_intervals_of_windows_cover_and_shrink_with_the_noise(rng):
    hits, widths = [], []
    for seed in range(6):
        draw = np.random.default_rng(seed)
        time, *motion = imposed(60.0, draw)
        noise = voluntary(time.size, 0.5, draw)
        for scale in (1.0, 0.5):
            torque = torque_of(doubling(time / 60.0), *motion) + scale * noise
            found = impedance_in_windows(
                MovedJoint(motion[0], torque, RATE), **WINDOWS, rng=np.random.default_rng(1)
            )
            widths.append(found.standard_error[:, 2].mean())
            hits.append(covered(found, doubling(found.at / 60.0)))
    assert np.mean(hits) > 0.88
    assert np.mean(widths[::2]) == pytest.approx(2.0 * np.mean(widths[1::2]), rel=0.1)


def test_noisier_part_of_a_record_has_wider_intervals(rng):
    time, *motion = imposed(60.0, rng)
    noise = voluntary(time.size, 0.2, rng) * np.where(time < 30.0, 1.0, 4.0)
    found = impedance_in_windows(
        MovedJoint(motion[0], torque_of(60.0, *motion) + noise, RATE), **WINDOWS, rng=rng
    )
    early, late = (found.standard_error[part, 2].mean() for part in (found.at < 25.0, found.at > 35.0))
    assert late == pytest.approx(4.0 * early, rel=0.35)


def test_reflex_torque_is_separated_from_the_stiffness(rng):
    time, *motion = imposed(60.0, rng)
    stretch = 8.0 * reflex(motion[1])
    gain = 1.0 + time / 60.0
    torque = torque_of(60.0, *motion) + gain * stretch + voluntary(time.size, 0.05, rng)
    alone = impedance_in_windows(MovedJoint(motion[0], torque, RATE), **WINDOWS, rng=rng)
    both = impedance_in_windows(MovedJoint(motion[0], torque, RATE, stretch), **WINDOWS, rng=rng)
    assert both.names[-1] == "reflex_gain_ratio"
    assert both.values[:, 3] == pytest.approx(1.0 + both.at / 60.0, rel=0.1)
    assert np.abs(both.values[:, 2] - 60.0).mean() < 0.5 * np.abs(alone.values[:, 2] - 60.0).mean()


def realisations(rng, count=30, noise=0.2):
    """A movement repeated every 1.5 s with random perturbations, K doubling within 1 s of its start."""
    time, angle, velocity, acceleration = imposed(1.5 * count + 1.0, rng)
    starts = np.arange(count) * 375
    stiffness = doubling(np.clip(time * RATE % 375 / 250.0, 0.0, 1.0))
    moved = 0.1 * np.sin(2.0 * np.pi * time / 1.5)
    # the movement has a torque of its own, the same every time, that is no stiffness
    torque = torque_of(stiffness, angle, velocity, acceleration) + 40.0 * moved**2 - 7.0 * moved
    return angle + moved, torque + voluntary(time.size, noise, rng), starts


def test_ensemble_follows_stiffness_within_a_second(rng):
    angle, torque, starts = realisations(rng)
    found = impedance_of_ensemble(MovedJoint(angle, torque, RATE), starts, **ENSEMBLE, rng=rng)
    truth = doubling(found.at)
    assert found.values[:, 2] == pytest.approx(truth, rel=0.10)
    assert covered(found, truth) >= 0.7
    assert (found.pieces == 30).all()
    # the operating point is that of the movement, about a perturbation whose mean is small
    assert found.angle == pytest.approx(0.1 * np.sin(2.0 * np.pi * found.at / 1.5), abs=0.02)


def test_realisations_that_do_not_end_in_the_record_are_left_out(rng):
    angle, torque, starts = realisations(rng)
    more = np.append(starts, [angle.size - 10, angle.size + 5])
    one, other = (
        impedance_of_ensemble(MovedJoint(angle, torque, RATE), s, **ENSEMBLE, rng=np.random.default_rng(1))
        for s in (starts, more)
    )
    assert (one.values == other.values).all()


def test_more_realisations_narrow_the_interval(rng):
    made = [realisations(rng, count) for count in (15, 60)]
    few, many = (impedance_of_ensemble(MovedJoint(a, t, RATE), at, **ENSEMBLE, rng=rng) for a, t, at in made)
    ratio = few.standard_error[:, 2].mean() / many.standard_error[:, 2].mean()
    assert 1.5 < ratio < 3.0


def test_schedule_that_is_passed_several_times(rng):
    time, *motion = imposed(100.0, rng)
    target = 1.0 - np.abs(time % 20.0 / 10.0 - 1.0)
    torque = torque_of(doubling(target), *motion) + 10.0 * target + voluntary(time.size, 0.2, rng)
    found = impedance_by_schedule(MovedJoint(motion[0], torque, RATE), target, **SCHEDULE, rng=rng)
    truth = doubling(found.at)
    assert found.at == pytest.approx(np.arange(0.1, 1.0, 0.2), abs=0.01)
    assert found.values[:, 2] == pytest.approx(truth, rel=0.05)
    assert covered(found, truth) >= 0.6
    assert found.torque == pytest.approx(10.0 * found.at, abs=0.4)


def test_a_trigger_marks_the_first_sample_above_its_middle():
    trigger = np.array([0.0, 0.0, 5.0, 5.0, 0.1, 0.0, 4.0, 0.0])
    assert rising_edges(trigger, "log").tolist() == [2, 6]


REFUSED = {
    "windows longer than half of the record": (
        lambda a, t, rng: impedance_in_windows(
            MovedJoint(a, t, RATE), **(WINDOWS | {"window_s": 29.0}), rng=rng
        ),
        "two perturbed windows",
    ),
    "windows of some samples": (
        lambda a, t, rng: impedance_in_windows(
            MovedJoint(a, t, RATE), **(WINDOWS | {"window_s": 0.05}), rng=rng
        ),
        "lengthen",
    ),
    "few realisations": (
        lambda a, t, rng: impedance_of_ensemble(
            MovedJoint(a, t, RATE), np.arange(5) * 300, **ENSEMBLE, rng=rng
        ),
        "found 5",
    ),
    "the same perturbation every time": (
        lambda a, t, rng: impedance_of_ensemble(
            MovedJoint(np.tile(a[:300], 10), np.tile(t[:300], 10), RATE),
            np.arange(10) * 300,
            **ENSEMBLE,
            rng=rng,
        ),
        "differ between the realisations",
    ),
    "segments longer than a realisation": (
        lambda a, t, rng: impedance_of_ensemble(
            MovedJoint(a, t, RATE), np.arange(20) * 300, **(ENSEMBLE | {"segment_s": 2.0}), rng=rng
        ),
        "shorten the segments",
    ),
    "a schedule that stands still": (
        lambda a, t, rng: impedance_by_schedule(MovedJoint(a, t, RATE), np.ones(a.size), **SCHEDULE, rng=rng),
        "schedule that changes",
    ),
    "a schedule that is passed once": (
        lambda a, t, rng: impedance_by_schedule(
            MovedJoint(a, t, RATE), np.arange(a.size) / 7500.0, **(SCHEDULE | {"piece_s": 5.0}), rng=rng
        ),
        "fewer in every bin",
    ),
    "a reflex torque in proportion to the angle": (
        lambda a, t, rng: impedance_in_windows(
            MovedJoint(a, t, RATE, reflex_torque=a - a.mean()), **WINDOWS, rng=rng
        ),
        "does not determine I, B, K",
    ),
    "a trigger that never rises": (lambda a, t, rng: rising_edges(np.zeros(10), "log"), "rises at"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_unusable_record_is_refused(case, rng):
    refuse, words = REFUSED[case]
    _, *motion = imposed(30.0, np.random.default_rng(2))
    with pytest.raises(InputError) as caught:
        refuse(motion[0], torque_of(60.0, *motion), rng)
    assert_one_sentence(caught.value, words)


def test_same_seed_gives_the_same_intervals(rng):
    angle, torque, starts = realisations(rng, 12)
    first, again, other = (
        impedance_of_ensemble(
            MovedJoint(angle, torque, RATE), starts, **ENSEMBLE, rng=np.random.default_rng(seed)
        ).low
        for seed in (1, 1, 2)
    )
    assert (first == again).all()
    assert (first != other).any()
