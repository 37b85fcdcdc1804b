"""Beginnings of the fits, which refuse what the fits refuse, and rows of their results."""

import copy

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.experiments.position_manipulator import fit as position_manipulator
from tepsipe.experiments.weight import fit as weight
from tepsipe.experiments.weight.calibrate import PlateTrial
from tepsipe.experiments.wristalyzer import fit as wristalyzer
from tepsipe.treadmill.trial_recordings import plate_filters
from tests.builders import trial_of
from tests.treadmill.test_trial_recordings import WEIGHT, plate_trial
from workflow.settings.complete import settings_of


@pytest.fixture(scope="module")
def settings(shipped_config):
    return settings_of(shipped_config)


@pytest.fixture
def of_plate(settings):
    """Section of the weight, of a trial on the right belt; no perturbation is longer than 0.3 s."""
    analysis = copy.deepcopy(settings["weight"]["analysis"])
    analysis["window"] |= {"rest_before_s": 2.5, "rest_after_s": 4.0}
    return {"belt": "right", "weight": vars(WEIGHT), "analysis": analysis | {"segment_s": 0.3}}


def still(seconds, **units):
    return trial_of(250.0, **{name: (np.zeros(round(250 * seconds)), unit) for name, unit in units.items()})


@pytest.mark.parametrize(
    ("module", "name", "seconds", "sentence"),
    [
        (wristalyzer, "wristalyzer", 60.0, "expected a torque perturbation and a moving joint"),
        (position_manipulator, "position_manipulator", 5.0, "expected at least 4 blocks of"),
    ],
    ids=["wristalyzer", "position_manipulator"],
)
def test_beginning_refuses_by_the_sentence_of_the_fit(module, name, seconds, sentence, settings):
    trial, section = still(seconds, torque="Nm", angle="rad"), settings[name]
    before = copy.deepcopy(section)
    further = [settings["uncertainty"][name]] if name == "wristalyzer" else []
    with pytest.raises(InputError, match=f"^{sentence}"):
        module.begin(trial, section, name)
    with pytest.raises(InputError, match=f"^{sentence}"):
        module.fit(trial, section, "a", 1, *further)
    assert section == before


def test_a_weight_has_one_more_recording_than_filters(of_plate, settings):
    filters = [f"{lowpass.cutoff_hz:g} Hz" for lowpass in plate_filters(of_plate["analysis"])]
    trial, uncertainty = plate_trial(WEIGHT.mass_kg, lag_s=0.002), settings["uncertainty"]["weight"]
    fitted = weight.fit(trial, of_plate, "a", uncertainty)
    assert fitted.result.facts["filters"] == [*filters, "belt"]
    assert fitted.result.facts["marker_lag_s"] == pytest.approx(0.002, abs=1e-4)
    assert {(row.experiment, row.condition) for row in fitted.estimates} == {("weight", "a")}
    assert {row.quantity for row in fitted.contributions} == {"mass"}
    recording = weight.begin(trial, of_plate, "weight/a")
    stored = fitted.result.arrays[f"{filters[0]}/added_force"]
    assert np.array_equal(recording.segments(recording.load), stored)


def test_an_empty_belt_has_a_recording_of_each_filter_and_no_mass(of_plate, settings):
    section, uncertainty = of_plate | {"weight": None}, settings["uncertainty"]["weight"]
    fitted = weight.fit(plate_trial(0.0), section, "a", uncertainty)
    assert len(fitted.result.facts["filters"]) == len(of_plate["analysis"]["cutoffs_hz"])
    assert fitted.result.facts["marker_lag_s"] is None
    assert [row.quantity for row in fitted.estimates] == ["added_force_peak"]
    assert fitted.contributions == []


def test_a_trial_of_a_calibration_has_the_name_of_messages(of_plate):
    trial = PlateTrial("weight", "a", "calibrate", WEIGHT, plate_trial(WEIGHT.mass_kg))
    analysis = of_plate["analysis"] | {"segment_s": 60.0}
    with pytest.raises(InputError, match=r"^weight/a: expected 60 s between perturbations"):
        trial.recordings("right", analysis, plate_filters(analysis)[0])
    assert trial.at_rest("right", analysis).place.shape == (4, 2)
