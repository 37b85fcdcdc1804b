"""Pages of the trials with the weight and with the empty belt."""

from collections.abc import Sequence

import numpy as np

from tepsipe.drawing import header
from tepsipe.drawing.trial_page import (
    CYCLE,
    Clock,
    Page,
    Panel,
    Section,
    Trace,
    belt_panel,
    force_panels,
    hidden_sentences,
    marker_panels,
    window_bands,
)
from tepsipe.io.estimates import ESTIMATES, Estimate
from tepsipe.io.result import Result, read_result
from tepsipe.io.trial import Trial, read_trial

TITLES = {"weight": "Weight on the belt", "empty": "Empty belt"}
ROLES = {"calibrate": "calibration of the treadmill models", "validate": "validation of the treadmill models"}


def page(files, chosen) -> Page:
    """Page of a trial, of its file, fit and estimates, and of the calibration of its belt, if any."""
    choices = header.choices_of_trial(files, chosen) | {"experiment": chosen.experiment}
    plate = read_result(files.plate[0]) if files.plate else None
    estimates = ESTIMATES.read(*files.estimates)
    return weight_page(read_trial(files.trial), read_result(files.fit), plate, estimates, choices)


def weight_page(
    trial: Trial, fit: Result, plate: Result | None, estimates: Sequence[Estimate], choices: dict
) -> Page:
    """Belt, markers and forces, and the belt-induced force, measured and predicted by the treadmill models.

    fit: of `analyse_weight`, by perturbation (N, m/s, kg, samples).
    plate: mean responses of the treadmill models, in which a trial for validation has its own.
    choices: ``study``, ``experiment``, ``condition``, ``role``, ``belt``, ``made``.
    Returns: time in s, and time from the onset in s.
    """
    rate, first = fit.facts["rate_hz"], fit.facts["filters"][0]
    onsets, segments = fit.arrays["onsets"], fit.arrays[f"{first}/added_force"]
    windows = np.column_stack([onsets, onsets + segments.shape[1]])[: len(segments)]
    masses = fit.arrays["masses"]
    bands = window_bands(trial.time, windows, [f"mass {mass:.2f} kg" for mass in masses])
    clock = Clock.of(trial.time, [(b.start_s - 0.1, b.stop_s + 0.3) for b in bands])
    facts = [
        *header.trial_facts(trial, choices["experiment"], choices),
        ("Mass on the belt", f"{fit.facts['carried_kg']:g} kg"),
        ("Perturbations", f"{len(windows)}, each for {1e3 * segments.shape[1] / rate:.0f} ms from its onset"),
        ("Role", ROLES.get(choices["role"], "")),
    ]
    flags = header.flagged(estimates, choices)
    left_out = [*hidden_sentences(trial), *_cut_short(len(onsets) - len(segments))]
    return Page(
        title=f"{TITLES[choices['experiment']]}, {choices['condition']}",
        study=choices["study"],
        header=header.facts_list(facts)
        + header.estimates_table(estimates, choices)
        + (header.sentences_list("Flags", flags, "") if flags else "")
        + header.sentences_list(
            "Left out or filled", left_out, "No perturbation was left out, and no marker was hidden."
        ),
        sections=(
            Section("Belt-induced force after the onset", _responses(fit, plate, choices)),
            Section("Belt and markers", (belt_panel(trial, clock, bands), *marker_panels(trial, clock))),
            Section("Force", tuple(force_panels(trial, clock, choices["belt"], bands))),
        ),
        footer=header.sources_table(trial) + header.processing(trial),
        windows=tuple(bands),
        axes={"time": "Time (s)", "onset": "Time from the onset (s)"},
    )


def _of_markers(fit: Result, name: str) -> str:
    """The filter, and the source of the weight's acceleration."""
    weight = "; acceleration of the weight from its markers" if fit.facts["carried_kg"] else ""
    return f"low-pass {name}{weight}"


def _cut_short(count: int) -> list[str]:
    return (
        [f"Perturbations left out because the trial ends too soon after them: {count}."] if count > 0 else []
    )


def _responses(fit: Result, plate: Result | None, choices: dict) -> tuple[Panel, ...]:
    """Mean belt-induced force, that of every perturbation, and the predictions of the models."""
    rate, first = fit.facts["rate_hz"], fit.facts["filters"][0]
    force = fit.arrays[f"{first}/added_force"]
    if not force.size:
        return ()
    clock = Clock(0.0, rate, force.shape[1])
    mean = Trace("mean", force.mean(axis=0), clock, "black", width=2.0)
    spread = [
        Trace("minimum", force.min(axis=0), clock, "grey", "2 2"),
        Trace("maximum", force.max(axis=0), clock, "grey", "6 3"),
    ]
    velocity = fit.arrays[f"{first}/belt_velocity"].mean(axis=0)
    panels = [
        Panel("Mean belt velocity", "m/s", (Trace("measured", velocity, clock),), axis="onset"),
        Panel("Belt-induced force", "N", (mean, *spread), axis="onset", note=_of_markers(fit, first)),
    ]
    condition = choices["condition"]
    if choices["experiment"] != "weight" or plate is None or f"{condition}/measured" not in plate.arrays:
        return tuple(panels)
    measured = plate.arrays[f"{condition}/measured"]
    clock = Clock(0.0, plate.facts["rate_hz"], measured.size)
    models = [m for m in plate.facts["models"] if f"{condition}/{m}" in plate.arrays]
    lines = dict(zip(models, CYCLE * 2, strict=False))
    predicted = [Trace(m, plate.arrays[f"{condition}/{m}"], clock, *lines[m]) for m in models]
    residual = [Trace(m, measured - plate.arrays[f"{condition}/{m}"], clock, *lines[m]) for m in models]
    return (
        *panels,
        Panel(
            "Belt-induced force, measured and predicted by the models",
            "N",
            (Trace("measured", measured, clock, width=2.0), *predicted),
            axis="onset",
            note="means over the perturbations; the weight is assumed to move with the belt; models fitted "
            "to other trials",
        ),
        Panel("Residuals of the models", "N", tuple(residual), axis="onset"),
    )
