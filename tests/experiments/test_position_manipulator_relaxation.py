"""Stiffness that relaxes, intervals from few blocks, and the pathways of a joint on the page of a trial."""

from dataclasses import replace

import numpy as np
import pytest

from tepsipe.experiments.position_manipulator.analysis import parallel_cascade_estimates
from tepsipe.experiments.position_manipulator.page import position_manipulator_page
from tepsipe.identification.cascade.pathways import relaxing_deflection
from tepsipe.io.result import Result
from tepsipe.signals.differentiation import derivative
from tepsipe.statistics.bootstrap import expanded_tail
from tests.identification.test_short_range import QUICK, RATE, fitted, held_angle, joint_torque
from tests.reporting.test_pages import manipulator_trial


def test_relaxing_element_decays_after_a_step_and_follows_a_ramp_as_a_damper():
    time = np.arange(1000) / RATE
    decaying = relaxing_deflection(np.where(time < 1.0, 0.0, 1.0), 0.05, RATE)
    later = np.searchsorted(time, 1.0) + 25
    assert decaying[later + 25] / decaying[later] == pytest.approx(np.exp(-25.0 / RATE / 0.05), rel=1e-9)
    # at a steady velocity the spring is deflected by velocity times time constant
    assert relaxing_deflection(3.0 * time, 0.2, RATE)[-1] == pytest.approx(0.6, rel=1e-6)


def test_cubic_spline_loses_acceleration_near_the_cutoff_and_that_of_degree_5_does_not():
    time = np.arange(500) / RATE
    w = 2.0 * np.pi * 30.0
    inner = slice(50, -50)
    lost = {}
    for degree in (3, 5):
        twice = derivative(time, derivative(time, np.sin(w * time), degree), degree)[inner]
        lost[degree] = 1.0 + twice @ np.sin(w * time[inner]) / w**2 / np.sum(np.sin(w * time[inner]) ** 2)
    assert lost[3] > 2e-3
    assert abs(lost[5]) < 4e-4


@pytest.mark.slow
@pytest.mark.parametrize(("relaxing", "found"), [(25.0, True), (0.0, False)])
def test_stiffness_that_remains_is_found_beside_one_that_relaxes(relaxing, found):
    rng = np.random.default_rng(8)
    angle = held_angle(rng)
    torque = joint_torque(angle, rng, slow=0.1, noise=0.1) + relaxing * relaxing_deflection(angle, 0.07, RATE)
    fit = fitted(angle, torque)
    assert fit.structure.relaxing is found
    assert fit.structure.direction == 0
    assert fit.impedance[2] == pytest.approx(60.0, rel=0.03)
    assert fit.relaxing.stiffness == pytest.approx(relaxing, rel=0.3)
    assert fit.short_range.stiffness == pytest.approx(60.0 + relaxing, rel=0.08)
    rows = parallel_cascade_estimates("position_manipulator", "a", fit)
    assert {row.quantity for row in rows if row.flags} == (
        {"I", "B", "K_short_range", "K_relaxing", "relaxation_time"} if found else set()
    )
    if found:
        assert 0.05 <= fit.relaxing.time_s <= 0.09
        without = fitted(angle, torque, replace(QUICK, relaxation_times_s=()))
        assert without.relaxing.stiffness == 0.0
        # the linear pathway takes its part of the quick torque for a smaller inertia
        assert without.impedance[0] < 0.8 * 0.015
        assert fit.impedance[0] == pytest.approx(0.015, rel=0.05)


def test_expanded_percentiles_of_few_blocks_hold_the_mean_as_often_as_they_say(rng):
    n, records, draws = 8, 4000, 400
    values = rng.standard_normal((records, n))
    times = rng.multinomial(n, [1.0 / n] * n, size=draws) / n
    means = values @ times.T
    held = {}
    for tail in (2.5, expanded_tail(0.95, n)):
        low, high = np.percentile(means, [tail, 100.0 - tail], axis=1)
        held[tail] = np.mean((low < 0.0) & (high > 0.0))
    plain, expanded = held.values()
    assert plain < 0.91
    assert expanded == pytest.approx(0.95, abs=0.02)
    assert expanded_tail(0.95, 10_000) == pytest.approx(2.5, abs=0.01)


def page_of(direction, short_range):
    trial = manipulator_trial("torque", "angle")
    time = trial.time[250:2750]
    arrays = {"time": time, "angle": np.cos(time), "torque": 6.0 + np.cos(time), "predicted_torque": time}
    parts = {"reflex_torque": direction * np.sin(time) ** 2, "stop_torque": 0.1 * np.sin(time)}
    parts |= {"predicted_torque": 5.0 + np.cos(time) + parts["reflex_torque"], "slow_torque": 0.2 * time}
    facts = {"held_out_from_s": 6.0, "training_s": 5.0, "vaf_held_out_percent": 80.0}
    own = {"vaf_held_out_percent": 93.0, "direction": direction, "slow_horizon_s": 0.25}
    facts["reflex"] = own | {"short_range": short_range, "relaxing": False}
    result = Result(arrays | {f"reflex/{key}": x for key, x in parts.items()}, {}, facts)
    choices = {"study": "A study", "condition": "c", "made": False}
    return time, parts, position_manipulator_page(trial, result, [], choices)


def test_page_shows_intrinsic_and_reflex_torque_whose_sum_is_the_prediction():
    time, parts, page = page_of(1, True)
    intrinsic, reflex, slow = page.sections[1].panels
    whole, small = intrinsic.traces
    assert whole.values == pytest.approx(np.cos(time) - np.cos(time).mean())
    assert "short-range stiffness" in small.label
    left = parts["predicted_torque"] - whole.values - reflex.traces[0].values
    assert np.ptp(left) < 1e-12
    assert slow.traces[0].values == pytest.approx(1.0 - np.sin(time) ** 2)


def test_page_of_a_joint_without_reflex_says_so():
    _, _, page = page_of(0, False)
    section = page.sections[1]
    assert section.note == "Cross-validation found no reflex."
    assert [len(panel.traces) for panel in section.panels] == [1, 0, 2]
