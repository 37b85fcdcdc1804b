"""Agreement of the public fits, with ``uncertainty=``, and the study, for the same trials.

    .venv/bin/python benchmarks/library_and_study.py results > benchmarks/library_and_study.md

Each trial of dummy and Wristalyzer is analysed by the study's own functions and, from its arrays, by the
public functions with the study's standard uncertainties. Printed: largest difference between the ends of
the intervals, or between the values, in % of the width of the study's interval. About 10 CPU-s per trial.
"""

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import yaml

sys.path.insert(0, str(Path(__file__).parents[1]))

from tepsipe import (
    ImpedanceFit,
    LegUncertainty,
    Trial,
    find_perturbations,
    fit_admittance,
    fit_impedance,
    fit_joint_likelihood,
    fit_output_error,
    frequency_response,
    joint_torque,
    lowpass,
    read_trial,
    segment_motion,
)
from tepsipe.arguments import options_of
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, analyse_dummy
from tepsipe.experiments.dummy.options import Pathway
from tepsipe.experiments.wristalyzer.analysis import ESTIMATORS
from tepsipe.experiments.wristalyzer.options import WristalyzerOptions
from tepsipe.experiments.wristalyzer.record import WristalyzerRecord, prepare, timed
from tepsipe.identification.budgets.leg import KNOWN_OF_LEGS
from tepsipe.mechanics.impedance_model import PARAMETERS, SMALL
from tepsipe.signals.perturbations import rest_samples
from tepsipe.statistics.uncertainty import sources_of

LEG_PATHWAYS = ("leg", "leg-thesis", "leg-output-error", "leg-joint-likelihood")
# setting of the Wristalyzer that another function receives
ELSEWHERE = ("swept_bins",)


def differences(fit: ImpedanceFit, values: np.ndarray, ends: np.ndarray, names=PARAMETERS) -> np.ndarray:
    """Largest difference of value or end, in % of the width of the study's interval, shape (names,)."""
    mine = np.array([[fit.quantities[name].value, *fit.intervals[name]] for name in names])
    theirs = np.column_stack([values, *ends])
    return 100.0 * np.abs(mine - theirs).max(axis=1) / np.diff(ends, axis=0)[0]


def dummy_differences(trial: Trial, options: DummyOptions, pathways: Mapping[str, Pathway]) -> dict:
    """Pathway -> differences for I, B, K (%) of one trial of the dummy; those of small movements apart."""
    study = analyse_dummy(trial, options, {name: pathways[name] for name in LEG_PATHWAYS})
    time, labels = trial.time, trial.axes["marker"].tolist()
    belt, leg, markers = trial.values("belt_velocity"), options.leg, options.leg_markers
    window, filtered = options.window, (options.lowpass_cutoff_hz, options.lowpass_order)
    perturbations = find_perturbations(
        time,
        belt,
        rest_before_s=window.rest_before_s - window.rest_margin_s,
        rest_after_s=window.rest_after_s - window.rest_margin_s,
        cutoff_hz=filtered[0],
        order=filtered[1],
        threshold_fraction=window.threshold_fraction,
        signal_to_noise=window.signal_to_noise,
        merge_s=window.merge_s,
    )
    sources = {name: source for name, source in options.sources.items() if name in KNOWN_OF_LEGS}
    windows = {"perturbations": perturbations, "rest": rest_samples(time, window)}
    found = {}
    for name, signal in (("leg", "marker_position"), ("leg-thesis", "marker_position_as_sampled")):
        positions, thesis = trial.values(signal), name == "leg-thesis"
        motion = _motion(time, positions, options, labels, filtered)
        slots = sources["marker_sampling_s"].standard_uncertainty * np.arange(len(labels))
        late = positions + slots[:, None] * np.gradient(positions, time, axis=0)
        known = LegUncertainty(
            leg=leg,
            markers=markers,
            motion=motion,
            sources=sources,
            sampled_later=_motion(time, late, options, labels, filtered),
            foot=options.foot,
        )
        found[name] = fit_impedance(
            time,
            motion.theta,
            joint_torque(motion, leg, thesis=thesis),
            **windows,
            cutoff_hz=None,
            thesis=thesis,
            uncertainty=None if thesis else known,
        )
    positions = trial.values("marker_position")
    motion = _motion(time, positions, options, labels, filtered)
    foot = positions[:, [labels.index(label) for label in options.belt_fixed_labels], 1].mean(axis=1)
    found["leg-output-error"] = fit_output_error(
        motion,
        foot,
        belt,
        leg,
        **windows,
        cutoff_hz=filtered[0],
        order=filtered[1],
        uncertainty=sources,
    )
    found["leg-joint-likelihood"] = fit_joint_likelihood(
        time,
        positions,
        markers,
        leg,
        labels=labels,
        belt_fixed=options.belt_fixed_labels,
        belt_velocity=belt,
        **windows,
        hidden=_hidden(trial),
        uncertainty=sources,
    )
    result = {}
    for name, fit in found.items():
        of_study = study.regressions[name].mean
        result[name] = differences(fit, of_study, study.budgets[name].interval(of_study))
    name = "leg-joint-likelihood"
    small = [study.quantities[name][q] for q in SMALL]
    interval = np.array([[q.low, q.high] for q in small]).T
    result[f"{name}, small movements"] = differences(
        found[name], np.array([q.value for q in small]), interval, SMALL
    )
    return result


def _motion(time, positions, options, labels, filtered):
    return segment_motion(
        time,
        positions,
        options.leg_markers,
        options.leg.com_m,
        labels=labels,
        cutoff_hz=filtered[0],
        order=filtered[1],
    )


def _hidden(trial: Trial) -> np.ndarray | None:
    """Samples at common instants that lie between two of which one was hidden, shape (n, markers)."""
    hidden = trial.optional("marker_hidden")
    if hidden is None:
        return None
    around = np.asarray(hidden, dtype=bool)
    return around | np.roll(around, 1, axis=0) | np.roll(around, -1, axis=0)


def wristalyzer_differences(trial: Trial, options: WristalyzerOptions, sources: Mapping) -> dict:
    """Estimator -> differences for I, B, K (%) of one trial of the Wristalyzer."""
    trial, _ = timed(trial, options.cut_s, options.perturbation_period_s, options.excited_band_hz)
    record = WristalyzerRecord(trial, prepare(trial, options), options, sources)
    cut = round(options.cut_s * trial.rate_hz)
    kept = slice(cut, trial.time.size - cut)
    time, bounds = trial.time[kept], options.bounds
    cutoff = {"cutoff_hz": options.lowpass_cutoff_hz, "order": options.lowpass_order}
    torque, angle = (lowpass(trial.values(key), trial.rate_hz, **cutoff)[kept] for key in ("torque", "angle"))
    spectra = {
        "spectral-fit": {"averaged_bins": options.averaged_bins, "taper": False},
        "spectral-fit-periods": {
            "period_s": options.perturbation_period_s,
            "band_hz": options.excited_band_hz,
        },
    }
    result = {}
    for name, how in spectra.items():
        fit = fit_admittance(
            frequency_response(time, torque, angle, **how),
            band_hz=options.fit_band_hz,
            start=bounds.start,
            lower=bounds.lower,
            upper=bounds.upper,
            uncertainty=sources,
        )
        of_study = ESTIMATORS[name].function(record)
        ends = np.array([(q.low, q.high) for q in of_study.quantities.values()]).T
        result[name] = differences(fit, of_study.parameters, ends)
    return result


def main() -> None:
    """Print the table as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="folder of results of the study")
    results = parser.parse_args().results
    config = yaml.safe_load((results / "config.yaml").read_text(encoding="utf-8"))
    dummy = config["dummy"]
    analysis = {key: value for key, value in dummy["analysis"].items() if key != "bootstrap_draws"}
    # one filter for all that stands on the treadmill
    analysis |= {key: config["plate_treadmill"][key] for key in ("lowpass_cutoff_hz", "lowpass_order")}
    options = DummyOptions.from_settings(
        dummy["geometry"], analysis, dummy["foot"]["belt_fixed_labels"], config["uncertainty"]["dummy"]
    )
    pathways = {name: Pathway(**choice) for name, choice in dummy["pathways"].items()}
    analysis = {key: x for key, x in config["wristalyzer"]["analysis"].items() if key not in ELSEWHERE}
    manipulator = options_of(WristalyzerOptions, analysis)
    sources = sources_of(config["uncertainty"]["wristalyzer"])
    print("# Library and study: largest differences of values and ends of intervals\n")
    print("In % of the width of the study's interval, by `benchmarks/library_and_study.py results`.\n")
    print("| Trial | Estimator | I | B | K |")
    print("|---|---|---|---|---|")
    for path in sorted((results / "trials/wristalyzer").glob("*.h5")):
        show("wristalyzer", path, wristalyzer_differences(read_trial(path), manipulator, sources))
    for path in sorted((results / "trials/dummy").glob("*.h5")):
        show("dummy", path, dummy_differences(read_trial(path), options, pathways))


def show(rig: str, path: Path, estimators: dict) -> None:
    """Print the rows of a trial."""
    for name, of_joint in estimators.items():
        print(
            f"| {rig} {path.stem} | {name} | " + " | ".join(f"{x:.2g}" for x in of_joint) + " |", flush=True
        )


if __name__ == "__main__":
    main()
