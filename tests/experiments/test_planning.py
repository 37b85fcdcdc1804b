"""A plan predicts what the estimators will show: analytic cases, scaling, bounds, and draws of noise."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.experiments.planning.design import PATHWAYS, Design, Protocol, Rig
from tepsipe.experiments.planning.monte_carlo import draw_estimates
from tepsipe.experiments.planning.optimal_pulse import optimise_pulse
from tepsipe.experiments.planning.plan import expected_likelihood, plan_experiment
from tepsipe.experiments.planning.pulses import PROFILES, STEP_S, Drive, Limits, peaks_of, pulse_of
from tepsipe.experiments.planning.window_noise import window_noise
from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.reporting import plan_arguments
from tepsipe.reporting.plan_command import best_of
from tepsipe.signals.perturbations import Perturbation
from tepsipe.statistics.uncertainty import Source

LEG = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027)
K = 2


@cache
def design(pathway="joint-likelihood-linear", profile="sine", amplitude=0.3, number=5, noise=2e-5, **changes):
    return Design(
        joint=Joint(0.007, 0.1, 10.0),
        leg=LEG,
        rig=Rig(marker_noise_m=noise, log_noise_m_per_s=noise * 150.0),
        protocol=Protocol(
            pulse=pulse_of(profile, amplitude, 0.1),
            number=number,
            interval_s=2.0,
            rest_before_s=1.5,
            rest_after_s=1.5,
            pathway=pathway,
            **changes,
        ),
    )


@cache
def plan(*arguments, **changes):
    return plan_experiment(design(*arguments, **changes))


def test_pure_spring_has_the_standard_error_of_a_line():
    """Torque noise alone and theta alone: SE(K) = sigma / sqrt(sum theta^2)."""
    still = design("foot", cutoff_hz=100.0, order=16)
    rig = replace(
        still.rig, marker_noise_m=1e-15, force_noise_N=0.0, moment_noise_Nm=0.3, plate_rate_hz=250.0
    )
    n = 300
    theta = 0.02 * np.random.default_rng(1).standard_normal(n)
    # other regressors that are at right angles to theta and far larger
    others = np.linalg.qr(np.column_stack([theta, np.random.default_rng(2).standard_normal((n, 2))]))[0][
        :, 1:
    ]
    found = window_noise(
        replace(still, rig=rig), np.column_stack([1e3 * others, theta]), [Perturbation(0, n, 0.3)], 10**9
    )
    passed = 2.0 * 100.0 / 250.0  # part of the band that the low-pass keeps
    expected = 0.3 / np.sqrt(np.sum(theta**2)) * np.sqrt(passed)
    assert np.sqrt(found.covariance[K, K]) == pytest.approx(expected, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("pathway", ["joint-likelihood-linear", "leg", "foot"])
def test_noise_number_and_amplitude_scale_as_they_must(pathway):
    base, noisy = plan(pathway), plan(pathway, noise=4e-5)
    if pathway != "foot":  # there the plate has a noise of its own
        assert noisy.type_a == pytest.approx(2.0 * base.type_a, rel=0.05)
    # the first pulse meets a leg at rest, the others one that still swings
    more = plan(pathway, number=10)
    assert more.type_a == pytest.approx(base.type_a_with(10), rel=0.15)
    falling = [np.sqrt(p.type_a**2 - p.of_rest**2) for p in (base, more)]
    assert falling[1] == pytest.approx(np.sqrt(0.5) * falling[0], rel=0.15)
    # the drive is at its limit of force at neither amplitude
    smaller = plan(pathway, amplitude=0.15)
    assert smaller.type_a[K] == pytest.approx(2.0 * base.type_a[K], rel=0.06)


@pytest.mark.parametrize("pathway", ["joint-likelihood", "joint-likelihood-linear"])
def test_no_estimator_is_below_the_cramer_rao_bound(pathway):
    assert (plan(pathway).type_a >= plan(pathway).bound).all()
    assert plan(pathway).bound[K] > 0.8 * plan(pathway).type_a[K]


def test_a_joint_that_may_soften_costs_information():
    assert (plan("joint-likelihood").type_a > plan("joint-likelihood-linear").type_a).all()


@pytest.mark.parametrize("pathway", ["leg", "foot"])
def test_draws_of_noise_scatter_as_predicted(pathway, rng):
    drawn = draw_estimates(design(pathway), plan(pathway).motion, rng, 30)
    # 30 draws determine a standard deviation to 13 %
    assert drawn.std(axis=0, ddof=1) == pytest.approx(plan(pathway).type_a, rel=0.5)
    assert drawn.mean(axis=0) == pytest.approx(design(pathway).parameters + plan(pathway).bias, rel=0.05)


@pytest.mark.slow
def test_likelihood_scatters_as_predicted(rng):
    drawn = draw_estimates(design(), plan().motion, rng, 8)
    chi_square = np.sum(((drawn - design().parameters) / plan().type_a) ** 2, axis=0)
    assert (chi_square > 1.0).all() and (chi_square < 26.0).all()  # 0.2 and 99.9 % of 8 draws


def test_noise_of_the_markers_biases_least_squares_towards_zero():
    assert plan("leg", amplitude=0.1).bias[K] < 0.0
    # noise over signal, squared
    ratio = plan("leg", amplitude=0.1).bias[K] / plan("leg").bias[K]
    assert ratio == pytest.approx(9.0, rel=0.15)


def test_tolerances_add_what_the_number_cannot_remove():
    known = replace(design(), sources={"leg_mass_kg": Source("leg_mass_kg", 0.004)})
    found = plan_experiment(known)
    assert found.type_b[K] == pytest.approx(0.01 * 10.0, rel=1e-3)  # K is proportional to the mass
    assert found.number_for(0.01) is None and found.number_for(0.1) == 1
    needed = plan("leg", amplitude=0.1, noise=1e-5).number_for(0.1)
    reached = 1.96 * plan("leg", amplitude=0.1, noise=1e-5).with_number(needed)[K]
    assert reached + abs(plan("leg", amplitude=0.1, noise=1e-5).bias[K]) <= 1.0


# ---- pulses ------------------------------------------------------------------------------------


def test_a_drive_follows_slow_commands_and_keeps_its_limit_of_force():
    slow = np.sin(np.pi * np.linspace(0.0, 1.0, 2001)) ** 2
    followed = Drive().follow(slow)
    assert np.abs(followed[: slow.size] - slow).max() < 0.03
    assert abs(followed[-1]) < 1e-5
    hard = Drive(acceleration_m_per_s2=5.0).follow(pulse_of("sine", 0.5, 0.1).velocity_m_per_s)
    assert np.abs(np.diff(hard)).max() / STEP_S == pytest.approx(5.0)


@pytest.mark.parametrize("profile", PROFILES)
def test_pulses_have_their_peak_and_displacement(profile):
    pulse = pulse_of(profile, 0.3, 0.1)
    peaks = peaks_of(pulse.velocity_m_per_s)
    assert peaks.velocity_m_per_s == pytest.approx(0.3, rel=0.01)
    moved = {"sine": 0.0, "minjerk": 0.0, "half-sine": 0.2 / np.pi, "ramp": 8.0 / 150.0}[profile]
    assert STEP_S * pulse.velocity_m_per_s.sum() == pytest.approx(0.3 * moved, abs=1e-5)


@cache
def optimal(one_way):
    planned = plan()
    pulse = replace(design().protocol.pulse, one_way=one_way)
    shaped = replace(design(), protocol=replace(design().protocol, pulse=pulse))
    limits = peaks_of(planned.motion.pulse_velocity)
    return optimise_pulse(shaped, expected_likelihood(design(), planned.motion), limits), limits


@pytest.mark.slow
@pytest.mark.parametrize("one_way", [False, True])
def test_the_best_pulse_is_no_worse_within_the_limits_and_no_better_than_its_bound(one_way):
    found, limits = optimal(one_way)
    assert limits.hold(found.peaks)
    assert found.least_standard_error <= found.standard_error < plan().bound[K]
    best = replace(design(), protocol=replace(design().protocol, pulse=found.pulse))
    assert plan_experiment(best).bound[K] == pytest.approx(found.standard_error, rel=0.02)


@pytest.mark.slow
def test_a_belt_that_stays_displaced_shows_more_of_k_and_one_that_returns_cannot():
    returning, staying = optimal(False)[0], optimal(True)[0]
    assert staying.standard_error < 0.75 * plan().bound[K]
    assert returning.least_standard_error > 0.9 * plan().bound[K]  # the proof for the thesis's sine
    assert abs(returning.belt_velocity.sum()) < 0.01 * np.abs(returning.belt_velocity).sum()


def test_bound_holds_for_other_pulses_within_the_limits():
    found, limits = optimal(True)
    for profile in PROFILES:
        command = pulse_of(profile, 0.3, 0.1)
        peaks = peaks_of(design().rig.drive.follow(command.velocity_m_per_s))
        shares = [vars(limits)[name] / vars(peaks)[name] for name in vars(peaks)]
        fitting = replace(command, velocity_m_per_s=min(1.0, *shares) * command.velocity_m_per_s)
        other = plan_experiment(replace(design(), protocol=replace(design().protocol, pulse=fitting)))
        assert other.bound[K] > 0.999 * found.least_standard_error


# ---- bad input ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Leg(mass_kg=-0.4, com_m=0.4, inertia_kgm2=0.02), "mass_kg: expected a number above 0"),
        (lambda: pulse_of("square", 0.3, 0.1), "expected a profile of"),
        (lambda: pulse_of("sine", -0.3, 0.1), "amplitude_m_per_s"),
        (lambda: pulse_of("sine", 0.3, 0.001), "duration_s"),
        (lambda: replace(design().protocol, interval_s=0.05), "leaves 0.1 s of rest after a pulse"),
        (lambda: replace(design().protocol, number=0), "at least 1 for 'number'"),
        (lambda: replace(design().protocol, pathway="legg"), "expected one of 'joint-likelihood'"),
        (lambda: replace(design().protocol, order=3), "even order"),
        (lambda: replace(design().protocol, rest_after_s=0.2), "at least 1 for 'rest_after_s'"),
        (lambda: replace(design(), joint=Joint(0.0, 0.1, 1.0)), "above the critical one"),
        (lambda: replace(design(), joint=Joint(0.0, -0.1, 10.0)), "damping"),
        (lambda: replace(design(), protocol=replace(design().protocol, cutoff_hz=200.0)), "cutoff_hz below"),
        (lambda: Rig(marker_noise_m=0.0), "marker_noise_m"),
        (lambda: Rig(camera_rate_hz=50.0), "at least 80 for 'camera_rate_hz'"),
        (lambda: Rig(log_rate_hz=100.0), "log_rate_hz of at least camera_rate_hz"),
        (lambda: Rig(foot_markers=0), "foot_markers"),
        (lambda: Drive(acceleration_m_per_s2=0.0), "acceleration_m_per_s2"),
        (lambda: Limits(displacement_m=0.0), "no pulse meets"),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(make, words):
    with pytest.raises(InputError, match=r"expected .*found .*: ") as refused:
        make()
    assert words in str(refused.value) and "\n" not in str(refused.value)


def test_limits_that_no_useful_pulse_meets_are_refused():
    with pytest.raises(InputError, match=r"limits that allow a pulse of 0\.01 m/s, found"):
        best_of(plan(), Limits(jerk_m_per_s3=0.1), True)


def test_a_pulse_that_cannot_be_shaped_is_refused():
    short = replace(design(), protocol=replace(design().protocol, pulse=pulse_of("sine", 0.3, 0.02)))
    expected = expected_likelihood(design(), plan().motion)
    with pytest.raises(InputError, match="to be shaped"):
        optimise_pulse(short, expected, Limits(velocity_m_per_s=0.3))


def test_arguments_of_the_command_name_what_can_be_planned():
    assert plan_arguments.PATHWAYS == PATHWAYS
    assert tuple(PROFILES) == plan_arguments.PROFILES
