"""Figures of the thesis's idea, of the rigs, and of the time lines of the trials."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from tepsipe.io.result import read_result
from tepsipe.io.trial import Trial, read_trial
from tepsipe.reporting.figures import protocol
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.figures.style import Drawing

# beginning of a trial, before the first perturbation, over which markers are averaged (s)
REST_S = 2.0


def draw(files, chosen) -> Iterator[tuple[str, Figure | Drawing]]:
    """Figures of one trial of each rig, and of the perturbations of all of them."""
    markers: dict[str, list] = {"wristalyzer": []} if chosen.time_lines.get("wristalyzer") else {}
    for experiment, path in zip(chosen.trials, files.trials, strict=True):
        markers[experiment] = markers_at_rest(read_trial(path))
    rigs = {"markers": markers, "geometry": chosen.geometry, "person": chosen.person}
    onsets = _onsets(files, chosen)
    lines = {
        experiment: [
            protocol.TimeLine(short_name(c), duration, onsets.get((experiment, c)), amplitude)
            for c, duration, amplitude in trials
        ]
        for experiment, trials in chosen.time_lines.items()
    }
    chain = {
        "plate_rate_hz": chosen.rate_hz,
        "sampling_hz": chosen.sampling_hz,
        "cutoff_hz": chosen.cutoff_hz,
        "emg": bool(chosen.standing),
    }
    source = files.drawings[0]
    yield "figure_1_1", Drawing(source, {})
    yield "figure_1_3", Drawing(source, {"methods": chosen.methods})
    yield "figure_rigs", Drawing(source, rigs | {"mass_kg": chosen.mass_kg})
    yield "figure_protocol", protocol.draw_protocol(lines)
    yield "figure_signal_chain", Drawing(source, chain)
    yield "figure_free_bodies", Drawing(source, {})


def markers_at_rest(trial: Trial) -> list[tuple[int, float, float]]:
    """Number in the order of sampling, y from the ankle (or the mean), z (m) of each marker seen at rest."""
    positions = trial.values("marker_position")[: round(REST_S * trial.rate_hz), :, 1:]
    seen = np.flatnonzero(np.isfinite(positions).any(axis=0).all(axis=1)).tolist()
    points = dict(zip(seen, np.nanmean(positions[:, seen], axis=0).tolist(), strict=True))
    ankle = [points[k][0] for k in seen if trial.axes["marker"][k] == "ankle"]
    middle = np.mean(ankle or [y for y, _ in points.values()])
    return [(k + 1, float(y - middle), z) for k, (y, z) in points.items()]


def _onsets(files, chosen) -> dict[tuple[str, str], np.ndarray]:
    """(experiment, condition) -> onsets of the perturbations (s), of trials with fits or epochs."""
    onsets = {}
    for (experiment, condition), path in zip(chosen.fitted, files.fits, strict=True):
        arrays = read_result(path).arrays
        begins = arrays["windows"][:, 0] if experiment == "dummy" else arrays["onsets"]
        onsets[experiment, condition] = begins / chosen.rate_hz
    for condition, path in zip(chosen.standing, files.epochs, strict=True):
        onsets["standing", condition] = read_result(path).arrays["onsets_s"]
    return onsets
