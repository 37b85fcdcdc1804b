"""NLID (McGill) and tepsipe on the same recordings of a human joint: VAF of the held-out part.

    NLID_FOLDER=/path/to/reklab_public .venv/bin/python benchmarks/nlid/run.py TABLE [TABLE ...]

Needs GNU Octave on the PATH and a copy of the toolbox (github.com/reklab/reklab_public), which is not part of
this project. Tables are described in `config/config.yaml`, section position_manipulator. Both programs fit
the same first part of a record; all predictions are filtered and scored by the same functions.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy
import yaml

from tepsipe.errors import InputError
from tepsipe.experiments.position_manipulator.analysis import (
    analyse_parallel_cascade,
    analyse_position_manipulator,
)
from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions
from tepsipe.identification.cascade.options import ParallelCascadeOptions
from tepsipe.ingest.manipulator_options import TableOptions
from tepsipe.ingest.manipulators import ingest_position_manipulator
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import Trial
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.statistics.goodness_of_fit import HeldOutVaf, evaluate_held_out

ROOT = Path(__file__).parents[2]
DRIVER = Path(__file__).with_name("nlid_models.m")
FOLDER = "NLID_FOLDER"
NEEDED = ("nlid_tools", "stiffnessID/PC_stiffnessID.m")
LONGEST_S = 900
DELIMITERS = {"comma": ",", "tab": "\t"}


@dataclass(frozen=True)
class Score:
    """VAF of one model on one recording (%), or the reason why there is none."""

    model: str
    vaf: HeldOutVaf | None
    reason: str = ""


def find_toolbox() -> Path:
    """Folder of the toolbox, by the environment variable."""
    named = os.environ.get(FOLDER, "")
    if not named:
        raise InputError(
            f"{FOLDER}: expected the folder of the toolbox NLID (github.com/reklab/reklab_public), found no "
            "such variable: download the toolbox and name its folder"
        )
    for part in NEEDED:
        if not (Path(named) / part).exists():
            raise InputError(
                f"{FOLDER}: expected the toolbox NLID with {part}, found none in {named}: name the folder "
                "that holds nlid_tools and stiffnessID"
            )
    return Path(named)


def find_octave() -> str:
    """The program Octave on the PATH."""
    for name in ("octave-cli", "octave"):
        if program := shutil.which(name):
            return program
    raise InputError(
        "PATH: expected GNU Octave, found neither octave-cli nor octave: install Octave 7 or later with its "
        "packages signal, statistics and control"
    )


def read_settings() -> dict:
    """Section position_manipulator of the shipped configuration."""
    text = (ROOT / "config/config.yaml").read_text(encoding="utf-8")
    return yaml.safe_load(text)["position_manipulator"]


def read_trial_of(path: Path, settings: dict, rate_hz: float | None = None) -> Trial:
    """Trial of a table at the configured rate, or another one (Hz)."""
    files = settings["files"]
    table = read_text_table(path, files["columns"], DELIMITERS[files["delimiter"]])
    options = TableOptions(
        angle_unit=files["angle_unit"], torque_sign=files["torque_sign"], **settings["ingest"]
    )
    if rate_hz is not None:
        options = replace(options, resample_rate_hz=rate_hz)
    return ingest_position_manipulator(table, options, float(np.ptp(table["time"])), str(path))


def own_scores(trial: Trial, options: PositionManipulatorOptions, reflex: ParallelCascadeOptions) -> list:
    """Both models of this project, as the study fits them."""
    rng = np.random.default_rng(0)
    alone = analyse_position_manipulator(trial, options, rng)
    both = analyse_parallel_cascade(trial, options, reflex, rng)
    return [Score("tepsipe: I, B, K", alone.vaf), Score("tepsipe: parallel cascade", both.vaf)]


def score(
    time: np.ndarray, predicted: np.ndarray, trial: Trial, options: PositionManipulatorOptions
) -> HeldOutVaf:
    """VAF (%) of a torque predicted at other instants, after the filter and on the parts of the study.

    ``time`` (s) is the trial's, with the ends that are not scored. The mean of the fitted part is given
    to the prediction, because the toolbox removes means before it fits.
    """

    def lowpass(x: np.ndarray) -> np.ndarray:
        return butterworth_lowpass(x, trial.rate_hz, options.lowpass_cutoff_hz, options.lowpass_order)

    cut = round(options.cut_s * trial.rate_hz)
    measured = lowpass(trial.values("torque"))[cut : trial.time.size - cut]
    # the ends of a decimated record lie within one of its samples of the record's ends
    at = np.clip(trial.time, time[0], time[-1])
    filtered = lowpass(scipy.interpolate.CubicSpline(time, predicted)(at))[cut : trial.time.size - cut]
    training = int(options.training_fraction * measured.size)
    offset = measured[:training].mean() - filtered[:training].mean()
    return evaluate_held_out(measured, filtered + offset, training)


def read_results(folder: Path) -> dict[str, np.ndarray | str]:
    """Model -> time (s) and torque (N·m), shape (n, 2), or the reason why there is no prediction."""
    path = folder / "models.txt"
    if not path.is_file():
        raise InputError(f"{path}: expected the models that Octave fitted, found no file: see its messages")
    predictions: dict[str, np.ndarray | str] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        model, _, reason = line.partition("\t")
        values = None if reason else np.loadtxt(folder / f"{model}.txt", ndmin=2)
        if values is not None and not (values.shape[1] == 2 and np.isfinite(values).all()):
            reason = "its prediction is not finite"
        predictions[model] = reason or values
    return predictions


def toolbox_scores(path: Path, settings: dict, options: PositionManipulatorOptions) -> list[Score]:
    """The toolbox's models, fitted to the recording at its own rate, about 1 kHz at most."""
    octave, toolbox = find_octave(), find_toolbox()
    trial = read_trial_of(path, settings)
    rate = min(1000.0, float(round(trial.attributes["recorded_rate_hz"])))
    fast = read_trial_of(path, settings, rate)
    cut = round(options.cut_s * rate)
    last = cut + int(options.training_fraction * (fast.time.size - 2 * cut))
    sign = settings["files"]["torque_sign"]
    record = np.column_stack([fast.values("angle"), sign * fast.values("torque")])
    with tempfile.TemporaryDirectory() as folder:
        np.savetxt(f"{folder}/record.txt", record)
        arguments = [str(toolbox), f"{folder}/record.txt", f"{rate:g}"]
        arguments += [str(cut + 1), str(last), folder]
        done = subprocess.run(
            [octave, "--no-gui", "--quiet", str(DRIVER), *arguments],
            capture_output=True,
            text=True,
            timeout=LONGEST_S,
            check=False,
        )
        if not (Path(folder) / "models.txt").is_file():
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            raise InputError(
                f"{DRIVER}: expected models, found that Octave stopped ({last}): check its installation"
            )
        results = read_results(Path(folder))
    scores = []
    for model, values in results.items():
        if isinstance(values, str):
            scores.append(Score(f"NLID: {model}", None, values))
        else:
            scores.append(Score(f"NLID: {model}", score(values[:, 0], sign * values[:, 1], trial, options)))
    return scores


def table_of(scores: dict[str, list[Score]]) -> str:
    """Table in Markdown: recording, model, VAF (%) of the fitted and of the held-out part."""
    lines = [
        "| Recording | Model | Fitted (%) | Held out (%) | Held out, free offset (%) |",
        "|---|---|---|---|---|",
    ]
    for recording, of_recording in scores.items():
        for s in of_recording:
            cells = [f"not fitted: {s.reason}", "–", "–"]
            if s.vaf is not None:
                cells = [f"{v:.2f}" for v in (s.vaf.training, s.vaf.held_out, s.vaf.held_out_any_offset)]
            lines.append("| " + " | ".join([recording, s.model, *cells]) + " |")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """Print the table, or one sentence on what is missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="+", type=Path)
    tables = parser.parse_args(arguments).tables
    settings = read_settings()
    choices = dict(settings["analysis"])
    reflex = ParallelCascadeOptions(**choices.pop("parallel_cascade"))
    options = PositionManipulatorOptions(**choices)
    try:
        find_octave(), find_toolbox()
        scores = {
            path.name.partition(".")[0]: own_scores(read_trial_of(path, settings), options, reflex)
            + toolbox_scores(path, settings, options)
            for path in tables
        }
    except InputError as error:
        print(f"nlid: {error}", file=sys.stderr)
        return 2
    print(table_of(scores))
    return 0


if __name__ == "__main__":
    sys.exit(main())
