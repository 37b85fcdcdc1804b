"""Laws of the dummy's rubber: energy and losses, limits worked by hand, and the laws that are shipped."""

import math

import numpy as np
import pytest
import scipy

from tepsipe.virtual_lab.integrate import integrate
from tepsipe.virtual_lab.rubber import Memory, Rubber

RATE_HZ = 4000.0
PAYNE = {"softening": 0.5, "softened_damping_Nms_per_rad": 0.1}
POWER = {"softening_power": 0.6}
FRICTION = {"bristle_Nm_per_rad": 5.0, "bristle_rad": 0.02}
CHAIN = {"relaxation_share": 0.6, "relaxation_s": (0.005, 0.05, 0.5)}


def rubber(damping=0.0, **own):
    plain = {
        "stiffness_Nm_per_rad": 10.0,
        "damping_Nms_per_rad": damping,
        "softening": 0.0,
        "softening_angle_rad": 0.02,
        "softened_damping_Nms_per_rad": 0.0,
    }
    return Rubber(**(plain | own))


def bent(law, rate_of, seconds):
    """Time, bending, rate, moment and states of a rubber that is bent at a given rate (rad/s at s)."""
    memory = Memory(law)
    steps = round(seconds * RATE_HZ)
    grid = np.arange(2 * steps + 1) / (2.0 * RATE_HZ)
    rates = rate_of(grid)
    inputs = np.column_stack([rates[:-2:2], rates[1:-1:2], rates[2::2]])

    def derivative(rate, state):
        own = memory.with_states(lambda *_: (rate,), lambda rig: (rig[0], rate))
        return own(rate, state) if memory.states else (rate,)

    time, states = integrate(derivative, (0.0, *memory.at_rest(0.0)), inputs, RATE_HZ)
    phi, rate = states[:, 0], rate_of(time)
    moment = law.moment(phi, rate)
    if memory.states:
        moment = moment + memory.remembered(phi, states[:, 1:])
    return time, phi, rate, moment, states[:, 1:]


def wandering(t):
    """Rate (rad/s) of a bending that comes and goes, up to 0.06 rad."""
    parts = ((0.05, 0.7, 0.3), (0.02, 2.3, 1.0), (0.004, 11.0, 2.0))
    return sum(size * 2.0 * np.pi * hz * np.cos(2.0 * np.pi * hz * t + turn) for size, hz, turn in parts)


def stored_and_lost(law, phi, rate, states):
    """Energy in the springs (J) and power that is lost (W), term by term."""
    half = law.softening_angle_rad
    grid = np.linspace(phi.min(), phi.max(), 20001)
    part = grid**2 / (grid**2 + half**2)
    elastic = law.stiffness_Nm_per_rad * grid * (1.0 - law.softening * part)
    elastic *= (1.0 + (grid / half) ** 2) ** (-0.5 * law.softening_power)
    stored = np.interp(phi, grid, scipy.integrate.cumulative_trapezoid(elastic, grid, initial=0.0))
    part = phi**2 / (phi**2 + half**2)
    lost = (law.damping_Nms_per_rad + law.softened_damping_Nms_per_rad * part) * rate**2
    times = law.relaxation_s if law.relaxation_share else ()
    for k, time_s in enumerate(times):
        each = law.relaxation_share * law.stiffness_Nm_per_rad / len(times)
        stretch = phi - states[:, k]
        stored, lost = stored + 0.5 * each * stretch**2, lost + each * stretch**2 / time_s
    if law.bristle_Nm_per_rad:
        z = states[:, -1]
        stored = stored + 0.5 * law.bristle_Nm_per_rad * z**2
        lost = lost + law.bristle_Nm_per_rad * z**2 * np.abs(rate) / law.bristle_rad
    return stored, lost


LAWS = {
    "payne": rubber(0.05, **PAYNE),
    "power": rubber(**POWER),
    "friction": rubber(**FRICTION),
    "relaxation": rubber(**CHAIN),
    "all": rubber(0.05, **PAYNE, **POWER, **FRICTION, **CHAIN),
}


@pytest.mark.parametrize("name", LAWS)
def test_work_is_stored_or_lost_and_never_made(name):
    law = LAWS[name]
    time, phi, rate, moment, states = bent(law, wandering, 3.0)
    work = scipy.integrate.cumulative_trapezoid(moment * rate, time, initial=0.0)
    stored, power = stored_and_lost(law, phi, rate, states)
    lost = scipy.integrate.cumulative_trapezoid(power, time, initial=0.0)
    assert (power >= 0.0).all()
    assert work == pytest.approx(stored - stored[0] + lost, abs=2e-4 * np.ptp(work))
    # passive: what was put in and not given back is at least what the springs hold
    assert (work >= stored - stored[0] - 2e-4 * np.ptp(work)).all()
    assert (lost[-1] > 0.05 * np.ptp(work)) == (name != "power")


def loop(law, hz, amplitude=0.03):
    """Energy (J) that the last of three cycles loses."""
    step = 1.0 / hz
    time, phi, _, moment, _ = bent(
        law, lambda t: amplitude * 2 * np.pi * hz * np.cos(2 * np.pi * hz * t), 3 * step
    )
    last = time >= 2 * step - 1e-9
    return scipy.integrate.trapezoid(moment[last], phi[last])


def test_friction_loses_as_much_quickly_as_slowly_and_yields():
    law = rubber(**FRICTION)
    assert loop(law, 4.0) == pytest.approx(loop(law, 0.5), rel=1e-2)
    assert loop(rubber(0.1), 4.0) == pytest.approx(8.0 * loop(rubber(0.1), 0.5), rel=1e-2)
    _, phi, _, moment, states = bent(law, lambda t: np.full(t.shape, 0.2), 1.0)
    # Dahl 1968: z = d (1 - exp(-phi / d)) on a path that never turns
    assert states[:, 0] == pytest.approx(0.02 * (1.0 - np.exp(-phi / 0.02)), abs=1e-8)
    assert moment[-1] == pytest.approx(10.0 * phi[-1] + 5.0 * 0.02, rel=1e-4)
    # small movements meet its whole stiffness
    assert moment[1] == pytest.approx(15.0 * phi[1], rel=2e-3)


def test_chain_has_the_response_worked_by_hand_and_loses_alike_over_two_decades():
    law = rubber(**CHAIN)
    for hz in (0.5, 3.0, 20.0):
        time, phi, _, moment, _ = bent(
            law, lambda t, hz=hz: 0.01 * 2 * np.pi * hz * np.cos(2 * np.pi * hz * t), 4.0 + 2.0 / hz
        )
        last = time > time[-1] - 1.0 / hz - 1e-9
        line = np.exp(-2j * np.pi * hz * time[last][1:])
        s = 2j * np.pi * hz
        expected = 10.0 + sum(2.0 * s * t / (1.0 + s * t) for t in law.relaxation_s)
        assert abs((line @ moment[last][1:]) / (line @ phi[last][1:]) / expected - 1.0) < 5e-3
    lost = [loop(law, hz) for hz in (0.5, 3.0, 20.0)]
    assert max(lost) < 1.6 * min(lost)


def test_power_law_softens_with_the_power_of_a_large_bending():
    law = rubber(**POWER)
    assert law.moment(1e-6, 0.0) == pytest.approx(10.0e-6)
    assert law.moment(20.0, 0.0) / law.moment(2.0, 0.0) == pytest.approx(10.0**0.4, rel=1e-3)
    assert law.moment(-0.03, 0.0) == -law.moment(0.03, 0.0)
    angles = np.linspace(0.0, 3.0, 3001)
    assert (np.diff(law.moment(angles, 0.0)) > 0.0).all()


def test_shipped_laws_are_as_stiff_as_the_rubber_when_quick_and_lose_half(shipped_truth):
    shared, laws = shipped_truth["dummy"]["rubber"], shipped_truth["dummy"]["other_laws"]
    assert set(laws) == {"friction", "power-law", "relaxation"}
    for name, changes in laws.items():
        law = Rubber(**(shared | changes))
        assert law.softening == law.softened_damping_Nms_per_rad == 0.0, name
        yielding, relaxing = law.bristle_Nm_per_rad, law.relaxation_share * law.stiffness_Nm_per_rad
        small = law.stiffness_Nm_per_rad + yielding + relaxing
        assert small == pytest.approx(shared["stiffness_Nm_per_rad"]), name
        far = 3.0 * shared["softening_angle_rad"]
        lasting = law.moment(far, 0.0) / far
        assert lasting == pytest.approx(0.5 * small, rel=5e-3), name
        assert sum((yielding > 0.0, relaxing > 0.0, law.softening_power > 0.0)) == 1, name
    assert laws["friction"].get("bristle_rad", shared["bristle_rad"]) == shared["softening_angle_rad"]


def test_a_rubber_without_memory_is_the_rubber_of_the_study(shipped_truth):
    law = Rubber(**shipped_truth["dummy"]["rubber"])
    assert Memory(law).states == 0
    phi, rate = 0.013, 0.4
    q = phi**2 / (phi**2 + law.softening_angle_rad**2)
    by_hand = law.stiffness_Nm_per_rad * phi * (1.0 - law.softening * q)
    by_hand += (law.damping_Nms_per_rad + law.softened_damping_Nms_per_rad * q) * rate
    assert math.isclose(law.moment(phi, rate), by_hand, rel_tol=1e-15)
