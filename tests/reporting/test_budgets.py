"""What the report says of budgets: sentences and bars chosen by the numbers."""

import math
from dataclasses import asdict, replace

import numpy as np
import pandas as pd
import pytest
from typst_builders import chapter_words, findings_of

from tepsipe.io.estimates import Contribution, Estimate
from tepsipe.reporting.budgets import budgeted, relative_budgets, source_words
from tepsipe.reporting.chapters import budgets
from tepsipe.reporting.chapters.budgets import largest_source
from tepsipe.reporting.figures import bars_of, plot_budgets
from tepsipe.reporting.run import Run, report_content

NAMES = ("dummy", "leg", "windowed-least-squares")


def estimates(values=(10.0, 5.0), recommended=True):
    return [
        Estimate(
            NAMES[0], c, *NAMES[1:], "K", "Nm/rad", v, 0.2, v - 0.4, v + 0.4, u_type_a=0.1,
            recommended=recommended,
        )
        for c, v in zip(("a", "b"), values, strict=True)
    ]  # fmt: skip


def parts(scatter, mass, clock=0.0001):
    sources = (("scatter", "A", scatter), ("leg_mass_kg", "B", mass), ("clock_ratio", "B", clock))
    return [
        Contribution(NAMES[0], c, *NAMES[1:], "K", "Nm/rad", *source)
        for c in ("a", "b")
        for source in sources
    ]


def run_of(contributions, estimates, foot_pathway):
    tables = {
        "uncertainty": pd.DataFrame([asdict(row) for row in contributions]),
        "estimates": pd.DataFrame([asdict(row) for row in estimates]),
    }
    study = {"foot_pathway": foot_pathway, "title": "t", "recordings_source": None, "experiments": {}}
    return Run(tables, study=study | {"made": {}})


def test_budgets_are_relative_to_the_estimate_of_each_trial():
    budget = relative_budgets(parts(0.1, 0.3), estimates())["K"]
    assert budget.percent["leg_mass_kg"].tolist() == [3.0, 6.0]
    assert budget.type_a.tolist() == [1.0, 2.0]
    assert budget.combined == pytest.approx([math.hypot(1.0, 3.0), math.hypot(2.0, 6.0)], rel=1e-6)
    assert budget.by_size == ["leg_mass_kg", "scatter", "clock_ratio"]
    assert budget.expanded(math.inf) == pytest.approx(1.96 * 4.5, rel=1e-3)
    # the median of what is left in each trial, not what the medians of both types leave
    of_trials = {"scatter": np.array([3.0, 0.0, 4.0]), "clock": np.array([0.0, 5.0, 3.0])}
    apart = replace(budget, conditions=["a", "b", "c"], percent=of_trials)
    assert apart.expanded(1.0) == pytest.approx(1.96 * 5.0, rel=1e-3)
    assert apart.expanded(4.0) == pytest.approx(1.96 * math.hypot(2.0, 3.0), rel=1e-3)


def test_what_may_be_zero_has_no_relative_budget():
    inertia = [Estimate(*NAMES[:1], "a", *NAMES[1:], "I", "Nms2/rad", 0.001)]
    rows = [Contribution(NAMES[0], "a", *NAMES[1:], "I", "Nms2/rad", "scatter", "A", 0.001)]
    assert relative_budgets(rows, inertia) == {}
    assert relative_budgets(parts(0.1, 0.3), estimates((0.0, math.nan))) == {}
    # 0.3 ± 0.4 includes 0
    assert relative_budgets(parts(0.1, 0.3), estimates((10.0, 0.3)))["K"].conditions == ["a"]


@pytest.mark.parametrize(
    ("scatter", "mass", "largest", "repeating"),
    [(0.1, 0.3, "mass of the leg", False), (0.3, 0.1, "scatter of the data", True)],
)
def test_the_sentence_on_the_largest_source_follows_the_numbers(scatter, mass, largest, repeating):
    told = largest_source(relative_budgets(parts(scatter, mass), estimates((10.0, 10.0)))["K"])
    assert (told["largest"], told["repeating"]) == (largest, repeating)
    assert told["now_percent"] == pytest.approx(1.96 * math.hypot(1.0, 3.0), rel=1e-3)
    after = math.hypot(1.5, 1.0) if repeating else 3.0
    assert told["after_percent"] == pytest.approx(1.96 * after, rel=1e-3)


def test_budgets_of_the_report_are_those_of_recommended_estimates_and_of_the_foot():
    quoted = estimates()
    foot = [
        Estimate(
            "dummy", "a", "foot-compensated", "windowed-least-squares", "K", "Nm/rad", 9.0, 1.0, 7.0, 11.0
        )
    ]
    others = estimates(recommended=False)
    assert list(budgeted([*others, *foot], None)) == []
    assert budgeted([*quoted, *foot], "foot-compensated") == {"dummy": quoted, "foot": foot}
    run = run_of(parts(0.1, 0.3), [*quoted, *foot], "foot-compensated")
    found = budgets.numbers(run)
    assert list(found) == ["dummy"]  # the foot has no budget here
    (quantity,) = found["dummy"]["quantities"]
    assert quantity["type_b_percent"] == pytest.approx([3.0, 6.0], rel=1e-3)
    assert quantity["type_a_percent"] == pytest.approx([1.0, 2.0])
    assert quantity["half_width_percent"] == pytest.approx([4.0, 8.0])
    assert (quantity["kept"], quantity["all"]) == (2, 2)
    # 0.3 ± 0.4 includes 0
    fewer = budgets.numbers(run_of(parts(0.1, 0.3), estimates((10.0, 0.3)), None))["dummy"]
    assert [(q["kept"], q["all"]) for q in fewer["quantities"]] == [(1, 2)]
    assert found["dummy"]["sources"] == ["scatter", "leg_mass_kg", "clock_ratio"]
    none = run_of([], quoted, None)
    assert budgets.numbers(none) == {}


@pytest.mark.parametrize(("scatter", "repeating"), [(0.1, False), (0.5, True)])
def test_the_table_and_the_caption_tell_the_budget(scatter, repeating):
    run = run_of(parts(scatter, 0.3), estimates((10.0, 10.0)), None)
    content = report_content(run, {"budgets": budgets}) | {"made": 0}
    words = chapter_words("budgets", content, cells="|")
    told = "scatter of the data (5.0)|11.4|7.65|" if repeating else "mass of the leg (3.0)|6.20|5.88 *|"
    type_a = "5.0" if repeating else "1.0"
    assert f"|Dummy: leg, windowed least squares|K|2|4.0|{type_a}|3.0|{told}" in words
    told = findings_of(["figure_budget_dummy", "figure_budget_weight"], content)
    largest = "scatter of the data (5.0 %)" if repeating else "mass of the leg (3.0 %)"
    caption = f"In the median, the largest source of uncertainty of K is the {largest}."
    assert told == {"figure_budget_dummy": caption}


def test_small_sources_are_one_bar_and_type_a_is_apart():
    rows = parts(0.1, 0.3) + [
        Contribution(NAMES[0], c, *NAMES[1:], "K", "Nm/rad", "vertical_rad", "B", 0.0002) for c in ("a", "b")
    ]
    budget = relative_budgets(rows, estimates((10.0, 10.0)))["K"]
    bars = bars_of(budget)
    assert [(label, kind) for label, kind, _ in bars] == [
        ("combined", "combined"),
        ("scatter of the data", "A"),
        ("mass of the leg", "B"),
        ("2 further sources", "B"),
    ]
    assert bars[-1][2] == pytest.approx([math.hypot(0.001, 0.002)] * 2)
    figure = plot_budgets({"K": budget})
    widths = [patch.get_width() for patch in figure.axes[0].patches[:4]]
    assert widths == pytest.approx([float(np.median(p)) for _, _, p in bars])


def test_a_source_without_a_name_in_words_is_readable():
    assert source_words("skin_wobble_m") == "skin wobble"
    assert source_words("leg_mass_kg") == "mass of the leg"


def test_figure_without_a_recommended_estimate_says_so():
    (axis,) = plot_budgets({}).axes
    assert axis.texts[0].get_text() == "No estimate is recommended: no budget."
