"""Conditions and numbers of the chapter on a recorded treadmill, and the sentences that they choose."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from typst_builders import evaluated, findings_of, typeset_words

from tepsipe.reporting.chapters import belt
from tepsipe.reporting.run import Run, report_content

INGESTED = {
    "recorded_rate_hz": 100.0,
    "clock": "kept",
    "largest_stamp_deviation_s": 0.0,
    "repeated_stamps": 0,
    "repeated_velocity_fraction": 0.0,
    "missing_samples": 0,
}
COLUMNS = ("model", "r2", "order", "converged")
CHAPTER = '#include "chapters/belt.typ"\n#bibliography("references.bib", style: "ieee")\n'


def run_of(*models, orders=(1.0,), chosen=None, **facts):
    """Run of one held-out recording; ``models`` are name, R², order and whether it converged."""
    scores = pd.DataFrame([dict(zip(COLUMNS, model, strict=True)) for model in models])
    scores = pd.concat([scores.assign(cutoff_hz=hz) for hz in (6.0, 20.0)]).assign(
        train="one", test="two", rms_before=10.0, rms_after=5.5, r2_limit=0.75, load="load", unit="N"
    )
    told = {"calibrated": {"velocity": [0.9, 1.5], "acceleration": [-3.0, 3.0]}, "beyond": {"two": 0.01}}
    told |= {"coefficients": {}, "crossed": {}, "unit": "N", "ingested": {"two": INGESTED}} | facts
    told |= {"recordings": ["two"], "models": [model[0] for model in models]}
    fit = SimpleNamespace(facts=told, arrays={"ripple/tracked_orders": np.array(orders)})
    models_of = {"ripple": {"memory_s": 20.0}, "fir_lead_s": 0.1}
    settings = {"analysis": {"shown_cutoff_hz": 6}, "models": models_of, "chosen": chosen}
    study = {"title": "t", "recordings_source": None, "experiments": {"belt": ["two"]}, "made": {}}
    study |= {"models": {"belt": "belt"}, "roles": {"two": "validate"}}
    return Run({"belt": scores}, {"belt": {"belt": fit}}, {"belt": settings}, study)


def content(run):
    tables = {"belt": run.tables["belt"].replace({True: "true", False: "false"}).to_csv(index=False)}
    return report_content(run, {"belt": belt}), tables


def scores(*values):
    orders = {"fir-causal": 40, "fir": 51, "ripple-tracking": 12}
    return [(name, r2, order, True) for (name, order), r2 in zip(orders.items(), values, strict=True)]


def usual():
    return run_of(
        *scores(0.5, 0.7, 0.8),
        orders=(1.0, 2.0),
        chosen="fir",
        coefficients={"mass-spring-damper": {"m": [2.8, 2.68, 2.92]}},
        crossed={"fir": {"one": {"one": 0.8, "two": 0.7}}},
    )


def contrary():
    return run_of(*scores(-3.0, -3.001, -5.0))


USUAL = (
    "The best linear model of the acceleration reaches",
    "shows how well a calibration transfers from one recording to another",
    "2.80 (2.68 to 2.92)",
    "Looking 100 ms ahead increases",
    "contains narrow lines",
)
CONTRARY = (
    "No linear model of the acceleration predicts the load better than its mean",
    "no more than the best model without it",
    "contains a narrow line",
)


@pytest.mark.parametrize("run", [usual, contrary])
def test_chapter_tells_what_its_data_show_and_nothing_else(run):
    words = typeset_words(CHAPTER, *content(run()))
    for sentences, expected in ((USUAL, usual), (CONTRARY, contrary)):
        for sentence in sentences:
            assert (sentence in words) is (run is expected), sentence


def recommended(*models):
    found = belt.numbers(run_of(*models))
    return [found["recommended"], found["recommended_live"]]


def test_smallest_of_equally_good_models_is_recommended_and_none_that_predicts_nothing():
    assert recommended(("fir", 0.727, 51, True), ("hnat2014", 0.721, 2, True)) == ["fir", "hnat2014"]
    assert recommended(("fir", 0.727, 51, True), ("hnat2014", 0.724, 2, True)) == ["hnat2014"] * 2
    assert recommended(("ripple-tracking", 0.9, 12, True), ("hnat2014", 0.7, 2, False)) == [None, None]
    assert recommended(("fir", -0.3, 51, True)) == [None, None]


@pytest.mark.parametrize(
    ("models", "told", "untold"),
    [
        (
            [("fir", 0.727, 51, True), ("hnat2014", 0.721, 2, True)],
            "In real time, where no model can look ahead, “Hnat (2014)”",
            "It does not look ahead",
        ),
        (
            [("arx", 0.727, 9, True), ("hnat2014", 0.7225, 2, True), ("fir", 0.731, 51, True)],
            "also works in real time. The smaller model “Hnat (2014)”",
            "In real time,",
        ),
        ([("fir", -0.3, 51, True)], "predicts the load of a held-out recording. The upper limit", "Subtract"),
    ],
)
def test_first_page_recommends_what_predicts(models, told, untold):
    (paragraph,) = evaluated(['told("abstract_belt").map(plain)'], "findings.typ", *content(run_of(*models)))
    text = " ".join(" ".join(paragraph).split())
    assert told in text
    assert untold not in text
    assert text.endswith("velocities of 0.900 to 1.50 m/s and accelerations of −3.00 to 3.00 m/s².")


@pytest.mark.parametrize(("orders", "none"), [((), True), ((1.6, 6.3), False)])
def test_captions_tell_the_lines_and_the_chosen_model(orders, none):
    figures = [f"figure_belt_{name}" for name in ("prediction", "cutoff", "ripple")]
    models = [("hnat2014", 0.0, 2, True), ("fir", 0.7, 51, True), ("ripple-tracking", 0.77, 12, True)]
    found = findings_of(figures, *content(run_of(*models, orders=orders, chosen="fir")))
    assert found["figure_belt_prediction"] == (
        "At 6 Hz the model impulse response predicts the load with R² = 0.700 and reduces its root mean "
        "square by 45.0 %."
    )
    assert found["figure_belt_cutoff"].endswith("R² = 0.700 at 6 Hz; the upper limit is 0.750.")
    assert ("no narrow line" in found["figure_belt_ripple"]) is none
    untracked = findings_of(figures, *content(run_of(*models[:2])))
    assert set(untracked) == {"figure_belt_cutoff"}


def test_what_was_not_fitted_is_not_told():
    run = run_of(("ripple-tracking", 0.5, 12, True), chosen="fir")
    assert not any((belt.chosen(run), belt.linear(run), belt.linear_predicts(run), belt.lead_helps(run)))
    assert not belt.tracking_useless(run)
    assert not belt.tracked(run_of(("fir", 0.5, 51, True)))
