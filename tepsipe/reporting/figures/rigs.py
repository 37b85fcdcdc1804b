"""Figures of the thesis's idea, of the rigs, and of the time lines of the trials."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.reporting.figures import flow_charts, protocol, schematics
from tepsipe.reporting.figures.names import short_name


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of one trial of each rig, and of the perturbations of all of them."""
    rigs = {"wristalyzer": None} if chosen.time_lines.get("wristalyzer") else {}
    for experiment, path in zip(chosen.trials, files.trials, strict=True):
        rigs[experiment] = schematics.rig_at_rest(read_trial(path))
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
    yield "figure_1_1", flow_charts.draw_identification()
    yield "figure_1_3", flow_charts.draw_methods(chosen.methods)
    yield "figure_rigs", schematics.draw_rigs(rigs, chosen.geometry, chosen.person, chosen.mass_kg)
    yield "figure_protocol", protocol.draw_protocol(lines)
    yield "figure_signal_chain", flow_charts.draw_signal_chain(chain)
    yield "figure_free_bodies", schematics.draw_free_bodies()


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
