"""Figures of the noise study."""

import job

job.start(snakemake)

from tepsipe.experiments.noise.rows import NOISE_ROWS
from tepsipe.reporting.figures import noise as figures
from tepsipe.reporting.figures.style import save_figure

joint = snakemake.params.joint
rows = NOISE_ROWS.read(*snakemake.input.noise)
stiffness = joint["stiffness_Nm_per_rad"]
others = (joint["inertia_Nms2_per_rad"], joint["damping_Nms_per_rad"])
level, conditions = float(snakemake.params.table_snr_db), list(snakemake.params.conditions)
drawn = {
    "figure_4_12": figures.plot_estimates(rows, conditions, level, (*others, stiffness[-1])),
    "figure_noise": figures.plot_usable(rows, (*others, stiffness[0])),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
