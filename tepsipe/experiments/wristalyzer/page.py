"""Pages of the trials in the torque-controlled manipulator."""

from collections.abc import Sequence

from tepsipe.drawing import header
from tepsipe.drawing.trial_page import Clock, Page, Panel, Section, Trace, cut_bands
from tepsipe.experiments.wristalyzer.names import AS_PRINTED
from tepsipe.io.estimates import ESTIMATES, Estimate
from tepsipe.io.result import Result, read_result
from tepsipe.io.trial import Trial, read_trial


def page(files, chosen) -> Page:
    """Page of a trial, of its file, its fit and its estimates."""
    trial, fit, estimates = read_trial(files.trial), read_result(files.fit), ESTIMATES.read(*files.estimates)
    return wristalyzer_page(trial, fit, estimates, header.choices_of_trial(files, chosen))


def wristalyzer_page(trial: Trial, fit: Result, estimates: Sequence[Estimate], choices: dict) -> Page:
    """Torque of the manipulator, and angle of the joint, measured and predicted.

    fit: of `analyse_wristalyzer`.
    choices: ``study``, ``condition``, ``made``.
    """
    clock, (start, stop) = Clock.of(trial.time), fit.facts["kept_samples"]
    bands = cut_bands(trial.time, start, stop)
    angle, predicted = fit.arrays["angle"], fit.arrays["predicted_angle"]
    facts = [
        *header.trial_facts(trial, "wristalyzer", choices),
        ("Part used", f"{(stop - start) / trial.rate_hz:.4g} s, starting at {trial.time[start]:.4g} s"),
    ]
    failed = [name for name, done in fit.facts["converged"].items() if not done]
    failed = [f"{name}: the search stopped before it converged." for name in failed]
    bounded = [f"{name}: a parameter is at its bound." for name, at in fit.facts["at_bound"].items() if at]
    return Page(
        title=f"Wristalyzer, {choices['condition']}",
        study=choices["study"],
        header=header.facts_and_checks(facts, estimates, [*failed, *bounded], choices),
        sections=(
            Section(
                "Torque and angle",
                (
                    Panel(
                        "Commanded torque",
                        "N·m",
                        (
                            Trace("unfiltered", trial.values("torque"), clock, "grey", width=1.0),
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
                        "Measured minus predicted angle",
                        "rad",
                        (Trace("residual", angle - predicted, clock, "blue", width=1.0),),
                        bands,
                    ),
                ),
            ),
        ),
        footer=header.sources_table(trial) + header.processing(trial),
    )
