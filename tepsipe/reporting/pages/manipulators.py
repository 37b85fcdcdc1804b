"""Pages of the trials in the torque-controlled and in the position-controlled manipulator, and of a belt."""

from collections.abc import Sequence

import numpy as np

from tepsipe.experiments.wristalyzer.names import AS_PRINTED
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.reporting.pages import header
from tepsipe.reporting.pages.trial_page import CYCLE, Band, Clock, Page, Panel, Section, Trace

OTHERWISE = "No check of this trial failed."


def wristalyzer_page(trial: Trial, fit: Result, estimates: Sequence[Estimate], choices: dict) -> Page:
    """Torque of the manipulator, and angle of the joint, measured and predicted.

    Parameters
    ----------
    trial : Trial
        Signals (N·m, rad).
    fit : Result
        Of `analyse_wristalyzer` (N·m, rad, Hz).
    estimates : sequence of Estimate
        Of the trial (units in them).
    choices : dict
        ``study``, ``condition``, ``made``.

    Returns
    -------
    Page
        Time in s.
    """
    clock, (start, stop) = Clock.of(trial.time), fit.facts["kept_samples"]
    bands = _cut_bands(trial.time, start, stop)
    angle, predicted = fit.arrays["angle"], fit.arrays["predicted_angle"]
    facts = [
        *header.trial_facts(trial, "wristalyzer", choices),
        ("Used", f"{(stop - start) / trial.rate_hz:.4g} s from {trial.time[start]:.4g} s on"),
    ]
    failed = [name for name, done in fit.facts["converged"].items() if not done]
    failed = [f"The search of {name} ended before it converged." for name in failed]
    bounded = [f"{name}: a parameter is at its bound." for name, at in fit.facts["at_bound"].items() if at]
    return Page(
        title=f"Wristalyzer, {choices['condition']}",
        study=choices["study"],
        header=_header(facts, estimates, [*failed, *bounded], OTHERWISE),
        sections=(
            Section(
                "Torque and angle",
                (
                    Panel(
                        "Commanded torque",
                        "N·m",
                        (
                            Trace("as ingested", trial.values("torque"), clock, "grey", width=1.0),
                            Trace("low-pass filtered", fit.arrays["torque"], clock, "black"),
                        ),
                        bands,
                    ),
                    Panel(
                        "Angle",
                        "rad",
                        (
                            Trace("measured", angle, clock, "black"),
                            Trace(f"predicted by {AS_PRINTED}", predicted, clock, "vermilion", "5 3"),
                        ),
                        bands,
                    ),
                    Panel(
                        "Measured less predicted angle",
                        "rad",
                        (Trace("residual", angle - predicted, clock, "blue", width=1.0),),
                        bands,
                    ),
                ),
            ),
        ),
        footer=header.sources_table(trial) + header.processing(trial),
    )


def position_manipulator_page(
    trial: Trial, fit: Result, estimates: Sequence[Estimate], choices: dict
) -> Page:
    """Angle of the joint, and torque, measured and predicted by both models, with the held-out part marked.

    Parameters
    ----------
    trial : Trial
        Signals (N·m, rad).
    fit : Result
        Of `analyse_position_manipulator` and `analyse_parallel_cascade` (N·m, rad, s).
    estimates : sequence of Estimate
        Of the trial (units in them).
    choices : dict
        ``study``, ``condition``, ``made``.

    Returns
    -------
    Page
        Time in s.
    """
    arrays, whole = fit.arrays, Clock.of(trial.time)
    clock = Clock.of(arrays["time"])
    held_out = Band("held-out", fit.facts["held_out_from_s"], float(arrays["time"][-1]), "held out")
    start, stop = np.searchsorted(trial.time, [arrays["time"][0], arrays["time"][-1]])
    bands = (*_cut_bands(trial.time, int(start), int(stop) + 1), held_out)
    torque = arrays["torque"]
    predictions = {"I, B, K": arrays["predicted_torque"]}
    for key, label in (
        ("reflex/predicted_torque", "parallel cascade"),
        ("reflex/muscle_predicted_torque", "parallel cascade, muscle model"),
    ):
        if key in arrays:
            predictions[label] = arrays[key]
    lines = dict(zip(predictions, CYCLE[1:], strict=False))
    facts = [
        *header.trial_facts(trial, "position_manipulator", choices),
        ("Fitted", f"first {fit.facts['training_s']:.4g} s; the rest is held out"),
        (
            "VAF of the held-out torque",
            f"{fit.facts['vaf_held_out_percent']:.1f} %, with a reflex pathway "
            f"{fit.facts['reflex']['vaf_held_out_percent']:.1f} %",
        ),
    ]
    return Page(
        title=f"{header.TITLES['position_manipulator']}, {choices['condition']}",
        study=choices["study"],
        header=_header(facts, estimates, [], OTHERWISE),
        sections=(
            Section(
                "Angle and torque",
                (
                    Panel("Angle", "rad", (Trace("as ingested", trial.values("angle"), whole),), bands),
                    Panel(
                        "Torque",
                        "N·m",
                        (
                            Trace("measured", torque, clock, "black"),
                            *(Trace(k, x, clock, *lines[k], 1.1) for k, x in predictions.items()),
                        ),
                        bands,
                    ),
                    Panel(
                        "Measured less predicted torque",
                        "N·m",
                        tuple(Trace(k, torque - x, clock, *lines[k], 1.0) for k, x in predictions.items()),
                        bands,
                    ),
                ),
            ),
            *_pathways(fit, clock, bands),
        ),
        footer=header.sources_table(trial) + header.processing(trial),
    )


def _pathways(fit: Result, clock: Clock, bands: tuple[Band, ...]) -> list[Section]:
    """Intrinsic, reflex and slow torque of the parallel-cascade model in time (N·m)."""
    parts = {name.removeprefix("reflex/"): x for name, x in fit.arrays.items() if name.startswith("reflex/")}
    if "reflex_torque" not in parts:
        return []
    facts = fit.facts["reflex"]
    intrinsic = parts["predicted_torque"] - parts["reflex_torque"]
    of_joint = [Trace("whole, about its mean", intrinsic - intrinsic.mean(), clock, "blue")]
    if facts["short_range"] or facts.get("relaxing", False):
        names = {"short_range": "short-range stiffness", "relaxing": "relaxation"}
        label = " and ".join(text for key, text in names.items() if facts.get(key, False))
        of_joint.append(Trace(f"of it {label}", parts["stop_torque"], clock, "purple", width=1.1))
    reflex, note = (), "Cross-validation found no reflex."
    if facts["direction"]:
        reflex, note = (Trace("reflex", parts["reflex_torque"], clock, "vermilion"),), ""
    ahead = f"slow torque, predicted {facts['slow_horizon_s']:g} s ahead"
    left = fit.arrays["torque"] - parts["predicted_torque"]
    slow = (
        Trace("measured less predicted", left, clock, "grey", width=0.8),
        Trace(ahead, parts["slow_torque"], clock, "green"),
    )
    panels = (
        Panel("Intrinsic torque", "N·m", tuple(of_joint), bands),
        Panel("Reflex torque", "N·m", reflex, bands),
        Panel("What the angle does not predict, and slow torque", "N·m", slow, bands),
    )
    return [Section("Pathways of the parallel-cascade model", panels, note)]


def belt_page(trial: Trial, calibration: Result, choices: dict) -> Page:
    """Velocity of a treadmill's belt, and load before and after compensation.

    Parameters
    ----------
    trial : Trial
        Signals (m/s; load in the unit of its file).
    calibration : Result
        Of the calibration, with a part of every recording for validation (s, unit of the load).
    choices : dict
        ``study``, ``condition``, ``role``, ``chosen`` (model), ``made``.

    Returns
    -------
    Page
        Time in s.
    """
    clock, condition = Clock.of(trial.time), choices["condition"]
    load = trial.signals["load"]
    unit = "N·m" if load.unit == "Nm" else load.unit
    panels = [
        Panel("Belt velocity", "m/s", (Trace("measured", trial.values("belt_velocity"), clock),)),
        Panel("Load", unit, (Trace("as ingested", load.values, clock, width=1.0),)),
    ]
    note = ""
    if f"{condition}/measured" in calibration.arrays:
        arrays = calibration.arrays
        part = Clock.of(arrays[f"{condition}/time"] + trial.time[0])
        measured = arrays[f"{condition}/measured"]
        models = [m for m in calibration.facts["models"] if f"{condition}/{m}" in arrays]
        models.sort(key=lambda name: name != choices["chosen"])
        lines = dict(zip(models, CYCLE * 2, strict=False))
        black = Trace("measured", measured, part, "black", width=1.8)
        predicted = [Trace(m, arrays[f"{condition}/{m}"], part, *lines[m]) for m in models]
        residual = [Trace(m, measured - arrays[f"{condition}/{m}"], part, *lines[m]) for m in models]
        panels += [
            Panel("Load, measured and predicted", unit, (black, *predicted), axis="part"),
            Panel("Load before and after compensation", unit, (black, *residual), axis="part"),
        ]
        note = (
            f"The predictions are stored for {measured.size / calibration.facts['rate_hz']:.4g} s in the "
            f"middle of the trial, with the low-pass at {calibration.facts['cutoff_hz']:g} Hz."
        )
    facts = [
        *header.trial_facts(trial, "belt", choices),
        (
            "Role",
            {"calibrate": "calibrates the models", "validate": "validates the models"}.get(
                choices["role"], ""
            ),
        ),
    ]
    return Page(
        title=f"{header.TITLES['belt']}, {condition}",
        study=choices["study"],
        header=_header(facts, [], [], OTHERWISE),
        sections=(Section("Velocity and load", tuple(panels), note),),
        footer=header.sources_table(trial) + header.processing(trial),
        axes={"time": "Time (s)", "part": "Time (s)"},
    )


def _header(facts: list, estimates: Sequence[Estimate], flags: list[str], otherwise: str) -> str:
    found = [*header.flagged(estimates), *flags]
    return (
        header.facts_list(facts)
        + header.estimates_table(estimates, [])
        + header.sentences_list("Flags", found, otherwise)
    )


def _cut_bands(time: np.ndarray, start: int, stop: int) -> tuple[Band, ...]:
    """Both ends that are not used (s), from the samples that are."""
    ends = []
    if start > 0:
        ends.append(Band("cut", float(time[0]), float(time[start]), "not used"))
    if stop < time.size:
        ends.append(Band("cut", float(time[stop - 1]), float(time[-1]), "not used"))
    return tuple(ends)
