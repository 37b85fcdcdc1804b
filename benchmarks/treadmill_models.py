# ruff: noqa: E402
"""Time to fit treadmill models, relative to the published one, side by side in one run.

    python benchmarks/treadmill_models.py [TABLE]

TABLE is a recording like RandomSlowSpeed1.txt (README.md); without it the folder that TEPSIPE_REAL_DATA names
is looked into, and without that a belt of the same length is made up.
"""

import os

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ[f"{library}_NUM_THREADS"] = "1"

import sys
import time
from pathlib import Path

import numpy as np
import yaml
from scipy import signal

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe.arguments import options_of
from tepsipe.ingest.belt_table import BeltTableOptions, ingest_belt_table
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import Signal, Trial
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FamilyOptions, evaluate, fit_model
from tepsipe.treadmill.trial_recordings import table_recording

COLUMNS = {"time": "Timestamp (s)", "load": "Pitch Moment (Nm)", "velocity": "Belt Velocity (m/s)"}
REFERENCE = "hnat2014"
MODELS = (REFERENCE, "fir", "ripple-tracking")
CUTOFFS_HZ = (6, 20)
REPETITIONS = 9


def recorded(path: Path, settings: dict) -> BeltRecording:
    """A recording of a real treadmill (Nm, m/s)."""
    options = BeltTableOptions(load_unit="Nm", **settings["ingest"])
    trial = ingest_belt_table(read_text_table(path, COLUMNS, "\t"), COLUMNS, options, 0.0, path.name)
    return table_recording(trial, path.name, settings["analysis"]["trimmed_s"])


def made_up(settings: dict, samples: int = 35_000, rate_hz: float = 100.0) -> BeltRecording:
    """A belt at 1.2 m/s with random accelerations, a frame of order 2, ripple of two rollers, and noise."""
    rng = np.random.default_rng(20140612)
    lowpass = signal.butter(2, 3.0, fs=rate_hz, output="sos")
    velocity = 1.2 + signal.sosfilt(lowpass, rng.standard_normal(samples))
    distance = np.cumsum(velocity) / rate_hz
    load = signal.lfilter([1.5, -2.0, 0.9], [1.0, -1.1, 0.5], np.gradient(velocity, 1.0 / rate_hz))
    load += np.cos(2.0 * np.pi * 1.58 * distance) + 0.5 * np.cos(2.0 * np.pi * 6.27 * distance)
    load += rng.standard_normal(samples)
    signals = {
        "load": Signal(load, "Nm", ("time",), "made up"),
        "belt_velocity": Signal(velocity, "m/s", ("time",), "made up"),
    }
    trial = Trial(rate_hz, {"time": np.arange(samples) / rate_hz}, signals)
    return table_recording(trial, "made up", settings["analysis"]["trimmed_s"])


def source(arguments: list[str], settings: dict) -> BeltRecording:
    """Recording that is named, else one in the folder of real data, else a simulated one (Nm, m/s)."""
    if arguments:
        return recorded(Path(arguments[0]), settings)
    folder = Path(os.environ.get("TEPSIPE_REAL_DATA", ROOT.parent / "shared" / "real-data"))
    path = folder / "rmill-treadmill" / "RandomSlowSpeed1.txt"
    return recorded(path, settings) if path.is_file() else made_up(settings)


def main() -> None:
    """Print times (ms) and their ratios to the published model's."""
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
    settings = config["belt"]
    models = {key: value for key, value in settings["models"].items() if key != "family"}
    options = options_of(FamilyOptions, models)
    recording = source(sys.argv[1:], settings)
    print(f"{recording.name}: {recording.load.size} samples, median of {REPETITIONS} repetitions\n")
    print(f"{'cutoff (Hz)':>11}  {'model':<16}{'fit (ms)':>9}{'times ' + REFERENCE:>17}{'R2 (-)':>9}")
    for cutoff in CUTOFFS_HZ:
        analysis = settings["analysis"]
        lowpass = Lowpass(cutoff, analysis["lowpass_order"], analysis["zero_lag"])
        filtered = [recording.filtered(lowpass)]
        times: dict[str, list[float]] = {name: [] for name in MODELS}
        fitted = {name: fit_model(name, filtered, options) for name in MODELS}  # the first is not timed
        for _ in range(REPETITIONS):
            for name in MODELS:  # one after another: what slows the computer down slows all of them
                start = time.perf_counter()
                fit_model(name, filtered, options)
                times[name].append(time.perf_counter() - start)
        reference = np.array(times[REFERENCE])
        for name in MODELS:
            ratio = float(np.median(np.array(times[name]) / reference))
            r2 = evaluate(fitted[name], filtered).r2
            print(f"{cutoff:>11}  {name:<16}{1e3 * np.median(times[name]):>9.1f}{ratio:>17.2f}{r2:>9.3f}")


if __name__ == "__main__":
    main()
