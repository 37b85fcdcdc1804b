"""A person with one foot on each of two plates: torque of each leg, and their sum, of unequal legs."""

import copy
from dataclasses import replace

import ezc3d
import numpy as np
import pytest
from c3d_builders import single_c3d, single_c3d_settings

from tepsipe.arguments import options_of
from tepsipe.errors import InputError
from tepsipe.experiments.standing.epochs import cut_standing_epochs, epochs_of
from tepsipe.experiments.standing.fit import Plates, begin, fit
from tepsipe.experiments.standing.fit_task import fit as fit_task
from tepsipe.experiments.standing.free_reflex.legs import cut_with_legs, legs_of, legs_results
from tepsipe.experiments.standing.free_reflex.reflex import REFLEX
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.options import BOTH, EpochOptions, StandingOptions, TorquePathway
from tepsipe.ingest.agreement import sides_of_plates
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.plate_treadmill import ingest_treadmill_files
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.ingest.treadmill_options import RecordingOptions, TreadmillOptions
from tepsipe.ingest.whole_trial import ingest_recording, read_recording_files
from tepsipe.io.result import joined
from tepsipe.io.trial import recorded_faults
from tepsipe.signals.filters import Lowpass
from tepsipe.virtual_lab.person_mechanisms import without
from tepsipe.virtual_lab.standing_trial import make_standing_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol
from tests.experiments.test_standing_recovery import NO_BELT
from workflow.settings.complete import without as left_out
from workflow.support.rigs import RIG_KEYS

pytestmark = pytest.mark.slow

# the right leg is marked; it bears less of the weight and more of the torque
RIGHT_TORQUE, LEFT_WEIGHT = 0.6, 0.55
DURATION_S = 36.0
PATHWAY = {"ankle": TorquePathway("ankle", None)}


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
def files(truth, tmp_path_factory):
    """Files of trials of both directions of the belt."""
    found = {}
    for profile in ("sine", "negative-sine"):
        folder = tmp_path_factory.mktemp(profile)
        kinds = {"log": "mat", "calibration": "csv", "markers": "c3d", "emg": "edf"}
        found[profile] = {kind: folder / f"{kind}.{ending}" for kind, ending in kinds.items()}
        protocol = Protocol(profile, 0.4, (3.6, 3.8), DURATION_S)
        make_standing_trial(truth, profile, "relax", protocol, found[profile], BOTH)
    return found


@pytest.fixture(scope="module")
def trials(files, section):
    """These trials, read."""
    labels, options = section["files"]["marker_labels"], TreadmillOptions(**section["ingest"])
    return {
        profile: ingest_treadmill_files(paths, labels, options, DURATION_S, bridge_long_gaps=True)
        for profile, paths in files.items()
    }


@pytest.fixture(scope="module")
def alone(section):
    """The section of a study with one pathway, one estimator and no treadmill model."""
    changed = {
        "belt": BOTH,
        "analysis": section["analysis"] | {"bootstrap_draws": 100},
        "pathways": {"ankle": {"torque": "ankle", "treadmill_model": None}},
        "estimators": {"free": {"window_s": 0.06, "inertia": False, "active": "free"}},
        "recommended": {"pathway": "ankle", "estimator": "free"},
        "as_printed": "ankle",
    }
    return section | changed


@pytest.fixture(scope="module")
def fitted(trials, alone, shipped_config):
    """Fit of each trial."""
    sources = shipped_config["uncertainty"]["standing"]
    return {name: fit(trial, alone, name, 1, sources) for name, trial in trials.items()}


@pytest.fixture(scope="module")
def stored(fitted):
    """Responses of both trials, as the files of a study hold them."""
    return [of_trial.further["responses"] for of_trial in fitted.values()]


@pytest.fixture(scope="module")
def task(stored, alone, shipped_config):
    return fit_task(stored, alone, "relax", 1, shipped_config["uncertainty"]["standing"])


@pytest.fixture(scope="module")
def rows(task):
    """Quantity -> row of the task, of both legs and of each."""
    of_joint = {"B", "K"}
    legs = {f"{quantity}_{leg}" for quantity in of_joint for leg in ("left", "right")}
    assert {row.quantity for row in task.contributions} == of_joint | legs | set(REFLEX)
    found = {row.quantity: row for row in task.estimates}
    return found, {name: [found[name].value] for name in ("B", "K")}


def test_fits_of_trial_and_task_without_a_treadmill_model_quote_nothing(fitted, task):
    for of_trial in fitted.values():
        assert of_trial.result.facts["responses"] == epochs_of(of_trial.further["responses"]).count > 3
        assert not any(row.recommended for row in of_trial.estimates)
    assert task.result.facts["trials"] == 2
    assert {row.flags for row in task.estimates if row.quantity == "K"} == {"uncompensated"}


def test_beginning_without_plates_has_responses_and_no_torque(trials, alone):
    standing, responses = begin(trials["sine"], alone, "sine")
    assert standing.torque == {}
    again, same = begin(trials["sine"], alone, "sine", Plates())
    assert set(again.torque) == {"ankle"}
    assert same.onsets_s.tolist() == responses.onsets_s.tolist()


def test_plates_take_two_models_of_every_belt():
    fy, mx = ({"ideal": f"{load} of one", "other": 0} for load in ("Fy", "Mx"))
    assert Plates.of_belts(("left", "right"), [], []).named("ideal") == {"left": {}, "right": {}}
    plates = Plates.of_belts(("left", "right"), [fy, mx, fy, mx], [])
    of_belt = {"Fy": "Fy of one", "Mx": "Mx of one"}
    assert plates.named("ideal") == {"left": of_belt, "right": of_belt}
    assert plates.named(None) == {"left": {}, "right": {}}
    with pytest.raises(InputError, match="expected a treadmill model named 'none'"):
        plates.named("none")


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


# ---- left and right --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def on_both(section):
    """The person's feet, one on each belt, as ingest compares them with the signals."""
    return Rig(BOTH, belt_fixed=tuple(m["label"] for m in section["person"]["foot_markers"]), person=True)


@pytest.mark.parametrize(
    ("change", "exchanged", "words"),
    [
        (lambda force, moment, marker: None, False, "lies 22 cm to the left of the right plate's"),
        (
            lambda force, moment, marker: (
                np.copyto(force, force[:, ::-1]),
                np.copyto(moment, moment[:, ::-1]),
            ),
            True,
            "lies 22 cm to the right of the right plate's",
        ),
        (lambda force, moment, marker: np.multiply(moment, 0.4, moment), None, "are 9 cm apart"),
        (lambda force, moment, marker: np.add(marker, 0.4, marker), None, "lies 40 cm beside the foot"),
        (lambda force, moment, marker: np.multiply(force[:, 0], 0.0, force[:, 0]), None, "carries nothing"),
    ],
)
def test_plates_are_compared_with_the_sides_of_their_loads(
    change, exchanged, words, trials, on_both, shipped_config
):
    trial = trials["sine"]
    arrays = {name: trial.values(name).copy() for name in ("force", "moment", "marker_position")}
    change(*arrays.values())
    signals = {name: replace(trial.signals[name], values=x) for name, x in arrays.items()}
    changed = replace(trial, signals=trial.signals | signals)
    found = sides_of_plates(changed, on_both)
    assert found[0] is exchanged
    assert words in found[1]
    assert found[1].startswith("cannot be told: ") == (exchanged is None)
    limits = Limits(**left_out(shipped_config["plausible"], *RIG_KEYS))
    if exchanged is not None:
        kept = plausible_trial(changed, limits, on_both, {"log": "log.mat", "markers": "markers.c3d"})
        assert recorded_faults(kept) == ("plates-exchanged",) * exchanged
        assert kept.attributes["plate_sides"] == found[1]
    for belt in ("right", None):
        assert sides_of_plates(changed, replace(on_both, belt=belt)) == (None, "")


@pytest.mark.parametrize("exchanged", [False, True])
def test_channels_of_two_plates_that_are_exchanged_are_refused(exchanged, files, section, tmp_path):
    path = single_c3d(files["sine"], tmp_path / "both.c3d")
    if exchanged:
        file = ezc3d.c3d(str(path))
        numbers = file["parameters"]["FORCE_PLATFORM"]["CHANNEL"]
        numbers["value"] = np.array(numbers["value"])[:, ::-1]
        file.write(str(path))
    use = options_of(RecordingOptions, single_c3d_settings())
    labels, options = section["files"]["marker_labels"], TreadmillOptions(**section["ingest"])
    recording = read_recording_files({"log": str(path)}, ())
    if not exchanged:
        trial = ingest_recording(recording, labels, options, use, DURATION_S, bridge_long_gaps=True)
        assert trial.axes["belt"].tolist() == ["left", "right"]
        return
    with pytest.raises(
        InputError, match=r"both\.c3d, force plate 2: .* 0\.35 m to the right .* exchange those"
    ):
        ingest_recording(recording, labels, options, use, DURATION_S, bridge_long_gaps=True)
