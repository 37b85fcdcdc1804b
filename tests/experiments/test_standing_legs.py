"""A person with one foot on each of two plates: torque of each leg, and their sum, of unequal legs."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.experiments.standing.epochs import EpochOptions, cut_standing_epochs
from tepsipe.experiments.standing.free_reflex.fit import FreeReflexOptions
from tepsipe.experiments.standing.free_reflex.legs import cut_with_legs, leg_rows, legs_of, legs_results
from tepsipe.experiments.standing.free_reflex.results import FreeReflexChoices, fit_free
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.options import BOTH, StandingEstimator, StandingOptions, TorquePathway
from tepsipe.ingest.plate_treadmill import TreadmillOptions, ingest_treadmill_files
from tepsipe.io.result import joined
from tepsipe.signals.filters import Lowpass
from tepsipe.statistics.uncertainty import sources_of
from tepsipe.virtual_lab.person_mechanisms import without
from tepsipe.virtual_lab.standing_trial import make_standing_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol
from tests.experiments.test_standing_recovery import NO_BELT

pytestmark = pytest.mark.slow

# the right leg is marked; it bears less of the weight and more of the torque
RIGHT_TORQUE, LEFT_WEIGHT = 0.6, 0.55
DURATION_S = 36.0
PATHWAY = {"ankle": TorquePathway("ankle", None)}
ESTIMATORS = {"free": StandingEstimator(0.06, False, "free")}


@pytest.fixture(scope="module")
def section(shipped_config):
    from workflow.settings.complete import settings_of

    return settings_of(shipped_config)["standing"]


@pytest.fixture(scope="module")
def options(section):
    return StandingOptions.from_settings(section["person"], BOTH, section["analysis"], section["stance"])


@pytest.fixture(scope="module")
def truth(shipped_truth):
    changed = copy.deepcopy(shipped_truth)
    changed["treadmill"]["plate"] |= NO_BELT
    # another plate on the left: nothing of it may be taken for that of the right one
    changed["treadmill"]["left_plate"] = {"moment_scale": 1.0, "belt_lag_s": 0.012}
    changed["standing"] = without(changed["standing"])
    changed["standing"]["person"] |= {"marked_share": RIGHT_TORQUE, "left_share": LEFT_WEIGHT}
    return changed


@pytest.fixture(scope="module")
def trials(truth, section, tmp_path_factory):
    """Trials of both directions of the belt, made, written and read."""
    found = {}
    for profile in ("sine", "negative-sine"):
        folder = tmp_path_factory.mktemp(profile)
        kinds = {"log": "mat", "calibration": "csv", "markers": "c3d", "emg": "edf"}
        files = {kind: folder / f"{kind}.{ending}" for kind, ending in kinds.items()}
        protocol = Protocol(profile, 0.4, (3.6, 3.8), DURATION_S)
        make_standing_trial(truth, profile, "relax", protocol, files, BOTH)
        found[profile] = ingest_treadmill_files(
            files,
            section["files"]["marker_labels"],
            TreadmillOptions(**section["ingest"]),
            DURATION_S,
            bridge_long_gaps=True,
        )
    return found


@pytest.fixture(scope="module")
def stored(trials, section, options):
    """Both trials as the files of a study hold them."""
    analysis = section["analysis"]
    cutting = EpochOptions.from_settings(analysis, section["emg"], section["ingest"]["max_gap_s"])
    found = []
    for name, trial in trials.items():
        standing = process_standing(trial, name, options, PATHWAY, {})
        assert standing.fault is None
        epochs = cut_standing_epochs(standing, cutting)
        lowpass = Lowpass(60.0, analysis["lowpass_order"], True)
        cut = cut_with_legs(standing, epochs, options, cutting, lowpass, {}, {}, 0.06)
        found.append(joined(*legs_results([cut])))
    return found


@pytest.fixture(scope="module")
def rows(stored, section, shipped_config):
    """Quantity -> row of the task, of both legs and of each."""
    choices = FreeReflexChoices(
        "ankle",
        FreeReflexOptions(**section["free_reflex"]),
        sources_of(shipped_config["uncertainty"]["standing"]),
        100,
        1,
    )
    whole, legs = legs_of(stored)
    fit = fit_free(whole, "relax", ESTIMATORS, choices, 14)["ankle", "free"]
    found, budgets = leg_rows("relax", legs, "relax", ESTIMATORS, choices, 14)
    assert {quantity for of_leg in budgets for quantity in of_leg.quantities} == {
        "B_left",
        "K_left",
        "B_right",
        "K_right",
    }
    return {row.quantity: row for row in found}, {name: fit.interval(name) for name in ("B", "K")}


def test_torque_of_both_legs_is_that_of_their_sum(truth, rows):
    """K and B of both legs are known to 4 %, as with both feet on one plate."""
    constants, (_, whole) = truth["standing"]["tasks"]["relax"], rows
    assert whole["K"][0] == pytest.approx(constants["stiffness_Nm_per_rad"][0], rel=0.04)
    assert whole["B"][0] == pytest.approx(constants["damping_Nms_per_rad"][0], rel=0.04)


@pytest.mark.parametrize("quantity", ["B", "K"])
def test_each_leg_has_its_part_of_the_torque_not_of_the_weight(quantity, rows):
    legs, whole = rows
    left, right = legs[f"{quantity}_left"], legs[f"{quantity}_right"]
    assert left.value + right.value == pytest.approx(whole[quantity][0], rel=0.02)
    assert right.value / (left.value + right.value) == pytest.approx(RIGHT_TORQUE, abs=0.01)
    assert left.ci_low < (1.0 - RIGHT_TORQUE) * whole[quantity][0] < left.ci_high
    assert 0.0 < left.u_type_a < 0.1 * left.value
    # of the feet's weight each leg has half
    assert legs["weight_share_left"].value == pytest.approx(LEFT_WEIGHT, abs=0.005)
    assert not any(row.recommended for row in legs.values())


def test_a_person_on_one_plate_has_no_legs_of_their_own(trials, section, options):
    """Epochs of a person on one plate, whichever its belt is, are read again as those of both legs."""
    cutting = EpochOptions.from_settings(section["analysis"], section["emg"], section["ingest"]["max_gap_s"])
    standing = process_standing(trials["sine"], "sine", options, PATHWAY, {})
    epochs = cut_standing_epochs(standing, cutting)
    lowpass = Lowpass(60.0, section["analysis"]["lowpass_order"], True)
    cut = cut_with_legs(standing, epochs, options.of_leg("right"), cutting, lowpass, {}, {}, 0.06)
    whole, legs = legs_of([joined(*legs_results([cut]))])
    assert len(whole) == 1
    assert legs == {}


def test_epochs_of_the_legs_add_up(stored):
    whole, legs = legs_of(stored)
    for k, both in enumerate(whole):
        parts = [legs[leg][k] for leg in ("left", "right")]
        total = sum(part.perturbed[..., 0] for part in parts)
        assert np.allclose(total, both.perturbed[..., 0], atol=2e-3)
        assert sum(part.carried_kg for part in parts) == pytest.approx(both.carried_kg, rel=1e-6)
        assert all(np.array_equal(part.perturbed[..., 1:], both.perturbed[..., 1:]) for part in parts)


def test_feet_on_two_belts_are_no_step_and_one_belt_is_not_enough(trials, options):
    trial = trials["sine"]
    one = replace(options, belt="right")
    with pytest.raises(InputError, match="expected about 64 kg on the right belt, found 2"):
        process_standing(trial, "one", one, PATHWAY, {})
    right = replace(trial, axes=trial.axes | {"belt": np.array(["right", "other"])})
    with pytest.raises(InputError, match="expected forces of the belt 'left'"):
        process_standing(right, "missing", options, PATHWAY, {})
