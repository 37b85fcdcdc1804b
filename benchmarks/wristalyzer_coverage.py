"""Coverage of the Wristalyzer's intervals over laboratories drawn from the beliefs of the analysis.

    .venv/bin/python benchmarks/wristalyzer_coverage.py --laboratories 200

Every laboratory has its own seed: torque scale, angle scale, delay, multisine, ripple and log are drawn. The
truth of a trial is the linear fit of its true torque. Prints a table.
"""

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import yaml

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe.arguments import options_of  # noqa: E402
from tepsipe.experiments.wristalyzer.analysis import (  # noqa: E402
    analyse_wristalyzer,
    wristalyzer_rows,
)
from tepsipe.experiments.wristalyzer.options import WristalyzerOptions  # noqa: E402
from tepsipe.experiments.wristalyzer.pooled import fit_together  # noqa: E402
from tepsipe.ingest.manipulator_options import ManipulatorOptions  # noqa: E402
from tepsipe.ingest.manipulators import ingest_torque_manipulator  # noqa: E402
from tepsipe.io.readers.text_table import read_text_table  # noqa: E402
from tepsipe.reporting.recovery import (  # noqa: E402
    linear_truth,
    read_true_motion,
    true_parameters,
)
from tepsipe.statistics.uncertainty import sources_of  # noqa: E402
from tepsipe.virtual_lab.drawn_laboratories import draw_laboratory  # noqa: E402
from tepsipe.virtual_lab.wristalyzer_trial import make_wristalyzer_trial  # noqa: E402
from workflow.settings.complete import without  # noqa: E402

FACTORS, DURATION_S = ("0.08", "0.12", "0.16", "0.20", "0.24"), 60.0


def quick_options(analysis: dict) -> WristalyzerOptions:
    """The study's choices, without the tests of starting values."""
    quick = {"random_starts": 0, "tried_stiffness_Nm_per_rad": (10.0,), "profile_points": 3}
    return options_of(WristalyzerOptions, without(analysis, "swept_bins") | quick)


def rows_of(seed: int, constants: dict, settings: dict, folder: Path) -> list[tuple]:
    """Estimator, quantity, truth, value and interval of every estimate of one laboratory."""
    truth = draw_laboratory(constants | {"seed": seed})
    section, options = settings["wristalyzer"], quick_options(settings["wristalyzer"]["analysis"])
    sources = sources_of(settings["uncertainty"]["wristalyzer"])
    log, command, motion_file = folder / "log.txt", folder / "command.txt", folder / "motion.h5"
    files = {"log": log, "command": command, "motion": motion_file}
    ingest = ManipulatorOptions(angle_unit=section["files"]["angle_unit"], **section["ingest"])
    rows_of_trials, trials = [], {}
    for factor in FACTORS:
        make_wristalyzer_trial(truth, factor, float(factor), DURATION_S, files)
        tables = [
            read_text_table(path, section["files"][columns], "\t")
            for path, columns in ((log, "log_columns"), (command, "command_columns"))
        ]
        trial = ingest_torque_manipulator(*tables, ingest, DURATION_S, "log", "command")
        trials[factor] = trial
        analysis = analyse_wristalyzer(trial, options, np.random.default_rng(1), sources)
        kept = analysis.prepared.kept
        window = (kept.start / trial.rate_hz, kept.stop / trial.rate_hz)
        true = linear_truth(read_true_motion(motion_file), [window], about_mean=True)
        rows = [r for r in wristalyzer_rows(factor, analysis)[0] if r.quantity in true]
        rows_of_trials += [
            (r.estimator, r.quantity, true[r.quantity], r) for r in rows if r.ci_low is not None
        ]
    names = ("lowpass_cutoff_hz", "lowpass_order", "cut_s", "excited_band_hz")
    choices = {name: section["analysis"][name] for name in names}
    period_s = section["analysis"]["perturbation_period_s"]
    pooled = fit_together(trials, sources, period_s=period_s, **choices)
    true = true_parameters(constants)["wristalyzer/pooled"]
    return rows_of_trials + [(r.estimator, r.quantity, true[r.quantity], r) for r in pooled.estimates]


def main() -> None:
    """Print the table: parts held with laboratories as clusters, bias, half width, Type A and B (%)."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--laboratories", type=int, default=20)
    count = parser.parse_args().laboratories
    constants = yaml.safe_load((ROOT / "config/virtual_lab.yaml").read_text())
    settings = yaml.safe_load((ROOT / "config/config.yaml").read_text())
    held: dict[tuple, list[list[tuple]]] = {}
    with TemporaryDirectory() as folder:
        for seed in range(1, count + 1):
            for estimator, quantity, true, row in rows_of(seed, constants, settings, Path(folder)):
                numbers = (
                    row.ci_low <= true <= row.ci_high,
                    *np.array(
                        [row.value - true, 0.5 * (row.ci_high - row.ci_low), row.u_type_a, row.u_type_b]
                    )
                    / abs(true),
                )
                laboratories = held.setdefault((estimator, quantity), [])
                if len(laboratories) < seed:
                    laboratories += [[] for _ in range(seed - len(laboratories))]
                laboratories[seed - 1].append(numbers)
    print(f"{count} laboratories (seeds 1 to {count}), {len(FACTORS)} trials each. Other columns in %.\n")
    print(
        "| Estimator | Quantity | Held | Bias | Half width | Type A | Type B |\n|---|---|---|---|---|---|---|"
    )
    for (estimator, quantity), laboratories in held.items():
        means = np.array([np.mean(scores, axis=0) for scores in laboratories if scores])
        error = means[:, 0].std(ddof=1) / np.sqrt(len(means)) if len(means) > 1 else np.nan
        cells = " | ".join(f"{100.0 * x:.2f}" for x in means[:, 1:].mean(axis=0))
        print(f"| `{estimator}` | {quantity} | {means[:, 0].mean():.3f} ± {error:.3f} | {cells} |")


if __name__ == "__main__":
    main()
