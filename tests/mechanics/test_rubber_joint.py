"""A softening rubber joint: small swings, softening, losses, and the free swing of a leg on it."""

import numpy as np
import pytest

from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.rubber_joint import SOFTENING, RubberJoint, swing

LEG = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027)
WEIGHT = 0.4 * 0.4485 * 9.81
ABOUT_ANKLE = 0.027 + 0.4 * 0.4485**2
STEP_S = 0.004


def joint(**changed):
    linear = {
        "stiffness_Nm_per_rad": 10.0,
        "half_softening_rad": np.inf,
        "damping_Nms_per_rad": 0.0,
        "softened_damping_Nms_per_rad": 0.0,
        "inertia_Nms2_per_rad": 0.0,
    }
    return RubberJoint(**(linear | changed))


def pushed(seconds, peak=2.0):
    """A push of 0.1 s (m/s²) with no net velocity, then rest: at whole and half steps."""
    t = np.arange(0.0, seconds, STEP_S / 2)[: 2 * int(seconds / STEP_S) + 1]
    push = np.where(t < 0.1, peak * np.sin(2 * np.pi * t / 0.1), 0.0)
    return push[None, : 2 * ((t.size - 1) // 2) + 1]


def free_period(theta):
    """Mean time between upward zero crossings after the push (s)."""
    late = theta[int(0.5 / STEP_S) :]
    crossings = np.flatnonzero((late[:-1] < 0.0) & (late[1:] >= 0.0))
    instants = crossings + late[crossings] / (late[crossings] - late[crossings + 1])
    return np.diff(instants).mean() * STEP_S


def test_a_linear_joint_swings_with_the_frequency_worked_by_hand():
    theta = swing(LEG, [joint(), joint(inertia_Nms2_per_rad=0.01)], pushed(8.0, 0.5), STEP_S)[0][:, 0]
    for k, inertia in enumerate((0.0, 0.01)):
        by_hand = 2.0 * np.pi * np.sqrt((ABOUT_ANKLE + inertia) / (10.0 - WEIGHT))
        assert free_period(theta[k]) == pytest.approx(by_hand, rel=1e-4)


def test_a_linear_joint_loses_energy_at_the_rate_worked_by_hand():
    theta = swing(LEG, [joint(damping_Nms_per_rad=0.02)], pushed(8.0, 0.5), STEP_S)[0][0, 0]
    n = round(free_period(theta) / STEP_S)
    early, late = np.abs(theta[200 : 200 + n]).max(), np.abs(theta[-n:]).max()
    elapsed = (
        np.abs(theta[-n:]).argmax() + theta.size - n - np.abs(theta[200 : 200 + n]).argmax() - 200
    ) * STEP_S
    assert np.log(early / late) / elapsed == pytest.approx(0.02 / (2.0 * ABOUT_ANKLE), rel=0.02)


def test_softening_lowers_the_stiffness_with_amplitude_and_raises_the_damping():
    soft = joint(half_softening_rad=0.02, damping_Nms_per_rad=0.02, softened_damping_Nms_per_rad=0.1)
    (tiny_k, tiny_b), (small_k, small_b), (large_k, large_b) = map(soft.linearised, (1e-5, 0.02, 10.0))
    assert (tiny_k, tiny_b) == pytest.approx((10.0, 0.02), rel=1e-4)
    assert (large_k, large_b) == pytest.approx((10.0 * (1.0 - SOFTENING), 0.12), rel=1e-2)
    assert tiny_k > small_k > large_k
    assert tiny_b < small_b < large_b


def test_the_linearised_joint_swings_as_the_softening_one():
    soft = joint(half_softening_rad=0.006)
    theta = swing(LEG, [soft], pushed(8.0), STEP_S)[0][0, 0]
    stiffness, _ = soft.linearised(float(np.abs(theta[500:]).max()))
    by_hand = 2.0 * np.pi * np.sqrt(ABOUT_ANKLE / (stiffness - WEIGHT))
    assert stiffness < 9.0
    assert free_period(theta) == pytest.approx(by_hand, rel=2e-3)


def test_several_joints_and_feet_at_once_are_those_one_by_one():
    joints = [joint(), joint(half_softening_rad=0.02, damping_Nms_per_rad=0.1)]
    pushes = np.concatenate([pushed(1.0, 1.0), pushed(1.0, 3.0)])
    together, _ = swing(LEG, joints, pushes, STEP_S)
    for k, one in enumerate(joints):
        for f in range(2):
            alone = swing(LEG, [one], pushes[f : f + 1], STEP_S)[0][0, 0]
            np.testing.assert_allclose(together[k, f], alone, rtol=1e-12, atol=1e-15)


def test_longer_steps_while_the_foot_rests_change_the_swing_little_and_its_rate_is_that_of_the_angle():
    soft = joint(half_softening_rad=0.02, damping_Nms_per_rad=0.05, softened_damping_Nms_per_rad=0.1)
    push = pushed(4.0)
    theta, rate = (x[0, 0] for x in swing(LEG, [soft], push, STEP_S))
    np.testing.assert_allclose(rate[1:-1], (theta[2:] - theta[:-2]) / (2 * STEP_S), atol=0.02 * rate.max())
    clock = np.concatenate([np.arange(40), np.arange(40, theta.size, 8)])  # the push lasts 25 steps
    halves = np.rint(np.interp(np.arange(2 * clock.size - 1) / 2, np.arange(clock.size), 2 * clock))
    steps = np.diff(clock) * STEP_S
    longer = swing(LEG, [soft], push[:, halves.astype(int)], steps[None])
    for found, exact in zip(longer, (theta, rate), strict=True):
        np.testing.assert_allclose(found[0, 0], exact[clock], atol=2e-3 * exact.max())
    # steps of no length at the end leave the leg where it is
    ended, _ = swing(LEG, [soft], push[:, :201], np.r_[np.full(90, STEP_S), np.zeros(10)][None])
    assert (ended[0, 0, 90:] == theta[90]).all()
