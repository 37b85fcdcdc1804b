"""Calibrations end to end: which models on which trials, their table, and recordings of a real treadmill."""

from dataclasses import replace

import numpy as np
import pytest
from belt_builders import OPTIONS, belt_recording, pulsed_evaluated, restless_belt, swaying_belt
from builders import assert_one_sentence

from tepsipe.arguments import options_of
from tepsipe.errors import InputError
from tepsipe.ingest.belt_table import BeltTableOptions, ingest_belt_table
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.calibration import (
    ALL_EMPTY,
    BOTH,
    MODEL_SCORES,
    Calibration,
    ModelScore,
    calibrate,
    coherence_limit,
    mean_responses,
    plate_groups,
    plate_plan,
    table_plan,
    table_result,
)
from tepsipe.treadmill.registry import FamilyOptions, evaluate, fit_model
from tepsipe.treadmill.trial_recordings import table_recording

LOWPASS = Lowpass(20.0, 2, False)


def gain(kg, noise, rng):
    return lambda v, a: kg * a + noise * rng.standard_normal(a.size)


# ---- plans -------------------------------------------------------------------------------------


def test_trials_on_the_plate_are_grouped_by_experiment_and_role(rng):
    labels = [
        ("empty", "calibrate"),
        ("empty", "validate"),
        ("weight", "calibrate"),
        ("weight", "validate"),
        ("weight", "validate"),
    ]
    recordings = [restless_belt(gain(1.0, 0.0, rng), rng, 1.0, name=str(k)) for k in range(5)]
    training, testing = plate_groups([(*label, r) for label, r in zip(labels, recordings, strict=True)])
    names = [{k: [r.name for r in v] for k, v in groups.items()} for groups in (training, testing)]
    assert names[0] == {ALL_EMPTY: ["0", "1"], "empty": ["0"], BOTH: ["0", "2"], "weight": ["2"]}
    assert names[1] == {"empty": ["1"], "weight": ["3", "4"]}


def test_plan_fits_every_model_where_it_can_be_fitted():
    plan = plate_plan(["mean-subtraction", "fir", "loaded-frame"], ["empty", "weight"])
    assert plan == [
        Calibration("mean-subtraction", ALL_EMPTY, ("weight",)),
        Calibration("fir", "empty", ("empty", "weight")),
        Calibration("fir", "weight", ("empty", "weight")),
        Calibration("loaded-frame", BOTH, ("empty", "weight")),
    ]
    assert table_plan(["fir", "hnat2014"], "slow-1", ["slow-2"]) == [
        Calibration("fir", "slow-1", ("slow-2",)),
        Calibration("hnat2014", "slow-1", ("slow-2",)),
    ]


# ---- scores ------------------------------------------------------------------------------------


def test_scores_are_those_of_unseen_recordings(rng):
    train, other, test = (restless_belt(gain(kg, 1.0, rng), rng) for kg in (3.0, 6.0, 3.0))
    train, other, test = (r.filtered(LOWPASS) for r in (train, other, test))
    scores, models = calibrate(
        [Calibration("fir", "good", ("test",)), Calibration("mass-spring-damper", "bad", ("test", "bad"))],
        {"good": [train], "bad": [other]},
        {"test": [test], "bad": [other]},
        "Mx",
        OPTIONS,
    )
    assert [(s.model, s.train, s.test) for s in scores] == [
        ("fir", "good", "test"),
        ("mass-spring-damper", "bad", "test"),
        ("mass-spring-damper", "bad", "bad"),
    ]
    assert [m.name for m in models] == ["fir", "mass-spring-damper"]
    fir, twice, seen = scores
    found = evaluate(fit_model("fir", [train], OPTIONS), [test])
    assert (fir.r2, fir.rms_before, fir.rms_after) == (found.r2, found.rms_before, found.rms_after)
    assert (fir.order, fir.cutoff_hz, fir.load, fir.unit) == (26, 20.0, "Mx", "Nm")
    assert fir.r2_limit == coherence_limit([test], OPTIONS.spectral_segment_s)
    assert twice.r2 == pytest.approx(0.0, abs=0.05)  # twice the load leaves as much as there was
    assert seen.r2 == pytest.approx(seen.r2_limit, abs=0.01)
    short = replace(test, evaluated=np.arange(test.load.size) < 100, name="too short")
    with pytest.raises(InputError) as caught:
        calibrate([], {}, {"test": [short]}, "Mx", OPTIONS)
    assert_one_sentence(caught.value, "too short", "1 s")


def test_scores_are_written_and_read_with_ten_digits(tmp_path):
    first = ModelScore("fir", "a, b", "c", 6.0, 0.123456789012, 2.0, 1.0, 51, float("nan"), "load", "Nm")
    second = replace(first, r2=-3.0, r2_limit=0.75, order=2)
    path = tmp_path / "scores.csv"
    MODEL_SCORES.write(path, [first, second])
    assert path.read_bytes().splitlines()[1] == b'fir,"a, b",c,6,0.123456789,2,1,51,nan,load,Nm,true'
    again = MODEL_SCORES.read(path)
    assert again[1] == replace(second, r2=-3.0)
    assert again[0].r2 == 0.123456789
    assert np.isnan(again[0].r2_limit)
    assert isinstance(again[0].order, int)


@pytest.mark.parametrize("header", ["", "model,train\n", "train,model\nfir,x\n"])
def test_table_of_other_columns_is_refused(header, tmp_path):
    path = tmp_path / "scores.csv"
    path.write_text(header)
    with pytest.raises(InputError) as caught:
        MODEL_SCORES.read(path)
    assert_one_sentence(caught.value, path, "r2_limit")


# ---- what figures show -------------------------------------------------------------------------


def test_mean_responses_are_those_of_the_perturbations():
    onsets, shape = (200, 500), np.hanning(30)
    acceleration = np.zeros(3000)
    for size, onset in zip((1.0, 3.0), onsets, strict=True):
        acceleration[onset : onset + 30] = size * shape
    r = belt_recording(np.cumsum(acceleration), acceleration, 5.0 * acceleration, condition="sine-0.3")
    r = replace(r, onsets=onsets, evaluated=pulsed_evaluated(3000, onsets, 60), lowpass=LOWPASS)
    fitted = fit_model("mass-spring-damper", [r], replace(OPTIONS, shortest_s=0.5))
    found = mean_responses([fitted], [r])
    assert found.arrays["sine-0.3/measured"] == pytest.approx(np.pad(10.0 * shape, (0, 30)))
    assert found.arrays["sine-0.3/mass-spring-damper"] == pytest.approx(
        np.pad(10.0 * shape, (0, 30)), abs=1e-6
    )
    assert found.units["sine-0.3/measured"] == "Nm"
    assert found.facts["conditions"] == ["sine-0.3"]


def test_result_of_a_table_shows_its_middle_and_the_lines_that_are_tracked(rng):
    def load(x, v, a):
        return 3.0 * a + 2.0 * np.cos(2.0 * np.pi * 1.3 * x) + 0.3 * rng.standard_normal(a.size)

    train, test = (swaying_belt(load, rng, name=name).filtered(LOWPASS) for name in ("slow-1", "slow-2"))
    models = [fit_model(name, [train], OPTIONS) for name in ("fir", "ripple-tracking")]
    found = table_result(models, [test], {"slow-2": {"clock": "kept"}}, most_samples=1000)
    arrays = found.arrays
    assert arrays["slow-2/time"][[0, -1]] == pytest.approx([25.0, 34.99])
    assert np.array_equal(arrays["slow-2/measured"], test.load[2500:3500])
    assert np.array_equal(arrays["slow-2/fir"], models[0].predict(test)[2500:3500])
    strongest = np.argmax(arrays["ripple/untracked"])
    assert arrays["ripple/order"][strongest] == pytest.approx(1.3, abs=0.02)
    assert arrays["ripple/tracked"][strongest] < 0.3 * arrays["ripple/untracked"][strongest]
    assert arrays["ripple/tracked_orders"] == pytest.approx([1.3], abs=0.01)
    assert found.units["ripple/order"] == "1/m"
    assert found.facts["ingested"] == {"slow-2": {"clock": "kept"}}


# ---- recordings of a real treadmill ------------------------------------------------------------

COLUMNS = {"time": "Timestamp (s)", "load": "Pitch Moment (Nm)", "velocity": "Belt Velocity (m/s)"}
ACCELERATION_ONLY = ("hnat2014", "output-error", "fir-causal", "fir", "spectral")


@pytest.fixture(scope="module")
def treadmill(shipped_config):
    return shipped_config["belt"]


@pytest.fixture
def real_scores(real_data, treadmill):
    """R2 and RMS at a cutoff: trained on the first trial at slow speed, tested on the second."""
    analysis, models = treadmill["analysis"], dict(treadmill["models"])
    options = BeltTableOptions(load_unit=treadmill["files"]["load_unit"], **treadmill["ingest"])
    recordings = []
    for name in ("RandomSlowSpeed1", "RandomSlowSpeed2"):
        path = real_data(f"rmill-treadmill/{name}.txt")
        trial = ingest_belt_table(read_text_table(path, COLUMNS, "\t"), COLUMNS, options, 349.0, str(path))
        recordings.append(table_recording(trial, name, analysis["trimmed_s"]))
    family = models.pop("family")
    chosen = options_of(FamilyOptions, models)

    def at(cutoff_hz):
        lowpass = Lowpass(cutoff_hz, analysis["lowpass_order"], analysis["zero_lag"])
        train, test = ([r.filtered(lowpass)] for r in recordings)
        scores, _ = calibrate(table_plan(family, "1", ["2"]), {"1": train}, {"2": test}, "load", chosen)
        return {score.model: score for score in scores}

    return at


@pytest.mark.slow
def test_published_figure_of_a_real_treadmill_is_reproduced_and_beaten(real_scores):
    found = real_scores(6)
    published = found["hnat2014"]
    # Hnat & van den Bogert (2014), slow trials: R2 0.7206, RMS 2.774 -> 1.460 Nm
    assert 0.720 < published.r2 < 0.721
    assert published.rms_before == pytest.approx(2.774, abs=1e-3)
    assert published.rms_after == pytest.approx(1.460, abs=1e-3)
    assert found["fir"].r2 >= 0.724
    assert found["ripple-tracking"].r2 >= 0.755
    assert published.r2_limit == pytest.approx(0.75, abs=0.005)
    assert_below_the_limit(found)
    assert found["ripple-tracking"].r2 > published.r2_limit  # ripple is not caused by acceleration


@pytest.mark.slow
def test_at_a_high_cutoff_the_real_treadmill_needs_more_than_two_poles(real_scores):
    found = real_scores(20)
    assert 0.54 < found["hnat2014"].r2 < 0.56
    assert found["fir"].r2 >= 0.615
    assert found["ripple-tracking"].r2 >= 0.67
    assert found["fir"].r2 - found["hnat2014"].r2 > 0.05
    assert_below_the_limit(found)


def assert_below_the_limit(found):
    assert set(ACCELERATION_ONLY) <= set(found)
    for name in ("mass-spring-damper", *ACCELERATION_ONLY):
        assert found[name].r2 < found[name].r2_limit, name
