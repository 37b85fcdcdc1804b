"""Panels that several experiments share: belt, markers, forces, and stretches where markers were hidden."""

from collections.abc import Sequence

import numpy as np

from tepsipe.io.trial import Trial
from tepsipe.reporting.pages.trial_page import CYCLE, Band, Clock, Panel, Trace
from tepsipe.signals.resampling import runs_of

MOST_BANDS = 300


def belt_panel(trial: Trial, clock: Clock, bands: Sequence[Band]) -> Panel:
    """Measured and commanded velocity of the belt (m/s)."""
    traces = [Trace("measured", trial.values("belt_velocity"), clock, "black")]
    command = trial.optional("belt_command")
    if command is not None:
        traces.append(Trace("command", command, clock, "vermilion", "5 3"))
    return Panel("Belt velocity", "m/s", tuple(traces), tuple(bands))


def marker_panels(trial: Trial, clock: Clock) -> list[Panel]:
    """Positions of all markers along the belt and upwards, from their medians (mm)."""
    if "marker_position" not in trial.signals:
        return []
    positions, labels = trial.values("marker_position"), trial.axes["marker"].tolist()
    hidden = hidden_bands(trial)
    panels = []
    for axis, title in ((1, "Markers along the belt"), (2, "Markers, vertical")):
        shown = 1e3 * positions[:, :, axis].astype(float)
        shown -= np.nanmedian(shown, axis=0)
        traces = [
            Trace(label, shown[:, k], clock, *CYCLE[k % len(CYCLE)], 1.0) for k, label in enumerate(labels)
        ]
        panels.append(
            Panel(title, "mm", tuple(traces), tuple(hidden), note="relative to each marker's median")
        )
    return panels


def hidden_bands(trial: Trial) -> list[Band]:
    """Stretches (s) in which a marker was hidden and its position was filled."""
    hidden = trial.optional("marker_hidden")
    if hidden is None or not hidden.any():
        return []
    time, labels = trial.time, trial.axes["marker"]
    bands = []
    for start, stop in runs_of(np.asarray(hidden).astype(bool).any(axis=1))[:MOST_BANDS]:
        which = ", ".join(labels[np.asarray(hidden)[start:stop].any(axis=0)].tolist())
        bands.append(Band("hidden", float(time[start]), float(time[stop - 1]), f"hidden: {which}"))
    return bands


def hidden_sentences(trial: Trial) -> list[str]:
    """Sentence with the number of filled samples of every marker that was hidden, if any."""
    hidden = trial.optional("marker_hidden")
    if hidden is None or not np.asarray(hidden).any():
        return []
    counts = np.asarray(hidden).sum(axis=0)
    labels = trial.axes["marker"].tolist()
    each = ", ".join(f"{label} {count}" for label, count in zip(labels, counts, strict=True) if count)
    return [f"Samples filled in where a marker was hidden: {each}."]


def force_panels(trial: Trial, clock: Clock, belt: str, bands: Sequence[Band]) -> list[Panel]:
    """Unfiltered forces on the perturbed belt: fore-aft, vertical and sideways (N)."""
    if "force" not in trial.signals or belt not in trial.axes["belt"]:
        return []
    force = trial.values("force")[:, trial.axes["belt"].tolist().index(belt)]
    panels = []
    for axis, name, colour in ((1, "Fore-aft force", "blue"), (2, "Vertical force", "green")):
        trace = Trace("unfiltered", force[:, axis], clock, colour, width=1.0)
        panels.append(
            Panel(f"{name}, {belt} belt", "N", (trace,), tuple(bands), note="before the low-pass filter")
        )
    return panels


def window_bands(time: np.ndarray, windows: np.ndarray, notes: Sequence[str] = ()) -> list[Band]:
    """Fitted windows, shape (perturbations, 2) (samples), as bands (s) with their numbers."""
    last = time.size - 1
    bands = []
    for k, (start, stop) in enumerate(windows):
        note = f": {notes[k]}" if notes else ""
        ends = (float(time[min(int(i), last)]) for i in (start, stop))
        bands.append(Band("window", *ends, f"perturbation {k + 1}{note}"))
    return bands


def cut_bands(time: np.ndarray, start: int, stop: int) -> tuple[Band, ...]:
    """Both ends that are not used (s), from the samples that are."""
    ends = []
    if start > 0:
        ends.append(Band("cut", float(time[0]), float(time[start]), "not used"))
    if stop < time.size:
        ends.append(Band("cut", float(time[stop - 1]), float(time[-1]), "not used"))
    return tuple(ends)
