"""Schematics of the rigs, and time lines of the trials."""

import job

job.start(snakemake)

from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial
from tepsipe.reporting.figures import protocol, schematics
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.figures.style import save_figure

params = snakemake.params
rigs = {"wristalyzer": None} if params.time_lines.get("wristalyzer") else {}
for experiment, path in zip(params.trials, snakemake.input.trials, strict=True):
    rigs[experiment] = schematics.rig_at_rest(read_trial(path))
onsets = {}
for (experiment, condition), path in zip(params.fitted, snakemake.input.fits, strict=True):
    arrays = read_result(path).arrays
    begins = arrays["windows"][:, 0] if experiment == "dummy" else arrays["onsets"]
    onsets[experiment, condition] = begins / params.rate_hz
for condition, path in zip(params.standing, snakemake.input.epochs, strict=True):
    onsets["standing", condition] = read_result(path).arrays["onsets_s"]
lines = {
    experiment: [
        protocol.TimeLine(short_name(c), duration, onsets.get((experiment, c)), amplitude)
        for c, duration, amplitude in trials
    ]
    for experiment, trials in params.time_lines.items()
}
chain = {
    "plate_rate_hz": params.rate_hz,
    "sampling_hz": params.sampling_hz,
    "cutoff_hz": params.cutoff_hz,
    "emg": bool(params.standing),
}
drawn = {
    "figure_rigs": schematics.draw_rigs(rigs, params.geometry, params.person, params.mass_kg),
    "figure_protocol": protocol.draw_protocol(lines),
    "figure_signal_chain": schematics.draw_signal_chain(chain),
    "figure_free_bodies": schematics.draw_free_bodies(),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
