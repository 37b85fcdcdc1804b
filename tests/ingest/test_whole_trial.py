"""One C3D gives the parameters of the same trial from log, calibration matrix, markers and EDF."""

from dataclasses import replace

import ezc3d
import numpy as np
import pytest
from builders import DUMMY_DURATION_S, assert_one_sentence
from c3d_builders import single_c3d, single_c3d_settings
from standing_builders import CUTTING, OPTIONS

from tepsipe.arguments import options_of
from tepsipe.errors import InputError
from tepsipe.experiments.dummy.foot_pathways import FootOptions, analyse_foot
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, analyse_dummy
from tepsipe.experiments.dummy.options import FootPathway, Pathway
from tepsipe.experiments.standing.epochs import cut_standing_epochs
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.muscle_torque import ActiveOptions
from tepsipe.experiments.standing.options import StandingEstimator, TorquePathway
from tepsipe.experiments.standing.thesis.impedance import fit_all
from tepsipe.experiments.standing.thesis.latency import muscle_latency
from tepsipe.experiments.weight.analysis import estimate_masses
from tepsipe.ingest.plate_treadmill import ingest_treadmill_files
from tepsipe.ingest.standing import ingest_standing_files, with_recorded_emg
from tepsipe.ingest.treadmill_options import (
    Axes,
    BeltVelocity,
    LoadCell,
    LoadCells,
    PlateNumbers,
    RecordingOptions,
    ScaledChannel,
    TreadmillOptions,
)
from tepsipe.ingest.whole_trial import ingest_recording, ingest_recording_files
from tepsipe.io.formats import read_recording
from tepsipe.io.readers.recording import Channel, ForcePlate
from tepsipe.io.trial import recorded_faults
from tepsipe.mechanics.inverse_dynamics import Foot
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.onsets import OnsetOptions
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.registry import FamilyOptions, fit_model
from tepsipe.treadmill.trial_recordings import PlateOptions, plate_recordings
from tepsipe.virtual_lab.standing_trial import make_standing_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol
from tepsipe.virtual_lab.weight_trial import make_weight_trial

BELT = BeltVelocity("Belt speed", 0.5, 2.5)
USE = RecordingOptions(plates=PlateNumbers((1,), (2,)), belt_velocity=BELT)
FIXED = ("foot1", "foot2", "foot3", "ankle")
LATENCY_S = 0.0008  # of the laboratory's cameras
LOWPASS = Lowpass(20.0, 4, True)


@pytest.fixture(scope="module")
def options(shipped_config):
    return TreadmillOptions(**shipped_config["dummy"]["ingest"], resample_rate_hz=250.0)


@pytest.fixture(scope="module")
def labels(shipped_config):
    return shipped_config["dummy"]["files"]["marker_labels"]


@pytest.fixture(scope="module")
def one_file(dummy_files, tmp_path_factory):
    return single_c3d(dummy_files, tmp_path_factory.mktemp("one") / "dummy.c3d")


@pytest.fixture(scope="module")
def recording(one_file):
    return read_recording(one_file)


@pytest.fixture(scope="module")
def ingested(dummy_files, one_file, options, labels):
    """The dummy's trial from three files, and from one."""
    files = {"log": str(one_file)}
    return (
        ingest_treadmill_files(dummy_files, labels, options, DUMMY_DURATION_S),
        ingest_recording_files(files, labels, options, USE, DUMMY_DURATION_S),
    )


@pytest.fixture(scope="module")
def dummy(shipped_config):
    """Options of the dummy's analysis, with the rests of the short laboratory."""
    from workflow.settings.complete import settings_of

    section = settings_of(shipped_config)["dummy"]
    analysis = section["analysis"] | {"rest_before_s": 2.0, "rest_after_s": 3.0}
    analysis.pop("bootstrap_draws")
    geometry = section["geometry"]
    foot = FootOptions(Foot(geometry["foot_mass_kg"], geometry["foot_height_m"]), "ankle", FIXED, "right")
    return DummyOptions.from_settings(geometry, analysis, FIXED), foot


def leg(trial, dummy):
    """B and K by windowed least squares and by output error."""
    pathways = {
        "leg": Pathway("leg", "aligned", "windowed-least-squares"),
        "error": Pathway("leg", "aligned", "output-error"),
    }
    found = analyse_dummy(trial, dummy[0], pathways).regressions
    return np.concatenate([found[name].mean[1:] for name in pathways])


def assert_same_joint(found, expected, stiffness_rel, delays_s):
    """Stiffness agrees; damping agrees but for K times a delay, by which a late angle changes it."""
    assert found[[1, 3]] == pytest.approx(expected[[1, 3]], rel=stiffness_rel)
    assert (np.abs(found - expected)[[0, 2]] < expected[[1, 3]] * delays_s).all()


# ---- the same parameters ---------------------------------------------------------------------------


def test_signals_of_one_file_are_those_of_three(ingested):
    several, one = ingested
    assert (several.time == one.time).all()
    for name, signal in one.signals.items():
        other = several.values(name).astype(float)
        assert signal.unit == several.signals[name].unit
        assert signal.axes == several.signals[name].axes
        inner = slice(50, -50)  # the log goes on before and after the trial, the file does not
        assert np.abs(signal.values - other)[inner].max() <= 2e-4 * np.abs(other).max(), name
    assert "belt_command" not in one.signals
    assert one.attributes["hidden_samples"] == several.attributes["hidden_samples"]


def test_leg_from_one_file(ingested, dummy):
    several, one = (leg(trial, dummy) for trial in ingested)
    assert_same_joint(one, several, stiffness_rel=1e-4, delays_s=(2e-6, 2e-6))


def test_leg_is_the_laboratorys(ingested, dummy, true_joint, short_truth):
    """In the windows the linear joint nearest to the rubber, over the whole trial that of small bending."""
    rubber = short_truth["dummy"]["rubber"]
    expected = [true_joint["K"], rubber["stiffness_Nm_per_rad"]]
    found = leg(ingested[0], dummy)
    assert found[[1, 3]] == pytest.approx(expected, rel=0.02)
    assert found[[0, 2]] == pytest.approx([true_joint["B"], rubber["damping_Nms_per_rad"]], abs=0.004)


def test_belt_velocity_from_markers(one_file, options, labels, ingested, dummy):
    """On the exact clock of the frames, and without a channel of the belt velocity."""
    use = replace(USE, belt_velocity=BeltVelocity(markers=FIXED))
    trial = ingest_recording_files({"log": str(one_file)}, labels, options, use, DUMMY_DURATION_S)
    found, expected = leg(trial, dummy), leg(ingested[0], dummy)
    # the instruments of the output error now have the noise of the markers
    assert_same_joint(found, expected, stiffness_rel=0.01, delays_s=(5e-5, 2.5e-4))
    smooth, measured = (LOWPASS(t.values("belt_velocity"), 250.0) for t in (trial, ingested[1]))
    assert smooth.max() == pytest.approx(measured.max(), rel=0.01)
    assert smooth.min() == pytest.approx(measured.min(), rel=0.01)
    assert "cannot show a delay" in trial.attributes["belt_velocity_from"]
    processing = trial.signals["belt_velocity"].processing
    assert "foot1, foot2, foot3, ankle" in "; ".join(processing)
    assert "low-pass filtered at 50 Hz" in processing


def test_markers_on_an_empty_belt_give_its_velocity_only(recording, ingested):
    options = TreadmillOptions(250.0, None, None, 2.5)
    use = replace(USE, belt_velocity=BeltVelocity(markers=FIXED[:3]))
    trial = ingest_recording(recording, None, options, use, DUMMY_DURATION_S)
    assert "marker" not in trial.axes
    assert not [name for name in trial.signals if name.startswith("marker")]
    smooth, measured = (LOWPASS(t.values("belt_velocity"), 250.0) for t in (trial, ingested[1]))
    # on this clock the cameras are 0.8 ms late, and sequential sampling, not corrected here, adds 0.4 ms
    assert np.abs(smooth - measured).max() < 0.08 * np.abs(measured).max()
    # the noise of the first and the last sample does not tilt the ends
    assert np.abs(smooth[[0, -1]]).max() < 0.005


@pytest.mark.slow
def test_frames_on_the_exact_clock_of_the_channels(dummy_files, options, labels, ingested, dummy, tmp_path):
    path = single_c3d(dummy_files, tmp_path / "exact.c3d", latency_s=LATENCY_S)
    trial = ingest_recording_files({"log": str(path)}, labels, options, USE, DUMMY_DURATION_S)
    assert_same_joint(leg(trial, dummy), leg(ingested[0], dummy), stiffness_rel=0.01, delays_s=(5e-5, 2.5e-4))


@pytest.fixture(scope="module")
def loads(short_truth, shipped_config, tmp_path_factory):
    """Recordings of the weight and of the empty belt, from several files and from one."""
    window = WindowOptions(**shipped_config["weight"]["analysis"]["window"])
    window = replace(window, rest_before_s=2.0, rest_after_s=2.0)
    plate = PlateOptions("right", LOWPASS, LOWPASS, window, 0.3)
    weight = Weight(**shipped_config["weight"]["weight"])
    labels = shipped_config["weight"]["files"]["marker_labels"]
    truth = short_truth | {
        "treadmill": short_truth["treadmill"]
        | {"protocol": short_truth["treadmill"]["protocol"] | {"rest_after_weight_s": 2.0}}
    }
    found = ([], [])
    for experiment, marked in (("empty", None), ("weight", labels)):
        folder = tmp_path_factory.mktemp(experiment)
        files = {"log": folder / "log.mat", "calibration": folder / "calibration.csv"}
        files |= {} if marked is None else {"markers": folder / "markers.c3d"}
        make_weight_trial(truth, "sine-0.5", Protocol("sine", 0.5, 2.0, 14.0), files)
        path = single_c3d(files, folder / "one.c3d", duration_s=14.0)
        gaps = (None, None) if marked is None else (0.1, 2500.0)
        options = TreadmillOptions(250.0, *gaps, 2.5)
        trials = (
            ingest_treadmill_files(files, marked, options, 14.0),
            ingest_recording_files({"log": path}, marked, options, USE, 14.0),
        )
        for trial, recordings in zip(trials, found, strict=True):
            carried = None if marked is None else weight
            recordings.append(plate_recordings(trial, experiment, "sine-0.5", plate, carried))
    return found


@pytest.mark.slow
def test_mass_of_the_weight_from_one_file(loads):
    several, one = (estimate_masses(recordings[1]["Fy"]) for recordings in loads)
    assert one == pytest.approx(several, rel=1e-3)


def test_compensated_foot_from_one_file(ingested, loads, dummy):
    """The torque is a small difference of large loads, after subtraction of what the treadmill adds."""
    family = FamilyOptions(0.5, 100, 3, 0.04, 0.04, 0.512)
    pathway = {"foot": FootPathway("foot", "loaded-frame", 2.0, "windowed-least-squares")}
    found = []
    for trial, recordings in zip(ingested, loads, strict=True):
        moment = fit_model("loaded-frame", [r["Mx"] for r in recordings], family)
        force = fit_model("loaded-frame", [r["Fy"] for r in recordings], family)
        models = {"Fy": {"loaded-frame": force}, "Mx": {"loaded-frame": moment}}
        found.append(analyse_foot(trial, "dummy", *dummy, pathway, models).regressions["foot"].mean[1:])
    assert found[1] == pytest.approx(found[0], rel=0.01)
    assert found[0][1] == pytest.approx(10.0, rel=0.3)


@pytest.mark.slow
def test_standing_person_from_one_file(short_truth, shipped_config, tmp_path):
    kinds = {"log": "log.mat", "calibration": "calibration.csv", "markers": "markers.c3d", "emg": "emg.edf"}
    files = {kind: tmp_path / name for kind, name in kinds.items()}
    make_standing_trial(short_truth, "relax", "relax", Protocol("sine", 0.5, (3.0, 3.2), 32.0), files)
    section = shipped_config["standing"]
    channels = {muscle: choice["channel"] for muscle, choice in section["muscles"].items()}
    labels = section["files"]["marker_labels"]
    path = single_c3d(files, tmp_path / "one.c3d", list(channels.values()), analog_rate_hz=2000.0)
    ingest = TreadmillOptions(**section["ingest"], resample_rate_hz=250.0)
    standing = replace(OPTIONS, window=replace(OPTIONS.window, rest_before_s=2.0, rest_after_s=2.0))
    trials = [
        ingest_standing_files(given, labels, channels, "Trigger", 2.5, ingest, 32.0, USE)
        for given in (files, {"log": path})
    ]
    responses = [
        cut_standing_epochs(
            process_standing(t, "t", standing, {"a": TorquePathway("ankle", None)}, {}), CUTTING
        )
        for t in trials
    ]
    estimator = {"short": StandingEstimator(0.06, False, "none")}
    fits = [fit_all([r], "t", ["a"], estimator, ActiveOptions((), (), (), {}), 20, 1)[0] for r in responses]
    for name in "BK":
        several, one = (found["a", "short"].quantities[name].value for found in fits)
        assert one == pytest.approx(several, rel=0.01)
    search = OnsetOptions(**section["latency"])
    compared = 0
    for muscle, choice in section["muscles"].items():
        several, one = (
            muscle_latency([r], muscle, choice["lengthened_by"], search, np.random.default_rng(1))
            for r in responses
        )
        if isinstance(several, str):  # not stretched first by this pulse
            assert one == several
            continue
        for detector, onset in several.onsets.items():
            compared += 1
            assert one.onsets[detector].latency_s == pytest.approx(onset.latency_s, abs=0.001)
    assert compared >= 6
    assert trials[1].attributes["emg_missing"] == ""
    assert trials[1].attributes["emg_rate_hz"] == 2000.0


# ---- axes, plates, load cells, trigger -----------------------------------------------------------


def turned(recording, rotation, shift):
    """The recording in other axes p' = R p + shift."""

    def plate(p):
        force = p.force @ rotation.T
        moment = p.moment @ rotation.T + np.cross(shift, force)
        return ForcePlate(force, moment, p.rate_hz, p.corners @ rotation.T + shift)

    positions = recording.markers.positions @ rotation.T + shift
    return replace(
        recording,
        markers=replace(recording.markers, positions=positions),
        plates=tuple(map(plate, recording.plates)),
    )


def same(trial, other, tolerance=1e-5):
    for name, signal in other.signals.items():
        size = np.abs(signal.values).max()
        assert trial.values(name).shape == signal.values.shape
        assert np.abs(trial.values(name).astype(float) - signal.values).max() <= tolerance * size, name


@pytest.mark.parametrize(
    ("forward", "up", "rows"),
    [
        ("-z", "+y", [[1, 0, 0], [0, 0, 1], [0, -1, 0]]),  # x to the right, y up, z backward
        ("+x", "+z", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),  # x forward, y to the left
        ("-y", "+z", [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]),
    ],
)
def test_axes_of_the_laboratory(forward, up, rows, recording, options, labels, ingested):
    shifted = turned(recording, np.array(rows, dtype=float), np.array([0.7, -1.2, 0.3]))
    use = replace(USE, axes=Axes(forward, up))
    same(ingest_recording(shifted, labels, options, use, DUMMY_DURATION_S), ingested[1])


def test_plates_that_give_the_force_on_the_plate(recording, options, labels, ingested):
    plates = tuple(replace(p, force=-p.force, moment=-p.moment) for p in recording.plates)
    other = replace(recording, plates=plates)
    use = replace(USE, force_sign=-1)
    same(ingest_recording(other, labels, options, use, DUMMY_DURATION_S), ingested[1])
    with pytest.raises(InputError) as caught:
        ingest_recording(other, labels, options, USE, DUMMY_DURATION_S)
    assert_one_sentence(caught.value, recording.name, "force_sign", "-24")


def test_origin_of_a_treadmill_that_points_the_other_way(dummy_files, options, labels, ingested, tmp_path):
    """Its z is 0, so that only the point of the force, far from the plate, shows it."""
    path = single_c3d(dummy_files, tmp_path / "reversed.c3d", origin_m=(0.236, 0.813, 0.0))
    file = ezc3d.c3d(str(path))
    file["parameters"]["FORCE_PLATFORM"]["ORIGIN"]["value"] *= -1.0
    file.write(str(path))
    with pytest.raises(InputError) as caught:
        ingest_recording_files({"log": path}, labels, options, USE, DUMMY_DURATION_S)
    assert_one_sentence(caught.value, path, "force plate 2", "reverse_origin", "m outside")
    trial = ingest_recording_files(
        {"log": path}, labels, options, replace(USE, reverse_origin=True), DUMMY_DURATION_S
    )
    same(trial, ingested[1], 1e-5)


def test_one_belt_on_several_plates_and_none_on_the_other(recording, options, labels, ingested):
    left, right = recording.plates
    half = replace(right, force=0.25 * right.force, moment=0.25 * right.moment)
    rest = replace(right, force=0.75 * right.force, moment=0.75 * right.moment)
    split = replace(recording, plates=(half, left, rest))
    use = replace(USE, plates=PlateNumbers(right=(1, 3)))
    trial = ingest_recording(split, labels, options, use, DUMMY_DURATION_S)
    assert trial.axes["belt"].tolist() == ["right"]
    force = ingested[1].values("force")[:, 1:]
    assert np.abs(trial.values("force") - force).max() < 1e-5 * np.abs(force).max()


def test_load_cells_by_their_geometry(recording, options, labels, ingested):
    """Eight channels in volts whose forces and moments are those of the right plate."""
    places = [("+z", (x, y, 0.0)) for x, y in ((0.5, 0.8), (0.1, 0.8), (0.1, -0.8), (0.5, -0.8))]
    places += [
        ("+y", (0.5, 0.0, 0.0)),
        ("+y", (0.1, 0.0, 0.0)),
        ("-x", (0.3, 0.8, 0.0)),
        ("-x", (0.3, -0.8, 0.0)),
    ]
    axes = {"x": 0, "y": 1, "z": 2}
    unit = np.zeros((6, 8))
    for k, (direction, place) in enumerate(places):
        along = np.zeros(3)
        along[axes[direction[1]]] = 1.0 if direction[0] == "+" else -1.0
        unit[:, k] = [*along, *np.cross(place, along)]
    right = recording.plates[1]
    newtons = np.hstack([right.force, right.moment]) @ np.linalg.pinv(unit).T
    channels = {f"cell {k}": Channel(x / 250.0, "V", 1000.0) for k, x in enumerate(newtons.T)}
    cells = tuple(LoadCell(f"cell {k}", 250.0, *place) for k, place in enumerate(places))
    use = replace(USE, plates=PlateNumbers((1,)), load_cells=LoadCells(right=cells))
    with_cells = replace(recording, channels=recording.channels | channels)
    trial = ingest_recording(with_cells, labels, options, use, DUMMY_DURATION_S)
    # the origin is now the centre of the left plate, at x = -0.285 m: only moments about y and z change
    same_force, moment = trial.values("force"), trial.values("moment")
    assert np.abs(same_force - ingested[1].values("force")).max() < 1e-3
    assert np.abs(moment[:, 1, 0] - ingested[1].values("moment")[:, 1, 0]).max() < 1e-3


def test_time_0_is_the_edge_of_a_trigger(recording, options, labels, ingested):
    """0.2 s are put before the trial, and the trigger rises with its first frame."""
    pad = {250.0: 50, 1000.0: 200}

    def later(x, rate):
        return np.concatenate([np.repeat(x[:1], pad[rate], axis=0), x])

    edge = np.where(np.arange(recording.plates[0].force.shape[0] + 200) < 200, 0.0, 5.0)
    padded = replace(
        recording,
        markers=replace(recording.markers, positions=later(recording.markers.positions, 250.0)),
        plates=tuple(
            replace(p, force=later(p.force, 1000.0), moment=later(p.moment, 1000.0)) for p in recording.plates
        ),
        channels={k: replace(c, values=later(c.values, 1000.0)) for k, c in recording.channels.items()}
        | {"Sync": Channel(edge, "V", 1000.0)},
    )
    trial = ingest_recording(padded, labels, options, replace(USE, trigger="Sync"), DUMMY_DURATION_S)
    assert trial.attributes["start_s"] == pytest.approx(0.1995)
    # the edge lies between two samples: half a millisecond before the first frame
    assert trial.time[0] == pytest.approx(0.0045)
    n = trial.time.size
    assert n == ingested[1].time.size
    for name in ("marker_position_as_sampled", "belt_velocity"):
        other = ingested[1].values(name)
        assert np.abs(trial.values(name) - other)[50:].max() < 1e-5
    cut = ingest_recording(padded, labels, options, replace(USE, trigger="Sync"), 6.0)
    assert cut.time[-1] <= 6.0 < cut.time[-1] + 0.005


def test_commanded_velocity_is_optional(recording, options, labels):
    use = replace(USE, belt_command=ScaledChannel("Belt speed", 0.5, 2.5))
    trial = ingest_recording(recording, labels, options, use, DUMMY_DURATION_S)
    assert (trial.values("belt_command") == trial.values("belt_velocity")).all()


def test_velocity_by_the_unit_of_its_channel(recording, options, labels, ingested):
    old = recording.channels["Belt speed"]
    channel = Channel(500.0 * (old.values - 2.5), "mm/s", old.rate_hz)
    other = replace(recording, channels=recording.channels | {"v": channel})
    use = replace(USE, belt_velocity=BeltVelocity("v"))
    same(ingest_recording(other, labels, options, use, DUMMY_DURATION_S), ingested[1])


def test_clipped_channel_of_a_plate_is_a_fault(recording, ingested, options, labels):
    assert recorded_faults(ingested[1]) == ()
    label = recording.plates[1].channels[1]
    channel = recording.channels[label]
    values = np.minimum(channel.values, 0.4 * channel.values.max())
    clipped = replace(recording, channels=recording.channels | {label: replace(channel, values=values)})
    assert recorded_faults(ingest_recording(clipped, labels, options, USE, DUMMY_DURATION_S)) == ("clipped",)


def test_calibration_of_a_plate_makes_its_load_of_its_channels(recording, ingested):
    for belt, plate in zip(("left", "right"), recording.plates, strict=True):
        volts = np.array([recording.channels[label].values for label in plate.channels])
        load = np.hstack([plate.force, plate.moment]).T
        assert plate.calibration @ volts == pytest.approx(load, abs=1e-9 * np.abs(load).max())
        assert np.array_equal(ingested[1].attributes[f"calibration_{belt}"], plate.calibration)


# ---- refusals --------------------------------------------------------------------------------------


def hole(channel):
    values = channel.values.copy()
    values[100] = np.nan
    return replace(channel, values=values)


@pytest.mark.parametrize(
    ("change", "use", "words"),
    [
        ({}, {"belt_velocity": BeltVelocity("speed")}, ["'speed'", "'Fx1'", "belt_velocity"]),
        ({}, {"belt_velocity": BeltVelocity("Belt speed")}, ["m/s", "'V'", "m_per_s_per_unit"]),
        ({}, {"belt_velocity": BeltVelocity()}, ["belt-fixed markers", "'Belt speed'", "belt_velocity"]),
        ({}, {"belt_velocity": BeltVelocity(markers=("sole",))}, ["'sole'", "marker_labels"]),
        ({}, {"plates": PlateNumbers(right=(3,))}, ["force plate 3", "2 force plates", "recording.plates"]),
        ({}, {"plates": PlateNumbers()}, ["number of a force plate", "2 force plates"]),
        ({}, {"axes": Axes("+y", "-y")}, ["two different axes", "'+y'", "'-y'"]),
        ({}, {"axes": Axes("+y", "+x")}, ["force plate 1", "a level surface", "faces along z"]),
        ({"gap": 1}, {}, ["force plate 2", "a number in every sample, found none in 1"]),
        ({}, {"trigger": "Sync"}, ["'Sync'", "trigger"]),
        ({}, {"trigger": "Belt speed"}, ["'Belt speed'", "high from the first"]),
        ({"markers": None}, {}, ["markers", "found none"]),
        ({"dead": 1}, {}, ["force plate 2", "zeros only"]),
        ({"exchanged": 1}, {}, ["force plate 1", "24.5 N that act 0.68 m to the left"]),
        ({"fault": 1}, {}, ["of an unknown type"]),
        ({}, {"plates": PlateNumbers((2,), (1,))}, ["0.57 m to the right", "exchange left and right"]),
        ({"far": 0.9}, {}, ["force plate 1 or 2", "1.2 m outside", "recording.plates"]),
        ({"hole": "Belt speed"}, {}, ["'Belt speed'", "found none in 1"]),
    ],
)  # fmt: skip
def test_what_does_not_fit_the_file_is_refused(change, use, words, recording, options, labels):
    if "markers" in change:
        recording = replace(recording, markers=None)
    if "gap" in change:
        plates = [*recording.plates]
        force = plates[1].force.copy()
        force[7, 2] = np.nan
        plates[1] = replace(plates[1], force=force)
        recording = replace(recording, plates=tuple(plates))
    if "dead" in change:
        plates = [*recording.plates]
        plates[1] = replace(plates[1], force=0.0 * plates[1].force, moment=0.0 * plates[1].moment)
        recording = replace(recording, plates=tuple(plates))
    if "exchanged" in change:
        left, right = recording.plates
        moved = (left.corners - right.corners).mean(axis=0)
        moment = right.moment + np.cross(moved, right.force)
        plates = (
            replace(right, corners=left.corners, moment=moment),
            replace(left, corners=right.corners),
        )
        recording = replace(recording, plates=plates)
    if "fault" in change:
        sentence = (
            f"{recording.name}, force plate 2: expected a plate, found one of an unknown type: export it"
        )
        nothing = ForcePlate(np.full((9, 3), np.nan), np.full((9, 3), np.nan), 1000.0, fault=sentence)
        recording = replace(recording, plates=(recording.plates[0], nothing))
        unused = replace(USE, plates=PlateNumbers((1,)))
        ingest_recording(recording, labels, options, unused, DUMMY_DURATION_S)
    if "far" in change:
        plates = tuple(replace(p, corners=p.corners + np.array([0.0, 2.2, 0.0])) for p in recording.plates)
        recording = replace(recording, plates=plates)
    if "hole" in change:
        channels = recording.channels | {change["hole"]: hole(recording.channels[change["hole"]])}
        recording = replace(recording, channels=channels)
    with pytest.raises(InputError) as caught:
        ingest_recording(recording, labels, options, replace(USE, **use), DUMMY_DURATION_S)
    assert_one_sentence(caught.value, recording.name, *words)


@pytest.mark.parametrize(
    ("rate_hz", "words"), [(200.0, ["200 Hz", "250 Hz"]), (2000.0, ["2000 Hz", "1000 Hz"])]
)
def test_other_rates_are_refused(rate_hz, words, recording, options, labels):
    with pytest.raises(InputError) as caught:
        ingest_recording(recording, labels, replace(options, resample_rate_hz=rate_hz), USE, DUMMY_DURATION_S)
    assert_one_sentence(caught.value, recording.name, "resample_rate_hz", *words)


def test_short_file_is_refused(recording, options, labels):
    with pytest.raises(InputError) as caught:
        ingest_recording(recording, labels, options, USE, DUMMY_DURATION_S + 1.0)
    assert_one_sentence(caught.value, recording.name, "13 s", "12.00 s")


# ---- electromyograms -------------------------------------------------------------------------------


def with_channels(recording, **channels):
    return replace(recording, channels={name.replace("_", " "): c for name, c in channels.items()})


def test_electromyograms_have_their_unit_and_limits(recording, ingested):
    x = np.linspace(-1.0, 1.0, 12000)
    found = with_channels(
        recording, EMG_TA=Channel(x, "mV", 1000.0), EMG_SOL=Channel(1e-3 * x, "V", 1000.0, (-0.005, 0.005))
    )
    trial = with_recorded_emg(ingested[1], found, {"TA": "EMG TA", "SOL": "EMG SOL", "GAS": "EMG GAS"})
    assert trial.axes["muscle"].tolist() == ["TA", "SOL"]
    np.testing.assert_allclose(trial.values("emg"), np.column_stack([1000.0 * x, 1000.0 * x]), rtol=1e-6)
    np.testing.assert_allclose(trial.attributes["emg_limits_uV"], [[-1000.0, 1000.0], [-5000.0, 5000.0]])
    assert trial.attributes["emg_missing"] == "GAS"
    assert trial.axes["emg_time"][0] == 0.0


def test_recording_without_muscles_says_so(recording, ingested):
    trial = with_recorded_emg(ingested[1], recording, {"TA": "EMG TA"})
    assert "emg" not in trial.signals
    assert_one_sentence(trial.attributes["no_emg"], "'EMG TA'", "'Belt speed'", "standing.muscles")


@pytest.mark.parametrize(
    ("unit", "rate_hz", "words"),
    [("%", 1000.0, ["'EMG TA'", "uV, mV or V", "'%'"]), ("V", 500.0, ["500, 1000 Hz"])],
)
def test_electromyograms_of_unknown_unit_or_several_rates_are_refused(
    unit, rate_hz, words, recording, ingested
):
    x = np.ones(6000)
    found = with_channels(recording, EMG_TA=Channel(x, unit, rate_hz), EMG_SOL=Channel(x, "V", 1000.0))
    with pytest.raises(InputError) as caught:
        with_recorded_emg(ingested[1], found, {"TA": "EMG TA", "SOL": "EMG SOL"})
    assert_one_sentence(caught.value, recording.name, *words)


# ---- the configuration that the builder promises -------------------------------------------------------


def test_settings_of_the_builder_are_these_options(shipped_config):
    section = shipped_config["plate_treadmill"]["recording"]
    assert options_of(RecordingOptions, section | single_c3d_settings()) == USE
    markers = options_of(RecordingOptions, section | single_c3d_settings(belt_velocity=False, markers=FIXED))
    assert markers.belt_velocity.channel is None
    assert markers.belt_velocity.markers == FIXED


# ---- recordings made by others -----------------------------------------------------------------------


@pytest.mark.parametrize(("forward", "sign"), [("+x", 1.0), ("-x", -1.0), ("-y", 0.0)])
def test_feet_of_a_walking_person_are_where_the_force_is(forward, sign, real_data):
    """Two plates, each under one foot: the point of the force lies between heel and toes."""
    recording = read_recording(real_data("c3d/Qualisys.c3d"))
    feet = {"left": ("L_FCC", "L_FM1", "L_FM5"), "right": ("R_FCC", "R_FM1", "R_FM5")}
    cells = (LoadCell("TAPIS FZ1", 250.0, "+z", (0.5, 1.5, 0.0)),)
    # with -y forward the second plate lies to the left of the first
    order = 1 if sign else -1
    left, right = [(1,), (2,)][::order]
    use = RecordingOptions(
        axes=Axes(forward),
        plates=PlateNumbers(left, right),
        belt_velocity=BeltVelocity(markers=("L_IAS", "R_IAS")),
    )
    labels = ["L_IAS", "R_IAS", *feet["left"], *feet["right"]]
    ingest = TreadmillOptions(200.0, 0.5, None, 2.5)
    trial = ingest_recording(recording, labels, ingest, use, 1.7, bridge_long_gaps=True)
    force, moment = (trial.values(name).astype(float) for name in ("force", "moment"))
    assert force[:, :, 2].max(axis=0) == pytest.approx([808.0, 838.0][::order], abs=1.0)
    # the person walks along +x of the file
    assert trial.values("belt_velocity").mean() == pytest.approx(1.46 * sign, abs=0.15)
    positions = trial.values("marker_position").astype(float)
    on_plate = []
    for plate in (0, 1):
        loaded = np.flatnonzero(force[:, plate, 2] > 300.0)
        place = np.column_stack([-moment[:, plate, 1], moment[:, plate, 0]]) / force[:, plate, 2:]
        foot = min(
            ("left", "right"), key=lambda side: positions[loaded][:, [labels.index(feet[side][1])], 2].mean()
        )
        on_plate.append(foot)
        heel, *toes = (positions[loaded, labels.index(label), :2] for label in feet[foot])
        # no farther from the line of heel and toes than half a foot's width, and not beyond its ends
        along = np.mean(toes, axis=0) - heel
        length = np.linalg.norm(along, axis=1)
        way = ((place[loaded] - heel) * along).sum(axis=1) / length
        assert way.min() > -0.05
        assert (way - length).max() < 0.08
        off = place[loaded] - heel
        aside = np.abs(along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]) / length
        assert aside.max() < 0.06
    assert set(on_plate) == {"left", "right"}
    # a cell of the unloaded treadmill, in volts, adds little
    more = replace(use, load_cells=LoadCells(right=cells))
    added = ingest_recording(recording, labels, ingest, more, 1.7, bridge_long_gaps=True)
    volts = (added.values("force")[:, 1, 2] - force[:, 1, 2]) / 250.0
    assert 0.01 < np.abs(volts).max() < 0.14
