"""Every combination of choices, by the functions of the study's own pathways."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import scipy
from builders import Joint
from typst_builders import findings_of

from tepsipe.drawing.names import words
from tepsipe.experiments.dummy.figures import plot_specification
from tepsipe.experiments.dummy.foot_pathways import FootOptions
from tepsipe.experiments.dummy.leg_pathways import analyse_dummy
from tepsipe.experiments.dummy.options import Pathway, SpecificationOptions
from tepsipe.experiments.dummy.specification_curve import (
    FILTERED,
    REFERENCES,
    SPECIFICATIONS,
    WINDOWS,
    filters,
    specify_dummy,
)
from tepsipe.io.trial import Signal, Trial
from tepsipe.mechanics.inverse_dynamics import Foot
from tepsipe.reporting.chapters import dummy
from tepsipe.reporting.run import Run
from tests.experiments.test_dummy_leg_pathways import OPTIONS, trial_of_swing

PRINTED = Pathway("leg-thesis", "aligned", "windowed-least-squares-thesis")
RECOMMENDED = Pathway("leg", "aligned", "windowed-least-squares")
SIMULATED = Pathway("leg", "aligned", "output-error")
DUMMY = replace(OPTIONS, belt_fixed_labels=("ankle",))
FOOT = FootOptions(Foot(2.1, 0.055), "ankle", ("ankle",), "right")
CHOSEN = SpecificationOptions(other_cutoff_hz=10.0, command_s=0.1, longer_s=0.4, before_segment_s=0.1)


@pytest.fixture(scope="module")
def trial():
    """A leg that swings, on a plate whose loads hold its joint's torque and some noise."""
    plain = trial_of_swing(Joint(rest=0.005), noise_m=5e-5)
    loads = np.random.default_rng(3).standard_normal((2, plain.time.size, 1, 3))
    loads[0, :, 0, 2] += 24.5
    axes = plain.axes | {"belt": np.array(["right"])}
    signals = plain.signals | {
        "force": Signal(loads[0], "N", ("time", "belt", "axis"), "force"),
        "moment": Signal(loads[1], "Nm", ("time", "belt", "axis"), "moment"),
    }
    return Trial(plain.rate_hz, axes, signals)


@pytest.fixture(scope="module")
def rows(trial):
    return specify_dummy(trial, "sine-0.3", DUMMY, FOOT, CHOSEN, PRINTED, RECOMMENDED)


@pytest.mark.slow
def test_every_combination_is_there_once_sorted_by_stiffness(rows):
    # torque, filters and what they filter or none at all, rest, window, estimator; output error by filter
    assert len(rows) == 4 * (4 * 3 + 1) * 2 * 3 * 2 + 5
    assert len({row.choices for row in rows}) == len(rows)
    stiffness = [row.K_Nm_per_rad for row in rows]
    assert stiffness == sorted(stiffness)
    assert np.isfinite([[row.I_Nms2_per_rad, row.B_Nms_per_rad, row.VAF_percent] for row in rows]).all()


def test_marked_columns_and_output_error_are_the_studys_own_estimates(trial, rows):
    own = {"as printed": PRINTED, "recommended": RECOMMENDED, "simulated": SIMULATED}
    analysis = analyse_dummy(trial, DUMMY, own)
    standard = next(iter(filters(DUMMY, CHOSEN)))
    for name, regression in analysis.regressions.items():
        if name == "simulated":
            chosen = [r for r in rows if r.estimator == "output-error" and r.filter == standard]
        else:
            chosen = [r for r in rows if r.role == name]
        assert len(chosen) == 1
        row = chosen[0]
        found = [row.I_Nms2_per_rad, row.B_Nms_per_rad, row.K_Nm_per_rad]
        assert found == regression.mean.tolist()
        assert row.VAF_percent == regression.vaf_per_perturbation.mean()


def test_one_filter_for_all_keeps_the_joint_and_a_filter_for_one_moves_its_damping(rows):
    def damping(filtered, filter_name):
        wanted = ("leg", filter_name, filtered, REFERENCES[0], WINDOWS[1], "windowed-least-squares")
        return next(row.B_Nms_per_rad for row in rows if row.choices == wanted)

    names = list(filters(DUMMY, CHOSEN))
    assert damping(FILTERED[0], names[0]) == pytest.approx(0.1, abs=0.01)
    # forwards only, a filter delays what passes it
    for filtered in FILTERED[1:]:
        assert abs(damping(filtered, names[1]) - 0.1) > 0.05


def test_an_order_in_each_pass_is_twice_the_order_of_both(rng):
    known = list(filters(DUMMY, CHOSEN).items())
    assert [name for name, _ in known] == [
        "bidirectional 20 Hz",
        "unidirectional 20 Hz",
        "bidirectional 10 Hz",
        "bidirectional 20 Hz, order 8",
        "none",
    ]
    noise = rng.standard_normal(2000)
    for (_, lowpass), order in ((known[0], 2), (known[3], 4)):
        sections = scipy.signal.butter(order, 20.0, fs=250.0, output="sos")
        twice = scipy.signal.sosfiltfilt(sections, noise)
        assert lowpass(noise, 250.0)[300:-300] == pytest.approx(twice[300:-300], abs=1e-6)


@pytest.mark.slow
def test_pathway_with_other_instants_has_no_column(trial):
    strobed = replace(PRINTED, marker_instants="as-sampled")
    found = specify_dummy(trial, "x", DUMMY, FOOT, CHOSEN, strobed, RECOMMENDED)
    assert {row.role for row in found} == {"", "recommended"}


def test_table_is_read_as_it_was_written(rows, tmp_path):
    SPECIFICATIONS.write(tmp_path / "specification.csv", rows)
    back = SPECIFICATIONS.read(tmp_path / "specification.csv")
    assert [row.choices for row in back] == [row.choices for row in rows]
    assert [row.role for row in back] == [row.role for row in rows]
    assert [row.K_Nm_per_rad for row in back] == pytest.approx([row.K_Nm_per_rad for row in rows], rel=1e-9)


@pytest.mark.slow
def test_numbers_of_the_report_are_those_of_the_rows(rows, tmp_path):
    def told(rows):
        path = tmp_path / "specification.csv"
        SPECIFICATIONS.write(path, rows)
        recommended = dummy.recommended_specified(Run({"specification": pd.read_csv(path)}))
        content = {"numbers": {}, "holds": {"recommended_specified": recommended}}
        return findings_of(
            ["figure_specification"], {"chapters": {"dummy": content}}, {"specification": path}
        )

    recommended = next(row.K_Nm_per_rad for row in rows if row.role == "recommended")
    near = [abs(row.K_Nm_per_rad / recommended - 1.0) < 0.05 for row in rows]
    (caption,) = told(rows).values()
    assert caption.endswith(f" in {100.0 * np.mean(near):.0f} % of the 629 combinations of choices.")
    assert told([row for row in rows if not row.role]) == {}


def test_figure_has_a_row_for_every_value_of_every_choice(rows):
    figure = plot_specification(rows)
    labels = [label.get_text() for label in figure.axes[2].get_yticklabels()]
    for row in rows:
        assert {words(choice) for choice in row.choices if choice != "none"} <= set(labels)
    assert len(labels) == 4 + 5 + 3 + 2 + 4 + 3
