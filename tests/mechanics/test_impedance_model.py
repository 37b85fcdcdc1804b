"""The joint as a second-order system: its statics, its resonance, and its motion under any torque."""

import numpy as np
import pytest
from builders import second_order_response
from scipy.integrate import solve_ivp

from tepsipe.mechanics.impedance_model import admittance, impedance_torque, simulate_angle

JOINT = np.array([0.015, 0.1, 10.0])
RATE = 256.0


def test_constant_torque_bends_the_joint_by_torque_over_stiffness():
    angle = simulate_angle(JOINT, np.full(2000, 0.5), RATE)
    assert angle[-1] == pytest.approx(0.05, rel=1e-6)
    assert admittance(JOINT, np.array([0.0]))[0] == pytest.approx(0.1)


def test_admittance_peaks_at_its_resonance_and_lags_a_quarter_turn_at_its_eigenfrequency():
    inertia, damping, stiffness = JOINT
    eigenfrequency = np.sqrt(stiffness / inertia) / (2.0 * np.pi)
    assert eigenfrequency == pytest.approx(4.11, abs=0.01)
    there = admittance(JOINT, np.array([eigenfrequency]))[0]
    assert np.angle(there) == pytest.approx(-0.5 * np.pi)
    assert abs(there) == pytest.approx(1.0 / (damping * 2.0 * np.pi * eigenfrequency))
    grid = np.linspace(3.0, 5.0, 20001)
    peak = grid[np.argmax(np.abs(admittance(JOINT, grid)))]
    damping_ratio = damping / (2.0 * np.sqrt(inertia * stiffness))
    assert peak == pytest.approx(eigenfrequency * np.sqrt(1.0 - 2.0 * damping_ratio**2), abs=1e-3)


def test_inertia_rules_far_above_the_eigenfrequency():
    far = admittance(JOINT, np.array([100.0, 200.0]))
    assert np.abs(far[0] / far[1]) == pytest.approx(4.0, rel=0.01)
    assert np.angle(far[1]) == pytest.approx(-np.pi, abs=0.01)


@pytest.mark.parametrize("frequency_hz", [1.0, 4.0, 9.0])
def test_steady_motion_under_a_sine_is_the_admittance(frequency_hz):
    time = np.arange(0.0, 12.0, 1.0 / RATE)
    wave = np.exp(2j * np.pi * frequency_hz * time)
    angle = simulate_angle(JOINT, wave.imag, RATE)[-1280:]
    found = 2.0 * np.mean(1j * angle * wave[-1280:].conj())
    truth = second_order_response(JOINT, frequency_hz)
    # a torque that runs straight between samples of a sine holds a little less of it
    assert found == pytest.approx(truth * np.sinc(frequency_hz / RATE) ** 2, rel=1e-4)


def test_angle_under_a_torque_that_runs_straight_is_exact(rng):
    knots = np.arange(40) / RATE
    torque = rng.standard_normal(40)
    torque[0] = 0.0
    angle = simulate_angle(JOINT, torque, RATE)
    inertia, damping, stiffness = JOINT

    def rate(t, x):
        return x[1], (np.interp(t, knots, torque) - damping * x[1] - stiffness * x[0]) / inertia

    exact = solve_ivp(
        rate, (0.0, knots[-1]), (0.0, 0.0), t_eval=knots, rtol=1e-9, atol=1e-12, max_step=0.5 / RATE
    )
    assert angle == pytest.approx(exact.y[0], abs=1e-6 * np.abs(angle).max())


def test_torque_that_comes_later_gives_the_same_angle_later(rng):
    torque = np.concatenate([np.zeros(10), rng.standard_normal(500)])
    later = np.concatenate([np.zeros(7), torque[:-7]])
    prompt, late = simulate_angle(JOINT, torque, RATE), simulate_angle(JOINT, later, RATE)
    assert late[7:] == pytest.approx(prompt[:-7], abs=1e-12)


def test_joint_returns_the_torque_of_its_own_motion():
    omega = 2.0 * np.pi * 3.0
    time = np.arange(0.0, 1.0, 0.01)
    torque = 0.4 * np.sin(omega * time)
    response = 0.4 * second_order_response(JOINT, 3.0) * np.exp(1j * omega * time)
    theta, theta_d, theta_dd = response.imag, (1j * omega * response).imag, (-(omega**2) * response).imag
    assert impedance_torque(JOINT, theta, theta_d, theta_dd) == pytest.approx(torque, abs=1e-12)


def test_unstable_joint_is_seen_in_its_angle():
    angle = simulate_angle(np.array([0.015, -0.1, 10.0]), np.ones(20000), RATE)
    assert np.abs(angle[-1]) > 1e6 or not np.isfinite(angle[-1])
