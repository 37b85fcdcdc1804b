"""Readers give back what an instrument wrote, and say in one sentence why they cannot."""

import gzip
import shutil
import struct
import time

import ezc3d
import numpy as np
import pytest
from builders import DUMMY_DURATION_S, WRISTALYZER_DURATION_S, assert_one_sentence
from scipy.io import loadmat, savemat

from tepsipe.errors import InputError
from tepsipe.io.formats import read_markers
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.readers.treadmill_log import read_calibration_matrix, read_treadmill_log
from tepsipe.virtual_lab.dummy import MARKERS
from tepsipe.virtual_lab.treadmill_trial import (
    CHANNELS,
    write_calibration,
    write_markers,
    write_treadmill_log,
)
from tepsipe.virtual_lab.wristalyzer_trial import ManipulatorRecording, write_dflow_log, write_torque_command

LOG_COLUMNS = {"time": "TimeStamp", "angle": "MotorAngle", "trigger_time": "TriggerTime"}


def read_log(path):
    return read_text_table(path, LOG_COLUMNS, "\t")


def read_leg(path):
    return read_markers(path, ["ankle", "leg1"])


# labels that stand in the recordings made by others
REAL_LABELS = {"c3d/Gait.c3d": ["RSHO", "LTOE", "C7"], "c3d/Qualisys.c3d": ["L_IAS", "R_SAJ"]}
# kind of file -> its reader
READERS = {
    "log.txt": read_log,
    "log.txt.gz": read_log,
    "log.mat": read_treadmill_log,
    "calibration.csv": read_calibration_matrix,
    "markers.c3d": read_leg,
}


@pytest.fixture(scope="module")
def raw(wristalyzer_files, dummy_files, tmp_path_factory):
    """One good file of every kind."""
    folder = tmp_path_factory.mktemp("raw")
    files = {
        "log.txt": wristalyzer_files["log"],
        "log.txt.gz": folder / "log.txt.gz",
        "log.mat": dummy_files["log"],
        "calibration.csv": dummy_files["calibration"],
        "markers.c3d": dummy_files["markers"],
    }
    files["log.txt.gz"].write_bytes(gzip.compress(files["log.txt"].read_bytes(), mtime=0))
    return files


@pytest.fixture
def damaged(raw, tmp_path):
    """Write a copy of a raw file whose bytes are changed; refuse it; return what was said."""

    def refuse(kind, change):
        path = tmp_path / kind
        path.write_bytes(change(raw[kind].read_bytes()))
        with pytest.raises(InputError) as caught:
            READERS[kind](path)
        assert_one_sentence(caught.value, path)
        return str(caught.value)

    return refuse


def edit(old, new, count=1):
    """Replace text in a file's bytes, and insist that it was there."""

    def change(content):
        assert old.encode() in content
        return content.replace(old.encode(), new.encode(), count)

    return change


# ---- every reader ------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", READERS)
def test_file_that_the_laboratory_wrote_is_read(kind, raw):
    READERS[kind](raw[kind])


@pytest.mark.parametrize("kind", READERS)
def test_missing_file_is_refused(kind, tmp_path):
    with pytest.raises(InputError) as caught:
        READERS[kind](tmp_path / kind)
    assert_one_sentence(caught.value, tmp_path / kind)


@pytest.mark.parametrize("kind", READERS)
def test_empty_file_is_refused(kind, damaged):
    damaged(kind, lambda content: b"")


@pytest.mark.parametrize("kind", READERS)
def test_folder_instead_of_a_file_is_refused(kind, tmp_path):
    (tmp_path / kind).mkdir()
    with pytest.raises(InputError) as caught:
        READERS[kind](tmp_path / kind)
    assert_one_sentence(caught.value, tmp_path / kind)


@pytest.mark.parametrize("kind", READERS)
def test_binary_rubbish_is_refused(kind, damaged):
    rubbish = np.random.default_rng(5).integers(0, 256, 20000).astype(np.uint8).tobytes()
    damaged(kind, lambda content: rubbish)


@pytest.mark.parametrize("kind", READERS)
def test_zeros_instead_of_content_are_refused(kind, damaged):
    damaged(kind, lambda content: bytes(5000))


@pytest.mark.parametrize("kind", ["log.mat", "markers.c3d", "log.txt.gz"])
def test_text_instead_of_binary_is_refused(kind, damaged):
    damaged(kind, lambda content: b"this is a letter, not a recording\n" * 100)


@pytest.mark.parametrize("part", [0.001, 0.02, 0.3, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("kind", ["log.txt.gz", "log.mat", "calibration.csv", "markers.c3d"])
def test_truncated_file_is_refused_wherever_it_ends(kind, part, damaged):
    damaged(kind, lambda content: content[: int(part * len(content))])


@pytest.mark.parametrize("missing", [1, 4, 9])
@pytest.mark.parametrize("kind", ["log.txt.gz", "log.mat", "markers.c3d"])
def test_file_that_lacks_only_its_last_bytes_is_refused(kind, missing, damaged):
    padding = {"markers.c3d": 512, "log.mat": 4}.get(kind, 0)  # an empty block, or half a word, ends the file
    damaged(kind, lambda content: content[: len(content) - padding - missing])


@pytest.mark.parametrize("line", [1, 2, 500, 1500])
@pytest.mark.parametrize("field", [0, 1, 2])
def test_text_that_ends_within_a_line_is_refused(line, field, damaged):
    def cut(content):
        lines = content.split(b"\n")
        fields = lines[line].split(b"\t")
        return b"\n".join([*lines[:line], b"\t".join([*fields[:field], fields[field][:3]])])

    message = damaged("log.txt", cut)
    assert "truncated" in message


def test_compressed_file_with_a_damaged_byte_is_refused_wherever_it_is(damaged):
    def flipped_at(k):
        return lambda content: content[:k] + bytes([content[k] ^ 0x5A]) + content[k + 1 :]

    for k in range(12, 4000, 97):
        damaged("log.txt.gz", flipped_at(k))


@pytest.mark.parametrize("rest", [b"x", b"\0\0x", bytes(range(200))])
def test_compressed_file_with_something_behind_it_is_refused(rest, damaged):
    damaged("log.txt.gz", lambda content: content + rest)


@pytest.mark.slow
def test_compressed_file_that_is_a_bomb_is_stopped_early(tmp_path):
    path = tmp_path / "bomb.txt.gz"
    path.write_bytes(gzip.compress(bytes(1 << 20)) * 1000)  # a gigabyte in one megabyte
    start = time.process_time()
    with pytest.raises(InputError) as caught:
        read_log(path)
    assert_one_sentence(caught.value, path, "MB")
    assert time.process_time() - start < 1.0


# ---- text --------------------------------------------------------------------------------------


def test_dflow_log_and_torque_command_come_back_as_they_were_written(tmp_path, rng):
    recording = ManipulatorRecording(
        log_time=812.5 + np.arange(300) / 163.0,
        angle=0.1 * rng.standard_normal(300),
        trigger_time=813.5,
        command=rng.standard_normal(500),
        command_rate_hz=2048.0,
        motion=None,
    )
    write_dflow_log(tmp_path / "log.txt", recording)
    write_torque_command(tmp_path / "command.txt", recording)
    log = read_log(tmp_path / "log.txt")
    assert log["time"] == pytest.approx(recording.log_time, abs=1e-6)
    assert log["angle"] == pytest.approx(recording.angle, abs=1e-8)
    assert set(log["trigger_time"]) == {0.0, 813.5}
    assert (log["trigger_time"] > 0.0).argmax() == np.argmax(recording.log_time >= 813.5)
    columns = {"time": "Time", "torque": "TorqueCommand"}
    command = read_text_table(tmp_path / "command.txt", columns, "\t")
    assert command["time"] == pytest.approx(np.arange(500) / 2048.0, abs=1e-9)
    assert command["torque"] == pytest.approx(recording.command, abs=1e-8)


def test_columns_are_found_by_name_whatever_their_order(tmp_path):
    (tmp_path / "table.csv").write_text("torque,time,angle\n1,2,3\n4,5,6\n")
    table = read_text_table(tmp_path / "table.csv", {"angle": "angle", "tau": "torque"}, ",")
    assert {key: values.tolist() for key, values in table.items()} == {
        "angle": [3.0, 6.0],
        "tau": [1.0, 4.0],
    }


def test_empty_field_is_a_missing_sample(tmp_path):
    (tmp_path / "table.csv").write_text("time,angle\n0,1\n1,\n2,3\n")
    angle = read_text_table(tmp_path / "table.csv", {"angle": "angle"}, ",")["angle"]
    assert angle == pytest.approx([1.0, np.nan, 3.0], nan_ok=True)


def test_windows_line_ends_and_empty_last_lines_do_not_matter(tmp_path):
    (tmp_path / "table.csv").write_bytes(b"time,angle\r\n0,1\r\n1,2\r\n\r\n")
    table = read_text_table(tmp_path / "table.csv", {"t": "time", "angle": "angle"}, ",")
    assert table["angle"].tolist() == [1.0, 2.0]


def test_last_line_that_may_be_cut_within_its_last_number_is_left_out(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("time,angle\n0,1.25\n1,2.2")
    assert read_text_table(path, {"angle": "angle"}, ",")["angle"].tolist() == [1.25]
    path.write_text("time,angle\n0,1.2")
    with pytest.raises(InputError) as caught:
        read_text_table(path, {"angle": "angle"}, ",")
    assert_one_sentence(caught.value, path, "truncated")


def test_missing_column_is_named_beside_those_that_are_there(damaged):
    message = damaged("log.txt", edit("MotorAngle", "Angle"))
    assert "'MotorAngle'" in message
    assert "'TimeStamp'" in message


def test_field_that_is_not_a_number_is_shown_with_its_line_and_column(raw, damaged):
    second = raw["log.txt"].read_text().splitlines()[2].split("\t")
    message = damaged("log.txt", edit("\t".join(second), "\t".join([*second[:2], "n/a", second[3]])))
    assert "'n/a'" in message
    assert "'MotorAngle'" in message
    assert "line 3" in message


def test_decimal_commas_are_read_where_they_do_not_separate_columns(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("Zeit (s);Winkel (Grad)\n0;1\n0,5;-1,25\n1;\n")
    table = read_text_table(path, {"time": "Zeit (s)", "angle": "Winkel (Grad)"}, ";", units={"angle": "deg"})
    np.testing.assert_array_equal(table["time"], [0.0, 0.5, 1.0])
    np.testing.assert_array_equal(table["angle"], [1.0, -1.25, np.nan])
    path.write_text("t;x\n0,5;1,234.5\n1;2\n")  # a comma between thousands
    with pytest.raises(InputError, match=r"expected a number, found '1,234\.5' in column 'x' on line 2"):
        read_text_table(path, {"x": "x"}, ";")


@pytest.mark.parametrize(
    ("column", "unit", "said"),
    [
        ("M (Nmm)", "Nm", "expected the torque in Nm, found 'Nmm' in the header"),
        ("torque_mNm", "Nm", "expected the torque in Nm, found 'mNm' in the header"),
        ("Angle [°]", "rad", "expected the torque in rad, found '°' in the header"),
        ("ankle_rad", "deg", "expected the torque in deg, found 'rad' in the header"),
    ],
)
def test_the_unit_in_a_name_is_compared(column, unit, said, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(f"{column},other\n1,2\n2,3\n")
    with pytest.raises(InputError) as caught:
        read_text_table(path, {"torque": column}, ",", units={"torque": unit})
    assert said in str(caught.value)
    read_text_table(path, {"torque": column}, ",")


def test_lines_above_the_header_are_told_from_a_truncated_file(tmp_path):
    path = tmp_path / "a.tsv"
    rows = "".join(f"{k}\t{k / 100}\t1.0\t2.0\n" for k in range(50))
    path.write_text(f"NO_OF_FRAMES\t50\nFREQUENCY\t100\nFrame\tTime\tA X\tA Y\n{rows}")
    with pytest.raises(InputError, match="expected the names of 4 columns in the header, found 2"):
        read_text_table(path, {"x": "NO_OF_FRAMES"}, "\t")


def test_damaged_line_in_the_middle_is_told_from_a_truncated_file(raw, damaged):
    line = raw["log.txt"].read_text().splitlines()[100]
    message = damaged("log.txt", edit(line, line + "\t7"))
    assert "line 101" in message
    assert "damaged" in message


def test_header_without_samples_is_refused(damaged):
    damaged("log.txt", lambda content: content.split(b"\n")[0] + b"\n")


# ---- treadmill log -----------------------------------------------------------------------------


def test_treadmill_log_comes_back_as_it_was_written(tmp_path, rng):
    voltages, lines = rng.standard_normal((50, 14)), rng.standard_normal((3, 50))
    write_treadmill_log(tmp_path / "log.mat", 1000.0, voltages, *lines)
    log = read_treadmill_log(tmp_path / "log.mat")
    assert log.rate_hz == 1000.0
    assert log.channels == CHANNELS
    assert log.voltages == pytest.approx(voltages, rel=1e-6)
    for found, written in zip((log.belt_velocity, log.command, log.trigger), lines, strict=True):
        assert found == pytest.approx(written, rel=1e-6)


def test_treadmill_log_of_a_trial_lasts_as_long_as_the_trial(raw):
    log = read_treadmill_log(raw["log.mat"])
    assert log.voltages.shape == (log.trigger.size, 14)
    assert (log.trigger > 2.5).sum() / log.rate_hz == pytest.approx(DUMMY_DURATION_S, abs=0.002)


@pytest.fixture
def changed_log(raw, tmp_path):
    """Save the good log with some variables changed; refuse it; return what was said."""

    def refuse(**changes):
        content = {k: v for k, v in loadmat(raw["log.mat"]).items() if not k.startswith("__")}
        content |= changes
        content = {name: values for name, values in content.items() if values is not None}
        path = tmp_path / "log.mat"
        savemat(path, content)
        with pytest.raises(InputError) as caught:
            read_treadmill_log(path)
        assert_one_sentence(caught.value, path)
        return str(caught.value)

    return refuse


@pytest.mark.parametrize(
    "name",
    ["sample_rate_hz", "channel_names", "transducers_V", "belt_velocity_m_per_s", "trigger_V"],
)
def test_missing_variable_of_the_log_is_named(name, changed_log):
    message = changed_log(**{name: None})
    assert repr(name) in message
    assert "command_m_per_s" in message


def test_log_whose_variables_differ_in_length_is_refused(changed_log):
    message = changed_log(trigger_V=np.zeros(100))
    assert "'trigger_V'" in message
    assert "100" in message


def test_log_with_another_number_of_channels_than_names_is_refused(changed_log):
    assert "14" in changed_log(transducers_V=np.zeros((100, 13)))


@pytest.mark.parametrize("name", ["transducers_V", "belt_velocity_m_per_s", "trigger_V"])
def test_words_instead_of_numbers_in_the_log_are_refused(name, changed_log):
    assert name in changed_log(**{name: np.array(["high", "low"], dtype=object)})


@pytest.mark.parametrize("rate", [[], 0.0, -1000.0, np.nan], ids=str)
def test_log_without_a_usable_sampling_rate_is_refused(rate, changed_log):
    assert "sample_rate_hz" in changed_log(sample_rate_hz=rate)


# ---- calibration matrix ------------------------------------------------------------------------


def test_calibration_matrix_comes_back_as_it_was_written(tmp_path, rng):
    matrix = 1000.0 * rng.standard_normal((12, 14))
    write_calibration(tmp_path / "calibration.csv", matrix)
    read = read_calibration_matrix(tmp_path / "calibration.csv")
    assert read.matrix == pytest.approx(matrix, rel=1e-8)
    assert read.channels == CHANNELS
    assert read.components[:2] == ("Fx_left", "Fy_left")
    assert read.components[-1] == "Mz_right"


def test_wrong_unit_in_the_calibration_matrix_is_refused(damaged):
    message = damaged("calibration.csv", edit("Fz_right,N/V", "Fz_right,N/mV"))
    assert "N/V for Fz_right" in message
    assert "'N/mV'" in message


def test_force_in_the_unit_of_a_moment_is_refused(damaged):
    assert "Nm/V for Mx_left" in damaged("calibration.csv", edit("Mx_left,Nm/V", "Mx_left,N/V"))


@pytest.mark.parametrize("field", ["abc", "", "nan", "inf", "1,5"])
def test_field_of_the_matrix_that_is_no_number_is_refused(field, raw, damaged):
    number = raw["calibration.csv"].read_text().splitlines()[3].split(",")[5]
    damaged("calibration.csv", edit(f",{number},", f",{field},"))


def test_matrix_without_its_labels_is_refused(damaged):
    damaged("calibration.csv", edit("component,unit", "name,dimension"))


def test_matrix_of_one_belt_is_refused(damaged):
    message = damaged("calibration.csv", lambda content: b"\n".join(content.split(b"\n")[:7]) + b"\n")
    assert "12 components" in message
    assert "found 6" in message


def test_matrix_that_lacks_any_number_of_bytes_of_its_last_line_is_refused(raw, tmp_path):
    content = raw["calibration.csv"].read_bytes()
    path = tmp_path / "calibration.csv"
    for missing in range(1, len(content.splitlines()[-1]) + 1):
        path.write_bytes(content[:-missing])
        with pytest.raises(InputError) as caught:
            read_calibration_matrix(path)
        assert_one_sentence(caught.value, path)


# ---- markers -----------------------------------------------------------------------------------


def test_markers_come_back_as_they_were_written(tmp_path, rng):
    positions = rng.standard_normal((40, 8, 3))
    positions[7, 3] = np.nan
    positions[20:25, 0] = np.nan
    write_markers(tmp_path / "markers.c3d", MARKERS, positions, 250.0)
    wanted = ["leg4", "foot1", "ankle"]
    read = read_markers(tmp_path / "markers.c3d", wanted)
    columns = [MARKERS.index(name) for name in wanted]
    assert read.rate_hz == 250.0
    assert read.labels == tuple(wanted)
    assert read.positions == pytest.approx(positions[:, columns], abs=1e-6, nan_ok=True)


def test_markers_of_a_trial_last_as_long_as_the_trial(raw):
    read = read_leg(raw["markers.c3d"])
    assert read.positions.shape[0] / read.rate_hz == DUMMY_DURATION_S
    height = np.nanmean(read.positions, axis=0)[:, 2]
    assert height == pytest.approx([0.055, 0.055 + 0.6], abs=2e-3)


def test_missing_marker_is_named_beside_those_that_are_there(raw):
    with pytest.raises(InputError) as caught:
        read_markers(raw["markers.c3d"], ["ankle", "knee"])
    assert_one_sentence(caught.value, raw["markers.c3d"], "'knee'", "'ankle', 'leg1'")


def c3d_in(unit, path):
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["ankle", "leg1"]
    file["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    points = np.ones((4, 2, 30))
    points[:3] = 5.0
    file["data"]["points"] = points
    file.write(str(path))
    return path


@pytest.mark.parametrize(("unit", "metres"), [("mm", 0.005), ("cm", 0.05), ("m", 5.0)])
def test_unit_of_the_markers_is_heeded(unit, metres, tmp_path):
    positions = read_leg(c3d_in(unit, tmp_path / "markers.c3d")).positions
    assert positions == pytest.approx(np.full((30, 2, 3), metres))


@pytest.mark.parametrize("rate_hz", [0.0, -250.0, -3.4e38, np.inf])
def test_impossible_rate_of_the_frames_is_refused(rate_hz, tmp_path):
    path = c3d_in("mm", tmp_path / "markers.c3d")
    path.write_bytes(path.read_bytes().replace(struct.pack("<f", 100.0), struct.pack("<f", rate_hz)))
    with pytest.raises(InputError) as caught:
        read_leg(path)
    assert_one_sentence(caught.value, path, "POINT:RATE")


@pytest.mark.parametrize("unit", ["in", "", "MM"])
def test_unknown_unit_of_the_markers_is_refused(unit, tmp_path):
    path = c3d_in(unit, tmp_path / "markers.c3d")
    with pytest.raises(InputError) as caught:
        read_leg(path)
    assert_one_sentence(caught.value, path, repr(unit))


def test_header_that_points_beyond_the_file_is_refused(damaged):
    damaged("markers.c3d", lambda content: b"\xff\x50" + content[2:5000])


@pytest.mark.parametrize("name", REAL_LABELS)
def test_other_systems_c3d_files_are_read(name, real_data):
    read = read_markers(real_data(name), REAL_LABELS[name])
    present = np.isfinite(read.positions).all(axis=2)
    assert present.any(axis=0).all()
    assert 0.1 < np.abs(read.positions[present]).max() < 10.0
    assert read.rate_hz in (100.0, 200.0)


@pytest.mark.parametrize("name", REAL_LABELS)
@pytest.mark.parametrize("part", [0.1, 0.4, 0.99])
def test_other_systems_c3d_files_are_refused_if_truncated(name, part, real_data, tmp_path):
    content = real_data(name).read_bytes()
    path = tmp_path / "markers.c3d"
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(InputError) as caught:
        read_markers(path, REAL_LABELS[name])
    assert_one_sentence(caught.value, path)


def test_c3d_file_that_claims_values_of_twice_the_size_is_refused(real_data, tmp_path):
    content = bytearray(real_data("c3d/Gait.c3d").read_bytes())
    content[13] |= 0x80  # a DEC number that is negative: the values are floating point
    path = tmp_path / "markers.c3d"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_markers(path, REAL_LABELS["c3d/Gait.c3d"])
    assert_one_sentence(caught.value, path, "487 frames")


def test_real_recording_of_an_ankle_is_read(real_data):
    columns = {"time": "time_s", "angle": "ankle_pos_rad", "torque": "ankle_torque_Nm"}
    table = read_text_table(real_data("human-ankle/ankle_trial1.csv.gz"), columns, ",")
    assert table["time"][-1] == pytest.approx(60.0, abs=0.01)
    assert np.diff(table["time"]) == pytest.approx(np.full(table["time"].size - 1, 1e-3), abs=1e-6)
    assert np.isfinite(table["torque"]).all()


def test_real_treadmill_table_is_read(real_data, tmp_path):
    source = real_data("rmill-treadmill/RandomSlowSpeed1.txt")
    header = source.read_text().split("\n", 1)[0].rstrip("\r").split("\t")
    assert len(header) == 3
    copied = shutil.copy(source, tmp_path / "table.txt")
    table = read_text_table(copied, dict(enumerate(name.strip() for name in header)), "\t")
    assert 300.0 < np.ptp(table[0]) < 400.0


def test_manipulator_log_of_a_trial_lasts_as_long_as_the_trial(raw):
    log = read_log(raw["log.txt"])
    trigger = log["trigger_time"].max()
    assert log["time"][-1] - trigger == pytest.approx(WRISTALYZER_DURATION_S + 2.0, abs=0.1)


def test_component_that_stands_twice_in_the_matrix_is_refused(damaged):
    def repeat(content):
        lines = content.split(b"\n")
        return b"\n".join([*lines[:2], lines[1], *lines[2:]])

    assert "Fx_left" in damaged("calibration.csv", repeat)


def test_label_that_two_markers_share_is_refused(tmp_path):
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["knee", "knee"]
    file["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    file["data"]["points"] = np.ones((4, 2, 10))
    file.write(str(tmp_path / "twice.c3d"))
    with pytest.raises(InputError) as caught:
        read_markers(tmp_path / "twice.c3d", ["knee"])
    assert_one_sentence(caught.value, tmp_path / "twice.c3d", "'knee'")
