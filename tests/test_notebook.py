"""The library in a notebook: recordings with their truth, results that show themselves, names with types."""

import ast
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from builders import assert_one_sentence, refused

import tepsipe
from tepsipe import (
    belt_recording,
    calibrate_treadmill,
    fit_admittance,
    fit_impedance,
    fit_joint_likelihood,
    frequency_response,
    load_example,
)
from tepsipe.experiments.example import EXAMPLES, FOLDER
from tepsipe.treadmill.registry import MOTION, calibrated_range, leaving
from tepsipe.virtual_lab import example_recordings


@pytest.fixture(scope="module")
def dummy():
    return load_example("dummy")


@pytest.fixture(scope="module")
def fit(dummy):
    return fit_impedance(dummy.time, dummy.angle, dummy.torque, perturbations=dummy.perturbations)


@pytest.fixture(scope="module")
def admittance():
    rig = load_example("manipulator")
    response = frequency_response(rig.time, rig.torque, rig.angle, period_s=rig.period_s, band_hz=(1.0, 20.0))
    return fit_admittance(response)


# ---- recordings to try ---------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_is_what_its_script_simulates(name):
    counts, facts = example_recordings.RECORDINGS[name]()
    kept = load_example(name)
    assert facts["truth"] == kept.truth
    with np.load(FOLDER / f"{name}.npz") as file:
        assert set(file.files) == {*counts, "facts"}
        for key, found in counts.items():
            assert np.abs(file[key] - found).max() <= 1, key  # another processor may round the other way


def test_examples_are_small_and_the_unknown_one_is_answered():
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < 2e6
    assert {path.stem for path in FOLDER.iterdir()} == set(EXAMPLES) == set(example_recordings.RECORDINGS)
    refused(lambda: load_example("dumy"), "'dumy'", "did you mean 'dummy'?")
    assert len(repr(load_example())) < 200


def test_the_truth_of_the_dummy_is_found_from_torque_and_from_markers(dummy, fit):
    likelihood = fit_joint_likelihood(
        dummy.time,
        dummy.positions,
        dummy.markers,
        dummy.leg,
        labels=dummy.labels,
        belt_fixed=dummy.belt_fixed,
        perturbations=dummy.perturbations,
        belt_velocity=dummy.belt_velocity,
        softening=False,
    )
    assert len(dummy.perturbations) == 14
    for found, closeness in ((fit, 0.04), (likelihood, 0.002)):
        assert found.parameters == pytest.approx([dummy.truth[name] for name in "IBK"], rel=closeness)


def test_the_truth_of_the_manipulator_is_found(admittance):
    truth = load_example("manipulator").truth
    assert admittance.parameters == pytest.approx([truth[name] for name in "IBK"], rel=2e-3)


# ---- results -------------------------------------------------------------------------------------


def test_a_result_is_short_as_text_and_complete_as_html(fit, admittance):
    for found in (fit, admittance):
        assert len(repr(found)) < 250
        page = found._repr_html_()
        for name, quantity in found.quantities.items():
            value, _, interval = quantity.cells()
            assert f"<td>{name}</td><td>{value}</td>" in page
            assert interval in page
        assert page.count("data:image/png;base64,") == 1
        assert page.count("<div") == page.count("</div>")
    noted = replace(fit, notes=("a <b> note",))
    assert "a &lt;b&gt; note" in noted._repr_html_()
    assert "1 note>" in repr(noted)


def test_plots_leave_nothing_open_and_warn_of_nothing(fit, admittance):
    import matplotlib.pyplot as plt

    before = plt.get_fignums()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(matplotlib.rcParams["figure.max_open_warning"] + 2):
            figure = fit.plot()
        admittance.plot()
    assert plt.get_fignums() == before
    assert "K = " in figure.axes[0].get_title("left")


def test_a_figure_of_a_notebook_is_closed_when_it_is_shown(fit, monkeypatch):
    """The inline backend shows the figures that are open at the end of a cell."""
    import matplotlib.pyplot as plt

    monkeypatch.setattr(plt, "get_backend", lambda: "inline")
    before = plt.get_fignums()
    made = plt.figure

    def first_figure(**options):
        """Loading a backend with the first figure may change settings."""
        monkeypatch.setitem(plt.rcParams, "figure.dpi", 77.0)
        return made(**options)

    monkeypatch.setattr(plt, "figure", first_figure)
    most = plt.rcParams["figure.max_open_warning"]
    figure = fit.plot()
    assert plt.rcParams["figure.dpi"] == 77.0
    assert plt.rcParams["figure.max_open_warning"] == most
    assert plt.get_fignums() == [*before, figure.number]
    assert figure._repr_mimebundle_(include=None, exclude=None) == {}
    assert plt.get_fignums() == before


def test_plots_are_drawn_on_given_axes(fit, admittance):
    from matplotlib.figure import Figure

    figure = Figure()
    one, two = figure.subplots(2)
    assert fit.plot(ax=one) is figure
    assert [text.get_text() for text in one.get_legend().get_texts()] == ["measured", "predicted"]
    # all perturbations lie on top of each other
    assert len(one.lines) == 2 * len(fit.windows)
    assert admittance.plot(ax=[one, two]) is figure
    refused(lambda: fit.plot(ax="here"), "ax", "'str'", "plt.subplots")
    refused(lambda: admittance.plot(ax=one), "list of 2", "'Axes'")


def test_a_result_becomes_an_xarray_dataset(fit, admittance):
    pytest.importorskip("xarray")
    data = fit.to_xarray()
    assert float(data["value"].sel(quantity="K")) == fit.K
    assert str(data["unit"].sel(quantity="K").values) == "N·m/rad"
    assert data["windows"].shape == (14, 3)
    assert data["measured"].attrs["units"] == "N·m"
    assert admittance.to_xarray()["measured"].attrs["units"] == "rad/(N·m)"


def test_without_xarray_one_sentence_says_what_to_install(fit, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    refused(fit.to_xarray, "xarray", "pip install xarray")


# ---- names with types ----------------------------------------------------------------------------


def test_the_stub_has_the_public_names_and_their_modules():
    package = Path(tepsipe.__file__).parent
    tree = ast.parse((package / "__init__.pyi").read_text(encoding="utf-8"))
    found = {
        alias.asname: node.module
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert found == tepsipe._PUBLIC
    (named,) = [node.value for node in tree.body if isinstance(node, ast.Assign)]
    assert sorted(ast.literal_eval(named)) == sorted(tepsipe.__all__)
    assert (package / "py.typed").is_file()


# ---- a treadmill outside its calibration ---------------------------------------------------------


def belt(seed, name, speed=1.2, swing=0.1):
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 60.0, 0.01)
    velocity = speed + swing * tepsipe.lowpass(rng.standard_normal(time.size), 100.0, cutoff_hz=5.0)
    load = 6.0 * np.gradient(velocity, time) + 0.05 * rng.standard_normal(time.size)
    return belt_recording(time, load, velocity, name=name)


def test_a_calibration_keeps_its_range_and_warns_outside_it(tmp_path):
    slow, again, fast = belt(1, "slow"), belt(2, "again"), belt(3, "fast", speed=2.0)
    found = calibrate_treadmill(slow, [again, fast], models=["fir"])
    (note,) = found.notes
    assert_one_sentence(note, "fast", "100.0 % of its velocity outside", "m/s")
    assert "load" not in note  # an acceleration of the same size loads the plate alike
    found.save(tmp_path / "models.json")
    kept = tepsipe.load_treadmill_models(tmp_path / "models.json")["fir"]
    with pytest.warns(UserWarning, match="of its velocity outside"):
        kept.compensate(fast.filtered(kept.lowpass))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        kept.compensate(again.filtered(kept.lowpass))


def test_a_range_is_left_by_what_is_beyond_it():
    slow = belt(1, "slow")
    ranges = calibrated_range([slow])
    assert leaving(slow, ranges) == ""
    assert "of its acceleration outside" in leaving(belt(2, "wild", swing=0.5), ranges, MOTION)


def test_the_recommended_model_is_not_chosen_on_the_test(monkeypatch):
    train = belt(1, "train")
    models = ["mass-spring-damper", "fir", "ripple-tracking"]
    first, other = (
        calibrate_treadmill(train, belt(seed, "test", swing=swing), models=models)
        for seed, swing in ((2, 0.1), (3, 0.02))
    )
    assert first.validated == other.validated
    assert set(first.validated) == {"mass-spring-damper", "fir"}
    # both predict the load of a mass; it has three constants, the impulse response many
    assert first.recommended == other.recommended == "mass-spring-damper"
    assert "follows the measured load" in first.summary()
    assert first.notes == ()
    assert "<img" in first._repr_html_()
