"""Every public reader with small good files of its kind, and what a successful read promises.

Commands that read a file in their own way are readers here, too: ``compensate`` with what it writes,
``check`` of a C3D, and ``benchmark score``.
"""

import gzip
import json
import os
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import scipy

ROOT = Path(__file__).parents[2]
REAL_DATA = Path(os.environ.get("TEPSIPE_REAL_DATA", ROOT.parent / "shared" / "real-data"))
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from tepsipe.errors import InputError  # noqa: E402
from tepsipe.experiments.belt.compensation import Compensation, compensate  # noqa: E402
from tepsipe.experiments.belt.files import BeltChannels, BeltVelocity, read_belt_file  # noqa: E402
from tepsipe.experiments.benchmark.problems import ANSWERS, AnswerRow  # noqa: E402
from tepsipe.ingest.plate_doctor import FINDINGS, Finding, examine_plates  # noqa: E402
from tepsipe.io.estimates import ESTIMATES, Estimate  # noqa: E402
from tepsipe.io.formats import contents_of, formats  # noqa: E402
from tepsipe.io.readers.c3d import read_c3d_recording  # noqa: E402
from tepsipe.io.readers.dflow import marker_columns, plate_columns, read_dflow  # noqa: E402
from tepsipe.io.readers.text_table import read_text_table  # noqa: E402
from tepsipe.io.readers.treadmill_log import read_calibration_matrix, read_treadmill_log  # noqa: E402
from tepsipe.io.result import Result, read_result, write_result  # noqa: E402
from tepsipe.io.trial import Signal, Trial, read_trial, write_trial  # noqa: E402
from tepsipe.reporting.benchmark import (  # noqa: E402
    FAULTS,
    TrueProblem,
    read_answers,
    read_truth,
    scores_of,
    table_of,
)
from tepsipe.signals.filters import Lowpass  # noqa: E402
from tepsipe.treadmill.black_box_models import ImpulseResponse  # noqa: E402
from tepsipe.treadmill.mass_models import LoadedFrame, MeanSubtraction  # noqa: E402
from tepsipe.treadmill.registry import FittedModel, load_treadmill_models, save_models  # noqa: E402
from tepsipe.virtual_lab.dummy import MARKERS  # noqa: E402
from tepsipe.virtual_lab.electromyography import write_emg  # noqa: E402
from tepsipe.virtual_lab.treadmill_trial import (  # noqa: E402
    CHANNELS,
    write_calibration,
    write_markers,
    write_treadmill_log,
)
from tepsipe.virtual_lab.wristalyzer_trial import ManipulatorRecording, write_dflow_log  # noqa: E402
from workflow.settings.config import check_config  # noqa: E402
from workflow.support.people import read_participants  # noqa: E402
from workflow.support.trial_sheet import read_trial_sheet  # noqa: E402
from workflow.support.yaml_file import read_settings  # noqa: E402

MUSCLES = {"TA": "EMG TA", "SOL": "EMG SOL"}
LOG = {"time": "TimeStamp", "angle": "MotorAngle", "trigger_time": "TriggerTime"}
BELT = {"time": "Timestamp (s)", "load": "Pitch Moment (Nm)", "velocity": "Belt Velocity (m/s)"}


@dataclass(frozen=True)
class Reader:
    """A public reader.

    ``make`` writes good files into a folder and returns their paths; ``check`` asserts what a successful read
    promises; ``text`` says whether the files are text.
    """

    make: Callable[[Path], list[Path]]
    read: Callable[[Path], object]
    check: Callable[[object], None]
    text: bool = False


def rng() -> np.random.Generator:
    """The source of the numbers in the good files."""
    return np.random.default_rng(20140612)


def finite(*values: object) -> bool:
    """Test for values that are all finite."""
    return all(np.isfinite(np.asarray(v, dtype=float)).all() for v in values)


def zipped(path: Path) -> Path:
    """A copy that is compressed with gzip."""
    copy = path.with_name(f"{path.name}.gz")
    copy.write_bytes(gzip.compress(path.read_bytes(), mtime=0))
    return copy


def real(*names: str) -> list[Path]:
    """Recordings made by others, where there are any."""
    return [path for path in (REAL_DATA / name for name in names) if path.is_file()]


# ---- C3D -----------------------------------------------------------------------------------------


def c3d_markers(folder: Path) -> list[Path]:
    """Eight markers, one of them hidden for a while."""
    positions = rng().standard_normal((20, len(MARKERS), 3))
    positions[3:7, 2] = np.nan
    path = folder / "markers.c3d"
    write_markers(path, MARKERS, positions, 250.0)
    return [path]


def check_markers(markers) -> None:
    """A rate, positions in whole, none of them infinite."""
    assert finite(markers.rate_hz) and markers.rate_hz > 0.0, f"rate {markers.rate_hz}"
    assert markers.positions.shape[1:] == (len(markers.labels), 3), f"shape {markers.positions.shape}"
    seen = np.isfinite(markers.positions)
    assert not np.isinf(markers.positions).any(), "infinite positions"
    assert (seen.all(axis=2) | ~seen.any(axis=2)).all(), "markers that are hidden in one coordinate only"


def c3d_recording(folder: Path) -> list[Path]:
    """Markers, a force plate, an electromyogram, as floating point and as measured by others."""
    from c3d_builders import plate_channels, plate_of, write_c3d

    plate, values = plate_of("right"), rng()
    channels = plate_channels(plate, values.standard_normal((40, 3)), values.standard_normal((40, 3)))
    channels |= {"EMG TA": (values.standard_normal(40), "mV")}
    markers = {name: values.standard_normal((10, 3)) for name in ("heel", "toe")}
    return [write_c3d(folder / "trial.c3d", 250.0, markers, channels, [plate]), *_real_c3d(folder)]


def _real_c3d(folder: Path) -> list[Path]:
    """The first frames of others' recordings, with the header and parameters that they wrote."""
    made = []
    for path in real("c3d/HC002D02.c3d", "c3d/Qualisys.c3d"):
        content = bytearray(path.read_bytes())
        first = int.from_bytes(content[6:8], "little")
        points, analog = (int.from_bytes(content[k : k + 2], "little") for k in (2, 4))
        size = 4 if content[15] & 0x80 else 2
        start = 512 * (int.from_bytes(content[16:18], "little") - 1)
        content[8:10] = (first + 9).to_bytes(2, "little")
        short = folder / f"real-{path.name}"
        short.write_bytes(content[: start + 10 * size * (4 * points + analog)].ljust(start + 10240, b"\0"))
        try:
            read_c3d_recording(short)
        except InputError:
            continue
        made.append(short)
    return made


def check_recording(recording) -> None:
    """The same of markers, plates and channels."""
    if recording.markers is not None:
        check_markers(recording.markers)
    for plate in recording.plates:
        assert finite(plate.rate_hz) and plate.rate_hz > 0.0, f"rate {plate.rate_hz}"
        assert plate.force.shape == plate.moment.shape == (len(plate.force), 3), "shapes of plates"
        assert plate.corners is None or (plate.corners.shape == (4, 3) and finite(plate.corners)), "corners"
        assert not np.isinf(plate.force).any() and not np.isinf(plate.moment).any(), "infinite loads"
    for label, channel in recording.channels.items():
        assert channel.values.ndim == 1 and channel.values.dtype.kind == "f", f"channel {label!r}"
        assert not np.isinf(channel.values).any(), f"infinite samples of {label!r}"
        assert finite(channel.rate_hz) and channel.rate_hz > 0.0, f"rate of {label!r}"


# ---- MATLAB, calibration, EDF --------------------------------------------------------------------


def mat_log(folder: Path) -> list[Path]:
    """A log without compression, and compressed as the laboratory writes it."""
    plain, packed = folder / "log.mat", folder / "packed.mat"
    write_treadmill_log(packed, 1000.0, rng().standard_normal((60, 14)), *rng().standard_normal((3, 60)))
    content = {k: v for k, v in scipy.io.loadmat(packed).items() if not k.startswith("__")}
    scipy.io.savemat(plain, content)
    return [plain, packed]


def check_log(log) -> None:
    """Lines of one length."""
    assert finite(log.rate_hz) and log.rate_hz > 0.0, f"rate {log.rate_hz}"
    lines = (log.belt_velocity, log.command, log.trigger)
    assert log.voltages.shape == (log.trigger.size, len(log.channels)), "shape of the voltages"
    assert all(line.shape == log.trigger.shape and line.dtype.kind == "f" for line in lines), "lines"


def mat73_log(folder: Path) -> list[Path]:
    """The same log as MATLAB 7.3."""
    from mat73_builders import write_mat73

    path, values = folder / "log73.mat", rng()
    arrays = {"transducers_V": values.standard_normal((60, 14))}
    for name in ("belt_velocity_m_per_s", "command_m_per_s", "trigger_V"):
        arrays[name] = values.standard_normal((60, 1))
    write_mat73(path, {"sample_rate_hz": 1000.0, "channel_names": list(CHANNELS), **arrays})
    return [path]


def calibration(folder: Path) -> list[Path]:
    """A calibration matrix."""
    path = folder / "calibration.csv"
    write_calibration(path, 1000.0 * rng().standard_normal((12, 14)))
    return [path]


def check_calibration(matrix) -> None:
    """Twelve rows of numbers."""
    assert finite(matrix.matrix), "numbers of the matrix"
    assert matrix.matrix.shape == (len(matrix.components), len(matrix.channels)), "shape of the matrix"
    assert len(matrix.components) >= 12, "components"


def edf(folder: Path) -> list[Path]:
    """Two seconds of two muscles and a trigger, as EDF+."""
    path = folder / "emg.edf"
    signals = np.clip(100.0 * rng().standard_normal((200, 2)), -3000.0, 3000.0)
    trigger = np.repeat([0.0, 5.0], 100)
    write_emg(path, tuple(MUSCLES.values()), signals, trigger, 100.0, 3276.8)
    return [path]


def bdf(folder: Path) -> list[Path]:
    """The same as BDF."""
    from edfio import Bdf, BdfSignal

    path, values = folder / "emg.bdf", np.clip(100.0 * rng().standard_normal((2, 200)), -3000.0, 3000.0)
    channels = [
        BdfSignal(x, 100.0, label=label, physical_dimension="uV", physical_range=(-3276.8, 3276.8))
        for x, label in zip(values, MUSCLES.values(), strict=True)
    ]
    trigger = np.repeat([0.0, 5.0], 100)
    line = BdfSignal(trigger, 100.0, label="Trigger", physical_dimension="V", physical_range=(-5.0, 5.0))
    Bdf([*channels, line], data_record_duration=1.0).write(path)
    return [path]


def delsys(folder: Path) -> list[Path]:
    """An export of Delsys, also with semicolons and decimal commas."""
    path, other = folder / "delsys.csv", folder / "decimal.csv"
    names, rates, counts = [*MUSCLES.values(), "Trigger"], (2000.0, 2000.0, 1000.0), (60, 60, 30)
    values = [1e-4 * rng().standard_normal(60), 1e-4 * rng().standard_normal(60), np.repeat([0.0, 5.0], 15)]
    lines = [
        f"Label: {name} Sampling frequency: {rate:g} Number of points: {n} start: 0 Unit: V Domain Unit: s"
        for name, rate, n in zip(names, rates, counts, strict=True)
    ]
    lines.append(",".join(f'X[s],"{name}"' for name in names))
    for k in range(60):
        cells = zip(rates, counts, values, strict=True)
        lines.append(",".join(f"{k / rate:.7f},{x[k]:.9f}" if k < n else "," for rate, n, x in cells))
    path.write_text("\n".join(lines) + "\n")
    lines[3:] = [line.replace(",", ";").replace(".", ",").replace('"', "") for line in lines[3:]]
    other.write_text("\n".join(lines) + "\n")
    return [path, other, zipped(path)]


def check_emg(emg) -> None:
    """Numbers only."""
    assert finite(emg.rate_hz) and emg.rate_hz > 0.0, f"rate {emg.rate_hz}"
    assert emg.signals.shape == (emg.trigger.size, len(emg.muscles)), "shape of the signals"
    assert finite(emg.signals, emg.trigger, emg.limits), "numbers of signals, trigger or limits"


# ---- text ----------------------------------------------------------------------------------------


def text_table(folder: Path) -> list[Path]:
    """A log of the manipulator, also compressed."""
    path = folder / "log.txt"
    time = 812.5 + np.arange(60) / 163.0
    angle = rng().standard_normal(60)
    write_dflow_log(path, ManipulatorRecording(time, angle, 812.6, np.zeros(9), 2048.0, motion=None))
    return [path, zipped(path)]


def belt_table(folder: Path) -> list[Path]:
    """A table of a treadmill."""
    path = folder / "belt.txt"
    columns = np.column_stack([np.arange(80) / 100.0, rng().standard_normal((80, 2))])
    np.savetxt(path, columns, "%.6f", "\t", header="\t".join(BELT.values()), comments="")
    return [path]


def check_table(columns: dict) -> None:
    """Columns of one length."""
    assert len({values.shape for values in columns.values()}) == 1, "lengths of the columns"
    assert all(values.ndim == 1 and values.size and values.dtype == float for values in columns.values())


def dflow(folder: Path) -> list[Path]:
    """D-Flow's mocap file, also compressed, and its record file."""
    from dflow_builders import write_mocap, write_record

    markers = {name: rng().standard_normal((30, 3)) for name in ("LHEE", "RHEE")}
    mocap = write_mocap(folder / "mocap.txt", 100.0, markers, {1: rng().standard_normal((30, 6))})
    speeds = {"LeftBelt.ActualSpeed": rng().standard_normal(40)}
    record = write_record(folder / "record.txt", 208.0 + np.arange(40) / 300.0, speeds)
    return [mocap, zipped(mocap), record]


def dflow_mocap(folder: Path) -> list[Path]:
    """D-Flow's mocap file alone."""
    return dflow(folder)[:-1]


def read_dflow_file(path: Path):
    """A file of D-Flow with its markers and plates."""
    table = read_dflow(path)
    return table, marker_columns(table), plate_columns(table)


def check_dflow(parts) -> None:
    """Columns, markers and plates of one length."""
    table, markers, plates = parts
    columns = (table.time, *table.columns.values())
    assert all(x.shape == table.time.shape and x.dtype == float for x in columns), "columns"
    assert table.frames is None or table.frames.shape == table.time.shape, "frames"
    assert all(x.shape == (table.time.size, 3) for x in markers.values()), "markers"
    assert all(x.shape == (table.time.size, 3) for pair in plates.values() for x in pair), "plates"


def text_recording(folder: Path) -> list[Path]:
    """A whole trial with two muscles as a plain table, also compressed."""
    path = folder / "trial.csv"
    names = ["time (s)", "belt_m_per_s", "EMG TA [uV]", "EMG SOL [uV]", "Trigger"]
    names += [f"{kind}{axis}_{belt}" for belt in ("left", "right") for kind in "FM" for axis in "xyz"]
    names += [f"HEEL_{axis} (mm)" for axis in "xyz"]
    values = rng().standard_normal((40, len(names)))
    values[:, 0] = np.arange(40) / 100.0
    np.savetxt(path, values, "%.6f", ";", header=";".join(names), comments="")
    return [path, zipped(path)]


def trc(folder: Path) -> list[Path]:
    """Two markers."""
    path, names = folder / "markers.trc", ("HEEL", "TOE")
    settings = {"DataRate": "100.00", "CameraRate": "100.00", "NumFrames": "20", "NumMarkers": "2"}
    settings |= {"Units": "mm", "OrigDataRate": "100.00", "OrigDataStartFrame": "1", "OrigNumFrames": "20"}
    rows = ["PathFileType\t4\t(X/Y/Z)\ttrial.trc", "\t".join(settings), "\t".join(settings.values())]
    rows += ["Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t", "\t\tX1\tY1\tZ1\tX2\tY2\tZ2", ""]
    for k, row in enumerate(1000.0 * rng().standard_normal((20, 6))):
        rows.append("\t".join([str(k + 1), f"{k / 100.0:.2f}", *(f"{x:.3f}" for x in row)]))
    path.write_text("\n".join(rows) + "\n")
    return [path, zipped(path)]


def trial_sheet(folder: Path) -> list[Path]:
    """The sheet of the study, and one with recorded trials."""
    made = []
    for name in ("config/trials.tsv", "config/human-ankle/trials.tsv", "config/rmill-treadmill/trials.tsv"):
        path = folder / name.replace("/", "-")
        path.write_bytes((ROOT / name).read_bytes())
        made.append(path)
    return made


def check_sheet(trials: dict) -> None:
    """Trials with positive numbers."""
    assert trials, "no trial"
    for row in trials.values():
        numbers = (row.duration_s, row.amplitude, row.interval_s, row.longest_interval_s)
        assert all(x is None or (finite(x) and x > 0.0) for x in numbers), f"numbers of {row.condition}"


def participants(folder: Path) -> list[Path]:
    """A table of two people."""
    path = folder / "participants.tsv"
    path.write_text("participant\tmass_kg\tstature_m\nA\t70.5\t1.81\nB\t62.25\t-\n")
    return [path]


def check_participants(people: dict) -> None:
    """Positive numbers."""
    assert all(finite(x) and x > 0.0 for person in people.values() for x in person.values()), "numbers"


def configuration(folder: Path) -> list[Path]:
    """The configuration of the study."""
    path = folder / "config.yaml"
    path.write_bytes((ROOT / "config/config.yaml").read_bytes())
    return [path]


def read_configuration(path: Path) -> dict:
    """A configuration that the study would accept."""
    content = read_settings(path)
    check_config(content, str(path))
    return content


def check_configuration(content: dict) -> None:
    """Sections."""
    assert isinstance(content, dict) and content, "sections"


# ---- files of the study --------------------------------------------------------------------------


def trial(folder: Path) -> list[Path]:
    """A trial with markers."""
    path, time = folder / "trial.h5", np.arange(40) / 250.0
    signals = {
        "belt_velocity": Signal(rng().standard_normal(40), "m/s", ("time",), "belt", ("resampled",)),
        "marker_position": Signal(
            rng().standard_normal((40, 2, 3)).astype(np.float32), "m", ("time", "marker", "axis"), "markers"
        ),
    }
    axes = {"time": time, "marker": np.array(["ankle", "leg1"]), "axis": np.array(["x", "y", "z"])}
    made = Trial(250.0, axes, signals, {"trigger_sample": 12})
    write_trial(path, made, "dummy", "sine-0.5", {"self": __file__}, {"lowpass_cutoff_hz": 20.0})
    return [path]


def check_trial(content) -> None:
    """A clock, and signals of numbers."""
    assert finite(content.rate_hz) and content.rate_hz > 0.0, f"rate {content.rate_hz}"
    assert finite(content.time) and content.time.ndim == 1 and content.time.size, "axis of time"
    for name, signal in content.signals.items():
        assert signal.values.dtype.kind in "fiub", f"numbers of {name!r}"
        assert len(signal.axes) == signal.values.ndim, f"axes of {name!r}"
        assert all(isinstance(word, str) for word in (signal.unit, signal.meaning, *signal.axes)), name


def result(folder: Path) -> list[Path]:
    """Arrays in groups, and facts."""
    path = folder / "result.h5"
    arrays = {"fits/theta": rng().standard_normal(50), "fits/tau": rng().standard_normal((5, 3))}
    arrays["windows"] = np.arange(12).reshape(6, 2)
    units = dict.fromkeys(arrays, "rad")
    write_result(path, Result(arrays, units, {"I_kgm2": 0.027, "names": ["a", "b"]}))
    return [path]


def check_result(content) -> None:
    """Arrays with units."""
    assert isinstance(content.facts, dict), "facts"
    assert set(content.arrays) == set(content.units), "units"
    assert all(isinstance(unit, str) for unit in content.units.values()), "units"
    assert all(array.dtype.kind in "fiubUSO" for array in content.arrays.values()), "arrays"


def estimates(folder: Path) -> list[Path]:
    """Rows of three quantities."""
    path = folder / "estimates.csv"
    names = ("dummy", "sine-0.3", "leg", "windowed-least-squares")
    rows = [
        Estimate(*names, quantity, unit, *rng().standard_normal(3), n_perturbations=14)
        for quantity, unit in (("I", "Nms2/rad"), ("B", "Nms/rad"), ("K", "Nm/rad"), ("VAF_trial", "%"))
    ]
    ESTIMATES.write(path, rows)
    return [path]


def check_estimates(rows) -> None:
    """Rows with values."""
    assert all(isinstance(row.value, float) for row in rows), "values"
    assert all(row.n_perturbations is None or row.n_perturbations >= 0 for row in rows), "perturbations"


def models(folder: Path) -> list[Path]:
    """Two models of a treadmill."""
    path = folder / "models.json"
    template = MeanSubtraction({"sine-0.5": rng().standard_normal(40)}, 250.0)
    lowpass = Lowpass(20.0, 2, True)
    frame = LoadedFrame(rng().standard_normal(3), rng().standard_normal(4), 0.01, 0.02, 0.1, 0.5, 250.0)
    save_models(
        path,
        [
            FittedModel("mean-subtraction", template, "N", lowpass, ("empty/sine-0.5",)),
            FittedModel("loaded-frame", frame, "N", None, ("weight/sine-0.5",)),
        ],
    )
    return [path]


def check_models(fitted: dict) -> None:
    """Models of numbers."""
    assert fitted, "no model"
    for name, model in fitted.items():
        assert isinstance(name, str) and isinstance(model, FittedModel), "kinds"
        assert finite(model.model.rate_hz) and model.model.rate_hz > 0.0, f"rate of {name!r}"
        for field in vars(model.model).values():
            if isinstance(field, np.ndarray | float):
                assert finite(field), f"numbers of {name!r}"


# ---- files of commands ------------------------------------------------------------------------------

COMPONENTS = tuple(f"{kind}{axis}" for kind in "FM" for axis in "xyz")
BELT_HZ, BELT_ROWS = 100.0, 260


@cache
def belt_models() -> tuple[tempfile.TemporaryDirectory, Path]:
    """A folder that lasts as long as the process, and the models in it for the loads of `belt_recordings`."""
    folder = tempfile.TemporaryDirectory(prefix="tepsipe-models-")
    path, lowpass = Path(folder.name) / "models.json", Lowpass(6.0, 2, False)
    kept = {
        "calibrated": {"velocity": [-9.0, 9.0], "acceleration": [-900.0, 900.0], "load": [-9.0, 9.0]},
        "errors": ((0.5, 0.1), (0.2, 0.1)),
        "held_out": 0.9,
        "recommended": True,
    }
    response = ImpulseResponse(np.array([0.5, 0.3, 0.1]), 0, BELT_HZ)
    loads = {f"plate 1 {name}": "Nm" if name[0] == "M" else "N" for name in COMPONENTS} | {"Mx": "Nm"}
    save_models(
        path,
        [
            FittedModel("fir-causal", response, unit, lowpass, ("empty.c3d",), load=load, **kept)
            for load, unit in loads.items()
        ],
    )
    return folder, path


def belt_recordings(folder: Path) -> list[Path]:
    """The belt under a load: a C3D, a mocap file of D-Flow, a table of a plate, and one of a single load."""
    from c3d_builders import plate_channels, plate_of, write_c3d
    from dflow_builders import write_mocap

    belt_models()
    values, time = rng(), np.arange(BELT_ROWS) / BELT_HZ
    velocity, load = np.sin(9.0 * time), 0.5 * values.standard_normal((BELT_ROWS, 6)) + [0, 0, 700, 60, 9, 0]
    marker = np.cumsum(velocity)[:, None] / BELT_HZ * [0.0, 1.0, 0.0]
    plate = plate_of("right")
    channels = plate_channels(plate, load[:, :3], load[:, 3:]) | {"speed": (velocity, "m/s")}
    c3d = write_c3d(folder / "belt.c3d", BELT_HZ, {"BELT": marker}, channels, [plate], BELT_HZ)
    mocap = write_mocap(folder / "belt.txt", BELT_HZ, {"BELT": marker[:, [0, 2, 1]]}, {1: load})
    tables = (("plate.csv", COMPONENTS, load), ("one.csv", ("Mx",), load[:, 3:4]))
    made = [c3d, mocap]
    for name, names, loads in tables:
        path, columns = folder / name, np.column_stack([time, loads, velocity])
        np.savetxt(path, columns, "%.6f", ";", header=";".join(["time", *names, "speed"]), comments="")
        made.append(path)
    return made


def read_compensated(path: Path) -> tuple[Compensation, object]:
    """A recording without the load of the belt, and its copy, which is read again."""
    copy = path.with_name(f"copy-{path.name}")
    source = BeltVelocity(None, ("BELT",)) if path.name == "belt.txt" else BeltVelocity("speed")
    channels = BeltChannels(source)
    done = compensate(path, belt_models()[1], copy, channels, model=None, strict=False)
    return done, read_belt_file(copy, channels)


def check_compensated(parts) -> None:
    """Loads of one length, and a copy with as many of them."""
    done, copy = parts
    assert done.summary() and done.loads, "loads"
    for name, load in done.loads.items():
        assert load.before.shape == load.removed.shape == copy.loads[name].values.shape, f"shape of {name!r}"
        assert finite(load.before, load.removed), f"numbers of {name!r}"


def person_on_plates(folder: Path) -> list[Path]:
    """A person who stands on two plates, and others' recordings."""
    from c3d_builders import plate_channels, plate_of, write_c3d

    values, plates, markers, channels = rng(), [plate_of("left"), plate_of("right")], {}, {}
    for side, plate in zip("LR", plates, strict=True):
        force = values.standard_normal((300, 3)) + np.array([0.0, 0.0, 350.0])
        place = plate.corners_m.mean(axis=0)
        channels |= plate_channels(
            plate,
            force,
            np.cross(place + np.array([0.02, 0.03, 0.0]), force) + 0.1 * values.standard_normal((300, 3)),
        )
        for name, along in (("HEE", -0.1), ("TOE", 0.12), ("ANK", 0.0)):
            shake = 1e-4 * values.standard_normal((60, 3))
            markers[f"{side}{name}"] = place + np.array([0.02, along, 0.04]) + shake
    return [write_c3d(folder / "stand.c3d", 100.0, markers, channels, plates, 500.0), *_real_c3d(folder)]


def check_findings(found: tuple) -> None:
    """Known faults with a place and one line of text."""
    for finding in found:
        assert isinstance(finding, Finding) and finding.fault in FINDINGS, "names"
        assert finding.place and finding.text and "\n" not in finding.text, "words"
        assert "nan" not in finding.text.split(), "numbers"


TRUTH = {
    "passive-01": TrueProblem("passive", "nominal", {"I": 0.01, "B": 0.1, "K": 10.0}),
    "passive-02": TrueProblem("passive", FAULTS[0], {"I": 0.02, "B": 0.2, "K": 8.0}),
    "standing-01": TrueProblem("standing", "nominal", {"B": 10.0, "K": 400.0}),
}


def answers(folder: Path) -> list[Path]:
    """Answers to three problems: with intervals, without, and withdrawn."""
    path = folder / "answers.csv"
    rows = [
        AnswerRow(
            name,
            quantity,
            x,
            None if quantity == "B" else 0.9 * x,
            None if quantity == "B" else 1.1 * x,
            k > 1,
        )
        for k, (name, hidden) in enumerate(TRUTH.items())
        for quantity, x in hidden.values.items()
    ]
    ANSWERS.write(path, rows)
    return [path]


def truths(folder: Path) -> list[Path]:
    """The hidden values of these problems."""
    path = folder / "truth.json"
    hidden = {
        name: {"kind": x.kind, "fault": x.fault if x.fault in FAULTS else "", "truth": x.values}
        for name, x in TRUTH.items()
    }
    path.write_text(json.dumps({"seed": "12345678", "problems": hidden}, indent=1))
    return [path]


def read_scores(path: Path) -> list:
    """Scores of a file of answers."""
    return scores_of("method", read_answers(path, TRUTH), TRUTH)


def check_truth(truth: dict[str, TrueProblem]) -> None:
    """Positive numbers, by which errors can be divided."""
    assert all(finite(x) and x > 0.0 for hidden in truth.values() for x in hidden.values.values()), "numbers"


def check_scores(rows: list) -> None:
    """A table of numbers."""
    assert table_of(rows), "table"
    numbers = [x for row in rows for x in vars(row).values() if isinstance(x, float)]
    assert finite(numbers), "scores"


# ---- all readers ---------------------------------------------------------------------------------

# module of a format -> what makes its good files
MAKERS = {
    "c3d": (c3d_markers, c3d_recording),
    "edf": (edf, bdf),
    "mat_file": (mat_log, mat73_log),
    "stored": (trial, result, models),
    "trc": (trc,),
    "dflow": (dflow_mocap,),
    "emg_table": (delsys,),
    "any_table": (text_recording,),
}
CHECKS = {"recording": check_recording, "markers": check_markers, "emg": check_emg}


def makers_of(module: str) -> tuple[Callable[[Path], list[Path]], ...]:
    """Makers of good files of a format; those of a new one are made by ``good_files`` of its test."""
    return MAKERS.get(module) or (import_module(f"tests.io.test_{module}").good_files,)


def readers_of_formats() -> dict[str, Reader]:
    """Every reader that a format declares."""
    readers = {}
    for known in formats():
        module = known.contents.__module__.rpartition(".")[2]
        for what, check in CHECKS.items():
            read = getattr(known, f"read_{what}")
            if read is not None:

                def good(folder: Path, module: str = module) -> list[Path]:
                    return [path for make in makers_of(module) for path in make(folder)]

                def read_good(path: Path, read: Callable = read, what: str = what) -> object:
                    return read(path, MUSCLES, "Trigger") if what == "emg" else read(path)

                readers[f"{module}-{what}"] = Reader(good, read_good, check, text=known.text)
    return readers


def any_file(folder: Path) -> list[Path]:
    """Good files of every format, and further tables."""
    modules = dict.fromkeys(known.contents.__module__.rpartition(".")[2] for known in formats())
    makers = [make for module in modules for make in makers_of(module)]
    return [path for make in (*makers, text_table, belt_table) for path in make(folder)]


def check_contents(contents) -> None:
    """A summary."""
    assert contents.summary(), "summary"


READERS = {
    **readers_of_formats(),
    "mat-log": Reader(mat_log, read_treadmill_log, check_log),
    "mat-7.3-log": Reader(mat73_log, read_treadmill_log, check_log),
    "calibration": Reader(calibration, read_calibration_matrix, check_calibration, text=True),
    "text-table": Reader(text_table, lambda path: read_text_table(path, LOG, "\t"), check_table, text=True),
    "belt-table": Reader(belt_table, lambda path: read_text_table(path, BELT, "\t"), check_table, text=True),
    "dflow": Reader(dflow, read_dflow_file, check_dflow, text=True),
    "trial-sheet": Reader(
        trial_sheet, lambda path: read_trial_sheet(path, "recordings"), check_sheet, text=True
    ),
    "participants": Reader(participants, read_participants, check_participants, text=True),
    "configuration": Reader(configuration, read_configuration, check_configuration, text=True),
    "trial": Reader(trial, read_trial, check_trial),
    "result": Reader(result, read_result, check_result),
    "estimates": Reader(estimates, ESTIMATES.read, check_estimates, text=True),
    "treadmill-models": Reader(models, load_treadmill_models, check_models, text=True),
    "info": Reader(any_file, contents_of, check_contents),
    "compensate": Reader(belt_recordings, read_compensated, check_compensated),
    "check-c3d": Reader(person_on_plates, examine_plates, check_findings),
    "benchmark-answers": Reader(answers, read_scores, check_scores, text=True),
    "benchmark-truth": Reader(truths, read_truth, check_truth, text=True),
}
