"""Public fits with stated uncertainties, and the benchmarks that count their intervals and notes."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from builders import assert_one_sentence
from scipy.interpolate import CubicSpline

from tepsipe import InputError, fit_impedance

FOLDER = Path(__file__).parents[2] / "benchmarks"


def loaded(name):
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def coverage():
    return loaded("public_fits")


@pytest.fixture(scope="module")
def arrays(coverage):
    """Signals of a noisy joint (s, rad, N·m), and its perturbations."""
    trial = coverage.Trial(6, 100.0)
    return trial.signals(np.random.default_rng(5), 0.01), {"perturbations": trial.perturbations}


def test_uncertainty_widens_intervals_by_its_share(arrays):
    plain, stated = (
        fit_impedance(*arrays[0], **arrays[1], uncertainty=u) for u in (None, {"torque_scale": 0.05})
    )
    assert "Type A" in plain.summary() and "Type B" not in plain.type_b
    assert stated.type_b == ("torque_scale",)
    assert "torque_scale (Type B)" in stated.summary()
    assert stated.budget["K"]["torque_scale"] == pytest.approx(0.05 * stated.K)
    assert stated.standard_errors["K"] == pytest.approx(
        np.hypot(stated.budget["K"]["scatter"], 0.05 * stated.K)
    )
    assert stated.standard_errors["K"] > plain.standard_errors["K"]
    assert stated.K == plain.K


def test_late_torque_shifts_the_damping_by_stiffness_times_the_delay(arrays):
    time, angle, torque = arrays[0]
    late = CubicSpline(time, torque)(time - 1e-3)
    # a delay that is stated to be 0 is not removed
    fits = [
        fit_impedance(time, angle, x, **arrays[1], uncertainty={"torque_delay_s": 0.0})
        for x in (torque, late)
    ]
    change = (fits[1].parameters - fits[0].parameters) / 1e-3
    # K (theta - d theta') has the damping - K d, but the inertia takes a part of it: B d moves to I
    assert change[0] == pytest.approx(-fits[0].B, rel=0.05)
    assert -fits[0].K < change[1] < -0.3 * fits[0].K


@pytest.mark.parametrize(
    ("uncertainty", "part"),
    [
        ({"leg_mas_kg": 0.1}, "'leg_mas_kg'"),
        ({"torque_scale": -0.1}, "at least 0"),
        ({"torque_scale": "1 %"}, "'1 %'"),
        ({"torque_scale": float("nan")}, "nan"),
        (0.05, "mapping"),
    ],
)
def test_uncertainty_that_cannot_be_is_refused(arrays, uncertainty, part):
    with pytest.raises(InputError, match=part) as caught:
        fit_impedance(*arrays[0], **arrays[1], uncertainty=uncertainty)
    assert_one_sentence(caught.value, "fit_impedance")


def test_quick_coverage_of_few_perturbations(coverage):
    trial = coverage.Trial(6, 100.0)
    held, bias, width = coverage.coverage(coverage.windows(trial, 0.1, None), coverage.JOINT, 60, 1)
    # 60 records: 86 to 100 % contain 99.7 % of what 95 % allows
    assert (held >= 86.0).all() and (np.abs(bias) < 0.6).all()
    assert (width > 1.7).all() and (width < 3.4).all()


# ---- the other benchmarks of the library run ------------------------------------------------------


@pytest.mark.slow
def test_every_kind_of_valid_record_is_fitted_without_a_note(capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["notes_on_valid_records.py", "--scale", "0.001"])
    loaded("notes_on_valid_records").main()
    assert capsys.readouterr().out == "0 of 9 valid records have notes: 0.0 %\n"


def test_spoiled_records_are_told_from_valid_ones():
    script = loaded("notes_on_valid_records")
    assert script.outcome(script.windowed, [3], script.unspoiled) in ("covered", "silent")
    for name in ("torque late", "torque clipped", "torque drifts"):
        assert script.outcome(script.windowed, [3], script.OF_SIGNALS[name]) == "noted", name
    assert script.outcome(script.output_error, [3], script.OF_MARKERS["belt reversed"]) == "refused"


@pytest.mark.slow
def test_every_public_fit_has_an_interval_near_its_truth():
    script = loaded("public_fits")
    for name, fit, truth, quantities in script.others():
        found = fit(np.random.default_rng(1)).quantities
        near = [abs(found[q].value / true - 1.0) < 0.5 for q, true in zip(quantities, truth, strict=True)]
        assert near == [True] * 3, name
        assert all(np.isfinite(found[q].standard_error) for q in quantities), name
