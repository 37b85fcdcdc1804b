"""Means over people: by hand, independent of the order, and every person once."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tepsipe.io.estimates import ESTIMATES, Contribution, Estimate, flagged
from tepsipe.reporting.participants import (
    GROUP_ESTIMATES,
    PERSON_ESTIMATES,
    Member,
    group_estimates,
    person_estimates,
)
from tepsipe.statistics.group import group_mean, typical_uncertainty

# 97.5 % quantiles of Student's distribution with 1, 2 and 9 degrees of freedom, from a printed table
T_1, T_2, T_9 = 12.706, 4.303, 2.262


def test_mean_spread_and_interval_of_three_people_are_those_of_a_calculation_by_hand():
    found = group_mean(np.array([10.0, 12.0, 17.0]))
    # deviations -3, -1 and 4: the sum of squares is 26, the variance 13
    assert (found.n, found.mean) == (3, 13.0)
    assert found.sd == pytest.approx(math.sqrt(13.0))
    assert found.sem == pytest.approx(math.sqrt(13.0 / 3.0))
    assert found.high - 13.0 == pytest.approx(T_2 * math.sqrt(13.0 / 3.0), rel=1e-4)
    assert 13.0 - found.low == pytest.approx(found.high - 13.0)


def test_interval_has_students_quantile_of_the_number_of_people():
    two = group_mean(np.array([1.0, 3.0]))
    assert two.high - two.mean == pytest.approx(T_1 * two.sem, rel=1e-4)
    ten = group_mean(np.arange(10.0))
    assert ten.high - ten.mean == pytest.approx(T_9 * ten.sem, rel=1e-3)


def test_one_person_has_a_mean_and_no_spread():
    found = group_mean(np.array([4.0]))
    assert (found.n, found.mean) == (1, 4.0)
    assert (found.sd, found.sem, found.low, found.high) == (None,) * 4


def test_interval_of_the_mean_covers_the_truth_as_often_as_it_says(rng):
    drawn = rng.normal(5.0, 2.0, (2000, 4))
    covered = [found.low <= 5.0 <= found.high for found in map(group_mean, drawn)]
    assert np.mean(covered) == pytest.approx(0.95, abs=0.015)


def test_typical_uncertainty_is_the_root_mean_square():
    assert typical_uncertainty(np.array([3.0, 4.0])) == pytest.approx(math.sqrt(12.5))
    assert typical_uncertainty(np.array([])) is None


# ---- participants ------------------------------------------------------------------------------------

# person -> task -> (K, standard error)
STIFFNESS = {
    "P1": {"relax": (300.0, 30.0), "stiff": (500.0, 40.0)},
    "P2": {"relax": (360.0, 40.0), "stiff": (640.0, 30.0)},
    "P3": {"relax": (330.0, 50.0)},
}
MASSES = {"standing": {"P1": 60.0, "P2": 80.0, "P3": None}}


def estimate(name, value, error, quantity="K", unit="Nm/rad", experiment="standing"):
    ends = (None, None) if error is None else (value - 2.0 * error, value + 2.0 * error)
    return Estimate(experiment, name, "ankle", "window", quantity, unit, value, error, *ends, None, 12)


def member(person, task, name=None, experiment="standing", is_task=True):
    return Member(experiment, name or f"{person}-{task}", person, task, is_task, 4)


@pytest.fixture
def people():
    rows = [estimate(f"{p}-{t}", *value) for p, own in STIFFNESS.items() for t, value in own.items()]
    members = [member(p, t) for p, own in STIFFNESS.items() for t in own]
    return rows, members


def chosen(rows, **wanted):
    return [r for r in rows if all(getattr(r, key) == value for key, value in wanted.items())]


def test_values_of_a_person_are_those_of_the_estimates(people):
    (row,) = chosen(person_estimates(*people, MASSES), participant="P2", condition="stiff", quantity="K")
    assert (row.value, row.standard_error, row.ci_low, row.ci_high) == (640.0, 30.0, 580.0, 700.0)
    assert (row.unit, row.n_trials, row.mass_kg) == ("Nm/rad", 4, 80.0)


def test_values_per_kilogram_have_their_unit_and_exist_only_with_a_mass(people):
    rows = chosen(person_estimates(*people, MASSES), condition="relax", quantity="K_per_kg")
    assert [(r.participant, r.value, r.standard_error) for r in rows] == [("P1", 5.0, 0.5), ("P2", 4.5, 0.5)]
    assert {r.unit for r in rows} == {"Nm/rad/kg"}


def test_difference_between_tasks_is_paired_person_by_person(people):
    found = person_estimates(*people, MASSES)
    rows = chosen(found, condition="stiff minus relax", quantity="K")
    # P3 has one task only
    assert [(r.participant, r.value, r.standard_error) for r in rows] == [
        ("P1", 200.0, 50.0),
        ("P2", 280.0, 50.0),
    ]
    assert rows[0].ci_high == pytest.approx(200.0 + 1.96 * 50.0, abs=0.01)
    (mean,) = chosen(group_estimates(found), condition="stiff minus relax", quantity="K")
    assert (mean.n, mean.mean, mean.u_within) == (2, 240.0, 50.0)
    # deviations -40 and 40: SD = sqrt(3200), SEM = 40
    assert mean.sd == pytest.approx(math.sqrt(3200.0))
    assert mean.ci_high == pytest.approx(240.0 + T_1 * 40.0, rel=1e-4)


def test_spread_between_people_stands_beside_the_uncertainty_within(people):
    (mean,) = chosen(group_estimates(person_estimates(*people, MASSES)), condition="relax", quantity="K")
    assert (mean.n, mean.mean) == (3, 330.0)
    assert mean.sd == pytest.approx(30.0)
    assert mean.u_within == pytest.approx(math.sqrt((900.0 + 1600.0 + 2500.0) / 3.0))


def test_trials_of_one_condition_are_averaged_before_people_are():
    rows = [
        estimate("P1-a", 10.0, 3.0, experiment="position_manipulator"),
        estimate("P1-b", 14.0, 4.0, experiment="position_manipulator"),
        estimate("P2-a", 20.0, 1.0, experiment="position_manipulator"),
    ]
    members = [
        member(name[:2], "relaxed", name, "position_manipulator", False) for name in ("P1-a", "P1-b", "P2-a")
    ]
    found = person_estimates(rows, members, {})
    assert [(r.participant, r.value, r.standard_error, r.n_trials) for r in found] == [
        ("P1", 12.0, 2.5, 8),
        ("P2", 20.0, 1.0, 4),
    ]
    (mean,) = group_estimates(found)
    assert (mean.n, mean.mean) == (2, 16.0)


def test_values_without_error_have_no_interval_and_values_that_are_not_finite_do_not_count(people):
    rows, members = people
    rows = [estimate("P1-relax", 1.0, None), estimate("P2-relax", math.nan, 1.0), *rows[4:]]
    found = chosen(person_estimates(rows, members, MASSES), quantity="K", condition="relax")
    assert [(r.participant, r.standard_error) for r in found] == [("P1", None), ("P3", 50.0)]
    (mean,) = group_estimates(found)
    assert (mean.n, mean.u_within) == (2, None)
    infinite = [estimate("P1-relax", 1.0, math.inf)]
    (alone,) = chosen(person_estimates(infinite, members, {}), quantity="K")
    assert (alone.standard_error, alone.ci_low) == (None, None)


def test_flags_of_estimates_are_those_of_the_person_and_counted_in_the_group(people):
    rows, members = people
    rows = [*flagged(rows[:1], "at-bound"), *rows[1:]]
    found = person_estimates(rows, members, MASSES)
    flags = {(r.participant, r.condition): r.flags for r in chosen(found, quantity="K")}
    assert flags["P1", "relax"] == flags["P1", "stiff minus relax"] == "at-bound"
    assert flags["P1", "stiff"] == flags["P2", "stiff minus relax"] == ""
    (mean,) = chosen(group_estimates(found), condition="relax", quantity="K_per_kg")
    sound = [r for r in found if r.condition == "relax" and r.quantity == "K_per_kg" and not r.flags]
    assert (mean.n, mean.n_flagged) == (1, 1)
    assert mean.mean == sound[0].value
    flagged_all = [replace(r, flags="at-bound") for r in found]
    (none,) = chosen(group_estimates(flagged_all), condition="relax", quantity="K_per_kg")
    assert (none.n, none.mean, none.n_flagged) == (0, None, 2)


def test_rows_of_trials_that_are_no_persons_are_omitted(people):
    rows, members = people
    others = [estimate("P1-relax-1", 1.0, 1.0), estimate("P1-relax", 1.0, 1.0, experiment="dummy")]
    assert person_estimates([*rows, *others], members, MASSES) == person_estimates(rows, members, MASSES)


def test_order_of_the_rows_does_not_change_a_byte(people, tmp_path, rng):
    rows, members = people
    rows = [*rows, *[estimate(r.condition, r.value / 7.0, 1.0, "B", "Nms/rad") for r in rows]]
    tables = []
    for order in (np.arange(len(rows)), rng.permutation(len(rows))):
        found = person_estimates([rows[k] for k in order], [members[k % 5] for k in order if k < 5], MASSES)
        PERSON_ESTIMATES.write(tmp_path / "people.csv", found, without=("belt",))
        GROUP_ESTIMATES.write(tmp_path / "group.csv", group_estimates(found), without=("belt",))
        tables.append([(tmp_path / name).read_bytes() for name in ("people.csv", "group.csv")])
    assert tables[0] == tables[1]


def test_belts_are_separate_and_a_column_only_where_the_sheet_names_them(tmp_path):
    rows = [estimate("P1-left-relax", 1.0, 0.1), estimate("P1-right-relax", 3.0, 0.1)]
    members = [
        Member("standing", f"P1-{belt}-relax", "P1", "relax", True, 1, belt) for belt in ("left", "right")
    ]
    found = person_estimates(rows, members, {})
    assert [(r.belt, r.value) for r in found] == [("left", 1.0), ("right", 3.0)]
    assert [(r.belt, r.mean) for r in group_estimates(found)] == [("left", 1.0), ("right", 3.0)]
    for by_belt in (True, False):
        PERSON_ESTIMATES.write(tmp_path / "people.csv", found, without=() if by_belt else ("belt",))
        header = (tmp_path / "people.csv").read_text().splitlines()[0].split(",")
        assert ("belt" in header) == by_belt
        assert header[0] == "experiment"


def test_labels_follow_the_columns_of_estimates_and_are_not_read(tmp_path):
    rows = [estimate("P1-relax", 1.0, 0.1), estimate("w", 2.0, 0.1)]
    path = tmp_path / "estimates.csv"
    ESTIMATES.write(path, rows, further={"participant": ["P1", ""]})
    lines = path.read_text().splitlines()
    assert lines[0].endswith("n_perturbations,u_type_a,u_type_b,recommended,flags,participant")
    assert lines[1].endswith(",P1")
    assert ESTIMATES.read(path) == [replace(row, u_type_a=row.standard_error) for row in rows]


# ---- Type A and Type B within a person ----------------------------------------------------------------


def with_parts(name, value, type_a, type_b):
    row = estimate(name, value, math.hypot(type_a, type_b))
    return replace(row, u_type_a=type_a, u_type_b=type_b)


def budget(name, **sources):
    where = ("standing", name, "ankle", "window", "K", "Nm/rad")
    return [Contribution(*where, s, "A" if s == "scatter" else "B", u) for s, u in sources.items()]


def test_a_source_common_to_two_tasks_counts_by_its_change_in_their_difference():
    rows = [with_parts("P1-relax", 300.0, 3.0, 30.0), with_parts("P1-stiff", 500.0, 4.0, 50.0)]
    members = [member("P1", "relax"), member("P1", "stiff")]
    parts = budget("P1-relax", scatter=3.0, joint_m=30.0) + budget(
        "P1-stiff", scatter=4.0, joint_m=40.0, skin_m=30.0
    )
    by_source = person_estimates(rows, members, {}, parts)
    (sharp,) = [p for p in by_source if p.condition == "stiff minus relax"]
    assert sharp.standard_error == pytest.approx(math.sqrt(3.0**2 + 4.0**2 + 10.0**2 + 30.0**2))
    # without the sources nothing is known to be common
    (blunt,) = [p for p in person_estimates(rows, members, {}) if p.condition == "stiff minus relax"]
    assert blunt.standard_error == pytest.approx(math.sqrt(3.0**2 + 4.0**2 + 30.0**2 + 50.0**2))
    # a single trial keeps its own interval
    assert {p.standard_error for p in by_source if "minus" not in p.condition} == {
        rows[0].standard_error,
        rows[1].standard_error,
    }


def test_repeated_trials_of_a_person_average_scatter_and_no_source():
    rows = [with_parts(f"P1-{k}", 300.0, 4.0, 3.0) for k in range(4)]
    members = [member("P1", "relax", name=row.condition) for row in rows]
    parts = [part for row in rows for part in budget(row.condition, scatter=4.0, joint_m=3.0)]
    (person,) = person_estimates(rows, members, {"standing": {"P1": None}}, parts)
    assert person.standard_error == pytest.approx(math.hypot(4.0 / 2.0, 3.0))
    assert person.ci_high - person.value == pytest.approx(1.96 * person.standard_error, rel=1e-4)


def test_a_group_mean_has_the_scatter_between_people_whatever_is_common_to_them(tmp_path):
    values = (300.0, 340.0, 320.0)
    rows = [with_parts(f"P{k}-relax", v, 1.0, 50.0) for k, v in enumerate(values)]
    members = [member(f"P{k}", "relax") for k in range(3)]
    people = person_estimates(rows, members, {})
    (group,) = group_estimates(people)
    assert group.sem == pytest.approx(20.0 / math.sqrt(3.0))
    assert group.u_within == pytest.approx(math.hypot(1.0, 50.0))
    PERSON_ESTIMATES.write(tmp_path / "people.csv", people, without=("belt",))
    assert "parts" not in (tmp_path / "people.csv").read_text().splitlines()[0]
