"""The weight and the empty belt: balance of forces by hand, what belt, floor and frame add, and ingest."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from builders import assert_one_sentence
from plate_builders import plate_voltages
from scipy.signal import welch

from tepsipe.errors import InputError
from tepsipe.ingest.plate_treadmill import ingest_treadmill
from tepsipe.ingest.treadmill_options import TreadmillOptions
from tepsipe.io.formats import read_markers
from tepsipe.io.readers.treadmill_log import read_calibration_matrix, read_treadmill_log
from tepsipe.io.trial import read_trial, write_trial
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.plate_check import check_plate, resting
from tepsipe.treadmill.prepared import prepare_trial
from tepsipe.virtual_lab.belt import DriveTruth, velocity_command
from tepsipe.virtual_lab.force_plate import (
    PlateTruth,
    belt_wrench,
    floor_tremor,
    plate_electronics,
    wandering_lag,
)
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import CaptureTruth, Protocol, record_markers
from tepsipe.virtual_lab.weight_trial import (
    MARKERS,
    WeightTruth,
    make_weight_trial,
    move_weight,
    weight_marker_paths,
    weight_reaction,
)

RATE_HZ = 2000.0
DURATION_S = 5.0
FY, FZ, MX = 1, 2, 3
# forces by number: 20 kg, centre of mass 0.1 m above the belt, 0.25 m right and 0.02 m in front of the origin
WEIGHT = WeightTruth(
    mass_kg=20.0,
    width_m=0.2,
    length_m=0.3,
    height_m=0.15,
    com_height_m=0.1,
    position_x_m=0.25,
    position_y_m=0.02,
    gravity_m_per_s2=9.81,
)
OPTIONS = TreadmillOptions(
    resample_rate_hz=250.0, max_gap_s=0.1, marker_sampling_hz=2500.0, trigger_threshold_V=2.5
)


def drive_of(truth):
    return DriveTruth(**truth["treadmill"]["drive"])


def plate_of(truth, **changes):
    """The shipped plate without memory, lever and second mode (see test_mechanisms.py)."""
    plain = {"bristle_share": 0.0, "friction_lever_m": 0.0, "second_share": [0.0, 0.0]}
    return replace(PlateTruth(**truth["treadmill"]["plate"]), **plain | changes)


def pulsed(truth, weight, amplitude=0.3, profile="sine"):
    """Motion of one pulse that starts at 0.2 s."""
    command = velocity_command(profile, amplitude, np.array([0.2]), 0.1)
    return move_weight(weight, drive_of(truth), command, 0.8, RATE_HZ)


# ---- the reaction on a rigid body --------------------------------------------------------------


def test_weight_under_constant_acceleration_is_pushed_by_mass_times_acceleration():
    time = np.arange(1000) / RATE_HZ
    y = 0.5 * 3.0 * time**2
    reaction = weight_reaction(WEIGHT, y, np.full(1000, 3.0))
    fx, fy, fz, mx, my, mz = reaction.T
    assert fx == pytest.approx(np.zeros(1000), abs=1e-12)
    assert fy == pytest.approx(np.full(1000, 60.0), rel=1e-9)  # 20 kg x 3 m/s2
    assert fz == pytest.approx(np.full(1000, 196.2))
    # about the origin: 196.2 N acts 0.02 m + y in front, the inertia of 60 N backwards 0.1 m above
    assert mx == pytest.approx(196.2 * (0.02 + y) - 6.0, abs=1e-9)
    assert my == pytest.approx(np.full(1000, -0.25 * 196.2))
    assert mz == pytest.approx(np.full(1000, 0.25 * 60.0), rel=1e-9)


def test_centre_of_pressure_falls_behind_an_accelerated_weight():
    reaction = weight_reaction(WEIGHT, np.zeros(100), np.full(100, 3.0))
    pressure = reaction[:, MX] / reaction[:, FZ]
    assert pressure == pytest.approx(np.full(100, 0.02 - 0.1 * 3.0 / 9.81))


def test_drive_pushes_belt_and_weight(shipped_truth):
    drive = replace(
        drive_of(shipped_truth), bandwidth_hz=1e-12, integral_time_s=1e12, force_limit_N=130.0, delay_s=0.0
    )
    drive = replace(drive, belt_mass_kg=45.0, viscous_Ns_per_m=0.0)
    loaded = move_weight(WEIGHT, drive, lambda t: np.full_like(t, 1e30), 0.2, RATE_HZ)
    empty = move_weight(None, drive, lambda t: np.full_like(t, 1e30), 0.2, RATE_HZ)
    assert loaded.belt_acceleration == pytest.approx(np.full(loaded.time.size, 130.0 / 65.0))
    assert empty.belt_acceleration == pytest.approx(np.full(empty.time.size, 130.0 / 45.0))
    assert loaded.reaction[:, FY] == pytest.approx(np.full(loaded.time.size, 40.0))


def test_nothing_on_the_belt_needs_no_reaction(shipped_truth):
    motion = pulsed(shipped_truth, None)
    assert np.abs(motion.belt_velocity).max() > 0.1
    assert (motion.reaction == 0.0).all()


def test_markers_sit_in_the_upper_corners_and_move_with_the_belt(shipped_truth):
    motion = pulsed(shipped_truth, WEIGHT)
    paths = weight_marker_paths(WEIGHT, motion)
    assert len(paths) == len(MARKERS)
    at_rest = np.array([path(np.array([0.1]))[0] for path in paths])
    expected = [[0.15, 0.17, 0.15], [0.35, 0.17, 0.15], [0.35, -0.13, 0.15], [0.15, -0.13, 0.15]]
    assert at_rest == pytest.approx(np.array(expected), abs=1e-9)
    moved = motion.time[600:900]
    for path, start in zip(paths, at_rest, strict=True):
        assert path(moved)[:, 1] - start[1] == pytest.approx(motion.belt_position[600:900], abs=1e-9)
        assert path(moved)[:, [0, 2]] == pytest.approx(np.tile(start[[0, 2]], (300, 1)))


def test_markers_are_strobed_one_after_another(shipped_truth):
    motion = pulsed(shipped_truth, WEIGHT)
    still = shipped_truth["treadmill"]["capture"] | {"noise_m": 0.0, "occlusions_per_minute": 0.0}
    capture = CaptureTruth(**still)
    paths = weight_marker_paths(WEIGHT, motion)
    strobed = record_markers(capture, paths, 0.1, 100, generator(1, "markers"))
    for k, path in enumerate(paths):
        instants = 0.1 + capture.latency_s + np.arange(100) / 250.0 + k / 2500.0
        assert strobed[:, k] == pytest.approx(path(instants), abs=1e-12)


# ---- what the belt adds ------------------------------------------------------------------------


def artefact(truth, motion, **changes):
    """Fy (N) and Mx (Nm) that the belt adds, with a lag that does not change."""
    plate = plate_of(truth, **changes)
    lag = np.full(motion.time.size, plate.belt_lag_s)
    wrench = belt_wrench(
        plate, motion.reaction[:, FZ], motion.belt_velocity, motion.belt_acceleration, lag, RATE_HZ
    )
    assert np.abs(np.delete(wrench, [FY, MX], axis=1)).max() == 0.0
    return wrench[:, FY], wrench[:, MX]


def test_belt_at_rest_adds_nothing(shipped_truth):
    motion = move_weight(WEIGHT, drive_of(shipped_truth), np.zeros_like, 0.1, RATE_HZ)
    force, moment = artefact(shipped_truth, motion)
    assert np.abs(force).max() == np.abs(moment).max() == 0.0


def test_reversed_pulse_reverses_what_the_belt_adds(shipped_truth):
    forward, backward = (pulsed(shipped_truth, WEIGHT, a) for a in (0.4, -0.4))
    for there, back in zip(artefact(shipped_truth, forward), artefact(shipped_truth, backward), strict=True):
        assert np.ptp(there) > 0.1
        assert back == pytest.approx(-there, abs=1e-9 * np.ptp(there))


def test_friction_is_full_beyond_its_speed_and_grows_with_the_load(shipped_truth):
    plate = plate_of(shipped_truth, friction_Ns_per_m=0.0, friction_N=15.0, friction_coefficient=0.08)
    velocity, still = np.array([1e-6, 10.0]), np.zeros(2)
    for load, full in ((0.0, 15.0), (200.0, 15.0 + 16.0)):
        force = belt_wrench(plate, np.full(2, load), velocity, still, still, RATE_HZ)[:, FY]
        assert force[1] == pytest.approx(full)
        assert force[0] == pytest.approx(full * 1e-6 / plate.friction_speed_m_per_s)


def test_what_the_belt_adds_grows_with_amplitude_but_less_than_in_proportion(shipped_truth):
    peaks = [np.abs(artefact(shipped_truth, pulsed(shipped_truth, None, a))[0]).max() for a in (0.1, 0.5)]
    assert peaks[0] < peaks[1] < 5.0 * peaks[0]


def test_rollers_that_run_ahead_of_the_load_pass_for_mass(shipped_truth):
    motion = pulsed(shipped_truth, None)
    off = {"friction_N": 0.0, "friction_coefficient": 0.0, "felt_belt_mass_kg": 0.0}
    force, _ = artefact(shipped_truth, motion, friction_Ns_per_m=50.0, belt_lag_s=0.004, **off)
    v, a = motion.belt_velocity, motion.belt_acceleration
    assert force == pytest.approx(50.0 * v + 0.2 * a, abs=1e-9)


def test_rollers_spin_up_against_the_frame(shipped_truth):
    motion = pulsed(shipped_truth, None)
    _, moment = artefact(shipped_truth, motion, felt_roller_inertia_kgm=0.03)
    assert moment == pytest.approx(-0.03 * motion.belt_acceleration)


def test_lag_wanders_about_its_mean_and_the_floor_trembles_as_asked(shipped_truth):
    plate = plate_of(shipped_truth, belt_lag_wander=0.2, belt_lag_wander_s=0.05)
    lag = wandering_lag(plate, 400_000, RATE_HZ, generator(1, "lag"))
    assert lag.mean() == pytest.approx(plate.belt_lag_s, rel=0.02)
    assert np.log(lag).std() == pytest.approx(0.2, rel=0.05)
    plate = plate_of(shipped_truth, floor_m_per_s2=0.02, floor_hz=12.0, floor_damping=0.05)
    tremor = floor_tremor(plate, 400_000, RATE_HZ, generator(1, "floor"))
    assert tremor.std() == pytest.approx(0.02, rel=0.05)
    frequency, power = welch(tremor, RATE_HZ, nperseg=8192)
    assert frequency[np.argmax(power)] == pytest.approx(12.0, abs=1.0)


# ---- what frame and mounts make of it ----------------------------------------------------------


def calibrated(truth, motion, **changes):
    """Wrench on the right belt that a noiseless plate measures (N, Nm), at 1 kHz."""
    quiet = {"noise_V": 0.0, "drift_V_per_s": 0.0, "calibration_error": 0.0, "floor_m_per_s2": 0.0}
    plate = plate_of(truth, **(quiet | {"belt_lag_wander": 0.0} | changes))
    volts_per_newton, matrix = plate_electronics(plate, generator(1, "plate"))
    voltages = plate_voltages(
        plate,
        volts_per_newton,
        motion,
        np.arange(0, motion.time.size, 2),
        generator(1, "noise"),
    )
    return (voltages @ matrix.T)[:, 6:]


def test_mounts_take_their_share_of_a_quick_force_and_let_go_of_it(shipped_truth):
    motion = move_weight(None, drive_of(shipped_truth), np.zeros_like, 1.0, RATE_HZ)
    motion.reaction[400:, FY] = 100.0
    rigid = {"resonance_hz": 300.0, "resonance_damping": 1.0}
    share = calibrated(shipped_truth, motion, mount_share=0.2, mount_relaxation_s=0.05, **rigid)
    elapsed = (np.arange(len(share)) - 200) / 1000.0
    after = elapsed > 0.005
    expected = 100.0 * (1.0 - 0.2 * np.exp(-elapsed[after] / 0.05))
    assert share[after, FY] == pytest.approx(expected, abs=1.0)
    assert abs(100.0 - share[-1, FY]) < 0.1
    # the mounts sit at the height of the belt
    assert np.abs(share[after, MX]).max() < 0.1


def test_noise_draws_do_not_depend_on_lag_and_floor(shipped_truth):
    """What follows the plate in a trial draws the same numbers whatever the plate's constants."""
    motion, following = pulsed(shipped_truth, WEIGHT), []
    for changes in ({}, {"belt_lag_wander": 0.0, "floor_m_per_s2": 0.0, "belt_lag_s": 0.0}):
        plate, rng = plate_of(shipped_truth, **changes), generator(1, "trial")
        plate_voltages(
            plate,
            np.eye(14),
            motion,
            np.arange(0, motion.time.size, 2),
            rng,
        )
        following.append(rng.random())
    assert following[0] == following[1]


# ---- trials ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def short_protocol(shipped_truth):
    truth = copy.deepcopy(shipped_truth)
    truth["treadmill"]["protocol"] |= {"rest_before_s": 1.0, "rest_after_weight_s": 1.0}
    return truth


def make(truth, experiment, folder, condition="sine-0.4"):
    """Raw files of one short trial: two perturbations, 1 s and 2 s after the trigger."""
    folder.mkdir()
    files = {"log": folder / "log.mat", "calibration": folder / "calibration.csv"}
    if experiment == "weight":
        files["markers"] = folder / "markers.c3d"
    make_weight_trial(truth, condition, Protocol("sine", 0.4, 1.0, DURATION_S), files)
    return files


@pytest.fixture(scope="module")
def weight_files(short_protocol, tmp_path_factory):
    return make(short_protocol, "weight", tmp_path_factory.mktemp("weight") / "files")


@pytest.fixture(scope="module")
def empty_files(short_protocol, tmp_path_factory):
    return make(short_protocol, "empty", tmp_path_factory.mktemp("empty") / "files")


def ingested(files, options=OPTIONS, duration_s=DURATION_S):
    with_markers = "markers" in files
    return ingest_treadmill(
        read_treadmill_log(files["log"]),
        read_calibration_matrix(files["calibration"]),
        read_markers(files["markers"], list(MARKERS)) if with_markers else None,
        options,
        duration_s,
        {"log": "log.mat", "calibration": "calibration.csv", "markers": "markers.c3d"},
    )


@pytest.mark.parametrize("experiment", ["weight", "empty"])
def test_same_seed_makes_the_same_bytes(experiment, short_protocol, weight_files, empty_files, tmp_path):
    first = weight_files if experiment == "weight" else empty_files
    again = make(short_protocol, experiment, tmp_path / "again")
    other = make(short_protocol | {"seed": 1}, experiment, tmp_path / "other")
    for kind, path in first.items():
        assert again[kind].read_bytes() == path.read_bytes()
        assert other[kind].read_bytes() != path.read_bytes()


def test_every_experiment_stands_on_the_same_plate(weight_files, empty_files, dummy_files):
    calibrations = {f["calibration"].read_bytes() for f in (weight_files, empty_files, dummy_files)}
    assert len(calibrations) == 1


def test_weight_lies_on_the_right_belt_and_its_inertia_is_felt(weight_files, shipped_truth):
    trial = ingested(weight_files)
    assert trial.axes["marker"].tolist() == list(MARKERS)
    at_rest = trial.time < 0.9
    force = trial.values("force")
    assert force[at_rest, 1, 2].mean() == pytest.approx(20.0 * 9.81, rel=5e-3)
    assert np.abs(force[at_rest, 0].mean(axis=0)).max() < 1.0
    # 20 kg at the weight's acceleration, within what belt, frame and mounts make of it
    belt = trial.values("belt_velocity")
    acceleration = np.gradient(belt, trial.time)
    moving = np.abs(belt) > 0.02
    mass = force[moving, 1, 1] @ acceleration[moving] / (acceleration[moving] @ acceleration[moving])
    assert mass == pytest.approx(20.0, abs=3.0)
    y = trial.values("marker_position")[:, :, 1]
    assert np.ptp(y.mean(axis=1)) > 0.01
    assert y.mean(axis=1)[at_rest].mean() == pytest.approx(shipped_truth["weight"]["position_y_m"], abs=1e-4)


def test_trial_without_markers_is_on_the_triggers_clock(empty_files, short_protocol):
    trial = ingested(empty_files)
    assert set(trial.signals) == {"force", "moment", "belt_velocity", "belt_command"}
    assert set(trial.axes) == {"time", "belt", "axis"}
    assert trial.time[0] == 0.0
    assert trial.time[-1] == pytest.approx(DURATION_S, abs=0.0041)
    assert np.diff(trial.time) == pytest.approx(np.full(trial.time.size - 1, 0.004))
    commanded = trial.time[np.abs(trial.values("belt_command")) > 0.05]
    assert commanded[0] == pytest.approx(1.0, abs=0.01)
    # moved by the command of the protocol, as in the log
    force = trial.values("force")[:, 1, 1]
    assert np.abs(force[trial.time > 1.0]).max() > 10.0
    rest = force[trial.time < 0.9]
    assert rest.std() < 3.0
    assert abs(trial.values("force")[:, 1, 2].mean()) < 1.0


def test_trial_without_markers_is_written_and_read(empty_files, tmp_path):
    trial = ingested(empty_files)
    write_trial(tmp_path / "t.h5", trial, "empty", "sine-0.4", empty_files, vars(OPTIONS))
    read = read_trial(tmp_path / "t.h5")
    assert set(read.signals) == set(trial.signals)
    assert read.values("force") == pytest.approx(trial.values("force"))
    assert "hidden_samples" not in read.attributes


def test_empty_belt_recorded_too_short_is_refused(empty_files):
    with pytest.raises(InputError) as caught:
        ingested(empty_files, duration_s=60.0)
    assert_one_sentence(caught.value, "log.mat", "60 s")


# ---- a plate with a fault, from raw files to its name --------------------------------------------


def checked_plate(truth, folder, **fault):
    """What weights at two places show of a plate with a fault."""
    changed = copy.deepcopy(truth)
    changed["treadmill"]["plate"] |= fault
    window = WindowOptions(0.8, 0.8, 0.1, 0.05, 0.5, 0.06)
    nothing = prepare_trial(
        ingested(make(changed, "empty", folder / "empty")), "empty", Lowpass(20.0, 4, True), window
    )
    rests = [resting(nothing, "right", None)]
    for k, y in enumerate((-0.1, 0.1)):
        changed["weight"] |= {"position_y_m": y, "mass_kg": 60.0}
        trial = ingested(make(changed, "weight", folder / str(k)))
        weight = Weight(mass_kg=60.0, com_height_m=0.1, gravity_m_per_s2=9.81, com_forward_of_markers_m=0.0)
        rests.append(resting(prepare_trial(trial, "weight", Lowpass(20.0, 4, True), window), "right", weight))
    return check_plate(rests, "plate")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "origin_m", "scale"),
    [
        ({}, 0.0, 1.0),
        ({"origin_forward_m": 0.02}, 0.02, 1.0),
        ({"origin_forward_m": -0.05}, -0.05, 1.0),
        ({"moment_scale": 1.1}, 0.0, 1.1),
    ],
)
def test_origin_and_scale_of_a_plate_are_corrected(fault, origin_m, scale, short_protocol, tmp_path):
    found = checked_plate(short_protocol, tmp_path, **fault)
    assert found.corrected_origin_m == pytest.approx(origin_m, abs=2.0 * found.origin_u_m)
    assert (found.corrected_origin_m == 0.0) == (origin_m == 0.0)
    assert found.corrected_scale == pytest.approx(scale, rel=0.01)
    assert found.flags == ()


@pytest.mark.slow
def test_reversed_moment_and_half_a_transducer_get_their_names(short_protocol, tmp_path):
    (tmp_path / "half").mkdir()
    half = checked_plate(short_protocol, tmp_path / "half", transducer_gain=[1.0, 0.5, 1.0, 1.0])
    assert half.flags == ("plate-transducer",)
    (tmp_path / "turned").mkdir()
    with pytest.raises(InputError, match="turn the sign of M_x"):
        checked_plate(short_protocol, tmp_path / "turned", moment_scale=-1.0)
