"""Trials as text give the same I, B and K as the instruments' own files."""

import copy
import gzip
import shutil
from dataclasses import replace

import numpy as np
import pytest
import yaml
from builders import DUMMY_DURATION_S, assert_one_sentence, trial_of
from dflow_builders import write_mocap, write_record

from tepsipe.errors import InputError
from tepsipe.experiments.dummy.leg_pathways import analyse_dummy
from tepsipe.ingest.plate_treadmill import ingest_treadmill_files
from tepsipe.ingest.standing import with_emg
from tepsipe.ingest.treadmill_options import (
    Axes,
    BeltVelocity,
    PlateNumbers,
    RecordingOptions,
    TreadmillOptions,
)
from tepsipe.ingest.whole_trial import ingest_recording_files
from tepsipe.io.formats import contents_of, read_markers
from tepsipe.io.readers.recording import EmgRecording
from tepsipe.io.readers.treadmill_log import read_treadmill_log
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.new_study.study import new_study
from tests.experiments.test_dummy_leg_pathways import OPTIONS, Pathway
from workflow.support.trial_sheet import read_trial_sheet

LABELS = ["foot1", "foot2", "foot3", "ankle", "leg1", "leg2", "leg3", "leg4"]
FEET = ("foot1", "foot2", "foot3")
INGEST = TreadmillOptions(250.0, 0.1, 2500.0, 2.5)
LATE_S, FIRST_S = 1.7, 500.0
# x to the right, y forward, z up -> D-Flow's x to the right, y up, z backward
TO_DFLOW = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
DFLOW = RecordingOptions(
    axes=Axes("-z", "+y"),
    plates=PlateNumbers((1,), (2,)),
    belt_velocity=BeltVelocity("RightBelt.Speed", -1.0, markers=FEET),
)
TABLE = RecordingOptions(plates=PlateNumbers((1,), (2,)), belt_velocity=BeltVelocity("belt"))


# markers of the shipped laboratory
MARKED = replace(
    OPTIONS,
    leg_markers=SegmentMarkers(
        OPTIONS.leg_markers.labels,
        np.array([[0.0, 0.0], [-0.012, 0.6], [0.012, 0.5], [-0.012, 0.4], [0.012, 0.3]]),
    ),
)


def parameters(trial):
    """I, B and K of the dummy by the recommended pathway."""
    pathway = Pathway("leg", "aligned", "windowed-least-squares")
    return analyse_dummy(trial, MARKED, {"leg": pathway}).regressions["leg"].mean


@pytest.fixture(scope="module")
def raw(dummy_files):
    """Signals of the dummy's trial on the clock of the frames, and its log: what every format is made of."""
    trial = ingest_treadmill_files(dummy_files, LABELS, INGEST, DUMMY_DURATION_S)
    markers = read_markers(dummy_files["markers"], LABELS)
    n = markers.positions.shape[0]
    load = np.concatenate([trial.values("force"), trial.values("moment")], axis=2).astype(float)
    log = read_treadmill_log(dummy_files["log"])
    edge = int(np.argmax(log.trigger > 2.5))
    time = (np.arange(log.trigger.size) - edge + 0.5) / log.rate_hz
    return {
        "trial": trial,
        "positions": markers.positions,
        "load": np.concatenate([load[:1].repeat(n - load.shape[0], axis=0), load]),
        "log_time": time,
        "log_velocity": log.belt_velocity,
        "velocity": np.interp(np.arange(n) / 250.0, time, log.belt_velocity),
    }


@pytest.fixture(scope="module")
def dflow_files(raw, tmp_path_factory):
    """The trial as D-Flow writes it: frames dropped and repeated, an irregular record file, wrong stamps."""
    folder = tmp_path_factory.mktemp("dflow")
    rng = np.random.default_rng(5)
    n = len(raw["positions"])
    rows = np.sort(np.concatenate([np.delete(np.arange(n), [400, 1203, 1204, 2111]), [77, 1500, 1500, 2600]]))
    turned = raw["positions"] @ TO_DFLOW.T
    six = {
        number: np.hstack([raw["load"][:, k, :3] @ TO_DFLOW.T, raw["load"][:, k, 3:] @ TO_DFLOW.T])
        for k, number in enumerate((1, 2))
    }
    stamps = FIRST_S + np.arange(n) / 250.0 + 0.002 * rng.random(n)
    stamps[900:930] = stamps[930]  # frames that queued up
    markers = dict(zip(LABELS, turned.transpose(1, 0, 2), strict=True))
    mocap = write_mocap(
        folder / "Mocap0001.txt", 250.0, markers, six, rows, stamps=np.maximum.accumulate(stamps)
    )
    picked = np.cumsum(rng.integers(2, 6, raw["log_time"].size // 3))
    picked = picked[picked < raw["log_time"].size]
    time, speed = raw["log_time"][picked], -raw["log_velocity"][picked]
    record = write_record(
        folder / "Record0001.txt",
        FIRST_S + time + LATE_S + 0.0005 * rng.random(time.size),
        {"LeftBelt.Speed": 0.0 * speed, "RightBelt.Speed": speed},
    )
    return {"log": str(record), "markers": str(mocap)}


@pytest.fixture(scope="module")
def expected(raw):
    return parameters(raw["trial"])


def test_trial_as_dflow_text(dflow_files, raw, expected):
    trial = ingest_recording_files(dflow_files, LABELS, INGEST, DFLOW, DUMMY_DURATION_S)
    inertia, damping, stiffness = parameters(trial)
    assert inertia == pytest.approx(expected[0], abs=2e-4)
    assert damping == pytest.approx(expected[1], rel=0.01)
    assert stiffness == pytest.approx(expected[2], rel=0.01)
    inside = slice(50, -50)
    reference, n = raw["trial"], trial.time.size
    assert n >= reference.time.size - 2
    for name, tolerance in (("belt_velocity", 0.03), ("force", 1.0), ("moment", 0.2)):
        away = np.abs(trial.values(name)[inside] - reference.values(name)[:n][inside])
        assert np.median(away) < tolerance / 10.0, name
        assert np.quantile(away, 0.999) < tolerance, name


def table_of(raw, with_markers):
    """The trial as one table at the rate of the frames."""
    names, columns = ["time (s)", "belt (m/s)"], [np.arange(len(raw["velocity"])) / 250.0, raw["velocity"]]
    for k, belt in enumerate(("left", "right")):
        names += [
            f"{kind}{axis}_{belt} ({unit})" for kind, unit in (("F", "N"), ("M", "Nm")) for axis in "xyz"
        ]
        columns += list(raw["load"][:, k].T)
    if with_markers:
        names += [f"{label}_{axis} (mm)" for label in LABELS for axis in "xyz"]
        columns += list(1000.0 * raw["positions"].reshape(len(raw["velocity"]), -1).T)
    return names, np.column_stack(columns)


def write_csv(path, names, values):
    rows = np.char.replace(np.char.mod("%.6f", values), "nan", "")
    path.write_text("\n".join([",".join(names), *(",".join(row) for row in rows)]) + "\n")
    return str(path)


def write_trc(path, positions):
    n = len(positions)
    head = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits",
        f"250\t250\t{n}\t{len(LABELS)}\tmm",
        "Frame#\tTime\t" + "\t\t\t".join(LABELS),
        "",
    ]
    values = np.char.replace(np.char.mod("%.4f", 1000.0 * positions.reshape(n, -1)), "nan", "")
    rows = ["\t".join([f"{k + 1}", f"{k / 250.0:.4f}", *row]) for k, row in enumerate(values)]
    path.write_text("\n".join(head + rows) + "\n")
    return str(path)


@pytest.mark.slow
@pytest.mark.parametrize("with_trc", [False, True])
def test_trial_as_tables(raw, expected, tmp_path, with_trc):
    files = {"log": write_csv(tmp_path / "trial.csv", *table_of(raw, not with_trc))}
    if with_trc:
        files["markers"] = write_trc(tmp_path / "trial.trc", raw["positions"])
    trial = ingest_recording_files(files, LABELS, INGEST, TABLE, DUMMY_DURATION_S)
    assert parameters(trial) == pytest.approx(expected, rel=0.01, abs=2e-4)
    n = trial.time.size
    assert trial.values("force")[: n - 1] == pytest.approx(raw["trial"].values("force")[: n - 1], abs=1e-3)


def refused(path, match, files, use=DFLOW):
    with pytest.raises(InputError, match=match) as caught:
        ingest_recording_files(files, LABELS, INGEST, use, DUMMY_DURATION_S)
    assert_one_sentence(caught.value, path)


def test_files_that_are_not_of_one_trial_are_refused(dflow_files, raw, tmp_path):
    record, mocap = dflow_files["log"], dflow_files["markers"]
    refused(mocap, "name the mocap file in the column", {"log": mocap, "markers": mocap})
    table = write_csv(tmp_path / "trial.csv", *table_of(raw, False))
    refused(table, "a text file of D-Flow beside the other one", {"log": record, "markers": table})
    refused(record, "mocap module", {"log": record})
    short = write_trc(tmp_path / "short.trc", raw["positions"][:-500])
    refused(short, "must begin and end together", {"log": table, "markers": short}, TABLE)
    refused(table, "expected columns of markers", {"log": table, "markers": table}, TABLE)


def test_another_trials_record_file_is_refused(dflow_files, raw, tmp_path):
    other = copy.deepcopy(dflow_files)
    rng = np.random.default_rng(8)
    time = np.arange(0.0, DUMMY_DURATION_S, 0.004)
    speed = np.convolve(rng.standard_normal(time.size), np.hanning(25) / 12.0, "same")
    path = write_record(tmp_path / "Record0002.txt", FIRST_S + time, {"RightBelt.Speed": speed})
    refused(path, "it is of another trial", other | {"log": str(path)})


def test_electromyograms_at_an_odd_rate_are_resampled_to_a_multiple():
    rate, onset = 2000.0 / 1.08, 1.2345
    time = np.arange(round(6.0 * rate)) / rate
    burst = np.exp(-(((time - onset - 2.0) / 0.02) ** 2))
    recording = EmgRecording(
        rate, ("TA",), burst[:, None], 5.0 * (time >= onset), np.array([[-1.0, 1.0]]), ()
    )
    trial = with_emg(trial_of(250.0, angle=(np.zeros(1000), "rad")), recording, 2.5, 4.0, "emg.csv")
    assert trial.attributes["emg_rate_hz"] == 1750.0
    emg, instants = trial.values("emg")[:, 0], trial.axes["emg_time"]
    assert np.diff(instants) == pytest.approx(1.0 / 1750.0)
    middle = np.sum(emg * instants) / np.sum(emg)
    assert middle == pytest.approx(2.0, abs=0.5 / rate + 1e-5)
    assert "resampled from 1851.85 to 1750 Hz" in trial.signals["emg"].processing


def test_recorder_that_the_trigger_started_needs_no_trigger_channel():
    samples = np.arange(4500.0)[:, None]
    recording = EmgRecording(1000.0, ("TA",), samples, None, np.array([[0.0, 4499.0]]), ())
    trial = with_emg(trial_of(250.0, angle=(np.zeros(1000), "rad")), recording, 2.5, 4.0, "emg.csv")
    assert trial.axes["emg_time"] == pytest.approx(np.arange(4500) / 1000.0)
    assert trial.values("emg").tolist() == samples.tolist()
    with pytest.raises(InputError, match="expected 5 s of trial"):
        with_emg(trial, recording, 2.5, 5.0, "emg.csv")


def test_compressed_c3d_is_the_same(dummy_files, raw, tmp_path):
    packed = tmp_path / "markers.c3d.gz"
    packed.write_bytes(gzip.compress(dummy_files["markers"].read_bytes(), compresslevel=1))
    assert np.array_equal(read_markers(packed, LABELS).positions, raw["positions"], equal_nan=True)
    cut = tmp_path / "cut.c3d.gz"
    cut.write_bytes(gzip.compress(dummy_files["markers"].read_bytes()[:-5000], compresslevel=1))
    with pytest.raises(InputError, match="truncated") as caught:
        read_markers(cut, LABELS)
    assert_one_sentence(caught.value, cut)


def test_trc_replaces_the_c3d_beside_a_log(dummy_files, raw, expected, tmp_path):
    files = dummy_files | {"markers": write_trc(tmp_path / "markers.trc", raw["positions"])}
    trial = ingest_treadmill_files(files, LABELS, INGEST, DUMMY_DURATION_S)
    assert parameters(trial) == pytest.approx(expected, rel=1e-3, abs=1e-5)


def test_info_shows_both_files_of_dflow(dflow_files):
    mocap, record = (contents_of(dflow_files[kind]) for kind in ("markers", "log"))
    assert mocap.kind == "D-Flow text, mocap module"
    assert mocap.facts["frames"].endswith("4 repeated, 4 dropped")
    assert mocap.facts["force plates"] == "FP1, FP2"
    assert {c.name: c.unit for c in mocap.channels}["foot1"] == "m"
    assert record.kind == "D-Flow text, record module"
    assert record.facts["belt speeds"] == "LeftBelt.Speed, RightBelt.Speed"


def write_sheet(path, header, rows):
    path.write_text("".join("\t".join(cells) + "\n" for cells in (header, *rows)))


def test_trial_sheet_takes_a_pair_of_text_files_and_no_calibration(tmp_path):
    header = (
        "experiment condition source profile amplitude interval_s duration_s log command calibration markers"
    )
    cells = ["dummy", "a", "recorded", "-", "-", "-", "12", "Record0001.txt", "-", "-", "Mocap0001.txt"]
    path = tmp_path / "trials.tsv"
    write_sheet(path, header.split(), [cells])
    row = read_trial_sheet(path, "folder")["dummy", "a"]
    assert row.files == {"log": "folder/Record0001.txt", "markers": "folder/Mocap0001.txt"}
    cells[0] = "empty"  # its forces are in the mocap file
    other = ["empty", "b", *cells[2:7], "Record0002.txt", "-", "-", "Mocap0002.txt", "validate"]
    write_sheet(path, [*header.split(), "role"], [[*cells, "calibrate"], other])
    assert read_trial_sheet(path, "folder")["empty", "a"].files == row.files
    cells[0], cells[9] = "dummy", "plate.csv"
    write_sheet(path, header.split(), [cells])
    with pytest.raises(InputError, match="for the calibration of dummy/a"):
        read_trial_sheet(path, "folder")


@pytest.mark.slow
def test_new_study_pairs_text_files(raw, dflow_files, tmp_path):
    for kind in ("dflow", "table"):
        (tmp_path / kind).mkdir()
    for path in dflow_files.values():
        shutil.copy(path, tmp_path / "dflow")
    write_csv(tmp_path / "table/trial.csv", *table_of(raw, False))
    write_trc(tmp_path / "table/trial.trc", raw["positions"])
    pairs = {"dflow": ("Record0001.txt", "Mocap0001.txt"), "table": ("trial.csv", "trial.trc")}
    for kind, (log, markers) in pairs.items():
        new_study(tmp_path / kind, output=tmp_path / f"{kind}-study")
        (row,) = read_trial_sheet(tmp_path / f"{kind}-study/trials.tsv", "").values()
        assert row.files == {"log": log, "markers": markers}
        found = yaml.safe_load((tmp_path / f"{kind}-study/config.yaml").read_text())["plate_treadmill"]
        velocity = found["recording"]["belt_velocity"]
        if kind == "dflow":
            assert (velocity["channel"], velocity["m_per_s_per_unit"]) == ("RightBelt.Speed", -1.0)
            assert set(velocity["markers"]) <= set(LABELS[:4])
        else:
            assert (velocity["channel"], velocity["m_per_s_per_unit"]) == ("belt", 1.0)
