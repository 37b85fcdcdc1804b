"""Pages of the recordings of an unloaded treadmill."""

from tepsipe.drawing import header
from tepsipe.drawing.trial_page import CYCLE, Clock, Page, Panel, Section, Trace
from tepsipe.io.result import Result, read_result
from tepsipe.io.trial import Trial, read_trial


def page(files, chosen) -> Page:
    """Page of a trial, beside the calibration of all of them (``fit``)."""
    choices = header.choices_of_trial(files, chosen) | {"chosen": chosen.model}
    return belt_page(read_trial(files.trial), read_result(files.fit), choices)


def belt_page(trial: Trial, calibration: Result, choices: dict) -> Page:
    """Velocity of a treadmill's belt, and load before and after compensation.

    calibration: of the calibration, with a part of every recording for validation (s, unit of the load).
    choices: ``study``, ``condition``, ``role``, ``chosen`` (model), ``made``.
    """
    clock, condition = Clock.of(trial.time), choices["condition"]
    load = trial.signals["load"]
    unit = "N·m" if load.unit == "Nm" else load.unit
    panels = [
        Panel("Belt velocity", "m/s", (Trace("measured", trial.values("belt_velocity"), clock),)),
        Panel("Load", unit, (Trace("unfiltered", load.values, clock, width=1.0),)),
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
            f"Predictions are shown for {measured.size / calibration.facts['rate_hz']:.4g} s in the middle "
            f"of the trial, low-pass filtered at {calibration.facts['cutoff_hz']:g} Hz."
        )
    facts = [
        *header.trial_facts(trial, "belt", choices),
        (
            "Role",
            {"calibrate": "calibration of the models", "validate": "validation of the models"}.get(
                choices["role"], ""
            ),
        ),
    ]
    return Page(
        title=f"{header.TITLES['belt']}, {condition}",
        study=choices["study"],
        header=header.facts_and_checks(facts, [], [], choices),
        sections=(Section("Velocity and load", tuple(panels), note),),
        footer=header.sources_table(trial) + header.processing(trial),
        axes={"time": "Time (s)", "part": "Time (s)"},
    )
