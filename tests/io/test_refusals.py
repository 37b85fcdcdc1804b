"""Refusals of readers and exports that no other test reads: a good file beside each spoiled one."""

import numpy as np
import pytest
from builders import assert_one_sentence
from scipy.io import savemat

from tepsipe import InputError, Signal, Trial
from tepsipe.io.formats import contents_of, read_all_markers
from tepsipe.io.opensim_export import motion_of, torque_of
from tepsipe.io.readers.dflow import frame_clock, read_dflow
from tepsipe.io.readers.emg_table import read_emg_table
from tepsipe.io.readers.plain_table import read_plain_table
from tepsipe.io.readers.treadmill_log import COMPONENTS, read_calibration_matrix, read_treadmill_log
from tepsipe.io.result import Result

TIME = np.arange(25) / 1000.0


def table(header, *columns, delimiter=","):
    """Text of a table."""
    rows = zip(*columns, strict=True)
    return "\n".join([header, *(delimiter.join(f"{x:.9g}" for x in row) for row in rows), ""])


def put(values, at, value):
    """Samples, one of which is another."""
    changed = np.array(values, dtype=float)
    changed[at] = value
    return changed


def emg(path):
    """Two muscles of a table."""
    return read_emg_table(path, {"TA": "TA", "SOL": "SOL"}, None)


def plain(path):
    """Any table."""
    return read_plain_table(path, "a table")


def dflow(path):
    """Frames of a mocap file."""
    return frame_clock(read_dflow(path))


def mocap(time, frames):
    """Text of a mocap file."""
    return table("TimeStamp\tFrameNumber", time, frames, delimiter="\t")


GOOD = "time (s),TA (mV),SOL (mV)"
FRAMES = np.arange(400)
# reader, text that it takes, text that it refuses, words of the refusal
TEXTS = {
    "emg-gap": (
        emg,
        table(GOOD, TIME, TIME, TIME),
        table(GOOD, TIME, put(TIME, 5, np.nan), TIME),
        "a number in every row of 'TA (mV)', found none on line 7",
    ),
    "emg-one-label-twice": (
        emg,
        table(GOOD, TIME, TIME, TIME),
        table("time (s),TA (mV),TA (V)", TIME, TIME, TIME),
        "one channel named 'TA', found two",
    ),
    "emg-no-time": (
        emg,
        table("X[s],TA (mV),SOL (mV)", TIME, TIME, TIME).replace("X[s]", "time (ms)"),
        table("clock,TA (mV),SOL (mV)", TIME, TIME, TIME),
        "a column of the time",
    ),
    "emg-time-in-minutes": (
        emg,
        table("time (us),TA (mV),SOL (mV)", 1e6 * TIME, TIME, TIME),
        table("time (min),TA (mV),SOL (mV)", TIME, TIME, TIME),
        "the unit 'min'",
    ),
    "emg-of-two-rates": (
        emg,
        table("X[s],TA,X[s],SOL", TIME, TIME, TIME, TIME),
        table("X[s],TA,X[s],SOL", TIME, TIME, 2.0 * TIME, TIME),
        "one sampling rate for all muscles, found 'TA' at 1000 Hz, 'SOL' at 500 Hz",
    ),
    "emg-19-samples": (
        emg,
        table(GOOD, TIME[:20], TIME[:20], TIME[:20]),
        table(GOOD, TIME[:19], TIME[:19], TIME[:19]),
        "at least 20 samples at different times, found 19",
    ),
    "table-without-header": (plain, "a,b,3\n1,2,3\n", "a,2,3\n1,2,3\n", "a header that names the columns"),
    "table-cut-in-its-first-row": (
        plain,
        "a,b\n1,2\n",
        "a,b\n1,2",
        "the file is truncated",
    ),
    "table-of-five-columns-with-two-names": (
        plain,
        "a,b\n" + "1,2\n" * 4,
        "a,b\n1,2\n" + "1,2,3,4,5\n" * 3,
        "the names of 5 columns in the header, found 2",
    ),
    "table-without-a-column": (
        lambda path: plain(path).column("b"),
        "a,b\n1,2\n",
        "a,c\n1,2\n",
        "one column named 'b', found 0",
    ),
    "table-with-1e101": (plain, "a,b\n1,1e99\n", "a,b\n1,1e101\n", "found 1e+101 in column 'b' on line 2"),
    "frames-with-a-fraction": (
        dflow,
        mocap(FRAMES / 100.0, FRAMES),
        mocap(FRAMES / 100.0, put(FRAMES, 3, 3.5)),
        "whole numbers in 'FrameNumber', found 3.5 on line 5",
    ),
    "frames-at-20-kHz": (
        dflow,
        mocap(FRAMES / 9e3, FRAMES),
        mocap(FRAMES / 2e4, FRAMES),
        "frames at 1 to 10000 Hz, found 5e-05 s",
    ),
    "frames-in-milliseconds": (
        dflow,
        mocap(FRAMES / 100.0, FRAMES),
        mocap(10.0 * FRAMES, FRAMES),
        "found 10 s between frames",
    ),
    "matrix-of-another-component": (
        read_calibration_matrix,
        "component,unit,a\n" + "".join(f"{c},{'N/V' if c[0] == 'F' else 'Nm/V'},1\n" for c in COMPONENTS),
        "component,unit,a\nFq,N/V,1\n",
        "found 'Fq' on line 2",
    ),
    "models-that-are-other-json": (
        contents_of,
        '{"format": "tepsipe-treadmill-models", "models": []}',
        '{"format": "tepsipe-treadmill-models", "models": [1]}',
        "a file of treadmill models, found other JSON",
    ),
}


@pytest.mark.parametrize("name", TEXTS)
def test_a_spoiled_text_is_refused_at_its_place(name, tmp_path):
    reader, good, bad, words = TEXTS[name]
    path = tmp_path / ("file.json" if good.startswith("{") else "file.txt")
    path.write_text(good)
    reader(path)
    path.write_text(bad)
    with pytest.raises(InputError) as caught:
        reader(path)
    assert_one_sentence(caught.value, "file.", words)


def test_a_log_has_two_samples_or_more(tmp_path):
    def log(samples):
        line = np.zeros(samples)
        content = {"transducers_V": np.zeros((samples, 1)), "sample_rate_hz": 1000.0}
        content |= {"channel_names": np.array(["a"], dtype=object), "trigger_V": line}
        content |= {"belt_velocity_m_per_s": line, "command_m_per_s": line}
        savemat(tmp_path / "log.mat", content, oned_as="column")
        return tmp_path / "log.mat"

    assert read_treadmill_log(log(2)).voltages.shape == (2, 1)
    with pytest.raises(InputError, match=r"log\.mat: expected a time series .*, found 1 samples"):
        read_treadmill_log(log(1))


def test_a_log_is_no_file_of_markers(tmp_path):
    path = tmp_path / "record.txt"
    path.write_text(table("Time\tLeftBeltSpeed", FRAMES, FRAMES, delimiter="\t"))
    with pytest.raises(InputError, match=r"record\.txt: expected markers as .*, found "):
        read_all_markers(path)


TRIAL = Trial(1000.0, {"time": TIME}, {"speed": Signal(TIME, "m/s")})
FIT = Result({"leg/torque": TIME, "leg/angle": TIME}, dict.fromkeys(["leg/torque", "leg/angle"], "1"), {})
# call that is refused, words of the refusal
OBJECTS = {
    "signal-of-unit-1": (lambda: Signal(TIME, 1), "Signal: expected a unit as text, found "),
    "trial-with-a-list": (lambda: Trial(1000.0, {"time": TIME}, [TIME]), "Trial: expected signals by name"),
    "trial-without-time": (
        lambda: Trial(1000.0, {}, {}).time,
        "trial: expected the axis 'time'",
    ),
    "motion-of-a-speed": (
        lambda: motion_of(TRIAL, "walk"),
        "walk: expected an angle or forces of",
    ),
    "torque-of-a-speed": (lambda: torque_of(TRIAL, "walk"), "walk: expected a torque, found 'speed'"),
    "torque-of-no-pathway": (
        lambda: torque_of(FIT, "fit", TRIAL, pathway="foot"),
        "fit: expected the pathway 'foot', found 'leg'",
    ),
    "motion-of-another-trial": (
        lambda: motion_of(FIT, "fit", Trial(1000.0, {"time": TIME[1:]}, {})),
        "fit: expected the time of 25 samples, found 24",
    ),
}


@pytest.mark.parametrize("name", OBJECTS)
def test_a_wrong_object_is_refused(name):
    call, words = OBJECTS[name]
    with pytest.raises(InputError) as caught:
        call()
    assert_one_sentence(caught.value, words)


def test_the_same_objects_that_fit_are_exported():
    assert torque_of(FIT, "fit", TRIAL, pathway="leg").columns["ankle_angle_r_moment"].size == TIME.size
    assert motion_of(FIT, "fit", TRIAL).time.size == TIME.size


def test_a_file_that_may_not_be_read_is_refused(tmp_path, monkeypatch):
    def forbidden(*_):
        raise PermissionError

    path = tmp_path / "table.txt"
    path.write_text("a,b\n1,2\n")
    monkeypatch.setattr("pathlib.Path.read_bytes", forbidden)
    with pytest.raises(
        InputError, match=r"table\.txt: expected a table, found a file that this user may not"
    ):
        plain(path)
