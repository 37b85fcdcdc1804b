"""Filters and the plan study: filtered alike there is no bias, and tables hold what was computed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest
from typst_builders import evaluated, page_of, plain_words

from tepsipe.errors import InputError
from tepsipe.experiments.planning.design import LEG_MARKERS, exact_markers
from tepsipe.experiments.planning.figures import (
    plot_filters,
    plot_needed,
    plot_pulses,
    plot_treadmill_filters,
)
from tepsipe.experiments.planning.filter_trials import FilteredEstimates
from tepsipe.experiments.planning.filtering import (
    delay_samples,
    filtered,
    filtered_motion,
    late,
    lowpasses,
    mismatch_bias,
)
from tepsipe.experiments.planning.plan import draw_estimates, plan_experiment
from tepsipe.identification.regression.windows import regress_torque
from tepsipe.io.tables import write_records
from tepsipe.reporting.chapters import plan as plan_chapter
from tepsipe.reporting.plan_tables import (
    checked_rows,
    predicted_filters,
    simulated_filters,
    window_rows,
)
from tepsipe.reporting.recovery import TrueMotion
from tepsipe.reporting.run import Run, report_content
from tepsipe.signals.filters import Lowpass
from tests.experiments.test_planning import design, plan

K = 2
ONE_SIDED, ZERO_LAG = Lowpass(20.0, 4, False), Lowpass(20.0, 4, True)


# ---- filters -----------------------------------------------------------------------------------


@pytest.mark.parametrize("lowpass", [ZERO_LAG, ONE_SIDED, Lowpass(8.0, 2, False), Lowpass(40.0, 8, True)])
def test_signals_filtered_alike_have_no_bias_without_noise(lowpass):
    bias = mismatch_bias(design("leg"), plan("leg").motion, lowpass, lowpass)
    assert np.abs(bias / design("leg").parameters).max() < 1e-3


def test_a_filter_of_one_side_biases_k_less_the_higher_its_cutoff():
    def bias(cutoff_hz, torque, motion):
        lowpass = Lowpass(cutoff_hz, 4, True)
        sides = (lowpass if torque else None, lowpass if motion else None)
        return mismatch_bias(design("leg"), plan("leg").motion, *sides)[K]

    # a torque that is smaller than its motion makes a softer joint
    assert bias(10.0, True, False) < bias(20.0, True, False) < bias(40.0, True, False) < -0.05
    assert bias(20.0, False, True) > 0.5


@pytest.mark.parametrize("lowpass", [Lowpass(6.0, 4, True), Lowpass(40.0, 2, False)])
def test_no_filter_removes_a_belt_induced_torque_in_the_band_of_the_joint(lowpass):
    moved = plan("leg").motion
    leg, rate, induced = design("leg").leg, design("leg").rig.camera_rate_hz, 0.02
    labels, layout = list(LEG_MARKERS.labels), LEG_MARKERS
    positions = exact_markers(design("leg"), moved)[0][:, -len(labels) :]
    motion = filtered_motion(moved.time, positions, labels, layout, leg.com_m, lowpass)
    torque = filtered(moved.simulated.torque + induced * moved.simulated.foot_y_dd, lowpass, rate)
    windows = late(moved.perturbations, lowpass, rate)
    found = regress_torque(motion, torque, windows, moved.at_rest)
    coupling = leg.mass_kg * leg.com_m
    inertia, damping, stiffness = design("leg").parameters
    swung = inertia + leg.inertia_kgm2 + coupling * leg.com_m
    apparent = np.array([swung, damping, stiffness - coupling * leg.gravity_m_per_s2])
    assert found.mean == pytest.approx(design("leg").parameters - induced / coupling * apparent, rel=2e-3)
    assert min(found.vaf_per_perturbation) > 99.99


def test_delay_of_a_filter_that_runs_forwards():
    # first order: 1 / (2 pi f_c)
    assert delay_samples(Lowpass(5.0, 1, False), 1000.0) == round(1000.0 / (2.0 * np.pi * 5.0))
    assert delay_samples(ZERO_LAG, 250.0) == 0


def test_one_sided_noise_is_predicted_too(rng):
    protocol = replace(design("leg").protocol, zero_lag=False)
    one_sided = replace(design("leg"), protocol=protocol)
    found = plan_experiment(one_sided)
    drawn = draw_estimates(one_sided, found.motion, rng, 25)
    assert drawn.std(axis=0, ddof=1) == pytest.approx(found.type_a, rel=0.45)
    # less of the noise is removed by one pass than by two
    assert found.type_a[K] > plan("leg").type_a[K]


# ---- tables ------------------------------------------------------------------------------------


def true_joint():
    time = np.arange(0.0, 4.0, 0.001)
    since = np.maximum(time - 0.3, 0.0)
    angle = 0.02 * np.sin(9.0 * since) * np.exp(-since) * (1.0 - np.exp(-20.0 * since)) ** 3
    rate = np.gradient(angle, time)
    acceleration = np.gradient(rate, time)
    return TrueMotion(time, angle, rate, acceleration, 0.1 * rate + 10.0 * angle + 0.007 * acceleration)


@cache
def tables():
    planned = plan("leg")
    drawn = planned.design.parameters + planned.type_a * np.random.default_rng(3).standard_normal((30, 3))
    designs = checked_rows("leg-design", planned, drawn)
    designs += checked_rows("likelihood", plan(), drawn)
    filters = predicted_filters(design("leg"), [ZERO_LAG, ONE_SIDED])
    estimates = [
        FilteredEstimates(
            pathway, lowpass, np.array([[0.007, 0.1, k], [0.007, 0.1, k + 0.2]]), [(0.5, 1.5), (1.5, 3.0)]
        )
        for pathway, k in (("leg", 10.1), ("foot", 4.0), ("foot-compensated", 9.5))
        for lowpass in (ZERO_LAG, Lowpass(20.0, 2, False))
    ]
    windows = pd.DataFrame(window_rows("sine-0.3", estimates))
    filters += simulated_filters(windows, {"sine-0.3": true_joint()})
    cases = [("its own peaks", "returns", 0.9), ("its own peaks", "one way", 0.5)]
    cases += [("its own acceleration", "one way", 0.2)]
    peaks = ("velocity_m_per_s", "displacement_m", "acceleration_m_per_s2", "jerk_m_per_s3")
    pulses = [
        {
            **{
                "reference": "sine",
                "limits": limits,
                "belt": belt,
                "reference_u": 1e-3,
                "best_u": ratio * 1e-3,
            },
            **{"u_ratio": ratio, "reference_cramer_rao": 5e-4, "best_cramer_rao": ratio * 5e-4},
            **{"least_cramer_rao": 0.99 * ratio * 5e-4},
            **{f"{kind}_{name}": 1.0 for kind in ("limit", "peak") for name in peaks},
        }
        for limits, belt, ratio in cases
    ]
    shapes = [
        {"reference": "sine", "limits": limits, "belt": belt, "time_s": t, "velocity_m_per_s": 0.3 * t}
        for limits, belt, _ in [("reference", "returns", 1.0), *cases]
        for t in (0.0, 0.1)
    ]
    return designs, pulses, shapes, filters


@cache
def frames(folder):
    names = ("plan", "pulses", "shapes", "filters")
    for name, rows in zip(names, tables(), strict=True):
        write_records(folder / f"{name}.csv", rows)
    return [pd.read_csv(folder / f"{name}.csv") for name in names]


def test_table_of_designs_compares_like_with_like(tmp_path):
    found = frames(tmp_path)[0]
    assert list(found.columns[:5]) == [
        "design",
        "quantity",
        "n_perturbations",
        "predicted_u",
        "monte_carlo_u",
    ]
    leg = found[found.design == "leg-design"]
    assert (leg.monte_carlo_u / leg.predicted_u).between(0.6, 1.5).all()
    assert leg.cramer_rao.isna().all() and found[found.design == "likelihood"].cramer_rao.notna().all()


def test_error_of_a_filter_is_that_against_the_truth_of_each_window(tmp_path):
    found = frames(tmp_path)[3]
    own = found[(found.source == "sine-0.3") & (found.quantity == "K") & (found.kind == "zero-lag")]
    errors = dict(zip(own.pathway, own.bias, strict=True))
    assert errors == pytest.approx({"leg": 0.2, "foot": -5.9, "foot-compensated": -0.4}, abs=0.01)
    assert own.sd_of_window.to_numpy() == pytest.approx(np.sqrt(0.02), rel=0.05)
    assert set(found.quantity) == {"B", "K"}


def test_every_filter_once():
    found = lowpasses([6.0, 20.0], [2, 4], [2])
    assert len(set(found)) == len(found) == 6 and sum(not lowpass.zero_lag for lowpass in found) == 2


JOINTS = {
    "protocol": {"after_s": 0.25, "epochs": 40},
    "limits": {"stiffness_percent": 15.0, "damping_percent": 50.0},
    "persons": 2,
}
STUDY = {"title": "Plan", "recordings_source": None, "experiments": {}, "made": {}}


def content(run):
    """Content of report.json, and tables, without those of several joints (test_several_joints.py)."""
    settings = {"plan": {"seed": 1, "several_joints": JOINTS}}
    study = STUDY | {"code": {"commit": None, "modified": False}}
    data = report_content(replace(run, settings=settings, study=study), {"plan": plan_chapter})
    return data, {name: table.to_csv(index=False) for name, table in run.tables.items()}


def run_of(folder):
    planned, pulses, _, filters = frames(folder)
    # pandas would write a number of perturbations as 1.0 where another is undefined
    counts = {name: "Int64" for name in planned if name.startswith("n_for")}
    return Run({"plan": planned.astype(counts), "pulses": pulses, "filters": filters})


def findings_of(run):
    (found,) = evaluated(["holding(findings).map(plain)"], "plan.typ", *content(run))
    return " ".join(" ".join(found).split())


def test_findings_follow_the_numbers(tmp_path):
    findings = findings_of(run_of(tmp_path))
    assert "cannot be halved" in findings and "standard error falls below half: it is 0.20" in findings
    assert "No low-pass filter removes the load of the treadmill" in findings


def test_contrary_numbers_say_the_contrary(tmp_path):
    run = run_of(tmp_path)
    planned, pulses, filters = run.tables.values()
    limits = ["its own peaks", "its own peaks", "its own acceleration"]
    contrary = {
        "plan": planned.assign(n_for_10_percent=pd.NA),
        "pulses": pulses.assign(limits=limits, least_cramer_rao=1e-4, u_ratio=0.8),
        "filters": filters[(filters.pathway != "foot") & (filters.filtered == "alike")],
    }
    findings = findings_of(Run(contrary))
    assert "may be halved" in findings and "does not fall below half: it is 0.80" in findings
    assert "No number of perturbations suffices to know K within ±10 % in leg-design, likelihood" in findings
    assert "No low-pass" not in findings and "only one of them" not in findings
    one = findings_of(Run(contrary | {"plan": planned.assign(n_for_10_percent=1)}))
    assert "In 2 of 2 designs, one perturbation suffices" in one
    assert "pulse" not in findings_of(Run(contrary | {"pulses": pulses[:0]}))


def test_cutoffs_of_nearly_the_least_error_are_recommended():
    errors = {5.0: 4.0, 10.0: 1.2, 20.0: 1.0, 40.0: 3.0}
    rows = [("leg", "K", "sine", "zero-lag", 4, hz, bias, 0.0, bias) for hz, bias in errors.items()]
    columns = ["pathway", "quantity", "source", "kind", "order", "cutoff_hz", "bias", "sd_of_window"]
    filters = pd.DataFrame(rows, columns=[*columns, "bias_percent"])
    (found,) = plan_chapter.numbers(Run({"filters": filters}))["recommended"]
    assert (found["from_hz"], found["to_hz"]) == (10.0, 20.0)
    assert (found["least"], found["least_at_hz"]) == (1.0, 20.0)
    assert (found["most"], found["most_at_hz"]) == (4.0, 5.0)


@pytest.mark.slow
def test_report_is_typeset(tmp_path):
    planned, _, shapes, filters = frames(tmp_path)
    drawn = (plot_needed(planned), plot_pulses(shapes), plot_filters(filters))
    assert all(figure.axes for figure in (*drawn, plot_treadmill_filters(filters)))
    words = plain_words(page_of(*content(run_of(tmp_path)), '#include "plan.typ"'))
    assert "K with the torque from plate and foot, compensated: 20 Hz" in words
    assert "This study predicts how precise the result" in words


# ---- configuration -----------------------------------------------------------------------------


@pytest.fixture
def checked(checked_study_of):
    """Check the shipped plan study with other values of some keys."""
    return checked_study_of("plan")


def test_shipped_plan_study_is_valid(checked):
    study = checked()
    assert set(study.experiments) == {"dummy", "weight", "empty"}
    assert len(study.config["plan"]["designs"]) >= 6


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plan/filters/design": "nothing"}, "plan.filters.design"),
        ({"plan/designs": {"a": {"protocol": {"profile": "square"}}}}, "plan.designs.a.protocol.profile"),
        ({"weight/models/family": ["loaded-frame"]}, "weight.models.family"),
    ],
)
def test_plan_study_that_cannot_run_is_refused_in_one_sentence(changes, words, checked):
    with pytest.raises(InputError) as refusal:
        checked(changes)
    assert words in str(refusal.value) and "\n" not in str(refusal.value)
