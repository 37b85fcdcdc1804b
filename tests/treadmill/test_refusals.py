"""What once went wrong in the treadmill models: numbers off, or wrong input taken."""

from dataclasses import replace

import numpy as np
import pytest
from belt_builders import OPTIONS, belt_recording, pulsed_evaluated, restless_belt, swaying_belt

from tepsipe.errors import InputError
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.time_alignment import marker_delay
from tepsipe.treadmill.calibration import MODEL_SCORES, ModelScore, coherence_limit
from tepsipe.treadmill.mass_models import fit_mean_subtraction
from tepsipe.treadmill.recording import check_recordings
from tepsipe.treadmill.registry import evaluate, fit_model, load_treadmill_models


@pytest.mark.slow
def test_noise_without_ripple_has_no_orders():
    spurious = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        r = swaying_belt(lambda x, v, a, rng=rng: 3.0 * a + 2.0 * rng.standard_normal(a.size), rng)
        spurious += fit_model("ripple-tracking", [r], OPTIONS).model.orders_per_m.tolist()
    assert spurious == []


def test_ripple_tracker_refuses_a_load_in_another_unit(rng):
    def load(x, v, a):
        return 3.0 * a + 4.0 * np.cos(2.0 * np.pi * 1.7 * x) + 0.5 * rng.standard_normal(a.size)

    train, test = (swaying_belt(load, rng) for _ in range(2))
    fitted = fit_model("ripple-tracking", [train], OPTIONS)
    with pytest.raises(InputError, match=r"trial 1: expected .*load"):
        evaluate(fitted, [replace(test, load=1e3 * test.load)])


def test_mass_damper_spring_come_back_from_filtered_signals(rng):
    def load(x, v, a):
        along = np.arange(x.size)
        return 3.0 * a + 7.0 * (v - v.mean()) + 40.0 * (x - np.polyval(np.polyfit(along, x, 1), along))

    r = swaying_belt(load, rng).filtered(Lowpass(6.0, 2, False))
    r = replace(r, evaluated=(np.arange(r.load.size) > 200) & (np.arange(r.load.size) < r.load.size - 200))
    fitted = fit_model("mass-spring-damper", [r], OPTIONS)
    assert fitted.model.coefficients[:3] == pytest.approx([3.0, 7.0, 40.0], rel=0.05)


def test_marker_that_never_moves_is_refused():
    time = np.arange(1000) / 250.0
    velocity = np.exp(-(((time - 2.0) / 0.03) ** 2))
    with pytest.raises(InputError, match="trial: expected a marker and a belt that move"):
        marker_delay(time, np.ones(1000), velocity, "trial")


def test_mean_of_two_recordings_of_one_condition():
    evaluated = pulsed_evaluated(1000, (100,), 50)
    load = np.where(evaluated, 1.0, 0.0)
    first = belt_recording(load, load, load, onsets=(100,), evaluated=evaluated)
    second = replace(first, load=3.0 * load)
    assert fit_mean_subtraction([first, second]).templates["random"] == pytest.approx(np.full(50, 2.0))


def test_segments_that_touch():
    x = np.arange(1000.0)
    r = belt_recording(x, x, x, onsets=(100, 150, 200), evaluated=pulsed_evaluated(1000, (100, 150, 200), 50))
    assert r.segments(x).shape == (3, 50)


@pytest.mark.parametrize(
    "text",
    [
        '{"models": [1]}',
        '{"models": [{"kind": "dict", "values": {}}]}',
        '{"format": "other 2", "models": []}',
    ],
)
def test_readable_json_that_holds_no_models(text, tmp_path):
    (tmp_path / "m.json").write_text(text)
    with pytest.raises(InputError, match=r"m\.json: expected a file of treadmill models"):
        load_treadmill_models(tmp_path / "m.json")


@pytest.mark.parametrize("key", ["load", "acceleration", "velocity"])
def test_missing_sample_is_refused(key, rng):
    r = restless_belt(lambda v, a: 3.0 * a, rng)
    x = getattr(r, key).copy()
    x[1000] = np.nan
    with pytest.raises(InputError, match=f"trial 1: expected numbers for {key}"):
        check_recordings([replace(r, **{key: x})], 20.0)


def test_limit_of_unrelated_perturbations_is_about_nothing():
    found = []
    for seed in range(50):
        rng = np.random.default_rng(seed)
        a, load = rng.standard_normal((2, 2000))
        onsets = tuple(range(100, 1900, 180))
        r = belt_recording(a, a, load, onsets=onsets, evaluated=pulsed_evaluated(2000, onsets, 75))
        found.append(coherence_limit([r], 1.0))
    assert np.mean(found) < 0.01, np.mean(found)


@pytest.mark.parametrize("change", [("0.75", "much"), (",load,Nm", ""), (",Nm", ",Nm,more")])
def test_damaged_table_of_scores(change, tmp_path):
    path = tmp_path / "s.csv"
    MODEL_SCORES.write(path, [ModelScore("fir", "a", "b", 6.0, 0.5, 2.0, 1.0, 51, 0.75, "load", "Nm")])
    head, row = path.read_text().splitlines()
    path.write_text(f"{head}\n{row.replace(*change)}\n")
    with pytest.raises(InputError, match=r"s\.csv: expected "):
        MODEL_SCORES.read(path)


def test_time_is_counted_together_as_documented(rng):
    both = [restless_belt(lambda v, a: 3.0 * a, rng, 15.0) for _ in range(2)]
    check_recordings(both, 20.0)
