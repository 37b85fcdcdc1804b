"""Page of a trial of a person on a moving platform."""

from collections.abc import Sequence

from tepsipe.drawing import header
from tepsipe.drawing.trial_page import CYCLE, Band, Clock, Page, Panel, Section, Trace
from tepsipe.io.estimates import ESTIMATES, Estimate
from tepsipe.io.result import Result, read_result
from tepsipe.io.trial import Trial, read_trial

OTHERWISE = "The perturbation identifies every quantity of the recommended model."


def page(files, chosen) -> Page:
    """Page of a trial, of its file, its fit and its estimates."""
    trial, fit, estimates = read_trial(files.trial), read_result(files.fit), ESTIMATES.read(*files.estimates)
    return platform_page(trial, fit, estimates, header.choices_of_trial(files, chosen))


def platform_page(trial: Trial, fit: Result, estimates: Sequence[Estimate], choices: dict) -> Page:
    """Motion of the platform, angles and torques of the joints, measured and predicted.

    fit: of `analyse_platform`.
    choices: ``study``, ``condition``, ``made``.
    """
    clock, part = Clock.of(trial.time), Clock.of(fit.arrays["time"])
    joints = fit.facts["joints"]
    held_out = Band(
        "held-out", fit.facts["held_out_from_s"], float(fit.arrays["time"][-1]), "held out of the prediction"
    )
    platform = trial.signals["platform"]
    panels = [Panel("Platform", platform.unit, (Trace("unfiltered", platform.values, clock),), (held_out,))]
    for k, joint in enumerate(joints):
        angle = Trace("unfiltered", trial.values("joint_angle")[:, k], clock)
        panels.append(Panel(f"Angle of the {joint}", "rad", (angle,), (held_out,)))
    for k, joint in enumerate(joints):
        measured = Trace("measured", fit.arrays["torque"][:, k], part, "black")
        predicted = Trace("predicted", fit.arrays["predicted_torque"][:, k], part, *CYCLE[0])
        panels.append(Panel(f"Torque of the {joint}", "N·m", (measured, predicted), (held_out,)))
    models = fit.facts["models"]
    rejected = [name for name, model in models.items() if model["rejected"]]
    facts = [
        *header.trial_facts(trial, "platform", choices),
        ("Recommended model", fit.facts["chosen"]),
        ("Rejected models", ", ".join(rejected) or "none"),
        ("Perturbations", str(fit.facts["perturbations"])),
    ]
    refusals = [f"{sentence}." for sentence in models[fit.facts["chosen"]]["refusals"]]
    return Page(
        title=f"Standing on a moving platform, {choices['condition']}",
        study=choices["study"],
        header=header.facts_list(facts)
        + header.estimates_table(estimates, choices)
        + header.sentences_list("Not identified by the recommended model", refusals, OTHERWISE),
        sections=(Section("Platform and joints", tuple(panels)),),
        footer=header.sources_table(trial) + header.processing(trial),
    )
