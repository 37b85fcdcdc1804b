"""Figure, numbers and chapter of the participants."""

from dataclasses import replace

import pandas as pd
import pytest
from typst_builders import typeset_words

from tepsipe.reporting.figures import plot_participants
from tepsipe.reporting.participants import GROUP_ESTIMATES, PERSON_ESTIMATES, PersonEstimate, group_estimates
from tepsipe.reporting.run import Run, report_content

CHAPTER = '#include "chapters/participants.typ"\n'
SHOWN = {"standing": ["ankle", "window"], "position_manipulator": ["impedance", "parallel-cascade"]}


def person(who, task, value, mass, experiment="standing", belt="", quantity="K", unit="Nm/rad"):
    error = 0.05 * value
    numbers = (value, error, value - 2.0 * error, value + 2.0 * error, 4, mass)
    return PersonEstimate(experiment, who, task, *SHOWN[experiment], quantity, unit, *numbers, "", belt)


@pytest.fixture
def tables(tmp_path):
    def write(people, by_belt=False):
        PERSON_ESTIMATES.write(tmp_path / "people.csv", people, without=() if by_belt else ("belt",))
        GROUP_ESTIMATES.write(
            tmp_path / "group.csv", group_estimates(people), without=() if by_belt else ("belt",)
        )
        text = {"participant": str, "condition": str}
        return [pd.read_csv(tmp_path / f"{name}.csv", dtype=text) for name in ("people", "group")]

    return write


PEOPLE = [
    person("01", "relax", 300.0, 60.0),
    person("02", "relax", 340.0, 80.0),
    person("01", "relax", 5.0, 60.0, quantity="K_per_kg", unit="Nm/rad/kg"),
    person("01", "stiff", 500.0, 60.0),
    person("01", "stiff minus relax", 200.0, 60.0),
    person("01", "rest", 50.0, None, "position_manipulator"),
]


def content(people, group, shown=SHOWN):
    """Content of report.json, and the tables of the chapter as text."""
    study = {"title": "People", "recordings_source": None, "experiments": {}, "made": {}}
    run = Run({"participants": people, "group": group}, study=study | {"shown_of_participants": shown})
    tables = {name: rows.to_csv(index=False) for name, rows in run.tables.items()}
    return report_content(run, {}), tables


def words(*found, shown=SHOWN):
    """Words of the chapter, with a bar after every cell."""
    return typeset_words(CHAPTER, *content(*found, shown), cells="|")


def test_chapter_tells_the_tables(tables):
    chapter = words(*tables(PEOPLE))
    assert "This study has 2 participants with body masses of 60.0 to 80.0 kg." in chapter
    # 12.706 times 20 on both sides
    assert "relax|K|N·m/rad|2|320|65.9 to 574|28.3|20.0|" in chapter
    means = chapter[chapter.index("relax|K|") :]
    conditions = [part for part in means.split("|") if part in ("relax", "stiff", "stiff minus relax")]
    assert conditions[:4] == ["relax", "relax", "stiff", "stiff minus relax"]
    assert "stiff minus relax|K|N·m/rad|1|200||" in chapter
    assert "relax|01|60.0|300 ± 15||5.00 ± 0.25|||" in chapter
    assert "rest|01||50.0 ± 2.5|" in chapter


def test_value_of_a_person_that_failed_a_check_is_marked_and_in_no_mean(tables):
    flagged = replace(person("03", "relax", 900.0, 70.0), flags="few-perturbations")
    chapter = words(*tables([*PEOPLE, flagged]))
    assert "relax|03|70.0|900 ± 45†|" in chapter
    assert "† A check failed." in chapter and "†" not in words(*tables(PEOPLE))
    assert "relax|K|N·m/rad|2|320|" in chapter


def test_figure_has_a_dot_for_every_person_and_the_mean_beside_them(tables):
    figure = plot_participants(*tables(PEOPLE), SHOWN)
    axis = figure.axes[0]
    dots = [line for line in axis.lines if line.get_marker() == "o"]
    assert [list(line.get_ydata()) for line in dots] == [[300.0, 500.0], [340.0]]
    assert [label.get_text() for label in axis.get_xticklabels()] == ["relax", "stiff"]
    means = [line for line in axis.lines if line.get_marker() == "s"]
    assert [float(line.get_ydata()[0]) for line in means] == [320.0, 500.0]
    # K and K per kilogram, of two experiments
    assert len(figure.axes) == 4


def test_belts_are_separate_in_figure_and_chapter(tables):
    people = [
        person("01", "relax", value, 60.0, belt=belt) for belt, value in (("left", 1.0), ("right", 3.0))
    ]
    found = tables(people, by_belt=True)
    chapter = words(*found, shown={"standing": SHOWN["standing"]})
    assert chapter.index("relax, left|K|") < chapter.index("relax, right|K|")
    axis = plot_participants(*found, {"standing": SHOWN["standing"]}).axes[0]
    assert [label.get_text() for label in axis.get_xticklabels()] == ["relax\nleft", "relax\nright"]
