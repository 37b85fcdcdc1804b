"""Table of the errors of K and B caused by each mechanism of the virtual person.

    .venv/bin/python benchmarks/standing_mechanisms.py [--seeds 1] [--assumptions]

Two trials of each task, one in each direction, on a plate that measures only the load of the feet, are
simulated and analysed by the shipped configuration. The truth is the linear fit of the true intrinsic torque
in the fitted window. With --assumptions, the table shows the recommended estimate and its interval where
forefoot or soft tissue differ from the assumptions of the corrections.
"""

import argparse
import copy
import math
import os
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402
import yaml  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe.experiments.standing.epochs import cut_standing_epochs  # noqa: E402
from tepsipe.experiments.standing.free_reflex.broadband import cut_broadband  # noqa: E402
from tepsipe.experiments.standing.free_reflex.results import (  # noqa: E402
    FreeReflexChoices,
    fit_free,
    reflex_onset,
)
from tepsipe.experiments.standing.joint_torque import process_standing  # noqa: E402
from tepsipe.experiments.standing.muscle_torque import ActiveOptions  # noqa: E402
from tepsipe.experiments.standing.options import (  # noqa: E402
    EpochOptions,
    FreeReflexOptions,
    StandingEstimator,
    StandingOptions,
    TorquePathway,
)
from tepsipe.experiments.standing.thesis.impedance import fit_standing  # noqa: E402
from tepsipe.experiments.standing.thesis.latency import muscle_latency  # noqa: E402
from tepsipe.ingest.standing import ingest_standing_files  # noqa: E402
from tepsipe.ingest.treadmill_options import TreadmillOptions  # noqa: E402
from tepsipe.reporting.recovery import linear_truth_standing, read_true_motion  # noqa: E402
from tepsipe.signals.filters import Lowpass  # noqa: E402
from tepsipe.signals.onsets import OnsetOptions  # noqa: E402
from tepsipe.statistics.uncertainty import sources_of  # noqa: E402
from tepsipe.virtual_lab.person_mechanisms import MECHANISMS, without  # noqa: E402
from tepsipe.virtual_lab.standing_trial import make_standing_trial  # noqa: E402
from tepsipe.virtual_lab.treadmill_trial import Protocol  # noqa: E402
from workflow.settings.complete import settings_of  # noqa: E402

DURATION_S, INTERVAL_S = 45.0, (3.6, 3.8)
TRIALS = (("sine", 0.4), ("negative-sine", 0.4))
# a plate that feels nothing but the feet
QUIET_PLATE = {
    "felt_belt_mass_kg": 0.0,
    "felt_roller_inertia_kgm": 0.0,
    "friction_N": 0.0,
    "friction_coefficient": 0.0,
    "friction_Ns_per_m": 0.0,
    "floor_m_per_s2": 0.0,
    "mount_share": 0.0,
    "resonance_hz": 2000.0,
    "second_share": [0.0, 0.0],
    "friction_lever_m": 0.0,
}
# what is drawn has no shipped size: one standard deviation of its distribution
DRAWN = {
    "joint centre 4 mm forward": {("markers", "joint_centre_m"): [0.004, 0.0]},
    "joint centre 3 mm up": {("markers", "joint_centre_m"): [0.0, 0.003]},
    "feet 8 % heavier": {("person", "foot_mass"): 1.08 * 0.0145},
}
# what the analysis assumes, and a stiffness of about what the short range leaves in these responses
AS_ANALYSED = {
    ("person", "foot_mass"): 0.0145,
    ("tasks", "relax", "stiffness_Nm_per_rad"): [355.0, 900.0, 600.0],
    ("tasks", "stiff", "stiffness_Nm_per_rad"): [585.0, 1400.0, 900.0],
}
SHORT_RANGE = "short-range stiffness"
FEET = {("person", "foot_mass"): AS_ANALYSED["person", "foot_mass"]}
# what the corrections assume (decisions 52 and 70): tissue of 12 Hz with a damping ratio of 0.3, and without
# pulses a forefoot that rotates half as much
ASSUMED = {
    "as assumed": {},
    "forefoot 0.3": {("person", "forefoot_share"): 0.3},
    "forefoot 0.7": {("person", "forefoot_share"): 0.7},
    "rigid feet on soft soles": {
        ("person", "forefoot_share"): 1.0,
        ("person", "foot_stiffness_Nm_per_rad"): 3000.0,
    },
    "soft tissue of 8 Hz": {("skin", "frequency_hz"): 8.0},
    "soft tissue of 18 Hz": {("skin", "frequency_hz"): 18.0},
    "soft tissue damped by 0.15": {("skin", "damping"): 0.15},
    "soft tissue damped by 0.5": {("skin", "damping"): 0.5},
}
ESTIMATOR = "pre-reflex-window"
WINDOWS_S = (0.04, 0.06, 0.08)  # one of them the estimator's


def placed(section: dict, values: dict) -> dict:
    """A copy of a configuration section with values at paths of keys."""
    changed = copy.deepcopy(section)
    for path, value in values.items():
        inner = changed
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = value
    return changed


def variants(standing: dict) -> dict[str, dict]:
    """Name -> section of the person: without mechanisms, with each one alone, with all shipped ones."""
    plain = placed(without(standing), AS_ANALYSED)
    sections = {"none": plain}
    for name in MECHANISMS:
        if name == "joint centre":
            continue
        others = [other for other in MECHANISMS if other != name]
        sections[name] = placed(without(standing, others), AS_ANALYSED if name != SHORT_RANGE else FEET)
    sections |= {name: placed(plain, values) for name, values in DRAWN.items()}
    sections["all that are shipped"] = standing
    return sections


class Analysis:
    """The shipped analysis of the standing person, on the torque of the plate as it is."""

    def __init__(self):
        config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
        self.section = section = settings_of(config)["standing"]
        analysis = section["analysis"]
        self.standing = StandingOptions.from_settings(
            section["person"], section["belt"], analysis, section["stance"]
        )
        self.cutting = EpochOptions.from_settings(analysis, section["emg"], section["ingest"]["max_gap_s"])
        self.active = ActiveOptions.from_settings(section["active"], section["muscles"])
        self.action = {muscle: choice["ankle_action"] for muscle, choice in section["muscles"].items()}
        self.estimators = {key: StandingEstimator(**one) for key, one in section["estimators"].items()}
        self.estimator = self.estimators[ESTIMATOR]
        self.choices = FreeReflexChoices(
            section["recommended"]["pathway"],
            FreeReflexOptions(**section["free_reflex"]),
            sources_of(settings_of(config)["uncertainty"]["standing"]),
        )

    def responses(self, files: dict[str, Path], name: str):
        """Epochs of one trial, from its raw files, with both filters."""
        section = self.section
        channels = {muscle: choice["channel"] for muscle, choice in section["muscles"].items()}
        trial = ingest_standing_files(
            files,
            section["files"]["marker_labels"],
            channels,
            section["files"]["emg_trigger"],
            section["files"]["emg_trigger_threshold"],
            TreadmillOptions(**section["ingest"]),
            DURATION_S,
        )
        processed = process_standing(trial, name, self.standing, {"ankle": TorquePathway("ankle", None)}, {})
        epochs = cut_standing_epochs(processed, self.cutting)
        lowpass = Lowpass(self.choices.options.lowpass_cutoff_hz, section["analysis"]["lowpass_order"], True)
        broadband = cut_broadband(processed, epochs, self.standing, self.cutting, lowpass, {})
        return epochs, broadband

    def quoted(self, epochs: list, broadband: list, name: str):
        """The recommended fit of a task."""
        latencies = [muscle_latency(epochs, m, *self.latency_options(m)) for m in self.action]
        known = [latency for latency in latencies if not isinstance(latency, str)]
        options, chosen = self.choices.options, self.section["recommended"]["estimator"]
        onset = reflex_onset(known, self.action, self.section["latency"]["detector"], options)
        used = {key: x for key, x in self.estimators.items() if key in (chosen, ESTIMATOR)}
        count = sum(len(e.onsets_s) for e in epochs)
        return fit_free(broadband, name, used, self.choices, count, onset)[self.choices.pathway, chosen]

    def latency_options(self, muscle: str) -> tuple[str, OnsetOptions, np.random.Generator]:
        """Lengthening of a muscle, detector of its onset, and random numbers."""
        choice = self.section["latency"]
        options = OnsetOptions(**choice | {"bootstrap_draws": 20})
        return self.section["muscles"][muscle]["lengthened_by"], options, np.random.default_rng(1)

    def latency(self, epochs: list, muscle: str) -> float:
        """Latency from the onset of the stretch to the onset of the muscle (s), NaN without one."""
        detection = muscle_latency(epochs, muscle, *self.latency_options(muscle))
        onset = (
            None
            if isinstance(detection, str)
            else detection.onsets[self.section["latency"]["detector"]].latency_s
        )
        return math.nan if onset is None else onset


def recorded(analysis: Analysis, name: str, truth: dict, task: str, seed: int) -> tuple[list, list, list]:
    """Epochs of the trials of a task with either filter, and their true motions."""
    epochs, broadband, motions = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for profile, amplitude in TRIALS:
            kinds = {"log": "mat", "calibration": "csv", "markers": "c3d", "emg": "edf"}
            files = {kind: Path(folder) / f"{profile}.{ending}" for kind, ending in kinds.items()}
            motion = Path(folder) / f"{profile}.h5"
            protocol = Protocol(profile, amplitude, INTERVAL_S, DURATION_S)
            made = files | {"motion": motion}
            make_standing_trial(truth | {"seed": seed}, f"{task}-{profile}", task, protocol, made)
            both = analysis.responses(files, f"{name}/{task}/{profile}")
            epochs.append(both[0])
            broadband.append(both[1])
            motions.append(read_true_motion(motion))
    return epochs, broadband, motions


def quoted(job: tuple[str, dict, str, int]) -> dict:
    """Error and half width of the interval (%) for B and K of a task, and flags."""
    name, truth, task, seed = job
    analysis = Analysis()
    epochs, broadband, motions = recorded(analysis, name, truth, task, seed)
    fit = analysis.quoted(epochs, broadband, f"{name}/{task}")
    window_s = analysis.estimators[analysis.section["recommended"]["estimator"]].window_s
    onsets = [e.onsets_s for e in epochs]
    true = linear_truth_standing(motions, onsets, window_s, False, analysis.cutting.baseline_s)
    scores = {"flags": fit.quantities["K"].flags}
    for key in "BK":
        found = fit.quantities[key]
        scores[key] = 100.0 * (found.value / true[key] - 1.0)
        scores[f"{key}_half"] = 50.0 * (found.high - found.low) / true[key]
    return scores


def measured(job: tuple[str, dict, str, int]) -> dict:
    """Latencies (ms), and by window true K and B (N·m/rad, N·m·s/rad) and their errors (%), of a task."""
    name, truth, task, seed = job
    analysis = Analysis()
    epochs, _, motions = recorded(analysis, name, truth, task, seed)
    scores = {
        "SOL": 1e3 * analysis.latency(epochs, "SOL"),
        "TA": 1e3 * analysis.latency(epochs, "TA"),
    }
    for window_s in WINDOWS_S:
        estimator = replace(analysis.estimator, window_s=window_s)
        true = linear_truth_standing(
            motions,
            [e.onsets_s for e in epochs],
            window_s,
            estimator.inertia,
            analysis.cutting.baseline_s,
        )
        fit = fit_standing(epochs, "ankle", estimator, analysis.active, 10, np.random.default_rng(1))
        for key in "KB":
            scores[f"{key}_true", window_s] = true[key]
            scores[key, window_s] = 100.0 * (fit.quantities[key].value / true[key] - 1.0)
    return scores


def print_assumptions(truth: dict, seeds: int, processes: int) -> None:
    """Print a table of the recommended estimate for persons who differ from the assumptions."""
    jobs = [
        (name, truth | {"standing": placed(truth["standing"], FEET | values), "drawn": None}, task, seed)
        for name, values in ASSUMED.items()
        for task in ("relax", "stiff")
        for seed in range(1, seeds + 1)
    ]
    with ProcessPoolExecutor(processes) as pool:
        results = list(zip(jobs, pool.map(quoted, jobs), strict=True))
    print("| person | error of K | half width | error of B | half width | covered K, B | flagged |")
    print("|---" * 7 + "|")
    for name in ASSUMED:
        by_task = {
            task: [r for j, r in results if (j[0], j[2]) == (name, task)] for task in ("relax", "stiff")
        }
        every = [r for group in by_task.values() for r in group]
        cells = [
            " / ".join(f"{np.mean([r[key] for r in group]):{form}}" for group in by_task.values())
            for key, form in (("K", "+.1f"), ("K_half", ".1f"), ("B", "+.1f"), ("B_half", ".1f"))
        ]
        held = [sum(abs(r[key]) <= r[f"{key}_half"] for r in every) for key in "KB"]
        flagged = sum(bool(r["flags"]) for r in every)
        counts = [f"{held[0]}, {held[1]} of {len(every)}", f"{flagged} of {len(every)}"]
        print("|", " | ".join([name, *cells, *counts]), "|", flush=True)


def main() -> None:
    """Print the table as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=1, help="laboratories per row")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--assumptions", action="store_true", help="forefoot and soft tissue only")
    options = parser.parse_args()
    truth = yaml.safe_load((ROOT / "config" / "virtual_lab.yaml").read_text(encoding="utf-8"))
    truth["treadmill"]["plate"] |= QUIET_PLATE
    if options.assumptions:
        return print_assumptions(truth, options.seeds, options.processes)
    tasks, analysis_window_s = ("relax", "stiff"), Analysis().estimator.window_s
    named = variants(truth["standing"])
    jobs = [
        (name, truth | {"standing": standing}, task, seed)
        for name, standing in named.items()
        for task in tasks
        for seed in range(1, options.seeds + 1)
    ]
    with ProcessPoolExecutor(options.processes) as pool:
        results = list(pool.map(measured, jobs))
    lengths = [f"{1e3 * window_s:.0f} ms" for window_s in WINDOWS_S]
    columns = ["mechanism", "true K", *[f"K, {x}" for x in lengths], "true B", *[f"B, {x}" for x in lengths]]
    print("|", " | ".join([*columns, "latency SOL, TA (ms)"]), "|")
    print("|---" * (len(columns) + 1) + "|")
    for name in named:
        by_task = {
            task: [r for j, r in zip(jobs, results, strict=True) if (j[0], j[2]) == (name, task)]
            for task in tasks
        }

        def cell(key: object, form: str, by_task: dict = by_task) -> str:
            return " / ".join(form.format(np.mean([r[key] for r in by_task[task]])) for task in tasks)

        cells = [name]
        for key, form in (("K", "{:.0f}"), ("B", "{:.1f}")):
            cells.append(cell((f"{key}_true", analysis_window_s), form))
            cells += [cell((key, window_s), "{:+.1f}") for window_s in WINDOWS_S]
        cells.append(f"{cell('SOL', '{:.1f}')}, {cell('TA', '{:.1f}')}")
        print("|", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
