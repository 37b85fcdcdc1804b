"""Windows that last until a passive joint is at rest again (`find_perturbations(..., until="rest")`)."""

import re
from functools import cache

import numpy as np
import pytest
from builders import LEG, RATE_HZ, refused
from scipy.interpolate import CubicSpline
from scipy.signal import lsim

from tepsipe import Signal, find_perturbations, fit_impedance, load_example, simulate_joint

TRUE = {"I": 0.02, "B": 0.3, "K": 10.0}
PULSE_S, FIRST_S = 0.1, 3.0


@cache
def moved(apart_s, count=8, damping=TRUE["B"], early_s=0.0):
    """Time (s), belt velocity (m/s) and motion of a leg on a belt that alternately moves to and fro.

    The fifth pulse comes ``early_s`` earlier than the others would let expect.
    """
    time = np.arange(0.0, FIRST_S + apart_s * count + 3.0, 1.0 / RATE_HZ)
    velocity = np.zeros_like(time)
    for k in range(count):
        x = (time - FIRST_S - apart_s * k + early_s * (k == 4)) / PULSE_S
        velocity += 0.3 * (-1) ** k * np.where((x > 0.0) & (x < 1.0), np.sin(np.pi * x), 0.0)
    made = simulate_joint(time, velocity, LEG, engine="equations", **(TRUE | {"B": damping}))
    return time, velocity, made.theta, made.torque


def recorded(seed, apart_s=4.0, **how):
    """Time (s), belt velocity (m/s), angle (rad) and torque (N·m) with noise."""
    time, velocity, angle, torque = moved(apart_s, **how)
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((2, time.size))
    return time, velocity, angle + 2e-5 * noise[0], torque + 3e-3 * noise[1]


def of_both(time, velocity, angle):
    """Windows until the belt stops, and until the joint is at rest."""
    return find_perturbations(time, velocity), find_perturbations(time, velocity, until="rest", angle=angle)


def of_joint(fit):
    """Intervals of I, B, K."""
    return {name: fit.intervals[name] for name in TRUE}


def on_decay(fit):
    """Findings on the free decay."""
    return tuple(finding for finding in fit.findings if finding.startswith("The joint moves on"))


def half_width(fit, name="K"):
    low, high = fit.intervals[name]
    return (high - low) / 2.0


def test_window_ends_when_the_rate_is_back_in_its_noise():
    time, velocity, angle, _ = recorded(1, apart_s=8.0)
    short, long = of_both(time, velocity, angle)
    assert [w.start for w in long] == [w.start for w in short]
    assert len({w.stop - w.start for w in long}) == 1
    # J theta'' + B theta' + (K - m g r) theta = 0, so the swing decays with 2 J / B
    inertia = TRUE["I"] + LEG.inertia_kgm2 + LEG.mass_kg * LEG.com_m**2
    decay = np.exp(-0.5 * TRUE["B"] / inertia * (long[0].stop - short[0].stop) / RATE_HZ)
    assert 0.02 < decay < 0.07  # 5 % of the peak after the belt's stop, which lies above the noise
    noisy = angle + 4e-4 * np.random.default_rng(2).standard_normal(time.size)
    earlier = find_perturbations(time, velocity, until="rest", angle=noisy)
    assert short[0].stop < earlier[0].stop < long[0].stop


def test_angle_is_converted_and_its_length_is_checked():
    time, velocity, angle, _ = recorded(1)
    plain = find_perturbations(time, velocity, until="rest", angle=angle)
    assert plain == find_perturbations(time, velocity, until="rest", angle=Signal(np.degrees(angle), "deg"))
    refused(lambda: find_perturbations(time, velocity, until="rest", angle=angle[1:]), "angle", "found")
    refused(lambda: find_perturbations(time, velocity, until="rest", angle=0.0 * angle), "angle")


def test_interval_is_narrower_and_covers():
    """The half-width of K is less than half of its size with windows that end when the belt stops."""
    draws, covered, ratios = 40, np.zeros(3), []
    for seed in range(draws):
        time, velocity, angle, torque = recorded(seed)
        short, long = (
            fit_impedance(time, angle, torque, perturbations=w) for w in of_both(time, velocity, angle)
        )
        covered += [low <= TRUE[name] <= high for name, (low, high) in of_joint(long).items()]
        ratios.append(half_width(short) / half_width(long))
        assert half_width(long, "B") < 1.2 * half_width(short, "B")
    assert np.median(ratios) > 2.0
    assert (covered >= 0.85 * draws).all()


def test_example_has_a_third_of_the_half_width():
    dummy = load_example("dummy")
    windows = find_perturbations(dummy.time, dummy.belt_velocity, until="rest", angle=dummy.angle)
    short, long = (
        fit_impedance(dummy.time, dummy.angle, dummy.torque, perturbations=w)
        for w in (dummy.perturbations, windows)
    )
    assert half_width(long) < min(half_width(short) / 2.2, 0.009 * long.K)
    late = np.interp(dummy.time - 0.001, dummy.time, dummy.torque)
    assert abs(fit_impedance(dummy.time, dummy.angle, late, perturbations=windows).K / long.K - 1.0) < 0.01


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("lag_s", [0.001, -0.5 / RATE_HZ])
def test_delay_of_the_torque_costs_less_stiffness(seed, lag_s):
    time, velocity, angle, torque = recorded(seed)
    late = CubicSpline(time, torque)(time - lag_s)
    changes = []
    for windows in of_both(time, velocity, angle):
        there, then = (fit_impedance(time, angle, x, perturbations=windows).K for x in (torque, late))
        changes.append(abs(then / there - 1.0))
    assert changes[1] < 0.2 * changes[0]
    assert changes[1] < 0.01


@pytest.mark.parametrize("seed", range(3))
def test_torque_that_is_held_between_samples_costs_no_stiffness(seed):
    """The joint is driven by a torque that is constant from one sample to the next: half a sample late."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 40.0, 1.0 / RATE_HZ)
    torque, phase = np.zeros_like(time), rng.uniform(0.0, 1.0 / RATE_HZ)
    for k in range(8):
        x = (time - 3.0 - 4.0 * k - phase) / 0.15
        torque += 0.5 * (-1) ** k * np.where((x > 0.0) & (x < 1.0), np.sin(np.pi * x), 0.0)
    angle = lsim(([1.0], [TRUE["I"], TRUE["B"] / 3.0, TRUE["K"]]), torque, time, interp=False)[1]
    angle += 1e-5 * rng.standard_normal(time.size)
    measured = torque + 1e-4 * rng.standard_normal(time.size)
    # the torque drives this joint, so its pulse takes the place of the belt's
    for windows in of_both(time, torque, angle):
        fit = fit_impedance(time, angle, measured, perturbations=windows)
        assert TRUE["K"] == pytest.approx(fit.K, rel=0.002)
        assert fit.quantities["delay"].value == pytest.approx(-0.5 / RATE_HZ, rel=0.1)


def test_pulses_that_follow_too_soon_end_the_window_before_and_are_noted():
    time, velocity, angle, torque = recorded(3, apart_s=1.0, damping=0.1)
    short, long = of_both(time, velocity, angle)
    assert [w.stop for w in long[:-1]] == [w.start for w in short[1:]]
    fit = fit_impedance(time, angle, torque, perturbations=long)
    assert [note.partition(",")[0] for note in fit.notes] == [
        "7 of 8 windows end where the next perturbation begins"
    ]
    assert fit.intervals["K"][0] < TRUE["K"] < fit.intervals["K"][1]
    time, velocity, angle, torque = recorded(3, apart_s=8.0)
    assert fit_impedance(time, angle, torque, perturbations=of_both(time, velocity, angle)[1]).notes == ()


def test_one_early_pulse_or_one_disturbance_leaves_the_other_windows_as_they_are():
    time, velocity, angle, torque = recorded(3)
    usual = of_both(time, velocity, angle)[1]
    length = usual[0].stop - usual[0].start
    time, velocity, angle, torque = recorded(3, early_s=3.4)
    short, long = of_both(time, velocity, angle)
    assert long[3].stop == short[4].start
    others = [w.stop - w.start for k, w in enumerate(long) if k != 3]
    assert max(others) == min(others) == pytest.approx(length, rel=0.05)
    (note,) = fit_impedance(time, angle, torque, perturbations=long).notes
    assert note.startswith("1 of 8 windows end")
    time, velocity, angle, _ = recorded(3, apart_s=8.0)
    usual = of_both(time, velocity, angle)[1]
    moved_again = angle + 0.02 * np.exp(-(((time - time[usual[2].start] - 6.0) / 0.1) ** 2))
    assert of_both(time, velocity, moved_again)[1] == usual


def test_joint_that_stops_with_the_belt_keeps_its_windows():
    time, velocity, *_ = moved(4.0)
    angle = 0.01 * velocity + 5e-4 * np.random.default_rng(1).standard_normal(time.size)
    short, long = of_both(time, velocity, angle)
    assert [(w.start, w.stop) for w in long] == [(w.start, w.stop) for w in short]


def test_windows_with_the_decay_are_not_recommended_again():
    """Nor if a slow mode, of which too little is left to see it move, would still narrow the interval."""
    for seed in range(15):
        time, velocity, angle, torque = recorded(seed, count=4, damping=2.5)
        torque = torque + 0.02 * np.random.default_rng(seed).standard_normal(time.size)
        windows = of_both(time, velocity, angle)[1]
        assert on_decay(fit_impedance(time, angle, torque, perturbations=windows)) == ()


def test_windows_given_as_pairs_may_follow_each_other():
    time, velocity, angle, torque = recorded(3, apart_s=1.0, damping=0.1)
    pairs = [(w.start, w.stop) for w in of_both(time, velocity, angle)[1]]
    assert fit_impedance(time, angle, torque, perturbations=pairs).notes == ()


def test_fit_recommends_the_decay_with_the_half_width_that_it_gives():
    time, velocity, angle, torque = recorded(4)
    short, long = of_both(time, velocity, angle)
    fit, longer = (fit_impedance(time, angle, torque, perturbations=w) for w in (short, long))
    (finding,) = on_decay(fit)
    assert 'until="rest"' in finding
    # the finding assumes the delay of the shorter windows
    value, half = re.search(r"gives about K = (\S+) ± (\S+) N·m/rad", finding).groups()
    assert float(value) == pytest.approx(longer.K, rel=1e-3)
    assert float(half) == pytest.approx(half_width(longer), rel=0.1)
    assert f"instead of {fit.K:.4g} ± {half_width(fit):.2g} N·m/rad" in finding
    assert finding in fit.summary()
    assert fit.notes == longer.notes == on_decay(longer) == ()
    assert on_decay(fit_impedance(time, angle, torque, perturbations=short, thesis=True)) == ()
    scale = {"torque_scale": 0.05}  # dominates both intervals, so the decay gains nothing
    assert on_decay(fit_impedance(time, angle, torque, perturbations=short, uncertainty=scale)) == ()
    # following the advice would put the rest at the end into the last window
    assert on_decay(fit_impedance(time, angle, torque, perturbations=short, rest=(2.0, 5.0))) == ()


@pytest.mark.parametrize("disturbed", ["reflex", "softening"])
def test_fit_does_not_recommend_a_decay_that_disagrees(disturbed):
    time, velocity, angle, torque = recorded(5)
    if disturbed == "reflex":  # of the stretch velocity, 40 ms late, by a muscle of 30 rad/s
        stretch = np.maximum(np.gradient(moved(4.0)[2], time), 0.0)
        stretch = np.roll(stretch, round(0.04 * RATE_HZ))
        torque = torque + 0.3 * lsim(([900.0], [1.0, 60.0, 900.0]), stretch, time)[1]
    else:  # by 30 % beyond 5 mrad
        torque = torque - 3.0 * np.sign(angle) * np.maximum(np.abs(angle) - 0.005, 0.0)
    windows = find_perturbations(time, velocity)
    assert on_decay(fit_impedance(time, angle, torque, perturbations=windows)) == ()


def test_delay_of_the_torque_does_not_hide_the_decay():
    time, velocity, angle, torque = recorded(5)
    late = CubicSpline(time, torque)(time - 0.002)
    fit = fit_impedance(time, angle, late, perturbations=find_perturbations(time, velocity))
    assert on_decay(fit) and "too late" in fit.notes[0]
