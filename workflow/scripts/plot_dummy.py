"""Figures of TEP-SIPE on the ankle dummy."""

import job

job.start(snakemake)

from tepsipe.figures import dummy_figures as figures
from tepsipe.figures.matrix_figure import plot_matrix
from tepsipe.figures.names import short_name
from tepsipe.figures.style import save_figure
from tepsipe.result_file import read_result

names = list(snakemake.params.conditions)
results = {name: read_result(path) for name, path in zip(names, snakemake.input.fits, strict=True)}
matrices = read_result(snakemake.input.matrices).arrays
example, printed = snakemake.params.example, snakemake.params.as_printed
colours = dict.fromkeys(matrices, "other")
colours |= {printed: "as printed", snakemake.params.recommended: "recommended"}
shown = {name: colours[name] for name in dict.fromkeys([printed, snakemake.params.recommended])}
axes = ("Parameters from", "Data of")
drawn = {
    "figure_2_9": figures.plot_perturbations(results),
    "figure_3_3": figures.plot_window(results[example], example, printed),
    "figure_4_4": figures.plot_parameter_boxes(results, printed),
    "figure_pathways": figures.plot_pathways(results, colours),
    "figure_torque": figures.plot_torque(results[example], example, shown),
    "figure_dummy_cross_validation": plot_matrix(
        matrices[printed], [short_name(name) for name in names], "VAF (%)", axes
    ),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
