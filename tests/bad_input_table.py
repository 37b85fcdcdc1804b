"""Two hundred bad inputs: how the input of a good study is spoiled, and what the one sentence about it says.

`FILES` are files of one recorded trial: they stop their own job, and the good trial beside it keeps its
results. `SETTINGS` are configurations and `SHEETS` trial sheets: they stop the run before the first job, and
all earlier results remain. `test_bad_inputs.py` refuses them by the functions of the library and of the
workflow, `benchmarks/soak/bad_inputs.py` by real runs.
"""

import numpy as np
from bad_inputs import (
    LEG,
    BadFile,
    BadSettings,
    BadSheet,
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


def random_bytes(size=50_000):
    return np.random.default_rng(7).integers(0, 256, size, dtype=np.uint8).tobytes()


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


def end_cut(names, samples_cut=3000):
    return {name: (lambda x: x[:-samples_cut]) for name in names}


def word_at(k):
    return lambda rows: [*rows[:k], "\t".join(["abc"] * len(rows[0].split("\t"))), *rows[k:]]


def short_at(k):
    return lambda rows: [*rows[:k], rows[k].split("\t")[0], *rows[k + 1 :]]


def without_numbers(rows):
    return [*rows[:500], *(f"{row.split(',')[0]},," for row in rows[500:600]), *rows[600:]]


def utf16(name):
    return lambda folder: (folder / name).write_text((folder / name).read_text(), "utf-16")


SIGNALS = ("transducers_V", "belt_velocity_m_per_s", "command_m_per_s", "trigger_V")


def dummy(group, entries):
    return [BadFile(group, name, "dummy", spoil, words) for name, spoil, words in entries]


THE_LOG = dummy(
    "log",
    [
        ("log missing", gone(LOG), "?"),
        ("log empty", empty(LOG), "?"),
        ("log truncated", cut(LOG, 0.5), "?"),
        ("log cut in its header", cut(LOG, 0.0002), "?"),
        ("log is a text", content(LOG, b"time\tvelocity\n0\t0\n"), "?"),
        ("log is noise", content(LOG, random_bytes()), "?"),
        ("log is a folder", folder_instead(LOG), "?"),
        ("log is the C3D file", swapped(LOG, MARKERS), "?"),
        ("log without voltages", mat(transducers_V=None), "?"),
        ("log without velocity", mat(belt_velocity_m_per_s=None), "?"),
        ("log without command", mat(command_m_per_s=None), "?"),
        ("log without trigger", mat(trigger_V=None), "?"),
        ("log without rate", mat(sample_rate_hz=None), "?"),
        ("log without names", mat(channel_names=None), "?"),
        ("rate of zero", mat(sample_rate_hz=times(0.0)), "?"),
        ("negative rate", mat(sample_rate_hz=times(-1.0)), "?"),
        ("rate not a number", mat(sample_rate_hz=times(np.nan)), "?"),
        ("rate as text", mat(sample_rate_hz=lambda x: "fast"), "?"),
        ("rate in kHz", mat(sample_rate_hz=times(0.001)), "?"),
        ("rate doubled", mat(sample_rate_hz=times(2.0)), "?"),
        ("voltage not a number", mat(transducers_V=put((3000, 5), np.nan)), "?"),
        ("voltage infinite", mat(transducers_V=put((3000, 5), np.inf)), "?"),
        ("velocity not a number", mat(belt_velocity_m_per_s=put(3000, np.nan)), "?"),
        ("velocity shorter", mat(belt_velocity_m_per_s=fewer), "?"),
        ("velocity as text", mat(belt_velocity_m_per_s=lambda x: "0.5"), "?"),
        ("velocity complex", mat(belt_velocity_m_per_s=times(1j)), "?"),
        ("voltages of three axes", mat(transducers_V=lambda x: x[..., None] * np.ones(2)), "?"),
        ("voltages without a channel", mat(transducers_V=lambda x: x[:, :-1]), "?"),
        ("channels exchanged", mat(channel_names=names_exchanged), "?"),
        ("trigger never rises", mat(trigger_V=times(0.0)), "?"),
        ("trigger high from the start", mat(trigger_V=lambda x: np.full_like(x, 5.0)), "?"),
        ("trigger falls early", mat(trigger_V=halved_trigger), "?"),
        ("trigger inverted", mat(trigger_V=lambda x: 5.0 - x), "?"),
        ("log ends early", mat(**end_cut(SIGNALS, 5000)), "?"),
    ],
)
MATRICES = dummy(
    "calibration",
    [
        ("matrix missing", gone(MATRIX), "?"),
        ("matrix empty", empty(MATRIX), "?"),
        ("matrix cut in its last number", cut_bytes(MATRIX, 4), "?"),
        ("matrix cut in half", cut(MATRIX, 0.5), "?"),
        ("matrix is the log", swapped(MATRIX, LOG), "?"),
        ("matrix with semicolons", text(MATRIX, ",", ";"), "?"),
        ("matrix without Fy", without_row("Fy_right"), "?"),
        ("matrix with a row twice", calibration(doubled_row), "?"),
        ("matrix with another unit", cell(1, 1, "kN/V"), "?"),
        ("matrix with a word", cell(3, 4, "abc"), "?"),
        ("matrix with NaN", cell(3, 4, "nan"), "?"),
        ("matrix with an infinite number", cell(3, 4, "inf"), "?"),
        ("matrix with an empty cell", cell(3, 4, ""), "?"),
        ("matrix without a channel", calibration(without_column), "?"),
        ("matrix of other channels", text(MATRIX, "left_", "west_"), "?"),
        ("matrix times 1000", factor(1000.0), "?"),
        ("matrix over 1000", factor(0.001), "?"),
        ("matrix of zeros", factor(0.0), "?"),
        ("matrix with Fz zero", factor(0.0, "Fz_right"), "?"),
        ("matrix with Fy zero", factor(0.0, "Fy_right"), "?"),
        ("matrix with Mx zero", factor(0.0, "Mx_right"), "?"),
        ("matrix with Fz reversed", factor(-1.0, "Fz_right"), "?"),
        ("belts of the matrix exchanged", calibration(exchanged_belts), "?"),
    ],
)
THE_MARKERS = dummy(
    "markers",
    [
        ("markers missing", gone(MARKERS), "?"),
        ("markers empty", empty(MARKERS), "?"),
        ("markers truncated", cut(MARKERS, 0.6), "?"),
        ("markers cut in their header", cut(MARKERS, 0.001), "?"),
        ("markers are a text", content(MARKERS, b"Frame X Y Z\n1 0 0 0\n"), "?"),
        ("markers are noise", content(MARKERS, random_bytes()), "?"),
        ("markers are the log", swapped(MARKERS, LOG), "?"),
        ("a label missing", label("leg3", "knee"), "?"),
        ("a label twice", label("leg3", "leg2"), "?"),
        ("markers at another rate", parameter("POINT", "RATE", 100.0), "?"),
        ("markers half as long", points(lambda p: p[:, :, : p.shape[2] // 2]), "?"),
        ("markers in an unknown unit", parameter("POINT", "UNITS", "furlong"), "?"),
        ("mm that are called m", parameter("POINT", "UNITS", "m"), "?"),
        ("mm that are called cm", parameter("POINT", "UNITS", "cm"), "?"),
        ("a marker hidden for half a second", points(put((slice(None), 5, slice(900, 1025)), np.nan)), "?"),
        ("a marker never seen", points(put((slice(None), 5), np.nan)), "?"),
        ("a hidden marker at the origin", points(put((slice(None), 5, slice(900, 925)), 0.0)), "?"),
        ("a jump of one marker", points(put((1, 6, 1300), 2500.0)), "?"),
        ("a sample of 1e6", points(put((1, 6, 1300), 1e6)), "?"),
        ("leg frozen at its first frame", points(frozen_at_start), "?"),
        ("leg frozen for the last fifth", points(frozen_at_end), "?"),
        ("one marker frozen", points(one_frozen), "?"),
        ("leg that only shows noise", points(still_leg), "?"),
        ("all markers frozen", points(lambda p: np.repeat(p[:, :, :1], p.shape[2], axis=2)), "?"),
        ("axes x and y exchanged", points(lambda p: p[[1, 0, 2]]), "?"),
        ("axis y reversed", points(lambda p: p * np.array([1.0, -1.0, 1.0])[:, None, None]), "?"),
        ("markers half a second late", points(shifted), "?"),
        ("markers of another trial", of_other(MARKERS), "?"),
        ("foot and leg exchanged", points(exchanged(0, 4)), "?"),
        ("markers a tenth too large", points(times(1.2)), "?"),
    ],
)
PHYSICS = dummy(
    "physics",
    [
        ("voltages in mV", mat(transducers_V=times(1000.0)), "?"),
        ("voltages of zero", mat(transducers_V=times(0.0)), "?"),
        ("one transducer dead", mat(transducers_V=put((slice(None), 9), 0.0)), "?"),
        ("one voltage of 1e6", mat(transducers_V=put((5000, 9), 1e6)), "?"),
        ("plate stops", mat(transducers_V=put(slice(6000, None), 0.1)), "?"),
        ("velocity in mm/s", mat(belt_velocity_m_per_s=times(1000.0)), "?"),
        ("velocity in cm/s", mat(belt_velocity_m_per_s=times(100.0)), "?"),
        ("velocity in km/h", mat(belt_velocity_m_per_s=times(3.6)), "?"),
        ("velocity reversed", mat(belt_velocity_m_per_s=times(-1.0)), "?"),
        ("velocity of zero", mat(belt_velocity_m_per_s=times(0.0)), "?"),
        ("velocity of noise", mat(belt_velocity_m_per_s=noise(0.001)), "?"),
        ("velocity stops", mat(belt_velocity_m_per_s=put(slice(6000, None), 0.0)), "?"),
        ("one velocity of 1e6", mat(belt_velocity_m_per_s=put(5000, 1e6)), "?"),
        ("one velocity of 3 m/s", mat(belt_velocity_m_per_s=put(slice(5000, 5004), 3.0)), "?"),
        ("command in mm/s", mat(command_m_per_s=times(1000.0)), "?"),
        ("log of another trial", of_other(LOG), "?"),
        ("log and matrix of another trial", of_other(LOG, MATRIX), "?"),
        ("log of the empty belt", of_experiment("empty", LOG), "?"),
        ("log of the weight", of_experiment("weight", LOG), "?"),
    ],
)


def others(group, experiment, entries):
    return [BadFile(group, name, experiment, spoil, words) for name, spoil, words in entries]


ON_THE_BELT = [
    *others(
        "weight",
        "weight",
        [
            ("weight: log of the empty belt", of_experiment("empty", LOG), "?"),
            ("weight: matrix over 1000", factor(0.001), "?"),
            ("weight: matrix 1.3 times", factor(1.3), "?"),
            ("weight: matrix with Fz reversed", factor(-1.0, "Fz_right"), "?"),
            ("weight: markers frozen", points(lambda p: np.repeat(p[:, :, :1], p.shape[2], axis=2)), "?"),
            ("weight: markers of another trial", of_other(MARKERS), "?"),
            ("weight: markers of the dummy", of_experiment("dummy", MARKERS), "?"),
        ],
    ),
    *others(
        "empty",
        "empty",
        [
            ("empty: log of the weight", of_experiment("weight", LOG), "?"),
            ("empty: dead plate", mat(transducers_V=times(0.0)), "?"),
            ("empty: velocity in mm/s", mat(belt_velocity_m_per_s=times(1000.0)), "?"),
            ("empty: trigger too short", mat(trigger_V=halved_trigger), "?"),
        ],
    ),
    *others(
        "standing",
        "standing",
        [
            ("standing: markers frozen", points(lambda p: np.repeat(p[:, :, :1], p.shape[2], axis=2)), "?"),
            ("standing: shank frozen", points(put((slice(None), 3), 200.0)), "?"),
            ("standing: mm that are called m", parameter("POINT", "UNITS", "m"), "?"),
            ("standing: matrix times 1000", factor(1000.0), "?"),
            ("standing: dead plate", mat(transducers_V=times(0.0)), "?"),
        ],
    ),
    *others(
        "EMG",
        "standing",
        [
            ("electromyograms missing", gone(EMG), "?"),
            ("electromyograms empty", empty(EMG), "?"),
            ("electromyograms truncated", cut(EMG, 0.5), "?"),
            ("electromyograms are a text", content(EMG, b"time,TA\n0,1\n"), "?"),
            ("electromyograms are the log", swapped(EMG, LOG), "?"),
            ("electromyograms are noise", content(EMG, random_bytes()), "?"),
            ("electromyograms without trigger", relabelled("Trigger", "Marker"), "?"),
            ("trigger of the electromyograms low", samples("Trigger", times(0.0)), "?"),
            ("trigger of the electromyograms high", samples("Trigger", lambda x: x * 0.0 + 5.0), "?"),
            ("an electromyogram of 1 V", samples("EMG SOL", lambda x: put(5000, 1e6)(x)), "?"),
            ("electromyograms of 0.2 V", samples("EMG SOL", times(1e3)), "?"),
        ],
    ),
]
WRIST = others(
    "manipulator log",
    "wristalyzer",
    [
        ("manipulator log missing", gone("log.txt"), "?"),
        ("manipulator log empty", empty("log.txt"), "?"),
        ("manipulator log of a header only", lines("log.txt", lambda rows: rows[:1]), "?"),
        ("manipulator log with another column", text("log.txt", "MotorAngle", "Angle"), "?"),
        ("manipulator log with commas", text("log.txt", "\t", ","), "?"),
        ("manipulator log with decimal commas", text("log.txt", ".", ","), "?"),
        (
            "manipulator log with a word",
            lines("log.txt", word_at(500)),
            "?",
        ),
        ("manipulator log backwards", lines("log.txt", lambda rows: [rows[0], *rows[:0:-1]]), "?"),
        ("manipulator log with a gap", lines("log.txt", lambda rows: rows[:1000] + rows[1100:]), "?"),
        ("manipulator log that ends early", lines("log.txt", lambda rows: rows[: len(rows) // 2]), "?"),
        (
            "manipulator log with a short line",
            lines("log.txt", short_at(500)),
            "?",
        ),
        ("manipulator log is noise", content("log.txt", random_bytes()), "?"),
        (
            "manipulator log in UTF-16",
            utf16("log.txt"),
            "?",
        ),
        ("manipulator log with a column twice", text("log.txt", "TimeStamp", "MotorAngle", 1), "?"),
        ("manipulator never triggered", cells("log.txt", "TriggerTime", times(0.0)), "?"),
        ("angle in degrees", cells("log.txt", "MotorAngle", times(57.3)), "?"),
        ("angle reversed", cells("log.txt", "MotorAngle", times(-1.0)), "?"),
        ("angle constant", cells("log.txt", "MotorAngle", times(0.0)), "?"),
        ("angle in mrad", cells("log.txt", "MotorAngle", times(1000.0)), "?"),
        ("angle stops", cells("log.txt", "MotorAngle", put(slice(1500, 1900), 0.0)), "?"),
        ("one angle of 1e6", cells("log.txt", "MotorAngle", put(1500, 1e6)), "?"),
        ("angle in thousandths", cells("log.txt", "MotorAngle", times(1e-3)), "?"),
    ],
) + others(
    "command",
    "wristalyzer",
    [
        ("command missing", gone(COMMAND), "?"),
        ("command empty", empty(COMMAND), "?"),
        ("command is the log", swapped(COMMAND, "log.txt"), "?"),
        ("command with another column", text(COMMAND, "TorqueCommand", "Torque"), "?"),
        ("command backwards", lines(COMMAND, lambda rows: [rows[0], *rows[:0:-1]]), "?"),
        ("command that ends early", lines(COMMAND, lambda rows: rows[: len(rows) // 2]), "?"),
        ("command with a gap", lines(COMMAND, lambda rows: rows[:1000] + rows[2000:]), "?"),
        ("command in mNm", cells(COMMAND, "TorqueCommand", times(1000.0)), "?"),
        ("command in kNm", cells(COMMAND, "TorqueCommand", times(0.001)), "?"),
        ("command reversed", cells(COMMAND, "TorqueCommand", times(-1.0)), "?"),
        ("one command of 1e6", cells(COMMAND, "TorqueCommand", put(3000, 1e6)), "?"),
    ],
)
TABLE = "table.csv"
TABLES = others(
    "text tables",
    "position_manipulator",
    [
        ("table missing", gone(TABLE), "?"),
        ("table empty", empty(TABLE), "?"),
        ("table with tabs", text(TABLE, ",", "\t"), "?"),
        ("table with another column", text(TABLE, "ankle_torque_Nm", "torque"), "?"),
        ("table backwards", lines(TABLE, lambda rows: [rows[0], *rows[:0:-1]]), "?"),
        ("table with a gap", lines(TABLE, lambda rows: rows[:1000] + rows[1100:]), "?"),
        ("table that ends early", lines(TABLE, lambda rows: rows[: len(rows) // 2]), "?"),
        ("table with a word", lines(TABLE, lambda r: [*r[:500], "a,b,c", *r[501:]]), "?"),
        (
            "table with long gaps",
            lines(TABLE, without_numbers),
            "?",
        ),
        ("table: angle in degrees", cells(TABLE, "ankle_pos_rad", times(5730.0), ","), "?"),
        ("table: torque in mNm", cells(TABLE, "ankle_torque_Nm", times(1e5), ","), "?"),
        ("table: torque of the other sign", cells(TABLE, "ankle_torque_Nm", times(-1.0), ","), "?"),
        ("table: torque constant", cells(TABLE, "ankle_torque_Nm", times(0.0), ","), "?"),
        ("table: torque stops", cells(TABLE, "ankle_torque_Nm", put(slice(4000, 5000), 0.0), ","), "?"),
        ("table: angle stops", cells(TABLE, "ankle_pos_rad", put(slice(4000, 5000), 0.0), ","), "?"),
        ("table: one torque of 1e6", cells(TABLE, "ankle_torque_Nm", put(4000, 1e6), ","), "?"),
    ],
) + others(
    "text tables",
    "belt",
    [
        ("belt table missing", gone("table.txt"), "?"),
        ("belt table with another unit", text("table.txt", "v (m/s)", "v (km/h)"), "?"),
        ("belt table in mm/s", cells("table.txt", "v (m/s)", times(1000.0)), "?"),
        ("belt table: velocity constant", cells("table.txt", "v (m/s)", lambda x: 0.0 * x + 1.2), "?"),
        ("belt table: load constant", cells("table.txt", "Mx (Nm)", times(0.0)), "?"),
        ("belt table: one load of 1e6", cells("table.txt", "Mx (Nm)", put(2000, 1e6)), "?"),
        ("belt table backwards", lines("table.txt", lambda rows: [rows[0], *rows[:0:-1]]), "?"),
        ("belt table too short", lines("table.txt", lambda rows: rows[:1500]), "?"),
        ("belt table: stamps of few decimals", cells("table.txt", "t", lambda x: np.floor(x)), "?"),
        ("belt table: an infinite load", cells("table.txt", "Mx (Nm)", put(2000, np.inf)), "?"),
    ],
)
FILES = [*THE_LOG, *MATRICES, *THE_MARKERS, *PHYSICS, *ON_THE_BELT, *WRIST, *TABLES]


# ---- configurations ----------------------------------------------------------------------------------------


def key(path, value):
    """A mapping of one value, at keys joined by dots."""
    for name in reversed(path.split(".")):
        value = {name: value}
    return value


SETTINGS = [
    BadSettings(name, overlay if isinstance(overlay, str) else key(*overlay), words)
    for name, overlay, words in [
        ("no YAML", "study: [1, 2\n", "?"),
        ("a tab", "study:\n\tname: a\n", "?"),
        ("a list", "- study\n", "?"),
        ("a word", "study\n", "?"),
        ("a key twice", "study:\n  seed: 1\n  seed: 2\n", "?"),
        ("a section twice", "study:\n  seed: 1\nstudy:\n  seed: 2\n", "?"),
        ("code", "__use_yte__: true\n?if True:\n  study: {}\n", "?"),
        ("an unknown section", ("studdy.seed", 1), "?"),
        ("an unknown key", ("dummy.analysis.rest_befor_s", 6.0), "?"),
        ("an earlier section", ("pilot.person.mass_kg", 70.0), "?"),
        ("an earlier key", ("weight.belt", "left"), "?"),
        ("an earlier value", ("dummy.pathways.leg.torque", "printed"), "?"),
        ("a number as text", ("plate_treadmill.lowpass_cutoff_hz", "20 Hz"), "?"),
        ("a negative cutoff", ("plate_treadmill.lowpass_cutoff_hz", -20.0), "?"),
        ("a cutoff above half the rate", ("plate_treadmill.lowpass_cutoff_hz", 125.0), "?"),
        ("an odd order", ("plate_treadmill.lowpass_order", 3), "?"),
        ("an infinite rate", "wristalyzer: {ingest: {resample_rate_hz: .inf}}\n", "?"),
        ("not a number", "wristalyzer: {ingest: {max_gap_s: .nan}}\n", "?"),
        ("null", ("dummy.ingest.trigger_threshold_V", None), "?"),
        ("a negative seed", ("study.seed", -1), "?"),
        ("a seed of 1.5", ("study.seed", 1.5), "?"),
        ("a name with spaces", ("study.name", "my study"), "?"),
        ("no trial sheet", ("study.trial_sheet", "nowhere.tsv"), "?"),
        ("no laboratory", ("study.virtual_lab", "nowhere.yaml"), "?"),
        ("another belt", ("plate_treadmill.belt", "middle"), "?"),
        ("an engine that there is not", ("dummy.simulation.engine", "bullet"), "?"),
        ("an unknown estimator", ("dummy.pathways.leg.estimator", "regression"), "?"),
        ("an unknown pathway", ("dummy.recommended", "legg"), "?"),
        ("an unknown treadmill model", ("standing.pathways.ankle.treadmill_model", "frame"), "?"),
        ("a marker that is not recorded", ("dummy.foot.belt_fixed_labels", ["foot1", "toe"]), "?"),
        ("a marker of the person twice", ("standing.files.marker_labels", ["ankle", "ankle"]), "?"),
        ("a window longer than its epoch", ("standing.estimators.long.window_s", 3.0), "?"),
        ("a band from high to low", ("standing.emg.band_hz", [300.0, 20.0]), "?"),
        ("a start beyond its bound", ("wristalyzer.analysis.start.K_Nm_per_rad", 30.0), "?"),
        ("an SNR that is not computed", ("noise.table_snr_db", 17), "?"),
        ("too few draws", ("dummy.analysis.bootstrap_draws", 3), "?"),
        ("a negative mass", ("weight.weight.mass_kg", -20.0), "?"),
        ("limits from high to low", ("plausible.force_N", [10.0, -10.0]), "?"),
        ("limits of three", ("plausible.force_N", [-10.0, 0.0, 10.0]), "?"),
        ("a correlation of 2", ("plausible.belt_fixed_correlation", 2.0), "?"),
        ("results over the configuration", ("pathvars.results", "config"), "?"),
        ("results outside", ("pathvars.results", "/"), "?"),
        ("results in a pattern", ("pathvars.results", "results/{B}"), "?"),
        ("an unknown path variable", ("pathvars.figures", "figures"), "?"),
    ]
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
    BadSheet(*entry)
    for entry in [
        ("sheet empty", all_rows(lambda rows: []), "?"),
        ("sheet of a header only", all_rows(lambda rows: rows[:1]), "?"),
        ("sheet without a header", all_rows(lambda rows: rows[1:]), "?"),
        ("a column misspelt", at(0, "condition", "conditon"), "?"),
        ("a column twice", at(0, "amplitude", "profile"), "?"),
        ("a column missing", dropped("duration_s"), "?"),
        ("sheet with commas", all_rows(lambda rows: [[",".join(row)] for row in rows]), "?"),
        ("a cell too many", lambda rows: rows[3].append("-"), "?"),
        ("a cell too few", lambda rows: rows[3].pop(), "?"),
        ("a trial twice", lambda rows: rows.append(list(rows[1])), "?"),
        ("an unknown experiment", at(1, "experiment", "wrist"), "?"),
        ("an earlier experiment", at(1, "experiment", "pilot"), "?"),
        ("a condition with a slash", at(1, "condition", "0.08/2"), "?"),
        ("a condition of dots", at(1, "condition", ".."), "?"),
        ("a condition like an option", at(1, "condition", "-rf"), "?"),
        ("a condition with spaces", at(1, "condition", "0 08"), "?"),
        ("an empty condition", at(1, "condition", ""), "?"),
        ("a condition that is no number", at(1, "condition", "small"), "?"),
        ("an unknown source", at(1, "source", "laboratory"), "?"),
        ("a recording without files", at(6, "source", "recorded"), "?"),
        ("files of a simulated trial", at(6, "log", "log.mat"), "?"),
        ("an unknown profile", at(6, "profile", "cosine"), "?"),
        ("a negative amplitude", at(6, "amplitude", "-0.1"), "?"),
        ("an amplitude in words", at(6, "amplitude", "large"), "?"),
        ("no amplitude", at(6, "amplitude", "-"), "?"),
        ("an infinite duration", at(6, "duration_s", "inf"), "?"),
        ("no duration", at(6, "duration_s", "-"), "?"),
        ("no interval", at(6, "interval_s", "-"), "?"),
        ("an interval from long to short", at(-1, "interval_s", "8-4"), "?"),
        ("a decimal comma", at(6, "amplitude", "0,1"), "?"),
        ("an unknown role", at(18, "role", "calibration"), "?"),
        ("a role of the dummy", at(6, "role", "calibrate"), "?"),
        (
            "no trial to calibrate with",
            replaced("calibrate", "validate"),
            "?",
        ),
        (
            "no trial to validate with",
            replaced("validate", "calibrate"),
            "?",
        ),
        (
            "the weight without the empty belt",
            without("empty"),
            "?",
        ),
        ("a person without a task", at(-1, "task", "-"), "?"),
        ("a task that is not simulated", at(-1, "task", "jump"), "?"),
        ("a task of the dummy", at(6, "task", "relax"), "?"),
    ]
]
