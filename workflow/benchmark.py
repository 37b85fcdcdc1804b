"""Sealed problems of a benchmark: ``python -m workflow.benchmark FOLDER ...``, as `tepsipe benchmark make`.

The only module that calls the laboratory and the analysis together, because it stands above both: it draws
laboratories as the coverage study does, has the laboratory make their files, and takes the truth from the
hidden motion as the comparison with the truth does. Arrays are the same recordings on one clock, with the
angle and the torque that sensors in the joint would show.

**Secrets.** Whoever has the seed has the truth, because the code is public. Every generator of a problem is
seeded by its own HMAC-SHA256 of its purpose, with the seed as the key. The constants (the truth), the fault,
and each source of noise have purposes of their own. A published signal could at most reveal the state of the
generator of its noise; this says nothing about the seed, nor about the generator of the constants, as long as
the seed cannot be found by trying: a seed that is drawn here has 128 bits. The truth's file holds the seed
and a salt, and the folder its SHA-256: once both are public, anyone can make the folder again and compare.
"""

import argparse
import hashlib
import hmac
import json
import secrets
import sys
import tempfile
from collections.abc import Callable
from itertools import count
from pathlib import Path
from random import Random
from typing import NamedTuple

import numpy as np
import scipy

from tepsipe import __version__
from tepsipe.errors import InputError, quoted
from tepsipe.experiments.benchmark.problems import (
    ANSWERS,
    ARRAYS,
    COLUMNS,
    FACTS,
    INSTRUMENTS,
    NAMED,
    PROBLEMS,
    QUANTITIES,
    UNITS,
    WINDOW_ROWS,
    WINDOWS,
    AnswerRow,
    Named,
    WindowRow,
)
from tepsipe.new_study.start import FAR
from tepsipe.reporting.benchmark import FAULTS
from tepsipe.reporting.recovery import linear_truth, linear_truth_standing, read_true_motion
from tepsipe.signals.perturbations import find_perturbations
from tepsipe.virtual_lab.drawn_laboratories import draw_laboratory
from tepsipe.virtual_lab.dummy import MARKERS
from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
from tepsipe.virtual_lab.human_joint import RATE_HZ as MANIPULATOR_HZ
from tepsipe.virtual_lab.human_joint import HumanJoint, move_human_joint
from tepsipe.virtual_lab.standing_trial import make_standing_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol, write_treadmill_log
from workflow.support.laboratories import changed_constants
from workflow.support.places import ROOT
from workflow.support.yaml_file import read_constants, read_settings

# file of the folder with the hash of the truth, which is written last
COMMITMENT = "truth.sha256"
# a seed below this can be found by trying
LEAST_SECRET = 2**64
# probability that a problem is spoiled
SPOILED = 0.4
CAMERA_HZ = 250.0
REST_S, INTERVAL_S, LEG_S = 4.0, 4.0, 44.0
STANDING_S, STANDING_INTERVAL_S = 65.0, (4.0, 6.0)
# window and baseline of the truth of a standing person, from the onset (s)
STANDING_WINDOW_S, STANDING_BASELINE_S = 0.08, (-0.1, -0.02)
ANKLE_S = 60.0
TORQUE_SCALE = 0.01
TORQUE_NOISE_NM = {"passive": 0.005, "softening": 0.005, "ankle": 0.05, "standing": 0.3}
# noise of an angle from markers, per noise of a marker (rad/m)
ANGLE_PER_NOISE = 5.0
PERSON_FALLS = 20
TIMES = {
    "treadmill.capture.rate_hz": CAMERA_HZ,
    "treadmill.protocol.rest_before_s": REST_S,
    "treadmill.protocol.rest_after_s": REST_S,
}

# what is drawn, and between which ends
DRAWN = read_settings(ROOT / "config/benchmark.yaml")
# known of a leg: its sources of uncertainty in the study that act on these recordings
KNOWN = (
    *("leg_mass_kg", "leg_com_m", "leg_inertia_kgm2", "joint_offset_m", "anterior_offset_m"),
    *("longitudinal_offset_m", "marker_scale", "levelled_rad", "leg_bending_rad_per_m_per_s2"),
)


class Secret:
    """Generators of a benchmark, each from its own keyed hash of the seed."""

    def __init__(self, seed: int) -> None:
        self._key = str(seed).encode()

    def number(self, *purpose: str) -> int:
        """A number of 256 bits."""
        return int.from_bytes(hmac.digest(self._key, "/".join(purpose).encode(), hashlib.sha256))

    def random(self, *purpose: str) -> Random:
        """Generator of single numbers."""
        return Random(self.number(*purpose))

    def samples(self, *purpose: str) -> np.random.Generator:
        """Generator of samples of noise."""
        return np.random.default_rng(self.number(*purpose))


class Fault(NamedTuple):
    """What spoils a recording, and how much; "" for nothing."""

    name: str = ""
    size: float = 0.0
    """Delay (s), cutoff (Hz), resonance (Hz) or noise of a marker (m)."""

    def size_of(self, name: str) -> float | None:
        """Size, if this is the named fault."""
        return self.size if name == self.name else None


class Made(NamedTuple):
    """A problem that was made."""

    signals: dict[str, np.ndarray]
    """By the keys of `COLUMNS`."""
    positions: np.ndarray | None
    """Positions y, z (m) of the markers, shape (n, markers, 2)."""
    truth: dict[str, float]
    """True values by quantity, in `UNITS`."""
    hidden: dict
    """Further facts of the truth's file."""
    windows_s: list[tuple[float, float]]
    """Windows of the recording to which the truth refers; none for the whole recording."""


def fault_of(secret: Secret, problem: str) -> Fault:
    """Fault of a problem; whether there is one does not depend on the other problems."""
    random = secret.random(problem, "fault")
    if random.random() >= SPOILED:
        return Fault()
    name = random.choice(FAULTS)
    return Fault(name, _between(random, *DRAWN["faults"][name]))


def _between(random: Random, low: float, high: float) -> float:
    return low * (high / low) ** random.random()


def laboratory_of(
    constants: dict, secret: Secret, problem: str, changes: dict, drawn: dict, fault: Fault
) -> dict:
    """Constants of one laboratory after drawing, seeded for the noise of its instruments.

    changes, drawn: path of a constant -> its value, and its distribution beside those of the file.
    """
    plate, fixed = fault.size_of("soft plate"), DRAWN["constants"] | TIMES
    changes = fixed | changes | {"treadmill.plate.force_delay_s": fault.size_of("late torque") or 0.0}
    changes |= {} if plate is None else {"treadmill.plate.resonance_hz": plate}
    noise = fault.size_of("camera noise")
    known = {path: how for path, how in constants["drawn"].items() if path not in fixed}
    chosen = {"constants": changes, "drawn": DRAWN["drawn"] | drawn}
    seed = secret.number(problem, "constants")
    own = draw_laboratory(changed_constants(constants | {"drawn": known}, chosen, seed, problem))
    if noise is not None:
        own["treadmill"]["capture"]["noise_m"] = noise
    own["seed"] = secret.number(problem, "instruments")
    return own


def make_leg(constants: dict, secret: Secret, problem: str, kind: str, fault: Fault, folder: Path) -> Made:
    """A leg on a joint, on a pulsed belt."""
    random = secret.random(problem, "protocol")
    law = "linear" if kind == "passive" else random.choice(("softening", "hysteresis"))
    truth = laboratory_of(constants, secret, problem, *DRAWN["legs"][law].values(), fault)
    amplitude = random.choice((0.2, 0.3, 0.4, 0.5))
    protocol = Protocol(random.choice(("sine", "minjerk")), amplitude, INTERVAL_S, LEG_S)
    names = {"log": "log.mat", "calibration": "calibration.csv", "markers": "markers.c3d"}
    files = {key: folder / name for key, name in names.items()}
    with tempfile.TemporaryDirectory() as hidden:
        motion = Path(hidden) / "motion.h5"
        make_dummy_trial(truth, problem, protocol, files | {"motion": motion})
        true = read_true_motion(motion)
    signals = _on_one_clock(true.time, true.angle, true.torque, files["log"], LEG_S)
    time = signals["time"]
    pulses = find_perturbations(time, signals["belt"])
    windows = [(time[pulse.start], time[pulse.stop - 1]) for pulse in pulses]
    signals = measured(secret, problem, kind, signals, fault, truth["treadmill"]["capture"]["noise_m"])
    _filter_log(files["log"], fault)
    linear = linear_truth(true, windows)
    return Made(signals, _positions(files["markers"]), linear, {"joint": law}, windows)


def make_standing(
    constants: dict, secret: Secret, problem: str, kind: str, fault: Fault, folder: Path
) -> Made:
    """A person who stands on a pulsed belt; one who would fall is drawn again."""
    random = secret.random(problem, "protocol")
    task = random.choice(tuple(DRAWN["tasks"]))
    amplitude = random.choice((0.3, 0.4, 0.5))
    protocol = Protocol(random.choice(("sine", "negative-sine")), amplitude, STANDING_INTERVAL_S, STANDING_S)
    names = {"log": "log.mat", "calibration": "calibration.csv", "markers": "markers.c3d", "emg": "emg.edf"}
    files = {key: folder / name for key, name in names.items()}
    with tempfile.TemporaryDirectory() as hidden:
        motion = Path(hidden) / "motion.h5"
        for attempt in range(PERSON_FALLS):
            own = problem if not attempt else f"{problem}+{attempt}"
            truth = laboratory_of(constants, secret, own, {}, DRAWN["tasks"][task], fault)
            try:
                make_standing_trial(truth, own, task, protocol, files | {"motion": motion})
                break
            except FloatingPointError:
                if attempt == PERSON_FALLS - 1:
                    raise
        true = read_true_motion(motion)
    signals = _on_one_clock(true.time, true.angle, true.torque + true.active, files["log"], STANDING_S)
    onsets = np.array(
        [signals["time"][p.start] for p in find_perturbations(signals["time"], signals["belt"])]
    )
    linear = linear_truth_standing([true], [onsets], STANDING_WINDOW_S, False, STANDING_BASELINE_S)
    signals = measured(secret, problem, kind, signals, fault, truth["treadmill"]["capture"]["noise_m"])
    _filter_log(files["log"], fault)
    windows = [(onset, onset + STANDING_WINDOW_S) for onset in onsets]
    return Made(signals, None, linear, {"task": task}, windows)


def make_ankle(constants: dict, secret: Secret, problem: str, kind: str, fault: Fault, folder: Path) -> Made:
    """A human ankle with a reflex in a position-controlled manipulator, which writes the table itself."""
    random = secret.random(problem, "constants")
    chosen = {name: _between(random, *ends) for name, ends in DRAWN["ankle"].items()}
    stiffness = chosen["stiffness_Nm_per_rad"]
    joint = HumanJoint(
        **chosen,
        short_range=random.choice((None, "dahl")),
        short_range_Nm_per_rad=stiffness * _between(random, 0.2, 0.5),
        yield_rad=_between(random, 0.003, 0.008),
    )
    record = move_human_joint(joint, ANKLE_S, secret.samples(problem, "movement"))
    noise = fault.size_of("camera noise")
    signals = {"time": record.time, "angle": record.angle, "torque": record.torque}
    signals = measured(secret, problem, kind, signals, fault, 5e-6 if noise is None else noise)
    return Made(
        signals,
        None,
        dict(zip(UNITS, record.linear.tolist(), strict=True)),
        {"short_range": joint.short_range},
        [],
    )


MAKERS: dict[str, Callable] = {
    "passive": make_leg,
    "softening": make_leg,
    "ankle": make_ankle,
    "standing": make_standing,
}


def measured(secret: Secret, problem: str, kind: str, exact: dict, fault: Fault, noise_m: float) -> dict:
    """Signals as the sensors of the joint show them: faults of the torque, its scale, and noise of both."""
    time, n = exact["time"], exact["time"].size
    torque = spoiled(exact["torque"], (n - 1) / (time[-1] - time[0]), fault)
    torque = torque * (1.0 + TORQUE_SCALE * secret.random(problem, "scale").gauss(0.0, 1.0))
    of_noise = secret.samples(problem, "sensors")
    torque = torque + TORQUE_NOISE_NM[kind] * of_noise.standard_normal(n)
    angle = exact["angle"] + ANGLE_PER_NOISE * noise_m * of_noise.standard_normal(n)
    return exact | {"angle": angle, "torque": torque}


def spoiled(torque: np.ndarray, rate_hz: float, fault: Fault) -> np.ndarray:
    """Torque (N·m) that is late, or passes a filter forwards only, or a frame on soft legs."""
    if (delay := fault.size_of("late torque")) is not None:
        sample = np.arange(torque.size)
        return np.interp(sample - delay * rate_hz, sample, torque)
    if (cutoff := fault.size_of("filtered torque")) is not None:
        return _causal(scipy.signal.butter(2, cutoff, fs=rate_hz), torque)
    if (resonance := fault.size_of("soft plate")) is not None:
        w = 2.0 * np.pi * resonance
        frame = scipy.signal.cont2discrete(([w**2], [1.0, 0.08 * w, w**2]), 1.0 / rate_hz, method="bilinear")
        return _causal((np.ravel(frame[0]), frame[1]), torque)
    return torque


def _causal(transfer: tuple[np.ndarray, np.ndarray], x: np.ndarray) -> np.ndarray:
    """Filtered signal that has long been at its first value (its unit)."""
    return scipy.signal.lfilter(*transfer, x, zi=scipy.signal.lfilter_zi(*transfer) * x[0])[0]


def _on_one_clock(instants, angle, torque, log: Path, duration_s: float) -> dict[str, np.ndarray]:
    """Exact angle and torque, and the logged belt velocity, at the frames of the cameras."""
    time = np.arange(round(duration_s * CAMERA_HZ)) / CAMERA_HZ
    content = scipy.io.loadmat(log)
    rate_hz, velocity = (
        content["sample_rate_hz"].item(),
        content["belt_velocity_m_per_s"].ravel().astype(float),
    )
    started = int(np.flatnonzero(content["trigger_V"].ravel() > 2.5)[0])
    smooth = np.convolve(velocity, np.full(5, 0.2), "same")
    belt = np.interp(time, (np.arange(velocity.size) - started) / rate_hz, smooth)
    exact = (scipy.interpolate.CubicSpline(instants, x)(time) for x in (angle, torque))
    return dict(zip(COLUMNS, (time, *exact, belt), strict=True))


def _positions(markers: Path) -> np.ndarray:
    """Positions y, z (m) from the cameras' file, shape (n, markers, 2)."""
    import ezc3d

    points = ezc3d.c3d(str(markers))["data"]["points"]
    return 0.001 * points[1:3].transpose(2, 1, 0)


def _filter_log(log: Path, fault: Fault) -> None:
    """Filter the transducers of a log as its torque was."""
    if fault.size_of("filtered torque") is None:
        return
    content = scipy.io.loadmat(log)
    rate_hz = content["sample_rate_hz"].item()
    volts = [spoiled(x.astype(float), rate_hz, fault) for x in content["transducers_V"].T]
    others = (content[name].ravel() for name in ("belt_velocity_m_per_s", "command_m_per_s", "trigger_V"))
    write_treadmill_log(log, rate_hz, np.column_stack(volts), *others)


def facts(constants: dict) -> dict[str, dict]:
    """What an analysis may know of each kind (units in the keys)."""
    subject, layout = constants["dummy"]["subject"], constants["dummy"]["markers"]
    sources = read_settings(ROOT / "config/config.yaml")["uncertainty"]["dummy"]
    scale = {"torque_scale": TORQUE_SCALE}
    leg = {
        "rate_hz": CAMERA_HZ,
        "uncertainty": scale,
        "labels": list(MARKERS),
        "belt_fixed": list(MARKERS[:4]),
        "leg": {name: subject[f"leg_{name}"] for name in ("mass_kg", "com_m", "inertia_kgm2")},
        "layout_m": dict(zip(MARKERS[3:], [layout["ankle_m"], *layout["leg_m"]], strict=True)),
        "leg_uncertainty": {name: sources[name]["standard_uncertainty"] for name in KNOWN},
    }
    plain = {"uncertainty": scale, "labels": []}
    return {
        "passive": leg,
        "softening": leg,
        "ankle": {"rate_hz": MANIPULATOR_HZ, **plain},
        "standing": {"rate_hz": CAMERA_HZ, **plain},
    }


def write_arrays(path: Path, made: Made, labels: list[str]) -> None:
    """Write the arrays of a problem as CSV, each with more digits than its noise has."""
    columns = {COLUMNS[key]: signal for key, signal in made.signals.items()}
    formats = ["%.3f", "%.7f", "%.4f", "%.4f"][: len(columns)]
    if made.positions is not None:
        flat = made.positions.reshape(len(made.positions), -1)
        names = [f"{label}_{axis}_m" for label in labels for axis in "yz"]
        columns |= dict(zip(names, flat.T, strict=True))
        formats += ["%.6f"] * len(names)
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, formats, ",", header=",".join(columns), comments="")


README = """\
# Problems of a benchmark of joint impedance

Made by tepsipe {version}. Estimate the impedance of every joint in `{problems}`, and write one row per
quantity as in `answers-template.csv`. The page "Benchmark" of tepsipe's documentation explains every column.

- `{arrays}/<problem>.csv`: the recording on one clock, with units in the names of the columns. The torque
  resists a positive angle. `{facts}` states what you may assume, with standard uncertainties.
- `{instruments}/<problem>/`: the same recording as the instruments wrote it: `log.mat` (voltages of the
  force plate, with `calibration.csv`), `markers.c3d`, `emg.edf`. The table of an ankle in a manipulator is
  its instrument's own file.
- `{windows}`: the times to which the true values refer. An ankle has none, because its values refer to the
  whole recording.
- `value`, `low`, `high`: estimate and ends of its 95 % interval, {units}.
  Leave low and high empty if your method has no intervals. Leave out rows that you cannot answer.
- `flagged`: true if you would not rely on this recording, otherwise false.

`truth.sha256` is the SHA-256 of the file with the true values, which the organiser publishes later.
"""


def make_benchmark(
    folder: Path,
    truth: Path,
    seed: int,
    per_kind: int,
    constants: dict,
    tell: Callable[[str], None] = lambda _: None,
) -> str:
    """Write the problems into a folder and the truth into a file; return the SHA-256 of the truth.

    tell: is given the name of the problem at work.
    """
    secret, known = Secret(seed), facts(constants)
    # accidents only: answers are not scored against the truth of another round
    round_ = f"{secret.number('round'):064x}"[:4]
    (folder / ARRAYS).mkdir(parents=True)
    named, windows, hidden = [], [], {}
    for kind in QUANTITIES:
        for number in range(1, per_kind + 1):
            problem = f"{kind}-{number:02d}"
            name = f"{problem}-{round_}"
            tell(name)
            instruments = folder / INSTRUMENTS / name
            if kind != "ankle":
                instruments.mkdir(parents=True)
            fault = fault_of(secret, problem)
            made = MAKERS[kind](constants, secret, problem, kind, fault, instruments)
            write_arrays(folder / ARRAYS / f"{name}.csv", made, known[kind]["labels"])
            named.append(Named(name, kind))
            windows += [WindowRow(name, round(start, 3), round(end, 3)) for start, end in made.windows_s]
            # as many digits as a table of answers has at least
            values = {quantity: float(f"{made.truth[quantity]:.8g}") for quantity in QUANTITIES[kind]}
            hidden[name] = {"kind": kind, "fault": fault.name, "fault_size": fault.size, "truth": values}
            hidden[name] |= made.hidden
    NAMED.write(folder / PROBLEMS, named)
    WINDOW_ROWS.write(folder / WINDOWS, windows)
    (folder / FACTS).write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    rows = [AnswerRow(row.problem, x, None, None, None, False) for row in named for x in QUANTITIES[row.kind]]
    ANSWERS.write(folder / "answers-template.csv", rows)
    units = ", ".join(f"{name} in {unit}" for name, unit in UNITS.items())
    places = {"problems": PROBLEMS, "windows": WINDOWS, "arrays": ARRAYS, "facts": FACTS}
    places |= {"instruments": INSTRUMENTS}
    text = README.format(version=__version__, units=units, **places)
    (folder / "README.md").write_text(text, encoding="utf-8")
    content = {"salt": f"{secret.number('salt'):064x}", "seed": str(seed), "per_kind": per_kind}
    content |= {"version": __version__, "problems": hidden}
    data = (json.dumps(content, indent=1) + "\n").encode()
    truth.write_bytes(data)
    digest = hashlib.sha256(data).hexdigest()
    (folder / COMMITMENT).write_text(f"{digest}  {truth.name}\n", encoding="utf-8")
    return digest


def refuse_places(folder: Path, truth: Path) -> None:
    """Refuse a folder with content, and a truth that would lie in it or replace a file."""
    if (folder / ARRAYS).is_dir() and not (folder / COMMITMENT).exists():
        raise InputError(
            f"{folder}: expected a new or empty folder for the problems, found those of a command that was "
            "stopped: delete the folder, and make it again"
        )
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(
            f"{folder}: expected a new or empty folder for the problems, found content: name another"
        )
    if truth.resolve().is_relative_to(folder.resolve()):
        raise InputError(
            f"--truth: expected a file outside the folder that is published, found {quoted(truth)}: choose "
            "another place"
        )
    if truth.exists() or not truth.resolve().parent.is_dir():
        raise InputError(
            f"--truth: expected a new file in a folder that exists, found {quoted(truth)}: choose another"
        )


def main(arguments: list[str]) -> int:
    """Make a benchmark and say where its truth is; 2, with one sentence, if it cannot be made."""
    parser = argparse.ArgumentParser(prog="tepsipe benchmark make")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--per-kind", type=int, default=10)
    parser.add_argument("--truth", type=Path)
    chosen = parser.parse_args(arguments)
    folder = chosen.folder
    truth = chosen.truth or folder.resolve().with_name(f"{folder.resolve().name}-truth.json")
    seed = secrets.randbits(128) if chosen.seed is None else chosen.seed
    try:
        if not 1 <= chosen.per_kind <= 99 or seed < 0:
            raise InputError(
                "tepsipe benchmark make: expected 1 to 99 problems of each kind and a seed of 0 or more, "
                f"found {chosen.per_kind} and {seed}: correct them"
            )
        refuse_places(folder, truth)
        constants = read_constants(ROOT / "config/virtual_lab.yaml")
        total = len(QUANTITIES) * chosen.per_kind
        numbers = count(1)

        def tell(name: str) -> None:
            print(f"{FAR}{name}, {next(numbers)} of {total}", file=sys.stderr, flush=True)

        digest = make_benchmark(folder, truth, seed, chosen.per_kind, constants, tell)
    except InputError as error:
        print(f"tepsipe: {error}", file=sys.stderr)
        return 2
    print(f"problems: {total} in {folder}")
    print(f"truth, which also holds the seed: {truth}: keep it until all answers are in")
    print(f"its SHA-256, to be published with the folder: {digest}")
    if seed < LEAST_SECRET:
        print("note: a seed below 2^64 can be found by trying, and with it the truth: for practice only")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
