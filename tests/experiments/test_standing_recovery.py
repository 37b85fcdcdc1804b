"""The laboratory's standing person, through files and on a plate without belt: impedance and latencies.

The person is the one that the analysis assumes, without the mechanisms that violate its assumptions.
"""

import copy
from dataclasses import replace

import numpy as np
import pytest

from tepsipe.experiments.standing.epochs import cut_standing_epochs
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.muscle_torque import ActiveOptions
from tepsipe.experiments.standing.options import (
    EpochOptions,
    StandingEstimator,
    StandingOptions,
    TorquePathway,
)
from tepsipe.experiments.standing.thesis.impedance import fit_all
from tepsipe.experiments.standing.thesis.latency import muscle_latency
from tepsipe.ingest.standing import ingest_standing_files
from tepsipe.ingest.treadmill_options import TreadmillOptions
from tepsipe.signals.onsets import OnsetOptions
from tepsipe.virtual_lab.person_mechanisms import without
from tepsipe.virtual_lab.standing_trial import make_standing_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol

pytestmark = pytest.mark.slow

DURATION_S = 36.0
TRIALS = (("sine", 0.4), ("sine", 0.5), ("negative-sine", 0.4), ("negative-sine", 0.5))
INTERVAL_S = (3.6, 3.8)
# a plate that feels nothing but the feet
NO_BELT = dict.fromkeys(
    (
        "felt_belt_mass_kg",
        "felt_roller_inertia_kgm",
        "friction_N",
        "friction_coefficient",
        "friction_Ns_per_m",
        "floor_m_per_s2",
        "mount_share",
    ),
    0.0,
) | {"resonance_hz": 2000.0, "second_share": [0.0, 0.0]}
PATHWAYS = {name: TorquePathway(name, None) for name in ("ankle", "ankle-thesis", "single-joint")}


@pytest.fixture(scope="module")
def choices(shipped_config):
    """The section of the standing person, and the library's options that its scripts make of it."""
    from workflow.settings.complete import settings_of

    section = settings_of(shipped_config)["standing"]
    analysis = section["analysis"]
    standing = StandingOptions.from_settings(section["person"], section["belt"], analysis, section["stance"])
    cutting = EpochOptions.from_settings(analysis, section["emg"], section["ingest"]["max_gap_s"])
    active = ActiveOptions.from_settings(section["active"], section["muscles"])
    estimators = {name: StandingEstimator(**choice) for name, choice in section["estimators"].items()}
    return section, standing, cutting, estimators, active


@pytest.fixture(scope="module")
def truth(shipped_truth):
    changed = copy.deepcopy(shipped_truth)
    assert NO_BELT.keys() <= changed["treadmill"]["plate"].keys()
    changed["treadmill"]["plate"] |= NO_BELT
    changed["standing"] = without(changed["standing"])
    return changed


@pytest.fixture(scope="module")
def responses(truth, choices, tmp_path_factory):
    """Task -> responses of its trials, made, written, read and processed."""
    section, standing, cutting, *_ = choices
    channels = {muscle: choice["channel"] for muscle, choice in section["muscles"].items()}
    found = {}
    for task in ("relax", "stiff"):
        found[task] = []
        for profile, amplitude in TRIALS:
            name = f"{task}-{profile}-{amplitude}"
            folder = tmp_path_factory.mktemp(name)
            kinds = {"log": "mat", "calibration": "csv", "markers": "c3d", "emg": "edf"}
            files = {kind: folder / f"{kind}.{ending}" for kind, ending in kinds.items()}
            protocol = Protocol(profile, amplitude, INTERVAL_S, DURATION_S)
            make_standing_trial(truth, name, task, protocol, files)
            trial = ingest_standing_files(
                files,
                section["files"]["marker_labels"],
                channels,
                section["files"]["emg_trigger"],
                section["files"]["emg_trigger_threshold"],
                TreadmillOptions(**section["ingest"]),
                DURATION_S,
            )
            processed = process_standing(trial, name, standing, PATHWAYS, {})
            assert processed.fault is None
            found[task].append(cut_standing_epochs(processed, cutting))
    return found


@pytest.fixture(scope="module")
def fits(responses, choices):
    *_, estimators, active = choices
    return {
        task: fit_all(trials, task, list(PATHWAYS), estimators, active, 200, 1)[0]
        for task, trials in responses.items()
    }


TASKS = ("relax", "stiff")


@pytest.mark.parametrize("task", TASKS)
def test_stiffness_before_the_reflex_is_the_persons(task, fits, truth):
    constants = truth["standing"]["tasks"][task]
    fit = fits[task]["ankle", "pre-reflex-window"]
    stiffness = fit.quantities["K"]
    value, error, low, high = stiffness.value, stiffness.standard_error, stiffness.low, stiffness.high
    assert value == pytest.approx(constants["stiffness_Nm_per_rad"][0], rel=0.1)
    assert low < value < high
    assert 0.0 < error < 0.05 * value
    damping = fit.quantities["B"].value
    assert damping == pytest.approx(constants["damping_Nms_per_rad"][0], rel=0.1)


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("estimator", ["delayed-reflex", "emg-driven"])
def test_muscles_torque_that_is_told_apart_leaves_the_same_stiffness(estimator, task, fits, truth):
    stiffness = truth["standing"]["tasks"][task]["stiffness_Nm_per_rad"][0]
    assert fits[task]["ankle", estimator].quantities["K"].value == pytest.approx(stiffness, rel=0.15)


@pytest.mark.parametrize("task", TASKS)
def test_other_ways_miss_the_stiffness(task, fits, truth):
    stiffness = truth["standing"]["tasks"][task]["stiffness_Nm_per_rad"][0]
    # no reflex in the model; no vertical force in the torque; no knee and hip in the body
    for pathway, estimator in (
        ("ankle", "long"),
        ("ankle-thesis", "pre-reflex-window"),
        ("single-joint", "pre-reflex-window"),
    ):
        value = fits[task][pathway, estimator].quantities["K"].value
        assert abs(value - stiffness) > 0.2 * stiffness, (pathway, estimator, value)


@pytest.mark.parametrize("task", TASKS)
def test_every_muscles_latency_is_the_persons(task, responses, choices, truth):
    section = choices[0]
    latency = section["latency"]
    options = OnsetOptions(**latency)
    for muscle, choice in section["muscles"].items():
        rng = np.random.default_rng(1)
        found = muscle_latency(responses[task], muscle, choice["lengthened_by"], options, rng)
        onset = found.onsets[latency["detector"]]
        true = truth["standing"]["muscles"][muscle]["latency_s"]
        assert onset.latency_s == pytest.approx(true, abs=0.005), muscle
        assert onset.interval_s[0] - 0.003 < true < onset.interval_s[1] + 0.003, muscle


def test_hardly_anything_is_left_out_of_quiet_standing(responses, choices):
    for trials in responses.values():
        for found in trials:
            assert found.muscles == tuple(choices[0]["muscles"])
            assert found.count >= 6
            assert found.usable.all()
            # an occlusion may fall into a pulse
            assert all("was hidden while the belt moved" in said for said in found.left_out)


def test_stiffness_does_not_depend_on_another_seed_or_pathway(responses, choices, fits):
    *_, estimators, active = choices
    short = {"pre-reflex-window": estimators["pre-reflex-window"]}
    again = fit_all(responses["relax"], "relax", ["ankle"], short, active, 200, 1)[0]
    key = ("ankle", "pre-reflex-window")
    assert again[key].quantities == fits["relax"][key].quantities
    other = fit_all(responses["relax"], "relax", ["ankle"], short, active, 200, 2)[0]
    assert other[key].quantities["K"].value == fits["relax"][key].quantities["K"].value


def test_trials_one_by_one_agree_with_all_together(responses, choices, fits):
    *_, estimators, active = choices
    short = {"pre-reflex-window": replace(estimators["pre-reflex-window"])}
    together = fits["stiff"]["ankle", "pre-reflex-window"].quantities["K"].value
    for trial in responses["stiff"]:
        alone = fit_all([trial], "one", ["ankle"], short, active, 200, 1)[0]["ankle", "pre-reflex-window"]
        q = alone.quantities["K"]
        assert q.value == pytest.approx(together, abs=4.0 * q.standard_error)
