"""Figure, numbers and chapter of the participants."""

import json
import shutil

import pandas as pd
import pytest

from tepsipe.reporting.figures.participants import plot_participants
from tepsipe.reporting.figures.style import save_figure
from tepsipe.reporting.numbers.abstract import abstract_of
from tepsipe.reporting.numbers.participants import participants_data
from tepsipe.reporting.participants import GROUP_ESTIMATES, PERSON_ESTIMATES, PersonEstimate, group_estimates

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


def test_numbers_of_the_chapter_are_those_of_the_tables(tables):
    data = participants_data(*tables(PEOPLE), SHOWN)
    assert (data["count"], data["masses"], data["belts"]) == ("2", "60.0 to 80.0", False)
    standing, manipulator = data["experiments"]
    first = standing["means"][0]
    assert (first["condition"], first["quantity"], first["n"], first["mean"]) == ("relax", "K", "2", "320")
    assert (first["unit"], first["sd"], first["sem"]) == ("N·m/rad", "28.3", "20.0")
    # 12.706 times 20 on both sides
    assert first["interval"] == "65.9 to 574"
    assert [row["condition"] for row in standing["means"]] == [
        "relax",
        "relax",
        "stiff",
        "stiff minus relax",
    ]
    assert standing["means"][-1]["interval"] == ""
    assert standing["persons"][0]["cells"][0] == "300 ± 15"
    assert standing["persons"][0]["cells"][2] == "5.00 ± 0.25"
    assert manipulator["persons"][0]["mass"] == "\N{EN DASH}"


def test_first_page_tells_the_means_over_people(tables):
    data = {
        "experiments": [],
        "claims": None,
        "cells": None,
        "participants": participants_data(*tables(PEOPLE), SHOWN),
    }
    ((paragraph,),) = abstract_of(data).values()
    text = "".join(piece for _, piece in paragraph)
    assert (
        "standing, as mean over participants, is 320 N·m/rad (relax, n = 2, 95 % interval 65.9 to 574)"
        in text
    )
    assert "200 N·m/rad (stiff minus relax, n = 1)" in text
    assert ["ref", "participants"] in paragraph


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
    data = participants_data(*found, {"standing": SHOWN["standing"]})
    assert [row["condition"] for row in data["experiments"][0]["means"]] == ["relax, left", "relax, right"]
    axis = plot_participants(*found, {"standing": SHOWN["standing"]}).axes[0]
    assert [label.get_text() for label in axis.get_xticklabels()] == ["relax\nleft", "relax\nright"]


@pytest.mark.slow
def test_chapter_is_typeset(tables, tmp_path, root):
    typst = pytest.importorskip("typst")
    found = tables(PEOPLE)
    shutil.copytree(root / "report", tmp_path / "report")
    (tmp_path / "report/figures").mkdir()
    figure = tmp_path / "report/figures/figure_participants.svg"
    save_figure(plot_participants(*found, SHOWN), figure, tmp_path / "figure.png")
    data = {"title": "People", "trials": 9, "participants": participants_data(*found, SHOWN)}
    (tmp_path / "report/report.json").write_text(json.dumps(data))
    source = '#import "style.typ": style\n#show: style\n#include "chapters/participants.typ"\n'
    (tmp_path / "report/main.typ").write_text(source)
    pdf = typst.compile(str(tmp_path / "report/main.typ"), ignore_system_fonts=True)
    assert pdf.startswith(b"%PDF")
    assert len(pdf) > 10_000
