"""Figures of TEP-SIPE on the ankle dummy."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.specification_curve import SPECIFICATIONS
from tepsipe.identification.estimators import JOINT_LIKELIHOOD, OUTPUT_ERROR
from tepsipe.io.result import read_result
from tepsipe.reporting.figures import dummy as figures
from tepsipe.reporting.figures.matrix import plot_matrix
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.figures.specification_curve import plot_specification
from tepsipe.reporting.figures.style import save_figure

names = list(snakemake.params.conditions)
results = {name: read_result(path) for name, path in zip(names, snakemake.input.fits, strict=True)}
matrices = read_result(snakemake.input.matrices).arrays
example, printed = snakemake.params.example, snakemake.params.as_printed
estimators = results[example].facts["estimators"]
special = {OUTPUT_ERROR: "compensated", JOINT_LIKELIHOOD: "joint likelihood"}
colours = {name: special.get(estimators[name], "other") for name in matrices}
colours |= {printed: "as printed", snakemake.params.recommended: "recommended"}
shown = {name: colours[name] for name in dict.fromkeys([printed, snakemake.params.recommended])}
axes = ("Parameters from", "Data of")
drawn = {
    "figure_2_9": figures.plot_perturbations(results),
    "figure_3_3": figures.plot_window(results[example], example, printed),
    "figure_4_4": figures.plot_parameter_boxes(results, printed),
    "figure_pathways": figures.plot_pathways(results, colours),
    "figure_torque": figures.plot_torque(results[example], example, shown),
    "figure_specification": plot_specification(SPECIFICATIONS.read(snakemake.input.specification)),
    "figure_dummy_cross_validation": plot_matrix(
        matrices[printed], [short_name(name) for name in names], "VAF (%)", axes
    ),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
