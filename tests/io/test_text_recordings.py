"""Trials, markers and electromyograms from text: plain tables, TRC, exports of Delsys."""

import gzip

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.io.formats import contents_of, read_emg, read_recording
from tepsipe.io.readers.clock import bridged
from tepsipe.io.readers.plain_table import read_plain_table
from tepsipe.io.readers.signal_table import read_table_recording, split_unit
from tepsipe.io.readers.trc import read_trc

TABLE = """time (s);belt_m_per_s;Fx_right (N);Fy_right;Fz_right;Mx_right;My_right;Mz_right (Nmm);\
Fx_left;Fy_left;Fz_left (kN);Mx_left;My_left;Mz_left;HEEL_x (mm);HEEL_y (mm);HEEL_z (mm);EMG TA [uV]
"""


def rows_of(n=40, rate_hz=50.0):
    """A table whose column c holds c + row/100, and its time."""
    values = np.arange(18.0) + np.arange(n)[:, None] / 100.0
    values[:, 0] = 3.0 + np.arange(n) / rate_hz
    return values


def write_table(path, values, header=TABLE, delimiter=";", decimal="."):
    lines = [delimiter.join("" if np.isnan(x) else f"{x:.5f}" for x in row) for row in values]
    path.write_text(header + "\n".join(lines).replace(".", decimal) + "\n")
    return path


def refused(path, match, call):
    with pytest.raises(InputError, match=match) as caught:
        call()
    assert_one_sentence(caught.value, path)


# ---- a whole trial in one table ----------------------------------------------------------------


@pytest.mark.parametrize("decimal", [".", ","])
def test_table_of_a_trial_holds_plates_markers_and_channels(tmp_path, decimal):
    values = rows_of()
    found = read_recording(write_table(tmp_path / "trial.csv", values, decimal=decimal))
    left, right = found.plates
    assert left.rate_hz == found.markers.rate_hz == 50.0
    assert left.force == pytest.approx(values[:, 8:11] * [1.0, 1.0, 1000.0])
    assert right.moment == pytest.approx(values[:, 5:8] * [1.0, 1.0, 1e-3])
    assert found.markers.labels == ("HEEL",)
    assert found.markers.positions[:, 0] == pytest.approx(1e-3 * values[:, 14:17])
    assert found.channels["belt"].values == pytest.approx(values[:, 1])
    assert (found.channels["belt"].unit, found.channels["EMG TA"].unit) == ("m/s", "uV")


def test_missing_samples_are_gaps_of_markers_and_bridged_elsewhere(tmp_path):
    values = rows_of()
    values[10:12, 14:17] = np.nan
    values[20, 9] = np.nan
    found = read_recording(write_table(tmp_path / "trial.csv", np.delete(values, 30, axis=0)))
    hidden = np.isnan(found.markers.positions[:, 0, 0])
    assert np.flatnonzero(hidden).tolist() == [10, 11, 30]
    assert found.plates[0].force[:, 1] == pytest.approx(np.arange(40) / 100.0 + 9.0)


def test_compressed_table_is_the_same(tmp_path):
    plain = write_table(tmp_path / "trial.csv", rows_of())
    packed = tmp_path / "trial.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    assert np.array_equal(read_recording(packed).plates[0].force, read_recording(plain).plates[0].force)


def test_table_of_a_real_walk_is_read_although_its_stamps_queued_up(real_data):
    found = read_recording(real_data("walking/UnpertPre_data.csv.gz"))
    assert found.markers.labels == ("LeftFoot", "RightFoot", "COM")
    assert found.markers.rate_hz == 100.0
    assert found.markers.positions.shape == (6001, 3, 3)
    assert np.median(found.channels["LeftBeltSpeed"].values) == pytest.approx(0.8, abs=0.01)
    load = found.channels["LeftGRF_y"].values + found.channels["RightGRF_y"].values
    assert load.mean() == pytest.approx(79.4 * 9.81, rel=0.05)


def test_real_force_plate_as_text(real_data):
    (plate,) = read_recording(real_data("quiet-standing/BDS00001.txt.gz")).plates
    assert plate.force[:, 2].mean() == pytest.approx(537.9, abs=0.1)
    assert plate.rate_hz == 100.0


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Fz_left (kN)", ("Fz_left", "kN")),
        ("X [s]", ("X", "s")),
        ("belt_m_per_s", ("belt", "m/s")),
        ("HEEL_x_mm", ("HEEL_x", "mm")),
        ("Fz_left", ("Fz_left", "")),
    ],
)
def test_units_stand_at_the_end_of_names(name, expected):
    assert split_unit(name) == expected


def test_unusable_tables_are_refused(tmp_path):
    path = tmp_path / "trial.csv"
    values = rows_of()
    jumping, coarse = values.copy(), values.copy()
    jumping[20:, 0] -= 0.5
    coarse[:, 0] = np.sort(np.random.default_rng(3).uniform(0.0, 1.0, 40))
    for header, rows, match in (
        (TABLE.replace("time (s)", "clock"), values, "a column of the time"),
        (TABLE.replace("time (s)", "time (min)"), values, "time in s, ms or us"),
        (TABLE.replace("Mz_left", "Qz_left"), values, "found no Mz beside"),
        (TABLE.replace("Fx_right (N)", "Fx_right (lbf)"), values, "found the unit 'lbf'"),
        (TABLE.replace("Fy_left", "Fx_left"), values, "one column named 'Fx_left'"),
        (TABLE, jumping, "running backwards"),
        (TABLE, np.delete(values, range(10, 38), axis=0), "at least 20 samples"),
        (TABLE, coarse, "stamps of a regular clock|no step longer"),
    ):
        write_table(path, rows, header)
        refused(path, match, lambda: read_table_recording(path))
    text = write_table(path, values).read_text()
    path.write_text(text[: text.rindex(";")])
    refused(path, "truncated", lambda: read_table_recording(path))
    write_table(path, values, TABLE.replace(";", ","), delimiter=",", decimal=",")
    refused(path, "export it with decimal points or semicolons", lambda: read_table_recording(path))


# ---- TRC ---------------------------------------------------------------------------------------

TRC = (
    "PathFileType\t4\t(X/Y/Z)\ttrial.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "100.00\t100.00\t4\t2\tmm\t100.00\t1\t4\n"
    "Frame#\tTime\tHEEL\t\t\tTOE\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
    "\n"
    "1\t0.00\t1.0\t2.0\t3.0\t4.0\t5.0\t6.0\n"
    "2\t0.01\t1.5\t2.5\t3.5\t\t\t\n"
    "3\t0.02\t0.0\t0.0\t0.0\t4.5\t5.5\t6.5\n"
    "4\t0.03\t1.0\t2.0\t3.0\t4.0\t5.0\t6.0\n"
)


def test_trc_gives_positions_in_metres(tmp_path):
    for path, content in (
        (tmp_path / "a.trc", TRC.encode()),
        (tmp_path / "b.gz", gzip.compress(TRC.encode())),
    ):
        path.write_bytes(content)
        found = read_trc(path)
        assert (found.rate_hz, found.labels) == (100.0, ("HEEL", "TOE"))
        assert found.positions[0].tolist() == [[0.001, 0.002, 0.003], [0.004, 0.005, 0.006]]
        hidden = np.isnan(found.positions).all(axis=2)
        assert hidden.tolist() == [[False, False], [False, True], [True, False], [False, False]]
        assert contents_of(path).kind == "TRC"
        assert [c.name for c in contents_of(path).channels] == ["HEEL", "TOE"]


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("PathFileType", "Path", "begins with 'PathFileType'"),
        ("\tmm\t", "\tfeet\t", "found the unit 'feet'"),
        ("\tTOE", "\t", "2 markers as NumMarkers says"),
        ("4\t0.03\t1.0\t2.0\t3.0\t4.0\t5.0\t6.0\n", "", "4 frames as NumFrames says"),
        ("6.0\n", "6.0", "4 frames as NumFrames says"),
        ("5.5", "5,5", "numbers on line 9"),
        ("3\t0.02", "7\t0.02", "every frame after frame 2"),
        ("DataRate", "Rate", "the setting 'DataRate'"),
        ("100.00\t100.00\t4", "fast\t100.00\t4", "a positive rate"),
    ],
)
def test_damaged_trc_is_refused(tmp_path, old, new, match):
    path = tmp_path / "a.trc"
    assert old in TRC
    path.write_text(TRC.replace(old, new))
    refused(path, match, lambda: read_trc(path))


# ---- electromyograms ---------------------------------------------------------------------------

CHANNELS = {"TA": "Avanti sensor 1: EMG 1", "SOL": "Avanti sensor 2: EMG 2", "GAS": "Avanti sensor 3: EMG 3"}
EMG_RATE_HZ, ACC_RATE_HZ = 2000.0 / 1.08, 200.0 / 1.35


@pytest.fixture
def delsys(rng, tmp_path):
    """Write an export of Delsys: two muscles, an accelerometer and a trigger; return path and truth (V)."""

    def write(delimiter=",", decimal=".", padding="", labels=True):
        emg = 1e-4 * rng.standard_normal((2, 400))
        acc = rng.standard_normal(32)
        trigger = np.where(np.arange(400) >= 100, 5.0, 0.0)
        names = ["Avanti sensor 1: EMG 1", "Avanti sensor 1: ACC.X 1", "Avanti sensor 2: EMG 2", "Trigger"]
        columns = [
            (EMG_RATE_HZ, emg[0], "V"),
            (ACC_RATE_HZ, acc, "g"),
            (EMG_RATE_HZ, emg[1], "V"),
            (EMG_RATE_HZ, trigger, "V"),
        ]
        lines = []
        if labels:
            for name, (rate, x, unit) in zip(names, columns, strict=True):
                lines.append(
                    f"Label: {name} Sampling frequency: {rate:.6g} Number of points: {x.size} start: 0 "
                    f"Unit: {unit} Domain Unit: s"
                )
        quote = '"' if delimiter == "," else ""
        lines.append(delimiter.join(f"X[s]{delimiter}{quote}{name}{quote}" for name in names))
        for k in range(400):
            fields = []
            for rate, x, _ in columns:
                inside = k < x.size
                fields += [f"{k / rate:.7f}", f"{x[k]:.9f}"] if inside else [padding, padding]
            lines.append(delimiter.join(field.replace(".", decimal) for field in fields))
        path = tmp_path / "Run_1.csv"
        path.write_text("\n".join(lines) + "\n")
        return path, emg

    return write


@pytest.mark.parametrize(
    "layout",
    [{}, {"delimiter": ";", "decimal": ","}, {"padding": "0"}, {"labels": False}, {"delimiter": "\t"}],
)
def test_export_of_delsys(delsys, layout):
    path, emg = delsys(**layout)
    found = read_emg(path, CHANNELS, "Trigger")
    assert found.rate_hz == pytest.approx(EMG_RATE_HZ, rel=1e-5)
    assert (found.muscles, found.missing) == (("TA", "SOL"), ("GAS",))
    assert found.signals == pytest.approx(1e6 * emg.T, abs=1e-3)
    assert np.flatnonzero(found.trigger > 2.5).tolist() == list(range(100, 400))
    assert read_emg(path, CHANNELS, None).trigger is None
    shown = {c.name: c for c in contents_of(path).channels}
    assert shown["Avanti sensor 1: ACC.X 1"].shape == (32,)
    assert shown["Avanti sensor 1: ACC.X 1"].rate_hz == pytest.approx(ACC_RATE_HZ, rel=1e-4)


def test_plain_table_of_electromyograms(tmp_path, rng):
    values = np.column_stack([np.arange(300.0), rng.standard_normal((300, 2)), np.arange(300) > 50])
    path = tmp_path / "emg.tsv"
    np.savetxt(path, values, delimiter="\t", header="time (ms)\tTA (mV)\tSOL [uV]\tsync", comments="")
    found = read_emg(path, {"TA": "TA", "SOL": "SOL [uV]"}, "sync")
    assert found.rate_hz == pytest.approx(1000.0)
    assert found.signals == pytest.approx(values[:, 1:3] * [1000.0, 1.0])
    assert found.trigger.tolist() == values[:, 3].tolist()


@pytest.mark.parametrize("text", ["", "\n\n", "# only\n# remarks\n"])
def test_table_without_header_is_refused(text, tmp_path):
    path = tmp_path / "a.tsv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_plain_table(path, "a table of signals")
    assert_one_sentence(caught.value, path, "the header of a table of signals", "an empty file")


def test_unusable_electromyograms_are_refused(delsys):
    path, _ = delsys()
    text = path.read_text()
    line = text.splitlines()[60]
    for content, trigger, match in (
        (text, "Sync", "a trigger channel named 'Sync'"),
        (text.replace("EMG 1", "RMS 1").replace("EMG 2", "RMS 2"), "Trigger", "at least one of the channels"),
        (text.replace("1851.85", "1925.93"), "Trigger", "at 1925.93 Hz as the header says"),
        (text.replace("1851.85", "18.51.85"), "Trigger", "as a number in the header, found '18.51.85'"),
        (text.replace("Unit: V", "Unit: W"), "Trigger", "found the unit 'W'"),
        (text.replace(line, line + ",1"), "Trigger", "fields on every line"),
        (text.replace(line, line.replace("0.0", "zero", 1)), "Trigger", "expected a number"),
        (text.replace(line + "\n", ""), "Trigger", "recording has gaps"),
        (text.replace(line, text.splitlines()[30]), "Trigger", "expected time to increase"),
    ):
        path.write_text(content)
        refused(path, match, lambda t=trigger: read_emg(path, CHANNELS, t))


def test_long_gaps_of_a_force_are_not_bridged():
    """At 100 Hz, five missing samples are bridged and six are not, nor any beyond."""
    values = np.arange(100.0)
    values[:5] = values[20:25] = values[40:46] = values[99] = np.nan
    filled = bridged(np.column_stack([values, np.arange(100.0)]), 100.0)
    assert np.flatnonzero(np.isnan(filled[:, 0])).tolist() == [*range(40, 46)]
    np.testing.assert_array_equal(filled[20:25, 0], np.arange(20.0, 25.0))
    assert filled[0, 0] == 5.0 and filled[99, 0] == 98.0
    assert np.isnan(bridged(np.full(30, np.nan), 100.0)).all()
