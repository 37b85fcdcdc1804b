"""Compensated loads and their draws: what an error of the calibration does to the load on the belt."""

from dataclasses import replace

import numpy as np
import pytest
from belt_builders import belt_recording
from builders import assert_one_sentence, belt_pulses

from tepsipe.errors import InputError
from tepsipe.treadmill.compensation import compensated_draws, compensated_loads
from tepsipe.treadmill.mass_models import LoadedFrame
from tepsipe.treadmill.registry import FittedModel, load_treadmill_models, save_models

RATE_HZ = 250.0
FRAME = np.array([4e-4, 4e-5, 2.5e-7])


def model(unit, motion, deviations=None):
    frame = LoadedFrame(FRAME, np.array(motion), 0.004, 0.15, 0.06, 0.1, RATE_HZ)
    return FittedModel("loaded-frame", frame, unit, None, ("weight/sine-0.3",), deviations)


@pytest.fixture
def recordings():
    time = np.arange(1500) / RATE_HZ
    _, v, a = belt_pulses(time, (1.0, 3.0), 0.3)
    load = 30.0 * np.exp(-0.5 * ((time - 1.05) / 0.03) ** 2)
    return {
        component: belt_recording(v, a, load, rate_hz=RATE_HZ, unit=unit, carried_kg=20.0)
        for component, unit in (("Fy", "N"), ("Mx", "Nm"))
    }


def test_draws_are_the_loads_of_models_with_the_drawn_constants(recordings, rng):
    spread = np.array([2e-5, 1e-6, 1e-8, 0.02, 0.1, 0.1, 0.005, 1e-5, 1e-3, 1e-3, 1e-3])
    models = {
        "Fy": model("N", [4.0, 9.0, 6.0, 0.5], spread * rng.standard_normal((30, 11))),
        "Mx": model("Nm", [-0.8, 1.5, 0.0, 0.0], 0.1 * spread * rng.standard_normal((30, 11))),
    }
    best, drawn = compensated_loads(models, recordings), compensated_draws(models, recordings)
    for component, fitted in models.items():
        assert drawn[component].shape == (30, 1500)
        for k in (0, 17):
            other = replace(fitted, model=fitted.model.moved(fitted.deviations[k]))
            change = other.compensate(recordings[component]) - best[component]
            assert drawn[component][k] - best[component] == pytest.approx(
                change, abs=0.05 * np.abs(change).max()
            )


def test_models_without_draws_give_none(recordings):
    models = {"Fy": model("N", [4.0, 9.0, 6.0, 0.5]), "Mx": model("Nm", [-0.8, 1.5, 0.0, 0.0])}
    assert compensated_draws(models, recordings)["Fy"].shape == (0, 1500)


def test_a_component_without_a_model_is_named(recordings):
    with pytest.raises(InputError) as error:
        compensated_loads({"Fy": model("N", [4.0, 9.0, 6.0, 0.5])}, recordings)
    assert_one_sentence(error, "trial 1", "Mx", "Fy")


def test_draws_are_stored_with_the_model(tmp_path, rng):
    kept = model("N", [4.0, 9.0, 6.0, 0.5], rng.standard_normal((5, 11)))
    save_models(tmp_path / "models.json", [kept])
    found = load_treadmill_models(tmp_path / "models.json")["loaded-frame"]
    assert np.array_equal(found.deviations, kept.deviations)
