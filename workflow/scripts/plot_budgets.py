"""Figures of the uncertainty budgets, source by source."""

import job

job.start(snakemake)

from tepsipe.io.budget_table import read_budgets
from tepsipe.io.estimates import read_estimates
from tepsipe.reporting.budgets import SHOWN, budgeted, relative_budgets
from tepsipe.reporting.figures.budget import plot_budgets
from tepsipe.reporting.figures.style import save_figure

contributions = read_budgets(snakemake.input.uncertainty)
own = budgeted(read_estimates(snakemake.input.estimates), snakemake.params.foot_pathway)
budgets = {
    "figure_budget_wristalyzer": "wristalyzer",
    "figure_budget_dummy": "dummy",
    "figure_budget_foot": "foot",
    "figure_budget_standing": "standing",
    "figure_budget_weight": "weight",
}
for figure, name in budgets.items():
    if name in snakemake.params.names:
        drawn = plot_budgets(relative_budgets(contributions, own.get(name, []), SHOWN))
        save_figure(drawn, snakemake.output[figure], snakemake.output[f"{figure}_png"])
