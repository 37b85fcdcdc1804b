"""Figure of stiffness and damping in the manipulator against amplitude."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.experiments.wristalyzer.names import PERIODS
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.recovery_table import RECOVERIES
from tepsipe.io.result import read_result
from tepsipe.reporting.figures.style import save_figure
from tepsipe.reporting.figures.wristalyzer_amplitudes import plot_amplitudes

pooled = read_result(snakemake.input.pooled)
names = list(pooled.facts["conditions"])
rows = {
    (row.condition, row.quantity): row
    for row in ESTIMATES.read(*snakemake.input.estimates)
    if row.estimator == PERIODS
}
fitted = {
    quantity: np.array([[row.value, row.ci_low, row.ci_high] for row in (rows[c, quantity] for c in names)]).T
    for quantity in ("B", "K")
}
truth = None
if snakemake.input.recovery:
    true = {
        (row.condition, row.quantity): row.truth
        for row in RECOVERIES.read(snakemake.input.recovery[0])
        if row.experiment == "wristalyzer" and row.estimator == PERIODS
    }
    if all((c, "K") in true for c in names):
        truth = {quantity: np.array([true[c, quantity] for c in names]) for quantity in ("B", "K")}
shares = {
    name.removeprefix("shares/"): values
    for name, values in pooled.arrays.items()
    if name.startswith("shares/")
}
drawn = {
    "figure_wristalyzer_amplitudes": plot_amplitudes(pooled.arrays["rms_angle"], shares, fitted, truth),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
