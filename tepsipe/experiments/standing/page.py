"""Page of a trial of a standing person."""

from collections.abc import Sequence

import numpy as np

from tepsipe.drawing import header
from tepsipe.drawing.names import words
from tepsipe.drawing.trial_page import (
    CYCLE,
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
)
from tepsipe.io.estimates import ESTIMATES, Estimate
from tepsipe.io.result import Result, read_result
from tepsipe.io.trial import Trial, read_trial
from tepsipe.treadmill.frame_peak import FramePeak, resonance_sentence

MUSCLES = {
    "TA": "TA (tibialis anterior)",
    "SOL": "SOL (soleus)",
    "GAS": "GAS (gastrocnemius)",
    "RF": "RF (rectus femoris)",
    "BF": "BF (biceps femoris)",
}
# origin of the ankle's centre if quiet sway does not determine it
NOT_SEEN = "palpated, because quiet sway does not determine it; the intervals include its uncertainty"


def page(files, chosen) -> Page:
    """Page of a trial, of its file, fit, epochs and estimates."""
    choices = header.choices_of_trial(files, chosen) | {"instead": "the estimate from all trials of the task"}
    trial, estimates = read_trial(files.trial), ESTIMATES.read(*files.estimates)
    return standing_page(trial, read_result(files.fit), read_result(files.epochs), estimates, choices)


def standing_page(
    trial: Trial, fit: Result, epochs: Result, estimates: Sequence[Estimate], choices: dict
) -> Page:
    """Belt, angles, forces, torque and electromyograms over the trial, and means over the responses.

    choices: ``study``, ``condition``, ``task``, ``belt``, ``instead`` (what is recommended), ``made``.
    Returns: time in s, and time from the onset in s.
    """
    bands = epoch_bands(epochs)
    focus = [(b.start_s - 0.1, b.stop_s) for b in bands]
    clock = Clock.of(trial.time, focus)
    critical = fit.facts["critical_stiffness_Nm_per_rad"]
    made, used = fit.facts["perturbations"], fit.facts["responses"]
    facts = [
        *header.trial_facts(trial, "standing", choices),
        ("Task", choices["task"]),
        ("Perturbations", f"{made}, {'all' if made == used else used} used"),
        (
            "Critical stiffness m g h",
            f"{critical:.4g} N·m/rad, below which active control must prevent a fall",
        ),
    ]
    if "plate_sides" in trial.attributes:
        facts.append(("Left and right plate", trial.attributes["plate_sides"]))
    if "broadband" in epochs.facts:
        broadband = epochs.facts["broadband"]
        seen = broadband["centre_used"]
        facts.append(("Centre of the ankle", "estimated from quiet sway" if seen else NOT_SEEN))
        under, empty = (
            None if broadband[key] is None else FramePeak(*broadband[key]) for key in ("frame", "empty_frame")
        )
        facts.append(("Resonance of the frame", resonance_sentence([] if under is None else [under], empty)))
    reasons = [*([epochs.facts["fault"]] if epochs.facts.get("fault") else []), *fit.facts["left_out"]]
    of_trial = f"standing/{choices['condition']}: "
    reasons = [reason.removeprefix(of_trial) for reason in reasons]
    reasons = [f"{reason[:1].upper()}{reason[1:].rstrip('.')}." for reason in reasons]
    reasons = list(dict.fromkeys([*reasons, *hidden_sentences(trial)]))
    flags = header.flagged(estimates, choices)
    return Page(
        title=f"Standing person, {choices['condition']}",
        study=choices["study"],
        header=header.facts_list(facts)
        + header.estimates_table(estimates, choices)
        + (header.sentences_list("Flags", flags, "") if flags else "")
        + header.sentences_list("Left out or filled", reasons, "Nothing was left out."),
        sections=(
            Section("Belt and markers", (belt_panel(trial, clock, bands), *marker_panels(trial, clock))),
            Section("Angle and torque of the ankle", tuple(_processed_panels(epochs, clock, bands, choices))),
            Section("Force", tuple(force_panels(trial, clock, choices["belt"], bands))),
            Section(
                "Electromyograms",
                tuple(_emg_panels(trial, bands, focus)),
                "The electromyograms may be recorded for longer than the other signals.",
            ),
            Section(
                "Mean response after the onset",
                tuple(_response_panels(fit, epochs, choices)),
                "Relative to the baseline before the onset.",
            ),
        ),
        footer=header.sources_table(trial) + header.processing(trial),
        windows=tuple(bands),
        axes={"time": "Time (s)", "onset": "Time from the onset (s)"},
    )


def epoch_bands(epochs: Result) -> list[Band]:
    """Epochs that are used, and perturbations that are left out (s), with the reason if one is stored."""
    used, time = epochs.arrays["onsets_s"], epochs.arrays["time"]
    after = float(time[-1]) if time.size else 1.0
    every = epochs.arrays.get("processed/onsets_s", used)
    bands = []
    for number, onset in enumerate(np.asarray(every, dtype=float)):
        label = f"perturbation {number + 1}"
        if used.size and np.abs(used - onset).min() < 0.02:
            bands.append(Band("epoch", float(onset), float(onset) + after, label))
            continue
        why = [s for s in epochs.facts["left_out"] if f" {onset:.2f} s" in s]
        reason = why[0] if why else epochs.facts.get("fault") or "left out"
        bands.append(Band("left-out", float(onset), float(onset) + after, f"{label}: {reason}"))
    return bands


def _processed_panels(epochs: Result, clock: Clock, bands: list[Band], choices: dict) -> list[Panel]:
    arrays = {key.removeprefix("processed/"): x for key, x in epochs.arrays.items()}
    if "ankle" not in arrays:
        return []
    torques, neutral = epochs.facts["torques"], choices.get("neutral", False)
    angle = Trace("ankle", arrays["ankle"], clock)
    velocity = Trace("ankle", arrays["ankle_d"], clock)
    torque = (
        Trace(words(torques["recommended"], neutral), arrays["torque_recommended"], clock, "blue"),
        *(
            Trace(words(name, neutral), values, clock, colour, "5 3")
            for name, values, colour in zip(
                torques["as_printed"], arrays["torque_as_printed"], ("vermilion", "purple"), strict=False
            )
        ),
    )
    pressure = Trace("along the belt", 1e3 * arrays["y_cop"].astype(float), clock)
    return [
        Panel("Angle of the ankle", "rad", (angle,), tuple(bands)),
        Panel("Angular velocity of the ankle", "rad/s", (velocity,), tuple(bands)),
        Panel("Torque of both ankles", "N·m", torque, tuple(bands)),
        Panel("Centre of pressure", "mm", (pressure,), tuple(bands)),
    ]


def _emg_panels(trial: Trial, bands: list[Band], focus: list[tuple[float, float]]) -> list[Panel]:
    if "emg" not in trial.signals:
        return []
    signal = trial.signals["emg"]
    # reflexes and the beginning of the balance; more would not fit
    clock = Clock.of(trial.axes[signal.axes[0]], [(a, min(b, a + 0.7)) for a, b in focus])
    names = trial.axes[signal.axes[1]].tolist()
    return [
        Panel(
            f"Electromyogram {MUSCLES.get(name, name)}",
            "µV",
            (Trace("raw", signal.values[:, k], clock, CYCLE[k % 6][0], width=0.8),),
            tuple(bands),
        )
        for k, name in enumerate(names)
    ]


def _response_panels(fit: Result, epochs: Result, choices: dict) -> list[Panel]:
    """Responses of belt and ankle, torque with the models of every estimator, and activity of the muscles."""
    panels, arrays, time = [], epochs.arrays, epochs.arrays["time"]
    if not arrays["onsets_s"].size:
        return []
    clock = Clock.of(time)
    for key, title, unit, scale in (
        ("belt_velocity", "Belt velocity", "m/s", 1.0),
        ("ankle", "Rotation of the ankle", "mrad", 1e3),
        ("f_y", "Fore-aft force", "N", 1.0),
    ):
        values = scale * arrays[f"perturbed/{key}"].astype(float)
        panels.append(Panel(title, unit, _with_spread(values, clock), axis="onset"))
    segments = [key for key in ("shank", "thigh", "knee") if f"perturbed/{key}" in arrays]
    joints = [
        Trace(key, 1e3 * arrays[f"perturbed/{key}"].astype(float).mean(axis=0), clock, *CYCLE[k])
        for k, key in enumerate(segments)
    ]
    panels.append(Panel("Mean rotation of shank, thigh and knee", "mrad", tuple(joints), axis="onset"))
    names = [key.split("/")[1] for key in fit.arrays if key.startswith("curve/") and key.endswith("/torque")]
    for name in names:
        part = {key: fit.arrays[f"curve/{name}/{key}"] for key in ("time", "torque", "intrinsic", "active")}
        clock = Clock.of(part["time"])
        intrinsic, active = part["intrinsic"][0], part["active"][0]
        traces = [
            Trace("measured", part["torque"][0], clock, width=2.0),
            Trace("model", intrinsic + active, clock, "vermilion"),
        ]
        if np.any(active):
            traces.append(Trace("intrinsic part", intrinsic, clock, "blue", "6 3"))
            traces.append(Trace("active part", active, clock, "green", "2 2"))
        panels.append(
            Panel(f"Torque, {words(name, choices.get('neutral', False))}", "N·m", tuple(traces), axis="onset")
        )
    clock = Clock.of(time)
    for k, muscle in enumerate(fit.facts["muscles"]):
        values = arrays["envelope"][..., k].astype(float)
        panels.append(Panel(f"Envelope of {muscle}", "µV", _with_spread(values, clock), axis="onset"))
    return panels


def _with_spread(values: np.ndarray, clock: Clock) -> tuple[Trace, ...]:
    """Mean over the responses, shape (responses, n), with their minimum and maximum (any unit)."""
    return (
        Trace("mean", values.mean(axis=0), clock, width=2.0),
        Trace("minimum", values.min(axis=0), clock, "grey", "2 2"),
        Trace("maximum", values.max(axis=0), clock, "grey", "6 3"),
    )
