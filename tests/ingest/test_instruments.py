"""Raw files become one trial on one clock, or are refused in one sentence."""

import copy
import hashlib
import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from builders import (
    DUMMY_DURATION_S,
    WRISTALYZER_DURATION_S,
    assert_one_sentence,
    multisine_record,
)
from scipy import signal

from tepsipe.errors import InputError
from tepsipe.ingest.manipulator_options import ManipulatorOptions, TableOptions
from tepsipe.ingest.manipulators import ingest_position_manipulator, ingest_torque_manipulator
from tepsipe.ingest.plate_treadmill import ingest_treadmill
from tepsipe.ingest.standing import with_emg
from tepsipe.ingest.treadmill_options import TreadmillOptions
from tepsipe.io.formats import read_markers
from tepsipe.io.readers.recording import EmgRecording, Markers
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.readers.treadmill_log import (
    CalibrationMatrix,
    TreadmillLog,
    read_calibration_matrix,
    read_treadmill_log,
)
from tepsipe.io.trial import checksum, read_sources, read_trial, recorded_faults, write_trial
from tepsipe.mechanics.segment_kinematics import fit_rigid_segment
from tepsipe.virtual_lab.belt import DriveTruth, velocity_command
from tepsipe.virtual_lab.dummy import DummyTruth, move_dummy
from tepsipe.virtual_lab.dummy_trial import INTEGRATION_RATE_HZ, make_dummy_trial
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import Protocol
from tepsipe.virtual_lab.wristalyzer_trial import make_wristalyzer_trial

LABELS = ["foot1", "foot2", "foot3", "ankle", "leg1", "leg2", "leg3", "leg4"]


# ---- the torque-controlled manipulator ---------------------------------------------------------

MANIPULATOR = ManipulatorOptions(resample_rate_hz=256.0, max_gap_s=0.05, angle_unit="rad")


@pytest.fixture
def log():
    """A regular log of 1 s before and 5 s after the trigger."""
    time = 500.0 + np.arange(6 * 160) / 160.0
    return {
        "time": time,
        "angle": 0.01 + 0.05 * np.sin(2.0 * np.pi * 2.0 * (time - 501.0)) * (time >= 501.0),
        "trigger_time": np.where(time >= 501.0, 501.0, 0.0),
    }


@pytest.fixture
def command():
    time = np.arange(5 * 2048) / 2048.0
    return {"time": time, "torque": np.sin(2.0 * np.pi * 2.0 * time)}


def ingest(log, command, options=MANIPULATOR, duration_s=4.95):
    return ingest_torque_manipulator(log, command, options, duration_s, "log.txt", "command.txt")


def held_and_late(torque):
    torque = torque.copy()
    torque[3000:3200] = torque[3000]
    return torque


@pytest.mark.parametrize(
    ("change", "faults"),
    [
        (lambda x: x, ()),
        (lambda x: np.clip(x, -0.7, None), ("clipped",)),
        (held_and_late, ("held-samples",)),
        (lambda x: x + 2.0 * (np.arange(x.size) == 3000), ("spikes",)),
        # a command of steps: random levels, and two of them
        (lambda x: np.random.default_rng(1).standard_normal(x.size // 8).repeat(8), ()),
        (lambda x: np.sign(np.random.default_rng(1).standard_normal(x.size // 128)).repeat(128), ()),
    ],
    ids=["sound", "cut", "held", "spike", "levels", "binary"],
)
def test_faults_of_a_command_are_told(change, faults, log, command):
    assert recorded_faults(ingest(log, command | {"torque": change(command["torque"])})) == faults


def test_clock_of_the_log_is_moved_to_the_trigger(log, command):
    trial = ingest(log, command)
    grid = trial.time
    assert trial.rate_hz == 256.0
    assert np.diff(grid) == pytest.approx(np.full(grid.size - 1, 1.0 / 256.0))
    assert grid[0] == 0.0
    inside = slice(64, -64)
    angle = 0.05 * np.sin(2.0 * np.pi * 2.0 * grid)
    assert trial.values("angle")[inside] == pytest.approx(angle[inside], abs=1e-4)
    torque = np.sin(2.0 * np.pi * 2.0 * grid)
    assert trial.values("torque")[inside] == pytest.approx(torque[inside], abs=1e-3)
    assert trial.attributes["rest_angle_rad"] == pytest.approx(0.01, rel=1e-6)


def test_angle_in_degrees_is_converted(log, command):
    in_degrees = log | {"angle": np.rad2deg(log["angle"])}
    trial = ingest(in_degrees, command, replace(MANIPULATOR, angle_unit="deg"))
    assert trial.values("angle") == pytest.approx(ingest(log, command).values("angle"), abs=1e-12)


def test_repeated_and_missing_lines_of_the_log_do_not_change_the_angle(log, command):
    whole = ingest(log, command)
    lines = np.sort(np.concatenate([np.delete(np.arange(960), [200, 431, 700]), [300, 301, 650]]))
    worn = ingest({name: values[lines] for name, values in log.items()}, command)
    assert worn.attributes["repeated_stamps"] == 3
    assert worn.attributes["longest_step_s"] == pytest.approx(2.0 / 160.0)
    assert worn.values("angle") == pytest.approx(whole.values("angle"), abs=2e-4)


def with_change(table, name, rows, value):
    changed = table | {name: table[name].copy()}
    changed[name][rows] = value
    return changed


BAD_LOGS = {
    "time runs backwards": (lambda t: with_change(t, "time", 300, 400.0), "backwards"),
    "a stamp is missing": (lambda t: with_change(t, "time", 300, np.nan), "line 301"),
    "the angle is missing too long": (
        lambda t: with_change(t, "angle", slice(300, 320), np.nan),
        "0.131 s",
    ),
    "the angle is in degrees": (
        lambda t: t | {"angle": np.rad2deg(t["angle"])},
        "unit",
    ),
    "there is no trigger": (lambda t: t | {"trigger_time": 0.0 * t["time"]}, "trigger"),
    "the log ends early": (lambda t: {k: v[:700] for k, v in t.items()}, "4.95 s"),
    "the log starts at the trigger": (lambda t: {k: v[160:] for k, v in t.items()}, "trigger"),
    "the log starts just before the trigger": (
        lambda t: {k: v[155:] for k, v in t.items()},
        "found 5",
    ),
    "the trigger comes after the log": (
        lambda t: t | {"trigger_time": np.where(t["time"] >= 501.0, 506.1, 0.0)},
        "by one clock",
    ),
    "the angle has coarse steps": (
        lambda t: t | {"angle": 0.02 * np.round(t["angle"] / 0.02)},
        "distinct values, found 6 in steps of 0.02 rad",
    ),
    "the angle is saturated": (lambda t: t | {"angle": np.minimum(t["angle"], 0.05)}, "range of its sensor"),
    "the angle is never there": (lambda t: t | {"angle": np.nan * t["angle"]}, "angle"),
}


@pytest.mark.parametrize("why", BAD_LOGS)
def test_log_is_refused_where(why, log, command):
    change, found = BAD_LOGS[why]
    with pytest.raises(InputError) as caught:
        ingest(change(log), command)
    assert_one_sentence(caught.value, "log.txt", found)


BAD_COMMANDS = {
    "a torque is missing": (lambda t: with_change(t, "torque", 77, np.nan), "gap"),
    "time runs backwards": (lambda t: with_change(t, "time", 77, 0.0), "backwards"),
    "a stretch is cut out": (
        lambda t: {k: np.delete(v, slice(1000, 2000)) for k, v in t.items()},
        "0.489 s",
    ),
    "the command ends early": (lambda t: {k: v[:8000] for k, v in t.items()}, "4.95 s"),
}


@pytest.mark.parametrize("why", BAD_COMMANDS)
def test_command_is_refused_where(why, log, command):
    change, found = BAD_COMMANDS[why]
    with pytest.raises(InputError) as caught:
        ingest(log, change(command))
    assert_one_sentence(caught.value, "command.txt", found)


@pytest.mark.parametrize("error", [1e-3, -1e-3])
def test_clock_of_the_log_that_runs_fast_or_slow_is_corrected(error):
    torque, angle = multisine_record((0.015, 0.1, 9.0), 6.2, rate_hz=512.0)
    command = {"time": np.arange(torque.size) / 512.0, "torque": torque}
    time = np.arange(-300, 61 * 160) / 160.0
    exact = np.where(time < 0.0, 0.0, np.interp(time, command["time"], angle))
    trigger = np.where(time >= 0.0, 500.0, 0.0)
    trials = [
        ingest(
            {"time": 500.0 + (1.0 + e) * time, "angle": exact, "trigger_time": trigger},
            command,
            duration_s=60.0,
        )
        for e in (0.0, error)
    ]
    assert [t.attributes["clock_error"] for t in trials] == pytest.approx([0.0, error], abs=5e-6)
    right, corrected = (t.values("angle")[: 256 * 60] for t in trials)
    assert corrected == pytest.approx(right, abs=0.02 * right.std())
    assert "clock" in trials[1].signals["angle"].processing[2]


def read_manipulator(files, config):
    columns = config["wristalyzer"]["files"]
    return (
        read_text_table(files["log"], columns["log_columns"], "\t"),
        read_text_table(files["command"], columns["command_columns"], "\t"),
    )


def test_ingested_angle_of_a_linear_laboratory_is_the_motion_that_the_torque_makes(
    shipped_truth, config, tmp_path
):
    truth = copy.deepcopy(shipped_truth)
    off = ("contact_Nm_per_rad3", "friction_Nm", "ripple_Nm")
    truth["wristalyzer"]["manipulator"] |= dict.fromkeys(off, 0.0)
    truth["dummy"]["rubber"] |= {"softening": 0.0, "softened_damping_Nms_per_rad": 0.0}
    rubber = truth["dummy"]["rubber"]
    files = {"log": tmp_path / "log.txt", "command": tmp_path / "command.txt"}
    make_wristalyzer_trial(truth, "0.16", 0.16, 6.0, files)
    log, command = read_manipulator(files, config)
    trial = ingest_torque_manipulator(log, command, MANIPULATOR, 6.0, "log", "command")
    joint = ([1.0], [0.015, rubber["damping_Nms_per_rad"], rubber["stiffness_Nm_per_rad"]])
    _, moved, _ = signal.lsim(joint, command["torque"], command["time"], interp=False)
    expected = np.interp(trial.time, command["time"], moved)
    kept = slice(100, -100)
    error = trial.values("angle")[kept] - expected[kept]
    late = np.interp(trial.time - 0.001, command["time"], moved)[kept] - expected[kept]
    assert np.std(error) < 0.03 * np.std(expected)
    assert np.std(error) < 0.5 * np.std(late)


def test_truncated_log_is_refused_wherever_it_ends(wristalyzer_files, config, tmp_path):
    content = wristalyzer_files["log"].read_bytes()
    columns = config["wristalyzer"]["files"]
    command = read_text_table(wristalyzer_files["command"], columns["command_columns"], "\t")
    path = tmp_path / "log.txt"
    for part in np.linspace(0.01, 0.85, 15):
        path.write_bytes(content[: int(part * len(content))])
        with pytest.raises(InputError) as caught:
            log = read_text_table(path, columns["log_columns"], "\t")
            duration = WRISTALYZER_DURATION_S
            ingest_torque_manipulator(log, command, MANIPULATOR, duration, path, "command.txt")
        assert_one_sentence(caught.value, path)


# ---- the position-controlled manipulator -------------------------------------------------------

TABLE = TableOptions(resample_rate_hz=250.0, max_gap_s=0.02, angle_unit="rad", torque_sign=-1)


@pytest.fixture
def table():
    time = 3.0 + np.arange(4000) / 1000.0
    return {
        "time": time,
        "angle": 0.1 * np.sin(2.0 * np.pi * 3.0 * (time - 3.0)),
        "torque": -2.0 * np.cos(2.0 * np.pi * 3.0 * (time - 3.0)),
    }


def ingest_table(table, options=TABLE, duration_s=4.0):
    return ingest_position_manipulator(table, options, duration_s, "table.csv")


def test_table_starts_at_time_0_with_a_torque_that_resists(table):
    trial = ingest_table(table)
    inside = slice(50, -50)
    phase = 2.0 * np.pi * 3.0 * trial.time[inside]
    assert trial.time[0] == 0.0
    assert trial.values("angle")[inside] == pytest.approx(0.1 * np.sin(phase), abs=1e-4)
    assert trial.values("torque")[inside] == pytest.approx(2.0 * np.cos(phase), abs=2e-3)
    assert trial.attributes["recorded_rate_hz"] == pytest.approx(1000.0)


def test_sign_and_unit_of_the_table_are_heeded(table):
    plain = ingest_table(table)
    turned = ingest_table(table, replace(TABLE, torque_sign=1))
    assert turned.values("torque") == pytest.approx(-plain.values("torque"))
    degrees = table | {"angle": np.rad2deg(table["angle"])}
    converted = ingest_table(degrees, replace(TABLE, angle_unit="deg"))
    assert converted.values("angle") == pytest.approx(plain.values("angle"), abs=1e-12)


def test_short_gap_in_the_table_is_filled_and_counted(table):
    trial = ingest_table(with_change(table, "torque", slice(1000, 1015), np.nan))
    assert trial.attributes["missing_samples"] == 15
    assert trial.values("torque") == pytest.approx(ingest_table(table).values("torque"), abs=1e-3)


def test_schedule_and_trigger_jump_where_they_jump_in_the_table(table):
    phase = (100.0 * (table["time"] - 3.0)) % 100.0
    # a trigger of a single sample, between two samples of the trial
    trigger = np.zeros(4000)
    trigger[[1001, 2002, 3003, 3999]] = 5.0
    trial = ingest_table(table | {"schedule": phase, "trigger": trigger})
    last = trial.time.size - 1
    assert trial.values("schedule") == pytest.approx((100.0 * trial.time + 1e-7) % 100.0, abs=1e-5)
    assert np.flatnonzero(trial.values("trigger")).tolist() == [251, 501, 751, last]
    assert "schedule" not in ingest_table(table).signals


BAD_TABLES = {
    "a trigger that never rises": (lambda t: t | {"trigger": np.full(4000, 5.0)}, "trigger"),
    "a schedule with a long gap": (
        lambda t: t | {"schedule": np.where(np.arange(4000) // 100 == 9, np.nan, 1.0)},
        "samples with a schedule",
    ),
    "time runs backwards": (lambda t: with_change(t, "time", 300, 1.0), "backwards"),
    "a stretch is cut out": (
        lambda t: {k: np.delete(v, slice(1000, 1100)) for k, v in t.items()},
        "0.101 s",
    ),
    "the torque is missing too long": (
        lambda t: with_change(t, "torque", slice(1000, 1030), np.nan),
        "0.03 s",
    ),
    "the angle is in degrees": (lambda t: t | {"angle": np.rad2deg(t["angle"])}, "unit"),
    "torque and angle are exchanged": (
        lambda t: t | {"angle": t["torque"], "torque": t["angle"]},
        "exchange the columns",
    ),
    "the torque is saturated": (
        lambda t: t | {"torque": np.minimum(t["torque"], 1.9)},
        "range of its sensor",
    ),
    "the angle has coarse steps": (
        lambda t: t | {"angle": 0.05 * np.round(t["angle"] / 0.05)},
        "distinct values, found 5",
    ),
    "the angle hardly moves": (lambda t: t | {"angle": 1e-4 * t["angle"]}, "is moved by at least"),
    "missing samples are zeros": (
        lambda t: with_change(t, "torque", slice(331, 337), 0.0),
        "6 zeros in a row at 0.331 s",
    ),
    "the table ends early": (lambda t: {k: v[:3500] for k, v in t.items()}, "4 s"),
    "the recording is slower than the trial": (
        lambda t: {k: v[::8] for k, v in t.items()},
        "125 Hz",
    ),
}


@pytest.mark.parametrize("why", BAD_TABLES)
def test_table_is_refused_where(why, table):
    change, found = BAD_TABLES[why]
    with pytest.raises(InputError) as caught:
        ingest_table(change(table))
    assert_one_sentence(caught.value, "table.csv", found)


# ---- the treadmill -----------------------------------------------------------------------------

TREADMILL = TreadmillOptions(
    resample_rate_hz=250.0, max_gap_s=0.1, marker_sampling_hz=2500.0, trigger_threshold_V=2.5
)
CHANNELS = ("z1", "z2", "y")


@pytest.fixture
def recordings():
    """Log, calibration and markers of 4 s, with simple signals."""
    time = np.arange(5000) / 1000.0 - 0.5
    running = (time >= 0.0) & (time < 4.0)
    log = TreadmillLog(
        rate_hz=1000.0,
        channels=CHANNELS,
        voltages=np.column_stack([np.full(5000, 0.2), np.full(5000, 0.3), 0.1 * np.sin(6.0 * time)]),
        belt_velocity=0.3 * np.sin(6.0 * time),
        command=0.3 * np.sin(6.0 * time),
        trigger=np.where(running, 5.0, 0.0),
    )
    components = [f"{kind}{axis}_{belt}" for belt in ("left", "right") for kind in "FM" for axis in "xyz"]
    matrix = np.zeros((12, 3))
    matrix[components.index("Fy_right")] = [0.0, 0.0, 100.0]
    matrix[components.index("Fz_right")] = [1000.0, 1000.0, 0.0]
    matrix[components.index("Mx_left")] = [10.0, 0.0, 0.0]
    calibration = CalibrationMatrix(tuple(components), CHANNELS, matrix)
    instants = np.arange(1000)[:, None] / 250.0 + np.arange(8) / 2500.0
    positions = np.zeros((1000, 8, 3))
    positions[..., 1] = 0.05 * np.sin(6.0 * instants)
    return log, calibration, Markers(250.0, tuple(LABELS), positions)


NAMES = {"log": "log.mat", "calibration": "calibration.csv", "markers": "markers.c3d"}


def ingest_all(log, calibration, markers, options=TREADMILL, duration_s=4.0):
    return ingest_treadmill(log, calibration, markers, options, duration_s, NAMES)


def test_treadmill_signals_and_markers_come_out_on_one_clock(recordings):
    trial = ingest_all(*recordings)
    inside = slice(50, -50)
    time = trial.time[inside]
    assert np.diff(trial.time) == pytest.approx(np.full(trial.time.size - 1, 0.004))
    belt = trial.values("belt_velocity")[inside]
    assert belt == pytest.approx(0.3 * np.sin(6.0 * time), abs=2e-3)
    left, right = 0, 1
    force, moment = trial.values("force")[inside], trial.values("moment")[inside]
    assert force[:, right, 1] == pytest.approx(10.0 * np.sin(6.0 * time), abs=0.05)
    assert force[:, right, 2] == pytest.approx(np.full(time.size, 500.0), rel=1e-5)
    assert moment[:, left, 0] == pytest.approx(np.full(time.size, 2.0), rel=1e-5)
    assert np.count_nonzero(np.abs(force).max(axis=0)) == 2
    assert np.count_nonzero(np.abs(moment).max(axis=0)) == 1
    for k in range(8):
        aligned = trial.values("marker_position")[inside, k, 1]
        assert aligned == pytest.approx(0.05 * np.sin(6.0 * time), abs=1e-6)
    last = trial.values("marker_position_as_sampled")[inside, 7, 1]
    assert last == pytest.approx(0.05 * np.sin(6.0 * (time + 7.0 / 2500.0)), abs=1e-6)


def test_clipped_transducer_is_a_fault_and_the_calibration_is_kept(recordings, rng):
    log, calibration, markers = recordings
    noisy = log.voltages + 1e-4 * rng.standard_normal(log.voltages.shape)
    trial = ingest_all(replace(log, voltages=noisy), calibration, markers)
    assert recorded_faults(trial) == ()
    right = calibration.matrix[6:]
    assert np.array_equal(trial.attributes["calibration_right"], right)
    for low in (-0.07, -0.04):
        clipped = ingest_all(replace(log, voltages=np.maximum(noisy, low)), calibration, markers)
        assert recorded_faults(clipped) == ("clipped",)
    unused = replace(calibration, matrix=calibration.matrix * [1.0, 1.0, 0.0])
    assert recorded_faults(ingest_all(replace(log, voltages=np.maximum(noisy, -0.04)), unused, markers)) == ()


def test_markers_sampled_at_once_are_left_where_they_are(recordings):
    trial = ingest_all(*recordings, options=replace(TREADMILL, marker_sampling_hz=None))
    as_sampled = trial.values("marker_position_as_sampled")
    assert (trial.values("marker_position") == as_sampled).all()


def test_hidden_marker_is_filled_and_marked(recordings):
    log, calibration, markers = recordings
    positions = markers.positions.copy()
    positions[300:320, 4] = np.nan
    trial = ingest_all(log, calibration, replace(markers, positions=positions))
    hidden = trial.values("marker_hidden")
    assert np.flatnonzero(hidden[:, 4]).tolist() == list(range(299, 319))
    assert hidden.sum() == trial.attributes["hidden_samples"] == 20
    whole = ingest_all(*recordings).values("marker_position")
    assert trial.values("marker_position") == pytest.approx(whole, abs=2e-5)


def bridged(log, calibration, markers):
    return ingest_treadmill(log, calibration, markers, TREADMILL, 4.0, NAMES, bridge_long_gaps=True)


def test_marker_hidden_too_long_is_bridged_and_marked_where_that_is_asked_for(recordings):
    log, calibration, markers = recordings
    positions = markers.positions.copy()
    positions[300:326, 4] = np.nan
    positions[500:510, 4] = np.nan
    changed = replace(markers, positions=positions)
    trial = bridged(log, calibration, changed)
    hidden = trial.values("marker_hidden")
    assert np.flatnonzero(hidden[:, 4]).tolist() == [*range(299, 325), *range(499, 509)]
    assert hidden.sum() == trial.attributes["hidden_samples"] == 36
    # strobed 1.6 ms after the frame, the straight line is told at the frame
    path = trial.values("marker_position_as_sampled")[298:326, 4, 1]
    assert np.diff(path) == pytest.approx(np.full(27, (path[-1] - path[0]) / 27.0), abs=1e-7)
    processing = trial.signals["marker_position"].processing
    assert "longer gaps bridged by straight lines" in processing
    others = [k for k in range(8) if k != 4]
    whole = ingest_all(*recordings).values("marker_position")
    assert (trial.values("marker_position")[:, others] == whole[:, others]).all()
    with pytest.raises(InputError, match="expected gaps of at most"):
        ingest_all(log, calibration, changed)


def test_bridging_changes_nothing_where_no_marker_is_hidden_for_long(recordings):
    log, calibration, markers = recordings
    positions = markers.positions.copy()
    positions[300:325, 4] = np.nan
    changed = replace(markers, positions=positions)
    strict, bridging = ingest_all(log, calibration, changed), bridged(log, calibration, changed)
    for name, signal_ in strict.signals.items():
        assert (bridging.values(name) == signal_.values).all(), name


def changed_line(recording, name, rows, value):
    values = getattr(recording, name).copy()
    values[rows] = value
    return replace(recording, **{name: values})


BAD_RECORDINGS = {
    "the trigger is missing": (0, lambda x: replace(x, trigger=0.0 * x.trigger), "log.mat"),
    "the trigger is high from the start": (
        0,
        lambda x: replace(x, trigger=x.trigger + 5.0),
        "log.mat",
    ),
    "a voltage is missing": (0, lambda x: changed_line(x, "voltages", 77, np.nan), "transducers_V"),
    "a belt velocity is missing": (
        0,
        lambda x: changed_line(x, "belt_velocity", 77, np.nan),
        "belt_velocity",
    ),
    "a command is missing": (0, lambda x: changed_line(x, "command", 77, np.nan), "command"),
    "the channels stand in another order": (
        1,
        lambda x: replace(x, channels=("z2", "z1", "y")),
        "calibration.csv",
    ),
    "the matrix has a channel less": (
        1,
        lambda x: replace(x, channels=("z1", "z2"), matrix=x.matrix[:, :2]),
        "calibration.csv",
    ),
    "the log is slower than the trial": (0, lambda x: replace(x, rate_hz=249.0), "found 249 Hz"),
    "the log ends before the markers": (
        0,
        lambda x: changed_line(x, "trigger", slice(3000, None), 0.0),
        "2.50 s",
    ),
    "the markers end before the log": (
        2,
        lambda x: replace(x, positions=x.positions[:700]),
        "2.80 s",
    ),
    "the markers have another rate": (2, lambda x: replace(x, rate_hz=100.0), "100 Hz"),
    "a marker is hidden too long": (
        2,
        lambda x: changed_line(x, "positions", (slice(300, 326), 4), np.nan),
        "'leg1'",
    ),
    "a marker is never seen": (
        2,
        lambda x: changed_line(x, "positions", (slice(None), 4), np.nan),
        "'leg1'",
    ),
}


@pytest.mark.parametrize("why", BAD_RECORDINGS)
def test_recordings_of_the_treadmill_are_refused_where(why, recordings):
    which, change, found = BAD_RECORDINGS[why]
    changed = list(recordings)
    changed[which] = change(changed[which])
    with pytest.raises(InputError) as caught:
        ingest_all(*changed)
    assert_one_sentence(caught.value, found)


def test_markers_of_another_trial_than_the_logs_are_refused(recordings):
    log, calibration, markers = recordings
    with pytest.raises(InputError) as caught:
        ingest_all(changed_line(log, "trigger", slice(4500, 4900), 5.0), calibration, markers)
    assert_one_sentence(caught.value, "log.mat", "markers.c3d", "4.40 s", "4.00 s")


def test_recordings_shorter_than_the_protocol_are_refused(recordings):
    with pytest.raises(InputError) as caught:
        ingest_all(*recordings, duration_s=70.0)
    assert_one_sentence(caught.value, "70 s", "4.00 s")
    assert ingest_all(*recordings[:2], None).time[-1] > 3.9
    log, calibration, markers = recordings
    short = replace(markers, positions=markers.positions[:985])
    with pytest.raises(InputError, match=r"markers\.c3d: expected 4\.05 s of trial.*3\.94"):
        ingest_all(log, calibration, short, duration_s=4.05)
    with pytest.raises(InputError, match=r"log\.mat: .*70 s.*4\.00 s"):
        ingest_all(*recordings[:2], None, duration_s=70.0)


def read_dummy(files):
    return (
        read_treadmill_log(files["log"]),
        read_calibration_matrix(files["calibration"]),
        read_markers(files["markers"], LABELS),
    )


def test_ingested_motion_of_the_dummy_is_the_laboratorys_motion(short_truth, tmp_path):
    truth = copy.deepcopy(short_truth)
    truth["treadmill"]["capture"] |= {"noise_m": 0.0, "occlusions_per_minute": 0.0, "latency_s": 0.0}
    truth["treadmill"]["drive"] |= {"velocity_noise_m_per_s": 0.0, "velocity_step_m_per_s": 1e-6}
    paths = {n: tmp_path / n for n in ("log", "calibration")} | {"markers": tmp_path / "m.c3d"}
    paths["log"] = tmp_path / "log.mat"
    make_dummy_trial(truth, "sine-0.5", Protocol("sine", 0.5, 2.0, 8.0), paths)
    trial = ingest_all(*read_dummy(paths), duration_s=8.0)
    # the laboratory's own motion, from the same protocol
    started = 0.5 + generator(truth["seed"], "dummy", "sine-0.5").random() / 1000.0
    onsets = started + np.array([2.0])
    motion = move_dummy(
        DummyTruth(**truth["dummy"]["subject"]),
        Rubber(**truth["dummy"]["rubber"]),
        DriveTruth(**truth["treadmill"]["drive"]),
        velocity_command("sine", 0.5, onsets, 0.1),
        9.0,
        INTEGRATION_RATE_HZ,
    )
    before_second = trial.time < 3.9
    at = started + trial.time[before_second]
    markers = trial.values("marker_position")[before_second, 3:, 1:]
    layout = np.array([[0.0, 0.0], *truth["dummy"]["markers"]["leg_m"]])
    angle = fit_rigid_segment(markers, layout, np.array([0.0, 0.4485])).angle
    expected = np.interp(at, motion.time, motion.angle)
    assert np.ptp(expected) > 0.025
    assert angle == pytest.approx(expected, abs=2e-4)
    belt = np.interp(at, motion.time, motion.belt_velocity)
    found = trial.values("belt_velocity")[before_second]
    late = np.interp(at - 0.001, motion.time, motion.belt_velocity)
    assert np.std(found - belt) < 0.6 * np.std(late - belt)
    weight = trial.values("force")[:400, 1, 2].mean()
    assert weight == pytest.approx(2.5 * 9.81, abs=0.5)


# ---- electromyograms beside the treadmill ----------------------------------------------------------


def recorded_emg(rate_hz=1000.0, lead_s=0.7, high_s=4.0, tail_s=0.5):
    """Two muscles whose samples are their own instants on the recorder's clock, and a trigger."""
    samples = round((lead_s + high_s + tail_s) * rate_hz)
    time = np.arange(samples) / rate_hz
    return EmgRecording(
        rate_hz=rate_hz,
        muscles=("TA", "SOL"),
        signals=np.column_stack([time, -time]),
        limits=np.array([[-2343.0, 2343.0]] * 2),
        trigger=np.where((time >= lead_s) & (time < lead_s + high_s - 1e-9), 5.0, 0.0),
        missing=("BF", "RF"),
    )


def test_electromyograms_keep_their_own_clock_counted_from_the_trigger(recordings):
    trial = ingest_all(*recordings)
    whole = with_emg(trial, recorded_emg(), 2.5, 4.0, "emg.edf")
    time = whole.axes["emg_time"]
    assert np.diff(time) == pytest.approx(np.full(time.size - 1, 0.001))
    # the trigger rose between the sample at 0.699 s and that at 0.7 s
    assert time[700] == pytest.approx(0.0005)
    assert whole.values("emg")[:, 0] == pytest.approx(time + 0.6995, abs=1e-6)
    assert whole.signals["emg"].axes == ("emg_time", "muscle")
    assert whole.signals["emg"].unit == "uV"
    assert whole.axes["muscle"].tolist() == ["TA", "SOL"]
    assert whole.attributes["emg_rate_hz"] == 1000.0
    assert whole.attributes["emg_missing"] == "BF, RF"
    assert (whole.time == trial.time).all()


def test_trial_file_tells_the_rate_of_each_clock(recordings, tmp_path):
    trial = with_emg(ingest_all(*recordings), recorded_emg(), 2.5, 4.0, "emg.edf")
    write_trial(tmp_path / "standing.h5", trial, "standing", "relax-pos-0.4", {}, {})
    with h5py.File(tmp_path / "standing.h5") as file:
        assert file["emg"].attrs["rate_hz"] == pytest.approx(1000.0)
        assert file["force"].attrs["rate_hz"] == 250.0
        assert file["emg_time"].attrs["units"] == "s"
    read = read_trial(tmp_path / "standing.h5")
    assert (read.values("emg") == trial.values("emg")).all()
    assert (read.axes["emg_time"] == trial.axes["emg_time"]).all()
    assert read.attributes["emg_missing"] == "BF, RF"
    assert read.attributes["emg_limits_uV"] == [[-2343.0, 2343.0]] * 2


BAD_EMG = {
    "its trigger never rises": (recorded_emg(high_s=0.0, tail_s=5.0), "trigger"),
    "its trigger is high from the start": (recorded_emg(lead_s=0.0), "first sample"),
    "its trigger falls early": (recorded_emg(high_s=3.0, tail_s=2.0), "3.00 s"),
    "it ends early": (recorded_emg(high_s=3.5, tail_s=0.0), "3.50 s"),
}


@pytest.mark.parametrize("why", BAD_EMG)
def test_electromyograms_are_refused_where(why, recordings):
    recording, found = BAD_EMG[why]
    with pytest.raises(InputError) as caught:
        with_emg(ingest_all(*recordings), recording, 2.5, 4.0, "emg.edf")
    assert_one_sentence(caught.value, "emg.edf", found)


# ---- one HDF5 file per trial -------------------------------------------------------------------


@pytest.fixture(scope="module")
def trial_file(dummy_files, tmp_path_factory):
    trial = ingest_all(*read_dummy(dummy_files), duration_s=DUMMY_DURATION_S)
    path = tmp_path_factory.mktemp("trials") / "sine-0.5.h5"
    write_trial(path, trial, "dummy", "sine-0.5", dummy_files, vars(TREADMILL))
    return path, trial


def test_trial_file_gives_back_what_was_written(trial_file):
    path, written = trial_file
    read = read_trial(path)
    assert read.rate_hz == written.rate_hz
    assert read.time.tolist() == written.time.tolist()
    assert read.axes["marker"].tolist() == LABELS
    assert set(read.signals) == set(written.signals)
    for name, signal_ in written.signals.items():
        assert (read.values(name) == signal_.values).all()
        assert read.signals[name].unit == signal_.unit
        assert read.signals[name].axes == signal_.axes
        assert read.signals[name].meaning == signal_.meaning
        assert read.signals[name].processing == signal_.processing
    for name, value in written.attributes.items():
        assert read.attributes[name] == value


def test_every_dataset_of_a_trial_names_its_unit_meaning_and_processing(trial_file):
    with h5py.File(trial_file[0]) as file:
        for name, dataset in file.items():
            if dataset.dtype.kind != "O":
                assert dataset.attrs["units"], name
            if not dataset.is_scale:
                assert dataset.attrs["long_name"], name
                assert dataset.attrs["rate_hz"] == 250.0, name
                assert "processing" in dataset.attrs, name
        assert file["belt_velocity"].attrs["units"] == "m/s"
        assert file["time"].attrs["units"] == "s"
        assert "resampled at 250 Hz" in file["force"].attrs["processing"]


def test_every_axis_of_a_signal_has_its_scale(trial_file):
    with h5py.File(trial_file[0]) as file:
        for name, dataset in file.items():
            if dataset.is_scale:
                continue
            for size, dimension in zip(dataset.shape, dataset.dims, strict=True):
                scale = dimension[0]
                assert dimension.label == scale.name.strip("/"), name
                assert scale.shape == (size,), name
        marker = file["marker_position"]
        assert [d.label for d in marker.dims] == ["time", "marker", "axis"]
        assert marker.dims[2][0].asstr()[...].tolist() == ["x", "y", "z"]


def test_trial_file_names_its_sources_with_their_checksums(trial_file, dummy_files):
    with h5py.File(trial_file[0]) as file:
        sources, options = (json.loads(file.attrs[name]) for name in ("sources", "options"))
        assert (file.attrs["experiment"], file.attrs["condition"]) == ("dummy", "sine-0.5")
    assert set(sources) == {"log", "calibration", "markers"}
    for kind, path in dummy_files.items():
        assert sources[kind]["file"] == str(path)
        assert sources[kind]["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert options == vars(TREADMILL)


def test_checksum_is_sha256_of_the_bytes(tmp_path):
    (tmp_path / "abc").write_bytes(b"abc")
    known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert checksum(tmp_path / "abc") == known


def test_same_trial_written_twice_is_the_same_bytes(trial_file, dummy_files, tmp_path):
    path, trial = trial_file
    write_trial(tmp_path / "again.h5", trial, "dummy", "sine-0.5", dummy_files, vars(TREADMILL))
    assert (tmp_path / "again.h5").read_bytes() == path.read_bytes()


@pytest.mark.parametrize("part", [0.0, 0.01, 0.3, 0.7, 0.99])
def test_truncated_trial_file_is_refused(part, trial_file, tmp_path):
    content = trial_file[0].read_bytes()
    path = tmp_path / "trial.h5"
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(InputError) as caught:
        read_trial(path)
    assert_one_sentence(caught.value, path)


def test_sources_of_a_trial_are_read_alone(trial_file):
    name, sources = read_sources(trial_file[0])
    assert name == "{experiment}/{condition}".format(**read_trial(trial_file[0]).attributes)
    assert sources == json.loads(read_trial(trial_file[0]).attributes["sources"])


def test_markers_that_end_before_the_trial_are_refused(recordings):
    log, calibration, markers = recordings
    short = replace(markers, positions=markers.positions[:900])
    with pytest.raises(InputError) as caught:
        ingest_all(log, calibration, short)
    assert_one_sentence(caught.value, "markers.c3d", "found 3.60 s")
