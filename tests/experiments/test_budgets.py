"""Budgets in rows of estimates, the table of their sources, and the section of the configuration."""

import math
from dataclasses import replace

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import contributions_of, cross_validation_rows, rows_of
from tepsipe.identification.result import Quantity, quantities_of
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES, Contribution, Estimate, recommended
from tepsipe.statistics.uncertainty import Budget, sources_of
from workflow.settings.config import check_config

NAMES = ("dummy", "sine-0.3", "leg", "windowed-least-squares")
ROWS = [
    Estimate(*NAMES, "B", "Nms/rad", 0.1),
    Estimate(*NAMES, "K", "Nm/rad", 10.0),
    Estimate(*NAMES, "VAF_trial", "%", 99.0),
]
BUDGET = Budget(
    np.array([0.03, 0.003]),
    4.0,
    {"leg_mass_kg": np.array([[-0.2, 0.002]]), "offset_m": np.array([[0.1, 0.0], [-0.1, 0.001]])},
)


def test_rows_hold_the_combined_interval_and_its_parts():
    stiffness, damping = rows_of(NAMES, quantities_of({"K": 10.0, "B": 0.1}, BUDGET))
    assert (stiffness.unit, damping.unit) == ("Nm/rad", "Nms/rad")
    type_b = math.sqrt(0.2**2 + 0.1**2 + 0.1**2)
    assert stiffness.u_type_a == 0.03 and stiffness.u_type_b == pytest.approx(type_b)
    assert stiffness.standard_error == pytest.approx(math.hypot(0.03, type_b))
    # scatter is a small part of K, so its 4 degrees of freedom hardly count
    assert stiffness.ci_high - 10.0 == pytest.approx(1.96 * stiffness.standard_error, rel=1e-3)
    assert 10.0 - stiffness.ci_low == pytest.approx(stiffness.ci_high - 10.0)
    # and most of B: (5/3)^4 4 / ... by Welch and Satterthwaite
    combined = math.sqrt(0.003**2 + 0.002**2 + 0.001**2)
    assert damping.standard_error == pytest.approx(combined)
    freedom = combined**4 / (0.003**4 / 4.0)
    assert 9.0 < freedom < 10.0
    assert 2.2 < (damping.ci_high - 0.1) / combined < 2.3


def test_a_lost_uncertainty_is_told_from_one_that_there_never_was():
    stiffness = Quantity(10.0, "N·m/rad", as_printed=0.2, flags=("assumed", "at-bound"))
    lost = Quantity.drawn(0.1, "N·m·s/rad", np.array([]), 0.95)
    never, lost = rows_of(NAMES, {"K": stiffness, "B": lost}, 7)
    assert (never.standard_error, never.ci_low, never.u_type_a) == (None, None, None)
    assert (never.sem_as_printed, never.n_perturbations, never.flags) == (0.2, 7, "assumed;at-bound")
    assert np.isnan([lost.standard_error, lost.ci_low, lost.ci_high, lost.u_type_a]).all()


def test_without_sources_type_b_is_not_evaluated_and_the_interval_is_students():
    (row,) = rows_of(NAMES, quantities_of({"K": 10.0}, Budget(np.array([0.5]), 13.0)))
    assert row.u_type_b is None
    assert row.ci_high - 10.0 == pytest.approx(2.1604 * 0.5, rel=1e-4)


def test_every_source_has_a_row_and_the_rows_add_up(tmp_path):
    joined = quantities_of({"K": 10.0, "B": 0.1}, BUDGET)
    rows = contributions_of(NAMES, {"VAF_trial": Quantity(99.0, "%"), "B": joined["B"], "K": joined["K"]})
    assert len(rows) == 6 and rows[0].unit == "Nms/rad"
    assert [(r.quantity, r.source, r.type) for r in rows[:3]] == [
        ("B", "scatter", "A"),
        ("B", "leg_mass_kg", "B"),
        ("B", "offset_m", "B"),
    ]
    for quantity in joined:
        total = math.sqrt(sum(row.u**2 for row in rows if row.quantity == quantity))
        assert total == pytest.approx(joined[quantity].standard_error)
    CONTRIBUTIONS.write(tmp_path / "budget.csv", rows)
    again = CONTRIBUTIONS.read(tmp_path / "budget.csv")
    assert [replace(r, u=0.0) for r in again] == [replace(r, u=0.0) for r in rows]
    assert [r.u for r in again] == pytest.approx([r.u for r in rows], rel=1e-9)
    single = Budget(np.array([np.inf, np.inf]), 1.0, BUDGET.contributions)
    one = contributions_of(NAMES, quantities_of({"K": 10.0, "B": 0.1}, single))
    assert {row.source for row in one} == set(BUDGET.contributions)


def test_cross_validation_is_the_mean_over_the_other_trials():
    names = [("dummy", condition, "leg", "windowed-least-squares") for condition in "abc"]
    vafs = np.array([[99.0, 80.0, 60.0], [70.0, 98.0, 50.0], [40.0, 20.0, 97.0]])
    rows = cross_validation_rows(names, vafs)
    assert [(row.condition, row.quantity, row.unit, row.value) for row in rows] == [
        ("a", "VAF_cross_validated", "%", 70.0),
        ("b", "VAF_cross_validated", "%", 60.0),
        ("c", "VAF_cross_validated", "%", 30.0),
    ]
    assert cross_validation_rows(names[:1], vafs[:1, :1]) == []


@pytest.mark.parametrize(("u", "kind"), [("-1", "B"), ("nan", "B"), ("1", "C")])
def test_a_damaged_budget_is_refused_in_one_sentence(tmp_path, u, kind):
    path = tmp_path / "budget.csv"
    CONTRIBUTIONS.write(path, [Contribution("a", "b", "c", "d", "K", "Nm/rad", "mass", "B", 1.0)])
    path.write_text(path.read_text().replace("mass,B,1", f"mass,{kind},{u}"))
    with pytest.raises(InputError) as error:
        CONTRIBUTIONS.read(path)
    assert_one_sentence(error.value, "budget.csv")


def test_marks_follow_pathway_estimator_and_quantity(tmp_path):
    other = Estimate("dummy", "sine-0.3", "leg-thesis", "windowed-least-squares", "K", "Nm/rad", 6.0)
    marked = recommended([*ROWS, other], "leg")
    assert [row.recommended for row in marked] == [True, True, False, False]
    assert not any(row.recommended for row in recommended(marked, "leg", "output-error"))
    ESTIMATES.write(tmp_path / "estimates.csv", marked)
    assert [row.recommended for row in ESTIMATES.read(tmp_path / "estimates.csv")] == [
        True,
        True,
        False,
        False,
    ]


def test_settings_become_sources_and_null_switches_off():
    stated = {"standard_uncertainty": 0.01, "distribution": "rectangular", "source": "weighed"}
    found = sources_of({"mass_kg": stated, "com_m": None, "scale": stated | {"freedom": 5}})
    assert list(found) == ["mass_kg", "scale"]
    assert found["mass_kg"].freedom == math.inf and found["scale"].freedom == 5
    assert found["mass_kg"].source == "weighed"
    for wrong, word in (({"standard_uncertainty": -0.01}, "-0.01"), ({"distribution": "flat"}, "'flat'")):
        with pytest.raises(InputError) as error:
            sources_of({"mass_kg": stated | wrong})
        assert_one_sentence(error.value, "mass_kg", word)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"leg_mas_kg": None}, ["uncertainty.dummy.leg_mas_kg", "leg_mass_kg", "log_delay_s"]),
        ({"belt_force_ratio": None}, ["uncertainty.dummy.belt_force_ratio", "leg_mass_kg", "log_delay_s"]),
        ({"leg_mass_kg": 0.01}, ["uncertainty.dummy.leg_mass_kg", "object or null"]),
        (
            {"leg_mass_kg": {"standard_uncertainty": -1.0, "distribution": "normal", "source": "x"}},
            ["at least 0", "-1.0"],
        ),
        (
            {"leg_mass_kg": {"standard_uncertainty": 1.0, "distribution": "flat", "source": "x"}},
            ["'normal', 'rectangular', 'triangular'", "'flat'"],
        ),
        ({"leg_mass_kg": {"standard_uncertainty": 1.0, "distribution": "normal"}}, ["source"]),
    ],
)
def test_a_wrong_source_stops_the_run_with_one_sentence(config, root, changes, words):
    config["uncertainty"]["dummy"] |= changes
    with pytest.raises(InputError) as error:
        check_config(config, "my-study/config.yaml")
    text = str(error.value)
    assert text.startswith("my-study/config.yaml: ") and "\n" not in text
    for word in words:
        assert word in text


def test_a_source_that_is_switched_off_is_accepted(config, root):
    config["uncertainty"]["dummy"]["leg_mass_kg"] = None
    check_config(config, "configuration")
    assert "leg_mass_kg" not in sources_of(config["uncertainty"]["dummy"])


def test_every_shipped_source_gives_a_reason_and_is_documented(config, root):
    text = (root / "config/README.md").read_text(encoding="utf-8")
    for experiment, section in config["uncertainty"].items():
        for name, source in sources_of(section).items():
            assert source.standard_uncertainty > 0.0 and source.source
            assert f"`{experiment}.{name}`" in text
