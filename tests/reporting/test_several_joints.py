"""Tables, figure and section on several joints: no number where none is known, sentences follow tables."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from typst_builders import evaluated, typeset_words

from tepsipe.errors import InputError
from tepsipe.experiments.planning.figures import plot_several_joints
from tepsipe.experiments.planning.several_joints import MODELS, epochs_of, estimate, predict, read_draws
from tepsipe.io.tables import write_records
from tepsipe.reporting.chapters import several_joints
from tepsipe.reporting.run import Run, report_content
from tepsipe.reporting.several_joints import element_rows, model_rows, movement, set_rows
from tepsipe.virtual_lab.standing_chain import write_chain_trials
from tests.identification.test_several_joints import (
    CHAIN,
    LIMITS,
    MATRICES,
    PERSON,
    POINTS,
    PROTOCOL,
    PULSES,
    THREE,
    predictions,
    recorded,
)

NAMES = ("several_joints", "several_joints_elements", "several_joints_models")
SETS = [("belt",), ("thigh", "pelvis"), THREE]
SETTINGS = {
    "protocol": {"after_s": 0.25, "epochs": 40},
    "limits": {"stiffness_percent": 15.0, "damping_percent": 50.0},
    "persons": 2,
    "inertia_percent": 3.0,
}
COLUMNS = [
    *("perturbations", "number", "rank", "unknowns", "condition", "identified"),
    *("k_rms_percent", "coverage_percent", "statement"),
]


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder, epochs = tmp_path_factory.mktemp("tables"), epochs_of(recorded(), CHAIN, POINTS)
    chosen = [predictions()[one] for one in SETS]
    drawn = {one: 2 * [estimate(epochs, one, LIMITS)] for one in SETS}
    cases = {
        window: [
            predict(epochs_of(recorded(), CHAIN, POINTS, model, window_s=window), SETS, MATRICES, LIMITS)
            for model in models
        ]
        for window, models in ((0.25, MODELS), (0.15, MODELS[:1]))
    }
    rows = {
        "sets": set_rows(chosen, drawn, MATRICES, LIMITS),
        "elements": element_rows(chosen, drawn, MATRICES, epochs),
        "models": model_rows(cases, MATRICES[0], LIMITS),
    }
    for name, own in rows.items():
        write_records(folder / f"{name}.csv", own)
    return [pd.read_csv(folder / f"{name}.csv") for name in rows]


@pytest.mark.slow
def test_table_has_the_columns_that_others_read_and_no_number_for_what_is_refused(tables):
    sets, elements, _ = tables
    assert list(sets.columns[: len(COLUMNS)]) == COLUMNS
    assert list(sets.perturbations) == ["belt", "thigh+pelvis", "belt+thigh+pelvis"]
    assert list(sets.number) == [1, 2, 3] and list(sets.unknowns) == [24] * 3
    refused = sets[~sets.identified]
    assert len(refused) == 2 and refused.k_rms_percent.isna().all() and refused.coverage_percent.isna().all()
    assert refused.statement.str.startswith("No values").all()
    best = sets[sets.identified].iloc[0]
    assert best["rank"] == 24 and 0.0 < best.k_rms_percent < 15.0 and best.coverage_percent > 60.0
    own = elements[elements.perturbations == "belt"]
    assert len(own) == 18 and own.monte_carlo_u_percent.isna().all() and own.errors_percent.isna().all()


def test_movements_are_ratios_of_angles():
    stiffness = np.diag([4.0, 1.0, 0.25])
    assert movement(np.array([1.0, 1.0, 1.0]), stiffness) == pytest.approx([0.25, 0.5, 1.0])
    assert movement(np.array([0.0, -1.0, 0.0]), stiffness) == pytest.approx([0.0, 1.0, 0.0])


def test_shorter_windows_and_unknown_inertia_identify_less(tables):
    _, _, models = tables
    best = models[(models.perturbations == "belt+thigh+pelvis") & (models.matrices == "any")]
    within = best[best.inertia == "within tolerance"].set_index("window_s").k_half_width_percent
    assert within[0.15] > 2.0 * within[0.25]
    at_once = best[best.window_s == 0.25].set_index("inertia").k_half_width_percent
    assert at_once["exact"] < at_once["within tolerance"] < at_once["unknown"]
    open_ = models[(models.perturbations == "belt") & (models.inertia == "unknown")]
    assert open_.statement.str.contains("The scale remains unknown").all()


def content(tables):
    """Content of report.json, and the tables as text."""
    named = dict(zip(NAMES, tables, strict=True))
    study = {"title": "Plan", "recordings_source": None, "experiments": {}, "made": {}}
    run = Run(named, settings={"plan": {"several_joints": SETTINGS}}, study=study)
    texts = {
        name: own.replace({True: "true", False: "false"}).to_csv(index=False) for name, own in named.items()
    }
    return report_content(run, {"several_joints": several_joints}), texts


def findings_of(*tables):
    (found,) = evaluated(["holding(findings).map(plain)"], "several_joints.typ", *content(tables))
    return " ".join(" ".join(found).split())


def test_findings_follow_the_numbers(tables):
    sets, elements, models = tables
    said = findings_of(*tables)
    assert "have 24 unknowns. They need 3 independent perturbations:" in said
    assert "The 2 other sets yield no values" in said and "The belt alone yields no values" in said
    assert "with 150 ms, no set identifies them" in said
    none = sets.assign(identified=False, k_rms_percent=np.nan, quoted_percent=0.0)
    said = findings_of(none, elements, models)
    assert "No set of perturbations identifies" in said and "The 3 other sets yield no values" in said
    some = none.assign(quoted_percent=5.0)
    assert "yield values in some recordings" in findings_of(some, elements, models)


def test_contrary_findings(tables):
    sets, elements, models = tables
    belt = sets.perturbations == "belt"
    enough = sets.assign(identified=sets.identified | belt)
    enough.loc[belt, "statement"] = "All 24 unknowns are determined."
    without = elements.assign(neglected_inertia_u_percent=np.nan)
    said = findings_of(enough, without, models.assign(identified=True)[models.window_s == 0.25])
    assert "need 1 independent perturbation: 1 of 1 sets of 1 identify them (belt)." in said
    assert "The belt alone is enough. All 24 unknowns" in said
    assert "If K and B are assumed to be symmetric, 1 can suffice (belt). Fewer than three" in said
    assert "only their proportions" not in said and "the window after" not in said
    assert "assumed to be exact" not in said
    assert "assumed to be symmetric" not in findings_of(sets, elements, models.assign(identified=False))


def test_section_is_drawn_and_typeset(tables):
    sets, elements, _ = tables
    figure = plot_several_joints(sets, elements, 15.0)
    assert len(figure.axes) == 2 and figure.axes[1].get_title(loc="left") == "belt + thigh + pelvis"
    words = typeset_words('#include "several_joints.typ"', *content(tables), cells=" ")
    assert "belt + thigh + pelvis 24 of 24 10" in words


@pytest.mark.slow
def test_recordings_are_read_as_they_were_made(tmp_path):
    protocol = replace(PROTOCOL, epochs=2, unperturbed_s=4.0)
    write_chain_trials(tmp_path / "joints.h5", PERSON, protocol, 1, 2)
    first, second = read_draws(tmp_path / "joints.h5")
    assert first.unperturbed.shape == (800, 3) and first.rate_hz == 200.0 and first.before == 20
    assert list(first.angle) == list(PULSES) and first.angle["belt"].shape == (2, 71, 3)
    assert first.drive["thigh"].shape == (2, 251)
    assert not np.array_equal(first.unperturbed, second.unperturbed)


# ---- configuration -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plan/several_joints/person/mass_kg": [7.0, 15.0]}, "plan.several_joints.person.mass_kg"),
        (
            {"plan/several_joints/perturbations/push": {"force_N": 50.0}},
            "plan.several_joints.perturbations.push",
        ),
        ({"plan/several_joints/protocol/epochs": 400}, "plan.several_joints.protocol.unperturbed_s"),
        ({"plan/several_joints/protocol/unperturbed_s": 5.0}, "plan.several_joints.protocol.unperturbed_s"),
    ],
)
def test_settings_that_cannot_be_simulated_are_refused_in_one_sentence(changes, words, checked_study_of):
    with pytest.raises(InputError) as refusal:
        checked_study_of("plan")(changes)
    assert words in str(refusal.value) and "\n" not in str(refusal.value)
