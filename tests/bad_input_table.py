"""Bad inputs: how the input of a good study is spoiled, and what the sentence about it says.

`FILES` are files of one recorded trial: they stop their own job, and the good trial beside it keeps its
results. `SETTINGS` are configurations and `SHEETS` trial sheets: they stop the run before the first job, and
all earlier results remain. `test_bad_inputs.py` refuses them by the functions of the library and of the
workflow, `benchmarks/soak/bad_inputs.py` by real runs.
"""

import re
from pathlib import Path

import numpy as np
from bad_inputs import (
    LEG,
    BadFile,
    BadSettings,
    BadSheet,
    c3d,
    calibration,
    cells,
    content,
    cut,
    cut_bytes,
    empty,
    factor,
    folder_instead,
    gone,
    label,
    lines,
    mat,
    noise,
    of_experiment,
    of_other,
    parameter,
    points,
    put,
    relabelled,
    samples,
    swapped,
    text,
    times,
)

LOG, MATRIX, MARKERS, EMG, COMMAND = "log.mat", "calibration.csv", "markers.c3d", "emg.edf", "command.txt"


def shifted(x):
    return np.roll(x, 125, axis=2)


def clipped(x):
    return np.clip(x, *np.percentile(x, [10, 90]))


def frozen_at_start(p):
    p[:, LEG] = p[:, LEG, :1]


def frozen_at_end(p):
    k = round(0.8 * p.shape[2])
    p[:, LEG, k:] = p[:, LEG, k : k + 1]


def one_frozen(p):
    p[:, 7, 1000:1060] = p[:, 7, 1000:1001]


def still_leg(p):
    p[:, LEG] = p[:, LEG, :1] + noise(0.1)(p[:, LEG])


def exchanged(a, b):
    def change(p):
        p[:, [a, b]] = p[:, [b, a]]

    return change


def without_row(name):
    def change(rows):
        rows[:] = [row for row in rows if row[0] != name]

    return calibration(change)


def cell(row, column, value):
    def change(rows):
        rows[row][column] = value

    return calibration(change)


def without_column(rows):
    for row in rows:
        del row[-1]


def doubled_row(rows):
    rows.append(rows[-1])


def exchanged_belts(rows):
    for row in rows[1:]:
        row[0] = row[0].replace("left", "?").replace("right", "left").replace("?", "right")


def forces_exchanged(rows):
    for row in rows[1:]:
        row[0] = {"Fx_right": "Fy_right", "Fy_right": "Fx_right"}.get(row[0], row[0])


def names_exchanged(x):
    x = np.array(x)
    flat = x.ravel()
    flat[[0, 7]] = flat[[7, 0]]
    return x


def fewer(x):
    return x[:-100]


def halved_trigger(x):
    x = np.array(x)
    high = np.flatnonzero(x.ravel() > 2.5)
    x.ravel()[high[high.size // 2] :] = 0.0
    return x


def word_at(k):
    return lambda rows: [*rows[:k], "\t".join(["abc"] * len(rows[0].split("\t"))), *rows[k:]]


def short_at(k):
    return lambda rows: [*rows[:k], rows[k].split("\t")[0], *rows[k + 1 :]]


def without_numbers(rows):
    return [*rows[:500], *(f"{row.split(',')[0]},," for row in rows[500:600]), *rows[600:]]


def utf16(name):
    return lambda folder: (folder / name).write_text((folder / name).read_text(), "utf-16")


SIGNALS = ("transducers_V", "belt_velocity_m_per_s", "command_m_per_s", "trigger_V")


def whole_words(words, begins):
    """Words of a sentence; those that name no file follow the usual beginning."""
    return words if re.match(r"[\w.]+[:,] ", words) else f"{begins}{words}"


def others(group, experiment, begins, entries):
    return [
        BadFile(group, name, experiment, spoil, whole_words(words, begins)) for name, spoil, words in entries
    ]


def dummy(group, begins, entries):
    return others(group, "dummy", begins, entries)


THE_LOG = dummy(
    "log",
    "log.mat: expected ",
    [
        ("log missing", gone(LOG), "a treadmill log, found no file"),
        ("log empty", empty(LOG), "a MATLAB file, found one that cannot be read"),
        (
            "log without voltages",
            mat(transducers_V=None),
            "the variable 'transducers_V' (transducer voltages)",
        ),
        ("log without rate", mat(sample_rate_hz=None), "the variable 'sample_rate_hz' (sampling rate)"),
        (
            "log without names",
            mat(channel_names=None),
            "the variable 'channel_names' (names of the transducer channels)",
        ),
        ("rate of zero", mat(sample_rate_hz=times(0.0)), "one positive number in 'sample_rate_hz'"),
        ("rate as text", mat(sample_rate_hz=lambda x: "fast"), "numbers in 'sample_rate_hz'"),
        ("rate in kHz", mat(sample_rate_hz=times(0.001)), "a log at 250 Hz or faster"),
        ("voltage infinite", mat(transducers_V=put((3000, 5), np.inf)), "numbers in 'transducers_V'"),
        (
            "velocity not a number",
            mat(belt_velocity_m_per_s=put(3000, np.nan)),
            "numbers in 'belt_velocity_m_per_s'",
        ),
        ("velocity shorter", mat(belt_velocity_m_per_s=fewer), "1300"),
        ("velocity complex", mat(belt_velocity_m_per_s=times(1j)), "numbers in 'belt_velocity_m_per_s'"),
        (
            "voltages of three axes",
            mat(transducers_V=lambda x: x[..., None] * np.ones(2)),
            "one column of transducers_V for each of the 14 channel names",
        ),
        (
            "channels exchanged",
            mat(channel_names=names_exchanged),
            "calibration.csv: expected the channels of log.mat in their order",
        ),
        ("trigger never rises", mat(trigger_V=times(0.0)), "the trigger to rise above 2.5 V"),
        (
            "trigger high from the start",
            mat(trigger_V=lambda x: np.full_like(x, 5.0)),
            "the trigger to rise after the log's start",
        ),
        (
            "trigger falls early",
            mat(trigger_V=halved_trigger),
            "markers.c3d: expected markers for the 6.00 s that the trigger was high in log.mat",
        ),
    ],
)
MATRICES = dummy(
    "calibration",
    "calibration.csv: expected ",
    [
        ("matrix missing", gone(MATRIX), "a calibration matrix"),
        (
            "matrix cut in its last number",
            cut_bytes(MATRIX, 4),
            "a line break at the end of a calibration matrix",
        ),
        ("matrix is the log", swapped(MATRIX, LOG), "a calibration matrix as text"),
        ("matrix with semicolons", text(MATRIX, ",", ";"), "the header to start with component,unit"),
        (
            "matrix without Fy",
            without_row("Fy_right"),
            "12 components, Fx to Mz of the left and the right belt",
        ),
        ("matrix with a row twice", calibration(doubled_row), "every component once"),
        ("matrix with another unit", cell(1, 1, "kN/V"), "the unit N/V for Fx_left"),
        ("matrix with a word", cell(3, 4, "abc"), "a finite number for Fz_left and left_z_rear_left, found "),
        ("matrix with an infinite number", cell(3, 4, "inf"), "a finite number for Fz_left"),
        ("matrix without a channel", calibration(without_column), "the channels of log.mat in their order"),
        ("matrix times 1000", factor(1000.0), "log.mat: expected a force of -10000 to 10000 N"),
        (
            "matrix with Fz zero",
            factor(0.0, "Fz_right"),
            "log.mat: expected Fz of the right belt to vary with its noise",
        ),
        (
            "matrix with Fy zero",
            factor(0.0, "Fy_right"),
            "log.mat: expected Fy of the right belt to vary with its noise",
        ),
        (
            "matrix with Mx zero",
            factor(0.0, "Mx_right"),
            "log.mat: expected Mx of the right belt to vary with its noise",
        ),
        (
            "matrix with Fz reversed",
            factor(-1.0, "Fz_right"),
            "log.mat: expected 1.5 to 3.5 kg on the right belt",
        ),
        (
            "belts of the matrix exchanged",
            calibration(exchanged_belts),
            "log.mat: expected 1.5 to 3.5 kg on the right belt",
        ),
    ],
)
THE_MARKERS = dummy(
    "markers",
    "markers.c3d: expected ",
    [
        ("markers missing", gone(MARKERS), "a C3D file, found no file"),
        ("markers truncated", cut(MARKERS, 0.6), "3000 frames"),
        ("markers cut in their header", cut(MARKERS, 0.001), "a C3D file"),
        ("a label missing", label("leg3", "knee"), "a marker named 'leg3'"),
        ("a label twice", label("leg3", "leg2"), "one marker named 'leg2'"),
        ("markers at another rate", parameter("POINT", "RATE", 100.0), "markers at 250 Hz"),
        (
            "markers at a negative rate",
            parameter("POINT", "RATE", -250.0),
            "a positive number of frames per second",
        ),
        (
            "markers half as long",
            points(lambda p: p[:, :, : p.shape[2] // 2]),
            "markers for the 12.00 s that the trigger was high in log.mat",
        ),
        (
            "markers in an unknown unit",
            parameter("POINT", "UNITS", "furlong"),
            "marker positions in mm, cm or m",
        ),
        ("mm that are called m", parameter("POINT", "UNITS", "m"), "a marker position of -20 to 20 m"),
        (
            "a marker hidden for half a second",
            points(put((slice(None), 5, slice(900, 1025)), np.nan)),
            "markers.c3d, marker 'leg2': expected gaps of at most 0.1 s",
        ),
        (
            "a marker never seen",
            points(put((slice(None), 5), np.nan)),
            "markers.c3d, marker 'leg2': expected gaps of at most 0.1 s",
        ),
        (
            "a hidden marker at the origin",
            points(put((slice(None), 5, slice(900, 925)), 0.0)),
            "markers of at most 15 m/s",
        ),
        (
            "leg frozen for the last fifth",
            points(frozen_at_end),
            "the marker 'leg1' to move or at least to show the noise of",
        ),
        (
            "one marker frozen",
            points(one_frozen),
            "the marker 'leg4' to move or at least to show the noise of",
        ),
        ("leg that only shows noise", points(still_leg), "the markers of the leg to move when the belt does"),
        (
            "axis y reversed",
            points(lambda p: p * np.array([1.0, -1.0, 1.0])[:, None, None]),
            "log.mat: expected the belt to move with the belt-fixed marker 'foot1' of markers.c3d",
        ),
        (
            "markers half a second late",
            points(shifted),
            "the belt-fixed marker 'foot1' to move with the belt of log.mat",
        ),
        (
            "markers of another trial",
            of_other(MARKERS),
            "the belt-fixed marker 'foot1' to move with the belt of log.mat",
        ),
        (
            "markers a tenth too large",
            points(times(1.2)),
            "the belt-fixed marker 'foot1' to move with the belt of log.mat",
        ),
    ],
)
PHYSICS = dummy(
    "physics",
    "log.mat: expected ",
    [
        ("one transducer dead", mat(transducers_V=put((slice(None), 9), 0.0)), "noise of every transducer"),
        ("one voltage of 1e6", mat(transducers_V=put((5000, 9), 1e6)), "a force of -10000 to 10000 N"),
        (
            "plate stops",
            mat(transducers_V=put(slice(6000, None), 0.1)),
            "Fy of the right belt to vary with its noise",
        ),
        ("velocity in cm/s", mat(belt_velocity_m_per_s=times(100.0)), "a belt velocity of -10 to 10 m/s"),
        (
            "velocity of zero",
            mat(belt_velocity_m_per_s=times(0.0)),
            "markers.c3d: expected the belt-fixed marker 'foot1' to move with the belt of log.mat",
        ),
        (
            "velocity stops",
            mat(belt_velocity_m_per_s=put(slice(6000, None), 0.0)),
            "markers.c3d: expected the belt-fixed marker 'foot1' to move with the belt of log.mat",
        ),
        (
            "one velocity of 3 m/s",
            mat(belt_velocity_m_per_s=put(slice(5000, 5004), 3.0)),
            "a belt acceleration of -200 to 200 m/s²",
        ),
        ("command in mm/s", mat(command_m_per_s=times(1000.0)), "a commanded belt velocity of -10 to 10 m/s"),
        (
            "fore-aft and lateral force exchanged",
            calibration(forces_exchanged),
            "the fore-aft force Fy of the right belt to accelerate at least",
        ),
        ("log of the weight", of_experiment("weight", LOG), "1.5 to 3.5 kg on the right belt"),
    ],
)


ON_THE_BELT = [
    *others(
        "weight",
        "weight",
        "log.mat: expected ",
        [
            ("weight: log of the empty belt", of_experiment("empty", LOG), "17 to 23 kg on the right belt"),
            (
                "weight: fore-aft force reversed",
                factor(-1.0, "Fy_right"),
                "the fore-aft force Fy of the right belt to accelerate at least",
            ),
            ("weight: matrix 1.3 times", factor(1.3), "17 to 23 kg on the right belt"),
            (
                "weight: markers frozen",
                points(lambda p: np.repeat(p[:, :, :1], p.shape[2], axis=2)),
                "markers.c3d: expected the marker 'weight1' to move or at least to show the noise of",
            ),
            (
                "weight: markers of another trial",
                of_other(MARKERS),
                "markers.c3d: expected the belt-fixed marker 'weight1' to move with the belt of",
            ),
            (
                "weight: markers of the dummy",
                of_experiment("dummy", MARKERS),
                "markers.c3d: expected a marker named 'weight1'",
            ),
        ],
    ),
    *others(
        "empty",
        "empty",
        "log.mat: expected ",
        [
            ("empty: log of the weight", of_experiment("weight", LOG), "-10 to 10 kg on the right belt"),
            ("empty: dead plate", mat(transducers_V=times(0.0)), "noise of every transducer"),
            (
                "empty: velocity in mm/s",
                mat(belt_velocity_m_per_s=times(1000.0)),
                "a belt velocity of -10 to 10 m/s",
            ),
            (
                "empty: trigger too short",
                mat(trigger_V=halved_trigger),
                "12 s of trial, as the trial sheet says",
            ),
        ],
    ),
    *others(
        "standing",
        "standing",
        "log.mat: expected ",
        [
            (
                "standing: fore-aft and lateral force exchanged",
                calibration(forces_exchanged),
                "the fore-aft force Fy of the right belt to accelerate at least",
            ),
            (
                "standing: fore-aft force reversed",
                factor(-1.0, "Fy_right"),
                "the fore-aft force Fy of the right belt to accelerate at least",
            ),
            (
                "standing: shank frozen",
                points(put((slice(None), 3), 200.0)),
                "markers.c3d: expected the marker 'shank1' to move or at least to show the noise of",
            ),
            (
                "standing: mm that are called m",
                parameter("POINT", "UNITS", "m"),
                "markers.c3d: expected a marker position of -20 to 20 m",
            ),
            ("standing: matrix times 1000", factor(1000.0), "a force of -10000 to 10000 N"),
            ("standing: dead plate", mat(transducers_V=times(0.0)), "noise of every transducer"),
        ],
    ),
    *others(
        "EMG",
        "standing",
        "emg.edf: expected ",
        [
            ("electromyograms missing", gone(EMG), "an EDF file, found no file"),
            ("electromyograms empty", empty(EMG), "an EDF file"),
            ("electromyograms truncated", cut(EMG, 0.5), "18 records"),
            (
                "electromyograms are a text",
                content(EMG, b"time,TA\n0,1\n"),
                "at least 20 samples at different times",
            ),
            (
                "electromyograms without trigger",
                relabelled("Trigger", "Marker"),
                "a trigger channel named 'Trigger'",
            ),
            (
                "trigger of the electromyograms low",
                samples("Trigger", times(0.0)),
                "the trigger to rise above 2.5 V",
            ),
            (
                "trigger of the electromyograms high",
                samples("Trigger", lambda x: x * 0.0 + 5.0),
                "the trigger to rise after the log's start",
            ),
            (
                "electromyograms of 0.2 V",
                samples("EMG SOL", times(1e3)),
                "an electromyogram of -100000 to 100000 uV",
            ),
        ],
    ),
]
WRIST = others(
    "manipulator log",
    "wristalyzer",
    "log.txt: expected ",
    [
        ("manipulator log missing", gone("log.txt"), "a table of samples"),
        ("manipulator log empty", empty("log.txt"), "a header and samples"),
        (
            "manipulator log of a header only",
            lines("log.txt", lambda rows: rows[:1]),
            "samples under the header",
        ),
        ("manipulator log with commas", text("log.txt", "\t", ","), "a column named 'TimeStamp'"),
        (
            "manipulator log with commas between thousands",
            lines("log.txt", lambda rows: [*rows[:500], rows[500].replace("8", "8,", 1), *rows[501:]]),
            "a number, found",
        ),
        (
            "manipulator log in degrees by its header",
            text("log.txt", "MotorAngle", "MotorAngle [deg]"),
            "a column named 'MotorAngle'",
        ),
        (
            "manipulator log with a word",
            lines("log.txt", word_at(500)),
            "a number, found 'abc' in column 'TimeStamp' on line",
        ),
        (
            "manipulator log backwards",
            lines("log.txt", lambda rows: [rows[0], *rows[:0:-1]]),
            "time to increase",
        ),
        (
            "manipulator log with a gap",
            lines("log.txt", lambda rows: rows[:1000] + rows[1100:]),
            "no step longer than 0.05 s",
        ),
        (
            "manipulator log that ends early",
            lines("log.txt", lambda rows: rows[: len(rows) // 2]),
            "16 s of trial, as the trial sheet says",
        ),
        ("manipulator log with a short line", lines("log.txt", short_at(500)), "4 fields on every line"),
        ("manipulator log in UTF-16", utf16("log.txt"), "a table of samples as text"),
        (
            "manipulator log with a column twice",
            text("log.txt", "TimeStamp", "MotorAngle", 1),
            "a column named 'TimeStamp'",
        ),
        (
            "manipulator never triggered",
            cells("log.txt", "TriggerTime", times(0.0)),
            "the stamp of the trigger",
        ),
        (
            "angle in degrees",
            cells("log.txt", "MotorAngle", times(57.3)),
            "joint angles within half a revolution",
        ),
        ("angle reversed", cells("log.txt", "MotorAngle", times(-1.0)), "a torque that moves the joint"),
        (
            "angle stops",
            cells("log.txt", "MotorAngle", put(slice(1500, 1900), 0.0)),
            "the angle to change with the torque",
        ),
        (
            "angle in thousandths",
            cells("log.txt", "MotorAngle", times(1e-3)),
            "command.txt: expected a torque of 0.01 to 5000 N·m per rad of the angle",
        ),
    ],
) + others(
    "command",
    "wristalyzer",
    "command.txt: expected ",
    [
        (
            "command with another column",
            text(COMMAND, "TorqueCommand", "Torque"),
            "a column named 'TorqueCommand'",
        ),
        (
            "command backwards",
            lines(COMMAND, lambda rows: [rows[0], *rows[:0:-1]]),
            "16 s of trial, as the trial sheet says",
        ),
        (
            "command that ends early",
            lines(COMMAND, lambda rows: rows[: len(rows) // 2]),
            "16 s of trial, as the trial sheet says",
        ),
        ("command in mNm", cells(COMMAND, "TorqueCommand", times(1000.0)), "a torque of -500 to 500 Nm"),
        (
            "command in kNm",
            cells(COMMAND, "TorqueCommand", times(0.001)),
            "a torque of 0.01 to 5000 N·m per rad of the angle",
        ),
    ],
)
TABLE = "table.csv"
TABLES = others(
    "text tables",
    "position_manipulator",
    "table.csv: expected ",
    [
        ("table with tabs", text(TABLE, ",", "\t"), "a column named 'time_s'"),
        ("table backwards", lines(TABLE, lambda rows: [rows[0], *rows[:0:-1]]), "time to increase"),
        (
            "table with a gap",
            lines(TABLE, lambda rows: rows[:1000] + rows[1100:]),
            "no step longer than 0.02 s",
        ),
        (
            "table that ends early",
            lines(TABLE, lambda rows: rows[: len(rows) // 2]),
            "20 s of trial, as the trial sheet says",
        ),
        (
            "table with a word",
            lines(TABLE, lambda r: [*r[:500], "a,b,c", *r[501:]]),
            "a number, found 'a' in column 'time_s' on line 501:",
        ),
        ("table with long gaps", lines(TABLE, without_numbers), "gaps of at most 0.02 s"),
        (
            "table: angle in degrees",
            cells(TABLE, "ankle_pos_rad", times(5730.0), ","),
            "joint angles within half a revolution",
        ),
        (
            "table: torque and angle exchanged",
            text(TABLE, "ankle_pos_rad,ankle_torque_Nm", "ankle_torque_Nm,ankle_pos_rad"),
            "a torque of at least 0.1 N·m per rad of the angle",
        ),
        (
            "table: torque saturated",
            cells(TABLE, "ankle_torque_Nm", clipped, ","),
            "a torque within the range of its sensor",
        ),
        (
            "table: angle hardly moves",
            cells(TABLE, "ankle_pos_rad", times(1e-3), ","),
            "an angle that is moved by at least 0.001 rad",
        ),
        (
            "table: torque of the other sign",
            cells(TABLE, "ankle_torque_Nm", times(-1.0), ","),
            "a torque that moves the joint",
        ),
        (
            "table: torque constant",
            cells(TABLE, "ankle_torque_Nm", times(0.0), ","),
            "the torque to change with the angle",
        ),
        (
            "table: angle stops",
            cells(TABLE, "ankle_pos_rad", put(slice(4000, 5000), 0.0), ","),
            "the angle to change with the torque",
        ),
        (
            "table: gap written as zeros",
            cells(TABLE, "ankle_pos_rad", put(slice(4000, 4008), 0.0), ","),
            "the angle of every sample, found 8 zeros in a row at 8.000 s",
        ),
        (
            "table: gap written as 9999",
            cells(TABLE, "ankle_pos_rad", put(slice(4000, 4008), 9999.0), ","),
            "joint angles within half a revolution",
        ),
        (
            "table: lines above the header",
            lines(TABLE, lambda rows: ["NO_OF_SAMPLES,10000", "FREQUENCY,500", *rows]),
            "a column named 'time_s'",
        ),
        (
            "table: one torque of 1e6",
            cells(TABLE, "ankle_torque_Nm", put(4000, 1e6), ","),
            "a torque of -500 to 500 Nm",
        ),
    ],
) + others(
    "text tables",
    "belt",
    "table.txt: expected ",
    [
        (
            "belt table in mm/s",
            cells("table.txt", "v (m/s)", times(1000.0)),
            "a belt velocity of -10 to 10 m/s",
        ),
        (
            "belt table: velocity constant",
            cells("table.txt", "v (m/s)", lambda x: 0.0 * x + 1.2),
            "'v (m/s)' to change with the belt's motion",
        ),
        (
            "belt table: one load of 1e6",
            cells("table.txt", "Mx (Nm)", put(2000, 1e6)),
            "a load of -5000 to 5000 Nm",
        ),
        (
            "belt table too short",
            lines("table.txt", lambda rows: rows[:1500]),
            "39 s of trial, as the trial sheet says",
        ),
        (
            "belt table: stamps of few decimals",
            cells("table.txt", "t", lambda x: np.floor(x)),
            "no step longer than 0.1 s",
        ),
        (
            "belt table: an infinite load",
            cells("table.txt", "Mx (Nm)", put(2000, np.inf)),
            "finite numbers in 'Mx (Nm)'",
        ),
    ],
)
PLATFORM = "platform.csv"
HIP, ANKLE = "hip_torque_Nm", "ankle_torque_Nm"
PLATFORMS = others(
    "text tables",
    "platform",
    "platform.csv: expected ",
    [
        ("platform without a torque", text(PLATFORM, HIP, "hip"), "a column named 'hip_torque_Nm'"),
        (
            "platform that ends early",
            lines(PLATFORM, lambda rows: rows[: len(rows) // 2]),
            "40 s of trial, as the trial sheet says",
        ),
        (
            "platform: torque and angle of the ankle exchanged",
            text(
                PLATFORM, f"ankle_angle_rad,hip_angle_rad,{ANKLE}", f"{ANKLE},hip_angle_rad,ankle_angle_rad"
            ),
            "a torque of at least 0.1 N·m per rad of the angle of the ankle",
        ),
        (
            "platform: angles in degrees",
            cells(PLATFORM, "ankle_angle_rad", times(5730.0), ","),
            "joint angles within half a revolution",
        ),
        (
            "platform: torque in Nmm",
            cells(PLATFORM, ANKLE, times(1e3), ","),
            "a joint torque of -500 to 500 Nm",
        ),
        (
            "platform: torque of the hip stops",
            cells(PLATFORM, HIP, put(slice(1000, 2500), 0.0), ","),
            "the torque of the hip to change",
        ),
        (
            "platform with a gap",
            lines(PLATFORM, lambda rows: rows[:500] + rows[600:]),
            "no step longer than 0.05 s",
        ),
    ],
)
WHOLE = "whole.c3d"


def analog(name, change):
    """Change an analog channel of the whole trial."""

    def on_file(file):
        k = file["parameters"]["ANALOG"]["LABELS"]["value"].index(name)
        values = file["data"]["analogs"]
        values[0, k] = change(values[0, k])

    return c3d(on_file, WHOLE)


def analog_label(old, new):
    def change(file):
        names = file["parameters"]["ANALOG"]["LABELS"]["value"]
        names[names.index(old)] = new

    return c3d(change, WHOLE)


def whole_markers(change):
    def on_file(file):
        change(file["data"]["points"][:3])

    return c3d(on_file, WHOLE)


def whole_label(old, new):
    def change(file):
        names = file["parameters"]["POINT"]["LABELS"]["value"]
        names[names.index(old)] = new

    return c3d(change, WHOLE)


def whole_unit(unit):
    def change(file):
        file["parameters"]["POINT"]["UNITS"]["value"] = [unit]

    return c3d(change, WHOLE)


WHOLE_TRIALS = [
    BadFile("whole trial", f"one C3D: {name}", "dummy", spoil, words, whole=True)
    for name, spoil, words in [
        ("missing", gone(WHOLE), "whole.c3d: expected a C3D file, found no file"),
        ("truncated", cut(WHOLE, 0.6), "whole.c3d: expected 3000 frames"),
        ("without a marker", whole_label("leg2", "knee"), "whole.c3d: expected a marker named 'leg2'"),
        (
            "without the belt velocity",
            analog_label("Belt speed", "Speed"),
            "whole.c3d: expected a channel named 'Belt speed'",
        ),
        (
            "belt velocity times 10",
            analog("Belt speed", lambda x: 10.0 * (x - 2.5) + 2.5),
            "whole.c3d: expected a belt acceleration of -200 to 200 m/s²",
        ),
        (
            "belt velocity reversed",
            analog("Belt speed", lambda x: 5.0 - x),
            "whole.c3d: expected the belt to move with the belt-fixed marker 'foot1' of whole.c3d",
        ),
        (
            "no force",
            analog("Fz2", times(0.0)),
            "whole.c3d: expected Fz of the right belt to vary with its noise",
        ),
        (
            "one force of 1e6",
            analog("Fy2", put(3000, 1e6)),
            "whole.c3d: expected a force of -10000 to 10000 N",
        ),
        ("mm that are called m", whole_unit("m"), "whole.c3d: expected a moment of -5000 to 5000 Nm"),
        (
            "leg frozen",
            whole_markers(frozen_at_start),
            "whole.c3d: expected the marker 'leg1' to move or at least to show",
        ),
    ]
]


def unit_of(name, unit):
    """Change the unit of an analog channel."""

    def change(file):
        analog = file["parameters"]["ANALOG"]
        analog["UNITS"]["value"][analog["LABELS"]["value"].index(name)] = unit

    return change


def plate_parameter(name, change):
    """Change a parameter of the force plates of the whole trial."""

    def on_file(file):
        entry = file["parameters"]["FORCE_PLATFORM"][name]
        entry["value"] = np.asarray(change(entry["value"]), dtype=float)

    return c3d(on_file, WHOLE)


def all_forces(value):
    """Forces and moments of the second plate of the whole trial times a number."""

    def on_file(file):
        names = file["parameters"]["ANALOG"]["LABELS"]["value"]
        for name in ("Fx2", "Fy2", "Fz2", "Mx2", "My2", "Mz2"):
            file["data"]["analogs"][0, names.index(name)] *= value

    return c3d(on_file, WHOLE)


def upright(axis):
    """The whole trial in axes whose vertical is x or y: markers and corners are turned."""
    order = {"y": [0, 2, 1], "x": [2, 0, 1]}[axis]

    def on_file(file):
        points = file["data"]["points"]
        points[:3] = points[order]
        entry = file["parameters"]["FORCE_PLATFORM"]["CORNERS"]
        entry["value"] = np.asarray(entry["value"])[order]

    return c3d(on_file, WHOLE)


ODD_FILES = [
    *[
        BadFile("whole trial", f"one C3D: {name}", "dummy", spoil, words, whole=True)
        for name, spoil, words in [
            ("y up", upright("y"), "whole.c3d, force plate 1: expected a level surface, with +z upward by"),
            (
                "in inches",
                whole_unit("in"),
                "whole.c3d: expected marker positions in mm, cm or m, found the unit",
            ),
            (
                "forces in pounds",
                c3d(unit_of("Fz2", "lb"), WHOLE),
                "whole.c3d, force plate 2: expected the channel 'Fz2' in N, kN, found the unit 'lb'",
            ),
            (
                "a plate of type 5",
                plate_parameter("TYPE", lambda x: [2, 5]),
                "whole.c3d, force plate 2: expected a plate of type 1, 2, 3 or 4, found the type 5",
            ),
            (
                "corners at one point",
                plate_parameter("CORNERS", lambda x: 0.0 * np.asarray(x)),
                "whole.c3d, force plate 1: expected four corners of a plate",
            ),
            (
                "channels of the plate missing",
                plate_parameter("CHANNEL", lambda x: np.asarray(x) + 900),
                "whole.c3d, force plate 1: expected channels from 1 to 13 in FORCE_PLATFORM:CHANNEL",
            ),
            (
                "one plate of two",
                plate_parameter("USED", lambda x: [1]),
                "whole.c3d: expected a force plate 2, found 1 force plates",
            ),
            (
                "corners beside the markers",
                plate_parameter("CORNERS", lambda x: np.asarray(x) + 3000.0),
                "whole.c3d: expected the markers above the force plate",
            ),
            (
                "force on the plate",
                all_forces(-1.0),
                "whole.c3d: expected vertical forces that point up under load",
            ),
            (
                "belt velocity not a number",
                analog("Belt speed", put(100, np.nan)),
                "whole.c3d: expected a number in every sample of the channel 'Belt speed'",
            ),
        ]
    ],
    *others(
        "text tables",
        "belt",
        "table.txt: expected ",
        [
            (
                "belt table: a header without units",
                text("table.txt", "Mx (Nm)", "Mx"),
                "a column named 'Mx (Nm)'",
            ),
            ("belt table: a folder", folder_instead("table.txt"), "a table of samples, found a folder"),
        ],
    ),
    *others(
        "text tables",
        "position_manipulator",
        "table.csv: expected ",
        [
            (
                "table: stamps in ms",
                cells("table.csv", "time_s", times(1000.0), ","),
                "samples closer than 0.02 s, found one every 2 s",
            )
        ],
    ),
]


def cell_of_line(name, number, column, value):
    """Replace one cell of a table with commas; the header is line 1."""

    def change(rows):
        fields = rows[number - 1].split(",")
        fields[column] = value
        return [*rows[: number - 1], ",".join(fields), *rows[number:]]

    return lines(name, change)


def in_steps(step):
    return lambda x: step * np.round(x / step)


def louder_half(factor):
    return lambda x: np.where(np.arange(x.shape[0])[:, None] < x.shape[0] // 2, x, factor * x)


def first_samples(count):
    return {
        name: (lambda x: np.atleast_2d(x)[:count] if x.shape[0] > 1 else x[:, :count]) for name in SIGNALS
    }


MANGLED = [
    *others(
        "text tables",
        "position_manipulator",
        "",
        [
            (
                f"table: {name}",
                cell_of_line(TABLE, 701, 1, cell),
                f"table.csv: expected a number, found '{cell}' in column 'ankle_pos_rad' on line 701",
            )
            for name, cell in [("an error of a spreadsheet", "#N/A"), ("digits with an underscore", "1_0")]
        ],
    ),
    *others(
        "text tables",
        "position_manipulator",
        "table.csv: expected ",
        [
            (
                "table: points between thousands, and a decimal comma",
                cell_of_line(TABLE, 701, 1, '"1.234,5"'),
                "3 fields on every line, found 4 on line 701: export the file",
            ),
            (
                "table: an angle in degrees, of a small swing",
                cells(TABLE, "ankle_pos_rad", np.degrees, ","),
                "a joint of at most 20 rad/s, found",
            ),
            (
                "table: angle in steps of a degree",
                cells(TABLE, "ankle_pos_rad", in_steps(np.radians(1.0)), ","),
                "an angle of at least 16 distinct values",
            ),
        ],
    ),
    *others(
        "manipulator log",
        "wristalyzer",
        "log.txt: expected ",
        [
            (
                "trigger of another clock",
                cells("log.txt", "TriggerTime", lambda x: np.where(x > 0.0, x + 1e4, x)),
                "the trigger between",
            ),
            (
                "trigger at negative stamps",
                cells("log.txt", "TriggerTime", lambda x: -x),
                "the stamp of the trigger, found none above 0, but -",
            ),
        ],
    ),
    *dummy(
        "log",
        "log.mat: expected ",
        [
            (
                "log without samples",
                mat(**first_samples(0)),
                "a time series in 'transducers_V', found 0 samples",
            )
        ],
    ),
    *dummy(
        "calibration",
        "calibration.csv: expected ",
        [
            (
                "matrix with digits and an underscore",
                cell(3, 4, "1_000"),
                "a finite number for Fz_left and left_z_rear_left, found '1_000'",
            ),
            (
                "matrix with a row of totals",
                calibration(lambda rows: rows.append(["Sum", "N/V", *["1"] * (len(rows[0]) - 2)])),
                "a component of Fx_left, Fy_left, Fz_left",
            ),
        ],
    ),
    *others(
        "weight",
        "weight",
        "log.mat: expected ",
        [
            (
                "weight: the plate's gain changes",
                mat(transducers_V=louder_half(1.25)),
                "the same mass on the right belt throughout, found",
            )
        ],
    ),
]
FILES = [
    *WHOLE_TRIALS,
    *THE_LOG,
    *MATRICES,
    *THE_MARKERS,
    *PHYSICS,
    *ON_THE_BELT,
    *WRIST,
    *TABLES,
    *PLATFORMS,
    *ODD_FILES,
    *MANGLED,
]


# ---- configurations ----------------------------------------------------------------------------------------


def key(path, value):
    """A mapping of one value, at keys joined by dots."""
    for name in reversed(path.split(".")):
        value = {name: value}
    return value


WALKING = (Path(__file__).parents[1] / "config/walking/config.yaml").read_text(encoding="utf-8")


def walking(old, new):
    """The shipped study of walking with one change."""
    assert old in WALKING
    return WALKING.replace(old, new)


SETTINGS = [
    BadSettings(
        name,
        overlay if isinstance(overlay, str) else key(*overlay),
        whole_words(words, "configuration: expected "),
    )
    for name, overlay, words in [
        (
            "walking: forward and up alike",
            walking("up: +y", "up: -z"),
            "walking.recording.axes to be two different axes, found '-z' and '-z'",
        ),
        (
            "walking: a phase without an expected stiffness",
            walking("[100.0, 180.0, 280.0, 400.0]", "[100.0, 180.0]"),
            "walking.planned.stiffness_Nm_per_rad to have a value for each of the 4 phases of",
        ),
        (
            "walking: one plate under both feet",
            walking("{own: 1, other: 2}", "{own: 1, other: 1}"),
            "walking.recording.plates to be two force plates, found 1 for both feet",
        ),
        (
            "walking: a low-pass above half of the rate",
            walking("lowpass_cutoff_hz: 20.0", "lowpass_cutoff_hz: 60.0"),
            "walking.analysis.lowpass_cutoff_hz below half of walking.rate_hz (50 Hz), found 60 Hz",
        ),
        (
            "walking: a simulated trial without its pulses",
            walking("small-pulses: {", "tiny-pulses: {"),
            "trials.tsv: expected the pulses of walking/small-pulses in walking.simulated.trials",
        ),
        (
            "walking: strides of a trial that is not there",
            walking("of: comfortable", "of: fast"),
            "trials.tsv: expected walking.simulated.of to be a recorded trial whose strides are resampled",
        ),
        ("no YAML", "study: [1, 2\n", "bad.yaml: expected YAML, found a mistake on line 2 (did not find"),
        ("a list", "- study\n", "bad.yaml: expected keys and values"),
        (
            "a key twice",
            "study:\n  seed: 1\n  seed: 2\n",
            "bad.yaml: expected YAML, found a mistake on line 3 (the key 'seed'",
        ),
        (
            "code",
            "__use_yte__: true\n?if True:\n  study: {}\n",
            "bad.yaml: expected settings only, found the key '__use_yte__', with which",
        ),
        ("an unknown section", ("studdy.seed", 1), "configuration: unknown key 'studdy'"),
        (
            "an unknown key",
            ("dummy.analysis.rest_befor_s", 6.0),
            "configuration: unknown key 'dummy.analysis.rest_befor_s'",
        ),
        (
            "a key of another section",
            ("weight.belt", "left"),
            "configuration: unknown key 'weight.belt': did you mean 'belt' or 'plate_treadmill.belt'",
        ),
        (
            "an unknown name",
            ("dummy.pathways.leg.torque", "printed"),
            "one of 'leg', 'leg-thesis' for 'dummy.pathways.leg.torque'",
        ),
        (
            "a cutoff above half the rate",
            ("plate_treadmill.lowpass_cutoff_hz", 125.0),
            "plate_treadmill.lowpass_cutoff_hz below half of",
        ),
        (
            "an odd order",
            ("plate_treadmill.lowpass_order", 3),
            "one of 2, 4, 6, 8 for 'plate_treadmill.lowpass_order'",
        ),
        (
            "an infinite rate",
            "wristalyzer: {ingest: {resample_rate_hz: .inf}}\n",
            "a finite number for 'wristalyzer.ingest.resample_rate_hz'",
        ),
        (
            "not a number",
            "wristalyzer: {ingest: {max_gap_s: .nan}}\n",
            "a finite number for 'wristalyzer.ingest.max_gap_s'",
        ),
        ("null", ("dummy.ingest.trigger_threshold_V", None), "a value of type number for"),
        ("a negative seed", ("study.seed", -1), "a number of at least 0 for 'study.seed'"),
        ("a seed of 1.5", ("study.seed", 1.5), "a value of type integer for 'study.seed'"),
        ("a name with spaces", ("study.name", "my study"), "a value of the pattern"),
        ("no trial sheet", ("study.trial_sheet", "nowhere.tsv"), "nowhere.tsv: expected the trial sheet"),
        (
            "no laboratory",
            ("study.virtual_lab", "nowhere.yaml"),
            "nowhere.yaml: expected a configuration file",
        ),
        (
            "an engine that there is not",
            ("dummy.simulation.engine", "bullet"),
            "one of 'pybullet', 'mujoco', 'equations', 'auto' for",
        ),
        (
            "an unknown estimator",
            ("dummy.pathways.leg.estimator", "regression"),
            "dummy.pathways.leg.estimator to name one of the estimators",
        ),
        (
            "an unknown pathway",
            ("dummy.recommended", "legg"),
            "dummy.recommended to name one of dummy.pathways",
        ),
        (
            "an unknown treadmill model",
            ("standing.pathways.ankle.treadmill_model", "frame"),
            "configuration: expected standing.pathways.ankle.treadmill_model, if not null, to",
        ),
        (
            "a marker that is not recorded",
            ("dummy.foot.belt_fixed_labels", ["foot1", "toe"]),
            "dummy.foot.belt_fixed_labels to name markers of",
        ),
        (
            "a window longer than its epoch",
            ("standing.estimators.long.window_s", 3.0),
            "standing.estimators.long.window_s of at most",
        ),
        (
            "a band from high to low",
            ("standing.emg.band_hz", [300.0, 20.0]),
            "standing.emg.band_hz from low to high, found [300.0, 20.0]: turn it",
        ),
        (
            "a start beyond its bound",
            ("wristalyzer.analysis.start.K_Nm_per_rad", 30.0),
            "wristalyzer.analysis.start.K_Nm_per_rad between its bounds",
        ),
        (
            "an SNR that is not computed",
            ("noise.table_snr_db", 17),
            "noise.table_snr_db to be one of noise.snr_db ([0, 5, 10,",
        ),
        ("too few draws", ("dummy.analysis.bootstrap_draws", 3), "a number of at least 100 for"),
        ("a negative mass", ("weight.weight.mass_kg", -20.0), "a number above 0 for 'weight.weight.mass_kg'"),
        (
            "limits from high to low",
            ("plausible.force_N", [10.0, -10.0]),
            "plausible.force_N from low to high",
        ),
        (
            "limits of three",
            ("plausible.force_N", [-10.0, 0.0, 10.0]),
            "at most 2 items for 'plausible.force_N'",
        ),
        (
            "a correlation of 2",
            ("plausible.belt_fixed_correlation", 2.0),
            "a number of at most 1 for 'plausible.belt_fixed_correlation'",
        ),
        (
            "results over the configuration",
            ("pathvars.results", "config"),
            "pathvars.results to be a folder of its own",
        ),
        (
            "results outside",
            ("pathvars.results", "/"),
            "pathvars.results in the folder that the study runs in",
        ),
        (
            "results in a pattern",
            ("pathvars.results", "results/{B}"),
            "a path without '{' '}' for 'pathvars.results'",
        ),
        (
            "an unknown path variable",
            ("pathvars.figures", "figures"),
            "configuration: unknown key 'pathvars.figures': known here: results, logs",
        ),
    ]
]

ODD_SETTINGS = [
    BadSettings(name, overlay if isinstance(overlay, str) else key(*overlay), f"configuration: {words}")
    for name, overlay, words in [
        ("a leg of 448.5 m", ("dummy.geometry.leg_com_m", 448.5), "expected a number of at most 3 for"),
        ("a leg of 400 kg", ("dummy.geometry.leg_mass_kg", 400.0), "expected a number of at most 100 for"),
        ("gravity in cm", ("dummy.geometry.gravity_m_per_s2", 981.0), "expected a number of at most 9.9 for"),
        (
            "gravity misspelt",
            ("weight.weight.gravity_m_per_s2", 9.18),
            "expected a number of at least 9.7 for",
        ),
        ("a stature in cm", ("standing.person.stature_m", 175.0), "expected a number of at most 2.6 for"),
        ("an ankle in cm", ("standing.person.ankle_height_m", 8.0), "expected a number of at most 0.3 for"),
        ("a fraction in percent", ("standing.person.com_height", 55.0), "expected a number below 1 for"),
        ("a foot in cm", ("standing.person.foot_com_m", 5.0), "expected a number of at most 0.3 for"),
        ("a weight in g", ("weight.weight.mass_kg", 20000.0), "expected a number of at most 500 for"),
        ("a height in mm", ("weight.weight.com_height_m", 100.0), "expected a number of at most 3 for"),
        ("a leg without mass", ("dummy.geometry.leg_mass_kg", 0.0), "expected a number above 0 for"),
        (
            "an inertia in g cm2",
            ("dummy.geometry.leg_inertia_kgm2", 270.0),
            "expected a number of at most 20",
        ),
        ("a slow cutoff", ("plate_treadmill.lowpass_cutoff_hz", 0.001), "expected a number of at least 0.01"),
        (
            "a cutoff in kHz",
            ("plate_treadmill.lowpass_cutoff_hz", 20000.0),
            "expected a number of at most 5000",
        ),
        (
            "truth for a number",
            ("plate_treadmill.lowpass_cutoff_hz", True),
            "expected a value of type number",
        ),
        ("yes for a seed", "study: {seed: yes}\n", "expected a value of type integer for 'study.seed'"),
        ("a number for a title", ("study.title", 5), "expected a value of type string for 'study.title'"),
        ("no folder of recordings", ("study.recordings_folder", None), "expected a value of type string for"),
        ("a section of nothing", ("dummy.geometry", None), "expected a value of type"),
        ("a text for a list", ("dummy.files.marker_labels", "ankle"), "expected a value of type array"),
        (
            "labels that are numbers",
            ("dummy.files.marker_labels", [1, 2]),
            "expected a value of type string for",
        ),
        ("one marker of the leg", ("dummy.geometry.leg_markers", []), "expected at least 2 items for"),
        ("no muscles", ("standing.muscles", 5), "expected a value of type"),
        ("no models", ("weight.models.family", []), "expected at least 1 items for 'weight.models.family'"),
        ("a model misspelt", ("weight.models.family", ["hnat"]), "expected one of 'mean-subtraction'"),
        (
            "two equal cutoffs",
            ("weight.analysis.other_cutoffs_hz", [20.0]),
            "expected weight.analysis.other_cut",
        ),
        ("a rate of 0", ("plate_treadmill.resample_rate_hz", 0.0), "expected a number above 0 for"),
        (
            "cameras of 30 Hz",
            ("plate_treadmill.resample_rate_hz", 30.0),
            "expected plate_treadmill.lowpass_cutoff",
        ),
        ("a plate twice", ("plate_treadmill.recording.plates.right", [1, 1]), "expected different items for"),
        ("plate 0", ("plate_treadmill.recording.plates.left", [0]), "expected a number of at least 1 for"),
        (
            "an axis without sign",
            ("plate_treadmill.recording.axes.up", "z"),
            "expected one of '+x', '-x', '+y'",
        ),
        ("a sign of 2", ("plate_treadmill.recording.force_sign", 2), "expected one of 1, -1 for"),
        ("frozen for 0 s", ("plausible.frozen_s", 0.0), "expected a number above 0 for 'plausible.frozen_s'"),
        ("a threshold of 1", ("dummy.analysis.threshold_fraction", 1.0), "expected a number below 1 for"),
        ("a rest of 0 s", ("dummy.analysis.rest_before_s", 0.0), "expected a number above 0 for"),
        (
            "a delimiter",
            ("position_manipulator.files.delimiter", ";"),
            "expected one of 'comma', 'tab', 'semi",
        ),
        ("a sign of 0", ("position_manipulator.files.torque_sign", 0), "expected one of 1, -1 for"),
        (
            "a free reflex above half of the rate",
            ("standing.free_reflex.lowpass_cutoff_hz", 130.0),
            "expected standing.free_reflex.lowpass_cutoff_hz below half of plate_treadmill.resample_rate_hz",
        ),
        (
            "a stretch above half of the rate",
            ("standing.analysis.stretch_cutoff_hz", 125.0),
            "expected standing.analysis.stretch_cutoff_hz below half of plate_treadmill.resample_rate_hz",
        ),
    ]
]
SETTINGS += ODD_SETTINGS

ODD_YAML = [
    (
        "a number with its unit",
        "dummy: {geometry: {leg_mass_kg: 0.4 kg}}",
        "expected a value of type number for",
    ),
    ("a decimal comma in YAML", "dummy: {geometry: {leg_mass_kg: 0,4}}", "unknown key 'dummy.geometry.4'"),
    ("a mass beyond floats", "dummy: {geometry: {leg_mass_kg: 1.0e+400}}", "expected a finite number for"),
    (
        "a power without a point",
        "dummy: {geometry: {leg_mass_kg: 4e-1}}",
        "expected a value of type number for",
    ),
    ("minutes and seconds", "dummy: {geometry: {leg_mass_kg: 1:30}}", "('1:30' is read as a number"),
    ("digits with an underscore", "study: {seed: 1_000}", "('1_000' is read as a number"),
    ("an octal number", "dummy: {geometry: {leg_mass_kg: 0o17}}", "expected a value of type number for"),
    ("a key of nothing", "null: 2\n", "(the key 'null' is no word: put it into quotes)"),
    ("a key that is true", "on: 2\n", "(the key 'on' is no word: put it into quotes)"),
    ("a number as key", "1: 2\n", "unknown key '1'"),
    ("a list as key", "? [a, b]\n: 1\n", "(a key that is not a word)"),
    ("a key with a space", "'study ': {seed: 1}\n", "unknown key 'study ': did you mean 'study'?"),
    ("a key with dots", "study.seed: 1\n", "unknown key 'study.seed': did you mean 'study'?"),
    ("spaces that are none", "study:\n\u00a0\u00a0seed: 1\n", "unknown key '\\xa0\\xa0seed'"),
    ("an alias of itself", "study: &a {title: *a}\n", "(found unconstructable recursive node)"),
    ("a section for aliases", "mine: &m {seed: 3}\nstudy: {<<: *m}\n", "unknown key 'mine'"),
    ("a tag of Python", "study: {title: !!python/tuple [a]}\n", "(could not determine a constructor"),
    ("a title that is a date", "study: {title: 2024-01-01}\n", "expected a value of type string for"),
    ("two documents", "study: {seed: 1}\n---\nstudy: {seed: 2}\n", "(but found another document)"),
    ("draws beyond any memory", ("dummy.analysis.bootstrap_draws", 10**9), "a number of at most 100000 for"),
    ("a share in percent", ("plausible.mass_fraction", 15.0), "expected a number of at most 1 for"),
    (
        "a scale of 0",
        ("plate_treadmill.recording.belt_velocity.m_per_s_per_unit", 0.0),
        "per_unit other than 0",
    ),
    ("a variable as path", ("study.recordings_folder", "$HOME/recordings"), "write the variable out"),
    ("a marker twice", ("dummy.files.marker_labels", ["a", "a", "b"]), "expected different items for"),
    (
        "a plate as a number",
        ("plate_treadmill.recording.plates.left", 1),
        "expected a value of type array for",
    ),
    ("both belts for the dummy", ("plate_treadmill.belt", "both"), "expected one of 'left', 'right' for"),
    (
        "a virtual laboratory that is the configuration",
        ("study.virtual_lab", "config/config.yaml"),
        "unknown key",
    ),
    ("a sheet that is the configuration", ("study.trial_sheet", "config/config.yaml"), "unknown column"),
    (
        "participants in place",
        ("study.participants", {"P01": {"mass_kg": 80}}),
        "expected a value of type string",
    ),
]
SETTINGS += [
    BadSettings(name, overlay if isinstance(overlay, str) else key(*overlay), words)
    for name, overlay, words in ODD_YAML
]

# keys that name a path, the path, and what the sentence says of it
FOLDERS, NAMED = ("pathvars.results", "pathvars.logs"), ("study.trial_sheet", "study.virtual_lab")
ODD_PATHS = [
    (*FOLDERS, *NAMED, "a<b>c", "without '<' '>'"),
    (*FOLDERS, "study.reported", "a\nb", r"without '\n'"),
    ("study.participants", *FOLDERS, "a\0b", r"without '\x00'"),
    ("study.recordings_folder", "study.reported", "a\x1b[2Jb", r"without '\x1b'"),
    ("study.virtual_lab", "study.recordings_folder", "a*", "without '*'"),
    ("study.reported", "pathvars.logs", 'a"b', "without '\"'"),
    ("study.participants", "pathvars.results", "~/a", "write the home directory out"),
    (*NAMED, "-rf", "does not begin with a hyphen"),
    ("study.recordings_folder", "study.reported", "", "is not empty"),
    ("pathvars.results", *NAMED, "x" * 256, "names of at most 255 bytes"),
    ("study.participants", *NAMED, "/dev/zero", "found a pipe or a device"),
    ("study.reported", "study.participants", "config", "found the folder 'config': name the file"),
    ("study.recordings_folder", "Snakefile", "to name a folder, found the file 'Snakefile'"),
    (*FOLDERS, ".venv/x", "which lies in .venv/ of the source code"),
    (*FOLDERS, "Snakefile", "which is a file"),
    ("study.name", "nul", "to be the name of a file"),
    ("study.name", "x" * 81, "of at most 80 characters"),
]
SETTINGS += [
    BadSettings(f"{where}: {path[:20]!r}", key(where, path), words)
    for *keys, path, words in ODD_PATHS
    for where in keys
]

# ---- trial sheets --------------------------------------------------------------------------------------


def at(row, column, value):
    """A cell of the sheet, by its column's name; row 0 is the header."""

    def spoil(rows):
        rows[row][rows[0].index(column)] = value

    return spoil


def dropped(column):
    def spoil(rows):
        k = rows[0].index(column)
        for row in rows:
            del row[k]

    return spoil


def all_rows(change):
    def spoil(rows):
        rows[:] = change(rows)

    return spoil


def replaced(old, new):
    return all_rows(lambda rows: [[cell.replace(old, new) for cell in row] for row in rows])


def without(experiment):
    return all_rows(lambda rows: [row for row in rows if row[0] != experiment])


SHEETS = [
    BadSheet(name, spoil, f"bad.tsv: {words}")
    for name, spoil, words in [
        (
            "walking without its section",
            all_rows(lambda rows: [rows[0], ["walking", "a", "recorded", *"---9a-------"]]),
            "expected the section walking in the configuration for trials of walking, found null",
        ),
        ("sheet empty", all_rows(lambda rows: []), "expected the tab-separated column 'experiment'"),
        ("sheet of a header only", all_rows(lambda rows: rows[:1]), "expected at least one trial"),
        (
            "sheet without a header",
            all_rows(lambda rows: rows[1:]),
            "unknown column 'wristalyzer': known: experiment, condition, source,",
        ),
        ("a column misspelt", at(0, "condition", "conditon"), "unknown column 'conditon'"),
        ("a column twice", at(0, "amplitude", "profile"), "expected the column 'profile' once"),
        ("a column missing", dropped("duration_s"), "expected the tab-separated column 'duration_s'"),
        ("sheet with commas", all_rows(lambda rows: [[",".join(row)] for row in rows]), "unknown column"),
        ("a cell too many", lambda rows: rows[3].append("-"), "expected 15 cells, found 16 on line 4"),
        ("a cell too few", lambda rows: rows[3].pop(), "expected 15 cells, found 14 on line 4"),
        ("a trial twice", lambda rows: rows.append(list(rows[1])), "expected every trial once"),
        (
            "an unknown experiment",
            at(1, "experiment", "wrist"),
            "line 2: expected an experiment of wristalyzer, dummy, weight, empty,",
        ),
        (
            "a condition with a slash",
            at(1, "condition", "0.08/2"),
            "line 2: expected a condition of letters, digits, dots and hyphens that",
        ),
        (
            "a condition of dots",
            at(1, "condition", ".."),
            "line 2: expected a condition of letters, digits, dots and hyphens that",
        ),
        (
            "a condition like an option",
            at(1, "condition", "-rf"),
            "line 2: expected a condition of letters, digits, dots and hyphens that",
        ),
        (
            "an empty condition",
            at(1, "condition", ""),
            "line 2: expected a condition of letters, digits, dots and hyphens that",
        ),
        (
            "an unknown source",
            at(1, "source", "laboratory"),
            "line 2: expected the source to be virtual_lab or recorded",
        ),
        (
            "a recording without files",
            at(6, "source", "recorded"),
            "line 7: expected a log file for dummy/sine-0.1",
        ),
        (
            "files of a simulated trial",
            at(6, "log", "log.mat"),
            "line 7: expected no files for what the virtual laboratory can make",
        ),
        ("an unknown profile", at(6, "profile", "cosine"), "line 7: expected a profile of sine, minjerk"),
        ("no amplitude", at(6, "amplitude", "-"), "line 7: expected a number for amplitude"),
        ("no duration", at(6, "duration_s", "-"), "line 7: expected a number for duration_s"),
        ("no interval", at(6, "interval_s", "-"), "line 7: expected a number for interval_s"),
        (
            "an interval from long to short",
            at(-1, "interval_s", "8-4"),
            "line 57: expected interval_s from short to long",
        ),
        (
            "a decimal comma",
            at(6, "amplitude", "0,1"),
            "line 7: expected a positive number or '-' for amplitude",
        ),
        (
            "an unknown role",
            at(18, "role", "calibration"),
            "line 19: expected a role of calibrate or validate for weight/sine-0.1",
        ),
        (
            "a role of the dummy",
            at(6, "role", "calibrate"),
            "line 7: expected '-' for the role, because trials of dummy have none",
        ),
        (
            "no trial to calibrate with",
            replaced("calibrate", "validate"),
            "expected a trial of weight with the role calibrate",
        ),
        (
            "no trial to validate with",
            replaced("validate", "calibrate"),
            "expected a trial of weight with the role validate",
        ),
        (
            "the weight without the empty belt",
            without("empty"),
            "expected trials of empty beside those of weight",
        ),
        (
            "a person without a task",
            at(-1, "task", "-"),
            "line 57: expected a task of relax or stiff for standing/stiff-neg-0.5",
        ),
        (
            "a task that is not simulated",
            at(-1, "task", "jump"),
            "line 57: expected a task of relax or stiff for standing/stiff-neg-0.5",
        ),
        (
            "a task of the dummy",
            at(6, "task", "relax"),
            "line 7: expected '-' for the task, because trials of dummy have none",
        ),
    ]
]


def added(name, cells):
    """A further column with cells by row, and - elsewhere."""

    def spoil(rows):
        for k, row in enumerate(rows):
            row.append(name if k == 0 else cells.get(k, "-"))

    return spoil


def recorded(log):
    """A trial that is recorded, and the path of its log."""

    def spoil(rows):
        row = dict(zip(rows[0], rows[6], strict=True))
        row |= {"source": "recorded", "profile": "-", "amplitude": "-", "interval_s": "-", "log": log}
        rows[6] = list((row | {"calibration": "c.csv", "markers": "m.c3d"}).values())

    return spoil


def several(*changes):
    def spoil(rows):
        for change in changes:
            change(rows)

    return spoil


def twice(first, second):
    """Two trials of the dummy with the recordings of these names."""
    row = ["dummy", "a", "recorded", "-", "-", "-", "46", first, *["-"] * 7]
    return lambda rows: rows.extend([row, ["dummy", "b", *row[2:7], second, *row[8:]]])


DURATION, ROLE = "line 7: expected a positive number or '-' for duration_s", "validate"
ODD_SHEETS = [
    BadSheet(name, spoil, f"bad.tsv: {words}")
    for name, spoil, words in [
        ("a duration of 1e7 s", at(6, "duration_s", "1e7"), "line 7: expected a duration_s of at most 3600"),
        ("a duration of 0", at(6, "duration_s", "0"), DURATION),
        ("a duration not a number", at(6, "duration_s", "nan"), DURATION),
        ("an amplitude of 0", at(6, "amplitude", "0"), "line 7: expected a positive number or '-' for"),
        ("an open interval", at(6, "interval_s", "4-"), "line 7: expected a positive number or '-' for"),
        ("an interval of words", at(-1, "interval_s", "a-b"), "line 57: expected a positive number or"),
        ("a mass of the dummy", at(6, "mass_kg", "20"), "line 7: expected '-' for mass_kg, because trials"),
        ("a mass below 0", at(28, "mass_kg", "-60"), "line 29: expected a positive number or '-' for mass"),
        ("a mass of no weight", at(28, "mass_kg", "61"), "expected a mass_kg of 20 or 60 for weight/"),
        (
            "only the heavy weight validates",
            several(*(at(k, "role", "calibrate") for k in range(23, 28))),
            "expected a trial with the usual weight (weight.weight.mass_kg) and the role validate",
        ),
        (
            "only the heavy weight calibrates",
            several(*(at(k, "role", ROLE) for k in range(18, 23))),
            "expected a trial with the usual weight (weight.weight.mass_kg) and the role calibrate",
        ),
        (
            "an empty belt of another name",
            at(36, "condition", "minjerk-a"),
            "expected a trial of the empty belt with the condition of weight/minjerk-0.1, whose",
        ),
        ("one recording twice", twice("a.c3d", "a.c3d"), "expected a recording of its own for every trial"),
        ("one recording by two paths", twice("a.c3d", "b/../a.c3d"), "expected a recording of its own"),
        ("a document", twice("a.doc", "b.doc"), "line 58: expected a calibration file for dummy/a"),
        ("an experiment in capitals", at(6, "experiment", "Dummy"), "line 7: expected an experiment of"),
        ("conditions that differ by case", at(7, "condition", "SINE-0.1"), "expected"),
        ("a condition that is missing", at(6, "condition", "MISSING"), "line 7: expected a value for"),
        ("a byte of zero", at(6, "condition", "a\0b"), ""),
        (
            "some with a participant",
            added("participant", {-1: "P1", 56: "P1"}),
            "expected a participant for every trial of standing, or for none",
        ),
        (
            "a participant of a weight",
            added("participant", {18: "P1"}),
            "line 19: expected '-' for the participant, because trials of weight have none",
        ),
        (
            "a belt in the middle",
            added("belt", {18: "middle"}),
            "line 19: expected the belt to be left or right",
        ),
        (
            "a belt of the manipulator",
            added("belt", {1: "left"}),
            "line 2: expected '-' for the belt, because trials of wristalyzer are not on the plate",
        ),
        (
            "a column of a simulated trial",
            added("angle_unit", {1: "deg"}),
            "line 2: expected '-' for angle_unit, because the virtual laboratory names its columns",
        ),
        (
            "an operating point of the dummy",
            added("operating_angle_rad", {6: "0.1"}),
            "line 7: expected '-' for operating_angle_rad, because only trials of position_",
        ),
    ]
]
SHEETS += ODD_SHEETS

SHEETS += [
    BadSheet(f"a recording called {path[:20]!r}", recorded(path), f"bad.tsv: {words}")
    for path, words in [
        ("a{x}.mat", "expected a path without '{' '}' for 'a recording'"),
        ("~/a.mat", "expected a path from / or from the folder of the run for 'a recording'"),
        ("-a.mat", "expected a path for 'a recording' that does not begin with a hyphen"),
        ("a*.mat", "expected a path without '*' for 'a recording'"),
        ("a\u202eb.mat", r"expected a path without '\u202e' for 'a recording'"),
        ("x" * 300, "expected names of at most 255 bytes in the path for 'a recording'"),
    ]
]
SHEETS += [
    BadSheet(f"a condition called {name[:20]!r}", at(6, "condition", name), f"bad.tsv: line 7: {words}")
    for name, words in [
        ("$(touch x)", "expected a condition of letters, digits, dots and hyphens"),
        ("a\u202eb", "expected a condition of letters, digits, dots and hyphens"),
        ("aux.1", "expected a condition that can be a file name"),
        ("x" * 81, "expected a condition of at most 80 characters"),
    ]
]

SHEETS += [
    BadSheet(f"a duration of {cell!r}", at(6, "duration_s", cell), f"bad.tsv: line 7: {words}")
    for cell, words in [
        ("1e400", "expected a positive number or '-' for duration_s"),
        ("6_0", "expected a positive number or '-' for duration_s"),
    ]
]
SHEETS += [
    BadSheet(name, spoil, f"bad.tsv: {words}")
    for name, spoil, words in [
        ("a column more", all_rows(lambda rows: [[*row, ""] for row in rows]), "unknown column ''"),
        ("a quote that is not closed", at(6, "condition", '"sine'), "expected 15 cells, found 2 on line 7"),
    ]
]

SETTINGS += [
    BadSettings(name, overlay if isinstance(overlay, str) else key(*overlay), f"configuration: {words}")
    for name, overlay, words in [
        ("an equals sign", "study:\n  seed = 5\n", "expected a value of type object for 'study'"),
        (
            "one channel for two muscles",
            ("standing.muscles.TA.channel", "EMG SOL"),
            "expected standing.muscles.SOL.channel to be the channel of one muscle",
        ),
        (
            "an estimator that lacks a key",
            ("standing.estimators.mine", {"window_s": 0.1}),
            "expected the key 'standing.estimators.mine.inertia', found none",
        ),
        (
            "a baseline after the onset",
            ("standing.analysis.baseline_s", [0.0, 0.1]),
            "expected a number of at most 0 for 'standing.analysis.baseline_s.1'",
        ),
        (
            "delays from long to short",
            ("position_manipulator.analysis.parallel_cascade.reflex_delays_s", [0.06, 0.03]),
            "expected position_manipulator.analysis.parallel_cascade.expected_delay_s within",
        ),
        (
            "an action of 2",
            ("standing.muscles.TA.ankle_action", 2),
            "expected one of -1, 0, 1 for 'standing.muscles.TA.ankle_action', found 2",
        ),
    ]
]
SETTINGS += [
    BadSettings(name, overlay, f"bad.yaml: {words}")
    for name, overlay, words in [
        ("brackets in brackets", f"study: {'[' * 3000}{']' * 3000}\n", "expected at most 100 brackets"),
        (
            "aliases of aliases",
            "a0: &a0 [x]\n" + "".join(f"a{k + 1}: &a{k + 1} [{f'*a{k}, ' * 9}]\n" for k in range(7)),
            "expected at most 100000 settings, found more when aliases are written out",
        ),
        ("a colon in a title", "study:\n  title: Ankle: pilot\n", "expected YAML, found a mistake on line 2"),
    ]
]


def empty_belt_twice(rows):
    """One recording of the empty belt that calibrates, and validates, too."""
    number = next(k for k, row in enumerate(rows) if row[0] == "empty")
    row = dict(zip(rows[0], rows[number], strict=True))
    row |= {"source": "recorded", "profile": "-", "amplitude": "-", "interval_s": "-", "log": "e.mat"}
    row |= {"calibration": "c.csv"}
    rows.extend([list((row | {"condition": f"twice-{role}", "role": role}).values()) for role in ROLES])


ROLES = ("calibrate", "validate")
SHEETS += [
    BadSheet(
        "one recording in both roles",
        empty_belt_twice,
        "bad.tsv: expected empty/twice-validate to validate on a recording of its own, found that of",
    )
]
