"""Figures of the standing person: those of the thesis for one trial, and those of all trials together."""

import job

job.start(snakemake)

from tepsipe.io.result import read_result
from tepsipe.reporting.figures import standing as figures
from tepsipe.reporting.figures.style import save_figure

params = snakemake.params
example = read_result(snakemake.input.example)
trials = dict(zip(params.conditions, map(read_result, snakemake.input.trials), strict=True))
tasks = dict(zip(params.tasks, map(read_result, snakemake.input.tasks), strict=True))
pathway = params.recommended["pathway"]
drawn = {
    "figure_4_13": figures.plot_processed(example),
    "figure_4_14": figures.plot_activity(example),
    "figure_standing_activity": figures.plot_ensembles(trials, params.groups, params.muscles),
    "figure_standing_latency": figures.plot_latencies(tasks, params.detector),
    "figure_standing_response": figures.plot_torque_parts(tasks, params.active),
    "figure_standing_stiffness": figures.plot_stiffness(
        trials, tasks, params.task_of, pathway, [params.recommended["estimator"], *params.active]
    ),
    "figure_standing_window": figures.plot_windows(
        tasks, params.window_s, pathway, params.recommended["estimator"]
    ),
    "figure_standing_joints": figures.plot_joints(tasks),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
