"""Pages of the trials in the position-controlled manipulator."""

from collections.abc import Sequence

import numpy as np

from tepsipe.drawing import header
from tepsipe.drawing.trial_page import CYCLE, Band, Clock, Page, Panel, Section, Trace, cut_bands
from tepsipe.io.estimates import ESTIMATES, Estimate
from tepsipe.io.result import Result, read_result
from tepsipe.io.trial import Trial, read_trial


def page(files, chosen) -> Page:
    """Page of a trial, of its file, its fit and its estimates."""
    trial, fit, estimates = read_trial(files.trial), read_result(files.fit), ESTIMATES.read(*files.estimates)
    return position_manipulator_page(trial, fit, estimates, header.choices_of_trial(files, chosen))


def position_manipulator_page(
    trial: Trial, fit: Result, estimates: Sequence[Estimate], choices: dict
) -> Page:
    """Angle of the joint, and torque, measured and predicted by both models, with the held-out part marked.

    fit: of `analyse_position_manipulator` and `analyse_parallel_cascade`.
    choices: ``study``, ``condition``, ``made``.
    """
    arrays, whole = fit.arrays, Clock.of(trial.time)
    clock = Clock.of(arrays["time"])
    held_out = Band("held-out", fit.facts["held_out_from_s"], float(arrays["time"][-1]), "held out")
    start, stop = np.searchsorted(trial.time, [arrays["time"][0], arrays["time"][-1]])
    bands = (*cut_bands(trial.time, int(start), int(stop) + 1), held_out)
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
        ("Part fitted", f"first {fit.facts['training_s']:.4g} s; the rest is held out"),
        (
            "VAF of the held-out torque",
            f"{fit.facts['vaf_held_out_percent']:.1f} %, with a reflex pathway "
            f"{fit.facts['reflex']['vaf_held_out_percent']:.1f} %",
        ),
    ]
    return Page(
        title=f"{header.TITLES['position_manipulator']}, {choices['condition']}",
        study=choices["study"],
        header=header.facts_and_checks(facts, estimates, [], choices),
        sections=(
            Section(
                "Angle and torque",
                (
                    Panel("Angle", "rad", (Trace("unfiltered", trial.values("angle"), whole),), bands),
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
                        "Measured minus predicted torque",
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
    of_joint = [Trace("total, relative to its mean", intrinsic - intrinsic.mean(), clock, "blue")]
    if facts["short_range"] or facts.get("relaxing", False):
        names = {"short_range": "short-range stiffness", "relaxing": "relaxation"}
        label = " and ".join(text for key, text in names.items() if facts.get(key, False))
        of_joint.append(Trace(f"part due to {label}", parts["stop_torque"], clock, "purple", width=1.1))
    reflex, note = (), "Cross-validation found no reflex."
    if facts["direction"]:
        reflex, note = (Trace("reflex", parts["reflex_torque"], clock, "vermilion"),), ""
    ahead = f"slow torque, predicted {facts['slow_horizon_s']:g} s ahead"
    left = fit.arrays["torque"] - parts["predicted_torque"]
    slow = (
        Trace("measured minus predicted", left, clock, "grey", width=0.8),
        Trace(ahead, parts["slow_torque"], clock, "green"),
    )
    panels = (
        Panel("Intrinsic torque", "N·m", tuple(of_joint), bands),
        Panel("Reflex torque", "N·m", reflex, bands),
        Panel("Torque that the angle does not predict, and slow torque", "N·m", slow, bands),
    )
    return [Section("Pathways of the parallel-cascade model", panels, note)]
