"""D-Flow's text files become one recording on the clock of the frames, or are refused in one sentence."""

import gzip

import numpy as np
import pytest
from builders import assert_one_sentence, belt_pulses
from dflow_builders import write_mocap, write_record, write_rows

from tepsipe.errors import InputError
from tepsipe.ingest.dflow import read_dflow_files
from tepsipe.io.formats import recognised
from tepsipe.io.readers import dflow

RATE_HZ = 100.0
SECONDS = 20.0
ONSETS_S = (4.0, 7.1, 9.3, 13.7)
BELT_FIXED = ("HEEL",)


@pytest.fixture
def truth(rng):
    """Belt-fixed marker (m) and belt speed (m/s) as functions of time, and a load, at the frames."""
    time = np.arange(round(SECONDS * RATE_HZ)) / RATE_HZ
    position, speed, _ = belt_pulses(time, ONSETS_S, 0.5)
    noise = 1e-4 * rng.standard_normal((time.size, 3))
    heel = np.column_stack([0.1 + 0.0 * time, 0.05 + 0.0 * time, -0.2 + position]) + noise
    load = np.column_stack([np.sin(k + time) * (k + 1.0) for k in range(6)])
    return {"time": time, "heel": heel, "speed": speed, "load": load}


def record_instants(rng, late_s=0.0, first_s=208.0):
    """Irregular instants (s on D-Flow's clock) of a record file, and the true time at each of them."""
    true = np.cumsum(rng.uniform(0.002, 0.006, 6000)) - 1.0
    true = true[true < SECONDS + 1.0]
    return first_s + true + late_s, true


@pytest.fixture
def files(truth, tmp_path, rng):
    """Write a good pair of files, changed as the arguments say; return their paths."""

    def write(late_s=0.0, shift_s=0.0, frames=False, rows=None, stamps=None, scale=1.0, **markers):
        mocap = tmp_path / "Mocap0001.txt"
        write_mocap(
            mocap, RATE_HZ, {"HEEL": truth["heel"], **markers}, {1: truth["load"]}, rows, stamps=stamps
        )
        stamp, true = record_instants(rng, late_s)
        speed = scale * belt_pulses(true + shift_s, ONSETS_S, 0.5)[1]
        counter = 7001 + np.floor(true * RATE_HZ) if frames else None
        record = write_record(
            tmp_path / "Record0001.txt",
            stamp,
            {"LeftBeltSpeed": speed, "RightBeltSpeed": 0.0 * speed},
            counter,
        )
        return mocap, record

    return write


def recording_of(mocap, record=None, belt_fixed=BELT_FIXED):
    return read_dflow_files(mocap, record, belt_fixed)


# ---- the mocap file ----------------------------------------------------------------------------


def test_markers_forces_and_clock_of_a_mocap_file(files, truth):
    found = recording_of(files()[0])
    assert found.markers.rate_hz == RATE_HZ
    assert found.markers.labels == ("HEEL",)
    assert found.markers.positions[:, 0] == pytest.approx(truth["heel"], abs=1e-6)
    assert len(found.plates) == 1
    assert found.plates[0].force == pytest.approx(truth["load"][:, :3], abs=1e-6)
    assert found.plates[0].moment == pytest.approx(truth["load"][:, 3:], abs=1e-6)
    assert found.channels["FP1.MomX"].unit == "Nm"


def test_dropped_frames_are_gaps_and_repeated_ones_go(files, truth):
    n = truth["time"].size
    rows = np.sort(np.concatenate([np.delete(np.arange(n), [50, 51, 700]), [10, 10, 900]]))
    found = recording_of(files(rows=rows)[0])
    missing = np.isnan(found.markers.positions[:, 0, 0])
    assert np.flatnonzero(missing).tolist() == [50, 51, 700]
    assert found.markers.positions[~missing, 0] == pytest.approx(truth["heel"][~missing], abs=1e-6)
    between = found.plates[0].force[50:52, 1] - truth["load"][[49, 52], 1] @ [[2 / 3, 1 / 3], [1 / 3, 2 / 3]]
    assert between == pytest.approx(np.zeros(2), abs=1e-5)


def test_stamps_that_queue_up_do_not_move_the_frames(files, truth, rng):
    stamps = 208.0 + truth["time"] + 0.002 * rng.random(truth["time"].size)
    stamps[600:640] = stamps[640]
    found = recording_of(files(stamps=np.maximum.accumulate(stamps))[0])
    assert found.markers.rate_hz == RATE_HZ
    assert found.markers.positions[:, 0] == pytest.approx(truth["heel"], abs=1e-6)


def test_hidden_markers_are_nan_whether_zero_or_held(files, truth):
    zero, kept = truth["heel"].copy(), truth["heel"].copy()
    zero[100:105] = 0.0
    kept[200:220] = kept[199]
    kept[300] = kept[299]  # two equal frames can be a measurement
    found = recording_of(files(ZERO=zero, KEPT=kept)[0]).markers
    hidden = np.isnan(found.positions[:, :, 0])
    assert np.flatnonzero(hidden[:, found.labels.index("ZERO")]).tolist() == list(range(100, 105))
    assert np.flatnonzero(hidden[:, found.labels.index("KEPT")]).tolist() == list(range(200, 220))


def test_regular_stamps_replace_a_missing_counter(truth, tmp_path, rng):
    columns = [208.0 + truth["time"], *truth["heel"].T]
    path = write_rows(tmp_path / "m.txt", ["TimeStamp", "HEEL.PosX", "HEEL.PosY", "HEEL.PosZ"], columns)
    assert recording_of(path).markers.positions.shape == (truth["time"].size, 1, 3)
    kept = np.delete(np.arange(truth["time"].size), [5, 6, 90])
    write_rows(path, ["TimeStamp", "HEEL.PosX", "HEEL.PosY", "HEEL.PosZ"], [x[kept] for x in columns])
    missing = np.isnan(recording_of(path).markers.positions[:, 0, 0])
    assert np.flatnonzero(missing).tolist() == [5, 6, 90]
    columns[0] = np.sort(rng.uniform(208.0, 228.0, truth["time"].size))
    write_rows(path, ["TimeStamp", "HEEL.PosX", "HEEL.PosY", "HEEL.PosZ"], columns)
    with pytest.raises(InputError, match="time stamps of a regular clock"):
        recording_of(path)


# ---- mocap and record together -----------------------------------------------------------------


@pytest.mark.parametrize("late_s", [0.0, 1.234, -3.7])
def test_belt_speed_is_aligned_by_the_belt_fixed_markers(files, truth, late_s):
    speed = recording_of(*files(late_s=late_s)).channels["LeftBeltSpeed"]
    inside = np.isfinite(speed.values)
    assert inside.mean() > 0.75
    assert speed.unit == "m/s"
    assert speed.rate_hz == RATE_HZ
    # a tenth of a frame of the steepest slope
    slope = np.abs(np.gradient(truth["speed"])).max()
    assert np.abs(speed.values - truth["speed"])[inside].max() < 0.2 * slope


def test_frame_counter_goes_before_stamps(files, truth):
    speed = recording_of(*files(late_s=4.0, frames=True)).channels["LeftBeltSpeed"].values
    inside = np.isfinite(speed)
    slope = np.abs(np.gradient(truth["speed"])).max()
    assert np.abs(speed - truth["speed"])[inside].max() < 0.7 * slope


def test_common_channel_aligns_without_belt_fixed_markers(files, truth, tmp_path, rng):
    mocap, _ = files()
    stamp, true = record_instants(rng, late_s=0.8)
    columns = [stamp, belt_pulses(true, ONSETS_S, 0.5)[1], 2.0 * np.sin(1.0 + true)]
    record = write_rows(tmp_path / "Record.txt", ["Time", "LeftBeltSpeed", "FP1.ForY"], columns)
    found = recording_of(mocap, record, ())
    speed = found.channels["LeftBeltSpeed"].values
    inside = np.isfinite(speed)
    assert np.abs(speed - truth["speed"])[inside].max() < 0.1
    assert found.channels["FP1.ForY"].values == pytest.approx(truth["load"][:, 1], abs=1e-6)


def test_constant_speed_needs_no_alignment(files, tmp_path, rng):
    mocap, _ = files()
    stamp, true = record_instants(rng)
    record = write_rows(tmp_path / "Record.txt", ["Time", "LeftBeltSpeed"], [stamp, 1.25 + 0.0 * true])
    assert np.nanmean(recording_of(mocap, record).channels["LeftBeltSpeed"].values) == pytest.approx(1.25)


def test_compressed_files_are_the_same(files):
    plain = files()
    packed = [path.with_name(path.name + ".gz") for path in plain]
    for path, other in zip(plain, packed, strict=True):
        other.write_bytes(gzip.compress(path.read_bytes()))
        assert recognised(other) is dflow.FORMAT
    a, b = recording_of(*plain), recording_of(*packed)
    assert np.array_equal(a.markers.positions, b.markers.positions)
    assert np.array_equal(
        a.channels["LeftBeltSpeed"].values, b.channels["LeftBeltSpeed"].values, equal_nan=True
    )


# ---- what is refused ---------------------------------------------------------------------------


def refused(path, match, call):
    with pytest.raises(InputError, match=match) as caught:
        call()
    assert_one_sentence(caught.value, path)


def test_truncated_and_damaged_text_is_refused(files):
    mocap, _ = files()
    text = mocap.read_text()
    line = text.splitlines()[500]
    for change, match in (
        (text[: text.index(line) + 30], "truncated"),
        (text.replace(line, line + "\t1.0"), "line is damaged"),
        (text.replace(line, line[:60]), "fields on every line"),
        (text.replace(line, line[:-3] + "x.y"), "expected a number"),
        (text.splitlines()[0], "found none"),
        ("", "an empty file"),
        (text.replace("TimeStamp", "Stamp"), "'TimeStamp' or 'Time'"),
        (text.replace("HEEL.PosX", "HEEL.PosY"), "one column named 'HEEL.PosY'"),
        (text.replace("FP1.MomZ", "Other"), "none named 'FP1.MomZ'"),
    ):
        mocap.write_text(change)
        refused(mocap, match, lambda: recording_of(mocap))


def test_last_line_without_its_end_is_left_out(files, truth):
    mocap, _ = files()
    mocap.write_text(mocap.read_text()[:-3])
    assert recording_of(mocap).markers.positions.shape[0] == truth["time"].size - 1


@pytest.mark.parametrize(
    ("rows", "match"),
    [
        (np.r_[0:500, 400:900], "time to increase|jumping back from 7500 to 7401 on line 502"),
        (np.r_[0:500, 560:900], "found 0.6 s from line 501 on"),
        (np.arange(5), "at least 20 frames"),
    ],
)
def test_frames_that_jump_are_refused(files, truth, rows, match):
    mocap, _ = files(rows=rows)
    refused(mocap, match, lambda: recording_of(mocap))


def test_record_of_another_trial_is_refused(files, rng):
    for changes, match in (
        ({"late_s": 300.0}, "it is of another trial"),
        ({"scale": 0.6}, "0.(59|60|61) times that"),
    ):
        mocap, record = files(**changes)
        refused(record, match, lambda m=mocap, r=record: recording_of(m, r))
    mocap, record = files()
    stamp, true = record_instants(rng)
    early = true < 0.495 * SECONDS  # by its stamps, which are late, it covers more than a half
    write_record(record, stamp[early] + 0.3, {"LeftBeltSpeed": belt_pulses(true[early], ONSETS_S, 0.5)[1]})
    refused(record, "it is of another trial, or was stopped early", lambda: recording_of(mocap, record))
    write_record(record, stamp, {"LeftBeltSpeed": belt_pulses(true, (5.0, 6.6, 11.2, 12.0), 0.5)[1]})
    refused(record, "correlation at least 0.7", lambda: recording_of(mocap, record))


def test_record_that_cannot_be_aligned_or_is_a_mocap_file_is_refused(files):
    mocap, record = files()
    refused(record, "a signal that the mocap file holds", lambda: recording_of(mocap, record, ()))
    refused(mocap, "name the mocap file in the column", lambda: recording_of(mocap, mocap))
    refused(record, "name the file of D-Flow's mocap module", lambda: recording_of(record))
    write_record(record, 208.0 + np.arange(3000) / 250.0, {"LeftBeltSpeed": np.full(3000, np.nan)})
    refused(record, "found no numbers", lambda: recording_of(mocap, record))
    write_record(record, 208.0 + np.arange(19) / 20.0, {"LeftBeltSpeed": np.arange(19.0)})
    refused(record, "at least 20 samples at different times, found 19", lambda: recording_of(mocap, record))
    files()
    refused(mocap, "the belt-fixed marker 'TOE'", lambda: recording_of(mocap, record, ("TOE",)))
