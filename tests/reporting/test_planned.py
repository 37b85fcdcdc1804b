"""What the planning says about the thesis's experiments, as table, chapter and claims."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from typst_builders import chapter_words

from tepsipe.io.estimates import Estimate
from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.reporting import planned
from tepsipe.reporting.chapters import planning
from tepsipe.reporting.claims import MEASURES, Findings
from tepsipe.reporting.planned import (
    BOUND,
    NUMBER,
    PLANNED_ROWS,
    RATIO,
    TYPE_A,
    plan_of_thesis,
    planned_value,
)
from tepsipe.reporting.run import Run, chapter_content

LEG_OF_DUMMY, FOOT_OF_DUMMY = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027), Foot(2.1, 0.055)


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("planned") / "planned.csv"
    PLANNED_ROWS.write(path, plan_of_thesis(LEG_OF_DUMMY, FOOT_OF_DUMMY, Joint(0.015, 0.1, 10.0), {}))
    return PLANNED_ROWS.read(path)


@pytest.mark.slow
def test_uncertainty_falls_with_amplitude_and_no_estimator_is_below_its_bound(rows):
    small, middle = (planned_value(rows, f"sine-{a:g}", TYPE_A) for a in (0.1, 0.3))
    assert small == pytest.approx(3.0 * middle, rel=0.01)
    of_all = (planned_value(rows, "sine-0.3", m, "K", "joint-likelihood") for m in (TYPE_A, BOUND))
    assert np.divide(*of_all) >= 1.0
    # without tolerances noise alone asks for perturbations
    assert planned_value(rows, "sine-0.3", NUMBER, "K", "foot") >= planned_value(rows, "sine-0.3", NUMBER)
    assert planned_value(rows, "best, one way", RATIO, "K", "joint-likelihood") < 0.6


@pytest.mark.slow
def test_claims_are_measured_on_the_rows(rows):
    findings = Findings([], {}, "leg-thesis", planned=rows)
    assert MEASURES["planned_small_over_large"](findings) > 4.0
    assert MEASURES["planned_foot_over_leg"](findings) > MEASURES["planned_minjerk_over_sine"](findings) > 1.0
    assert MEASURES["planned_zero_lag_filter"](findings) < 0.1
    assert MEASURES["planned_one_sided_filter"](findings) > 10.0
    with pytest.raises(KeyError):
        MEASURES["planned_small_over_large"](Findings([], {}, "leg-thesis"))


@pytest.mark.slow
def test_the_treadmill_left_in_is_compared_with_the_leg():
    values = {"leg": 10.0, "foot": 2.0, "foot-compensated": 9.0}
    estimates = [
        Estimate("dummy", "sine-0.3", pathway, "windowed-least-squares", "K", "Nm/rad", value)
        for pathway, value in values.items()
    ]
    assert MEASURES["treadmill_left_in"](Findings(estimates, {}, "leg-thesis")) == pytest.approx(8.0)


def chapter(rows, tmp_path):
    PLANNED_ROWS.write(tmp_path / "planned.csv", rows)
    joint = {"inertia_Nms2_per_rad": 0.015, "damping_Nms_per_rad": 0.1, "stiffness_Nm_per_rad": [10.0, 15.0]}
    run = Run({"planned": pd.DataFrame([vars(row) for row in rows])})
    study = {"study": {"planned_joint": joint}, "chapters": {"planning": chapter_content(planning, run)}}
    return chapter_words("planning", study, {"planned": tmp_path / "planned.csv"}, cells=" | ")


@pytest.mark.slow
def test_the_chapter_follows_the_rows(rows, tmp_path):
    words = chapter(rows, tmp_path)
    assert "so no pulse of this kind halves the uncertainty. If" in words and "at most one half." in words
    assert "(not in this run)" not in words
    assert "applied to both torque and motion changes the parameters by less than 0.5 %" in words
    assert "It distorts them most of all if it is one-sided" in words
    of_noise, combined = ratios_of_profiles(words)
    assert of_noise == combined > 1.0  # no tolerances here
    assert "K = 10 N·m/rad" in words
    designs = re.findall(
        r"\| (sine|minimum jerk) \| (0\.\d) \| (leg|foot, compensated|joint likelihood) \|", words
    )
    assert len(designs) == len(planned.DESIGNS)
    assert "| zero-lag, all signals | 0.0 | 0.0 | 0.0 |" in words
    changes = re.search(r"\| zero-lag, torque only \| (\S+) \| (\S+) \| (\S+) \|", words)
    assert changes[3].startswith("\u2212")
    assert re.search(r"one-sided, torque only \| \S+ \| \+\d", words)


def ratios_of_profiles(words):
    """Uncertainty of minimum-jerk pulses over that of sines: from noise alone, and with tolerances."""
    pattern = r"minimum-jerk pulses is (\S+) times that of sines\..*tolerances \(Type B\), is (\S+) times"
    return [float(text) for text in re.search(pattern, words).groups()]


@pytest.mark.slow
def test_tolerances_that_all_profiles_share_bring_their_uncertainties_together(rows, tmp_path):
    shared = [replace(r, value=1.0) if r.measure == planned.TYPE_B else r for r in rows]
    of_noise, combined = ratios_of_profiles(chapter(shared, tmp_path))
    assert of_noise > 1.1 and combined == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
def test_the_chapter_of_other_pulses_tells_the_contrary(rows, tmp_path):
    ratios = {"best, belt returns": 0.4, "best, one way": 0.9}
    words = chapter([replace(r, value=ratios[r.design]) if r.measure == RATIO else r for r in rows], tmp_path)
    assert "of K to the standard uncertainty with the sine is 0.400." in words
    assert "halves" not in words and "one half" not in words  # both are struck through
    assert "At the same peaks, the ratio is then 0.900. All" in words
