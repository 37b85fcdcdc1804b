"""Numbers and tables of the chapter on a recorded treadmill."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from typst_builders import typeset_words

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


def test_chapter_lists_models_coefficients_and_lines():
    words = typeset_words(CHAPTER, *content(usual()), cells="|")
    assert (
        "impulse response|finite impulse response with a short look-ahead|51|0.700|5.500|45.0|0.700|" in words
    )
    assert "2.80 (2.68 to 2.92)" in words and "Cross-prediction at 6 Hz" in words
    assert "significant lines at 1.000, 2.000 cycles per metre" in words
    plain = run_of(*scores(-3.0, -3.001, -5.0), orders=())
    words = typeset_words(CHAPTER, *content(plain), cells="|")
    assert "Cross-prediction" not in words and "significant lines" not in words
    assert "An asterisk" not in words
    stopped = typeset_words(CHAPTER, *content(run_of(("fir", 0.7, 51, False))), cells="|")
    assert "impulse response *|" in stopped and "An asterisk marks an optimisation" in stopped


def recommended(*models):
    return belt.numbers(run_of(*models))["recommended"]


def test_smallest_of_equally_good_models_is_recommended_and_none_that_predicts_nothing():
    assert recommended(("fir", 0.727, 51, True), ("hnat2014", 0.721, 2, True)) == "fir"
    assert recommended(("fir", 0.727, 51, True), ("hnat2014", 0.724, 2, True)) == "hnat2014"
    assert recommended(("ripple-tracking", 0.9, 12, True), ("hnat2014", 0.7, 2, False)) is None
    assert recommended(("fir", -0.3, 51, True)) is None


@pytest.mark.parametrize(
    ("r2", "told"),
    [
        (
            0.727,
            "impulse response predicts the belt-induced load of the held-out recording two with R2 = 0.727",
        ),
        (-0.3, "so the belt-induced load cannot be compensated"),
    ],
)
def test_first_page_recommends_what_predicts(r2, told):
    source = '#import "study_values.typ": belt-answer\n#belt-answer'
    assert told in typeset_words(source, *content(run_of(("fir", r2, 51, True))))
