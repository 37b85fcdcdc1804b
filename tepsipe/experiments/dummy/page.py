"""Page of a trial of the ankle dummy."""

from collections.abc import Sequence

import numpy as np

from tepsipe.drawing import header
from tepsipe.drawing.names import below_100, words
from tepsipe.drawing.trial_page import (
    Band,
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
from tepsipe.experiments.dummy.rig import RIG_FLAGS, flag_rig, rig_flags
from tepsipe.io.estimates import ESTIMATES, Estimate
from tepsipe.io.result import Result, read_result
from tepsipe.io.trial import Trial, read_trial

LOADS = {"Fy": ("Fore-aft force", "N"), "Mx": ("Moment about the plate's x axis", "N·m")}


def page(files, chosen) -> Page:
    """Page of a trial, of its file, its fits from the leg and, if any, the foot, and its estimates.

    ``rig`` are the faults of its rig, if they are known; without them, those that the trial shows alone.
    """
    choices = header.choices_of_trial(files, chosen) | {"recommended": chosen.recommended}
    foot = read_result(files.foot[0]) if files.foot else None
    leg, estimates = read_result(files.fit), ESTIMATES.read(*files.estimates)
    of_rig = RIG_FLAGS.read(*files.rig) if files.rig else rig_flags({choices["condition"]: leg.facts})
    return dummy_page(read_trial(files.trial), leg, foot, flag_rig(estimates, of_rig), choices)


def dummy_page(
    trial: Trial, leg: Result, foot: Result | None, estimates: Sequence[Estimate], choices: dict
) -> Page:
    """Belt, markers, forces, angle, and torque of every pathway with its prediction.

    leg, foot: fits of the pathways from the leg, and from the foot if there are any (N·m, rad, samples).
    choices: ``study``, ``condition``, ``belt``, ``recommended`` (pathway), ``made``, ``participant``.
    """
    time, windows = trial.time, leg.arrays["windows"]
    vaf = leg.arrays.get(f"{choices['recommended']}/vaf_per_perturbation", np.empty(0))
    neutral = choices.get("neutral", False)
    notes = [f"VAF {_percent(value)} % ({words(choices['recommended'], neutral)})" for value in vaf]
    bands = window_bands(time, windows, notes if len(notes) == len(windows) else ())
    clock = Clock.of(time, [(b.start_s - 0.1, b.stop_s + 0.6) for b in bands])
    torques = _torque_panels(leg, clock, bands, neutral)
    if foot is not None:
        torques += _torque_panels(foot, clock, window_bands(time, foot.arrays["windows"]), neutral)
    lengths = np.diff(windows, axis=1) / trial.rate_hz
    residual = leg.facts["marker_residual_rms_m"]
    facts = [
        *header.trial_facts(trial, "dummy", choices),
        ("Perturbations", f"{len(windows)}, windows of {1e3 * lengths.mean():.3g} ms on average"),
        ("Marker residual", f"{1e3 * residual:.2g} mm RMS deviation from a rigid leg"),
    ]
    flags = header.flagged(estimates, choices)
    top = (
        header.facts_list(facts)
        + header.estimates_table(estimates, choices)
        + (header.sentences_list("Flags", flags, "") if flags else "")
        + header.sentences_list(
            "Left out or filled",
            hidden_sentences(trial),
            "No perturbation was left out, and no marker was hidden.",
        )
    )
    return Page(
        title=f"Ankle dummy, {choices['condition']}",
        study=choices["study"],
        header=top,
        sections=(
            Section("Belt and markers", (belt_panel(trial, clock, bands), *marker_panels(trial, clock))),
            Section("Angle of the leg", tuple(_angle_panels(leg, clock, bands, neutral))),
            Section(
                "Force",
                (*_load_panels(foot, clock, bands), *force_panels(trial, clock, choices["belt"], bands)),
            ),
            Section(
                "Torque of the ankle, by pathway",
                tuple(torques),
                "Predictions of windowed estimates use the means of I, B and K over the windows.",
            ),
        ),
        footer=header.sources_table(trial) + header.processing(trial),
        windows=tuple(bands),
    )


def _percent(vaf: float) -> str:
    return below_100(f"{vaf:.2f}", vaf)


def _torque_panels(result: Result, clock: Clock, bands: list[Band], neutral: bool) -> list[Panel]:
    panels = []
    for name in result.facts["pathways"]:
        if f"{name}/torque" not in result.arrays:
            continue
        vaf = result.arrays[f"{name}/vaf_per_perturbation"]
        panels.append(
            Panel(
                f"Torque, {words(name, neutral)}",
                "N·m",
                (
                    Trace("torque", result.arrays[f"{name}/torque"], clock, "black"),
                    Trace("predicted", result.arrays[f"{name}/predicted_torque"], clock, "vermilion", "5 3"),
                ),
                tuple(bands),
                note=f"mean VAF in the windows {_percent(np.nanmean(vaf))} %" if vaf.size else "",
            )
        )
    return panels


def _angle_panels(leg: Result, clock: Clock, bands: list[Band], neutral: bool) -> list[Panel]:
    for name in leg.facts["pathways"]:
        if f"{name}/simulated_angle" in leg.arrays:
            traces = (
                Trace("measured", leg.arrays[f"{name}/angle"], clock, "black"),
                Trace(
                    f"simulated, {words(name, neutral)}",
                    leg.arrays[f"{name}/simulated_angle"],
                    clock,
                    "vermilion",
                    "5 3",
                ),
            )
            return [Panel("Angle", "rad", traces, tuple(bands))]
    name = leg.facts["pathways"][0]
    angle = Trace("measured", leg.arrays[f"{name}/regressors"][:, 2], clock, "black")
    return [Panel("Angle from rest", "rad", (angle,), tuple(bands))]


def _load_panels(foot: Result | None, clock: Clock, bands: list[Band]) -> list[Panel]:
    """Loads of the plate before and after compensation, if the fit of the foot holds them."""
    if foot is None:
        return []
    panels = []
    for load, (title, unit) in LOADS.items():
        names = [key for key in foot.arrays if key.startswith(f"loads/{load}/")]
        traces = []
        for key, (colour, dash) in zip(
            sorted(names, key=lambda key: not key.endswith("/measured")),
            (("black", ""), ("blue", ""), ("vermilion", "5 3"), ("green", "2 2")),
            strict=False,
        ):
            name = key.rpartition("/")[2]
            label = "measured" if name == "measured" else f"compensated, treadmill model {name}"
            traces.append(Trace(label, foot.arrays[key], clock, colour, dash))
        panels.append(
            Panel(
                f"{title} before and after compensation",
                unit,
                tuple(traces),
                tuple(bands),
                note="low-pass filtered",
            )
        )
    return panels
