"""Human joint under imposed movement: its parts against their equations."""

import numpy as np
import pytest

from tepsipe.virtual_lab.human_joint import HumanJoint, move_human_joint, short_range_torque

PASSIVE = HumanJoint(reflex_gain_Nms_per_rad=0.0, slow_torque_Nm=0.0)


def moved(joint, seed=1):
    return move_human_joint(joint, 10.0, np.random.default_rng(seed))


def test_a_joint_without_reflex_and_short_range_is_linear():
    record = moved(PASSIVE)
    assert record.linear == pytest.approx([0.014, 0.7, 60.0])
    velocity = np.gradient(record.angle, record.time)
    columns = np.column_stack([np.gradient(velocity, record.time), velocity, record.angle])
    # central differences are inexact where the acceleration of the actuator jumps
    left = (record.torque - columns @ record.linear)[10:-10]
    assert np.std(left) < 0.1 * np.std(record.torque)
    assert np.median(np.abs(left)) < 0.001 * np.std(record.torque)


def test_a_reflex_answers_quick_stretches_only_and_late():
    joint = HumanJoint(slow_torque_Nm=0.0)
    record = moved(joint)
    reflex = record.torque - moved(PASSIVE).torque
    velocity = np.gradient(record.angle, record.time)
    assert reflex.max() > 0.5 and reflex.min() > -0.05 * reflex.max()
    first = np.flatnonzero(velocity > joint.reflex_threshold_rad_per_s)[0] / 1000.0
    answered = np.flatnonzero(np.abs(reflex) > 1e-9)[0] / 1000.0
    assert answered == pytest.approx(first + joint.reflex_delay_s, abs=0.005)


def test_a_dahl_element_is_stiff_at_first_and_then_yields():
    joint = HumanJoint(short_range="dahl", short_range_Nm_per_rad=20.0, yield_rad=0.004)
    torque = short_range_torque(joint, np.r_[0.0, np.linspace(0.0, 0.1, 100_001)])
    assert torque[11] == pytest.approx(20.0 * 1e-5, rel=0.01)
    assert torque[-1] == pytest.approx(20.0 * 0.004)
    assert moved(joint).linear[2] > 60.5


def test_a_maxwell_element_relaxes():
    joint = HumanJoint(short_range="maxwell", short_range_Nm_per_rad=20.0, relaxation_s=0.05)
    torque = short_range_torque(joint, np.r_[0.0, np.full(500, 0.1)])
    assert torque[1] == pytest.approx(2.0)
    assert torque[51] == pytest.approx(2.0 * np.exp(-1.0), rel=1e-6)
