"""Tables, figure and section on several joints: no number where none is known, sentences follow tables."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tepsipe.errors import InputError
from tepsipe.experiments.planning.several_joints import MODELS, epochs_of, estimate, predict, read_draws
from tepsipe.reporting.figures.several_joints import plot_several_joints
from tepsipe.reporting.numbers.several_joints import joints_data
from tepsipe.reporting.plan_tables import write_rows
from tepsipe.reporting.several_joints import element_rows, model_rows, movement, set_rows
from tepsipe.virtual_lab.chain_trials import write_chain_trials
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
        write_rows(folder / f"{name}.csv", own)
    return [pd.read_csv(folder / f"{name}.csv") for name in rows]


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
    assert open_.statement.str.contains("The scale is open").all()


def test_findings_follow_the_numbers(tables):
    sets, elements, models = tables
    said = " ".join(joints_data(sets, elements, models, SETTINGS)["findings"])
    assert "24 unknowns, need 3 independent perturbations" in said
    assert "The 2 other sets have no values" in said and "The belt alone gives no values" in said
    assert "with 150 ms, no set identifies them" in said
    none = sets.assign(identified=False, k_rms_percent=np.nan, quoted_percent=0.0)
    said = " ".join(joints_data(none, elements, models, SETTINGS)["findings"])
    assert "No set of perturbations identifies" in said and "The 3 other sets have no values" in said
    some = none.assign(quoted_percent=5.0)
    assert "have values in some recordings" in " ".join(
        joints_data(some, elements, models, SETTINGS)["findings"]
    )


def test_section_is_drawn_and_typeset(tables, tmp_path, root):
    typst = pytest.importorskip("typst")
    sets, elements, models = tables
    figure = plot_several_joints(sets, elements, 15.0)
    assert len(figure.axes) == 2 and figure.axes[1].get_title(loc="left") == "belt + thigh + pelvis"
    data = {"title": "Plan", "joints": joints_data(sets, elements, models, SETTINGS)}
    (tmp_path / "report.json").write_text(json.dumps(data), encoding="utf-8")
    for name in ("several_joints.typ", "style.typ", "data.typ", "format.typ"):
        (tmp_path / name).write_text((root / "report" / name).read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "several_joints.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"></svg>'
    )
    pdf = typst.compile(str(tmp_path / "several_joints.typ"), root=str(tmp_path), ignore_system_fonts=True)
    assert pdf.startswith(b"%PDF")


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
