"""Figures of the uncertainty budgets, source by source."""

import job

job.start(snakemake)

from tepsipe.io.budget_table import CONTRIBUTIONS
from tepsipe.io.estimates import ESTIMATES
from tepsipe.reporting.budgets import SHOWN, budgeted, relative_budgets
from tepsipe.reporting.figures.budget import plot_budgets
from tepsipe.reporting.figures.style import save_figure

contributions = CONTRIBUTIONS.read(snakemake.input.uncertainty)
own = budgeted(ESTIMATES.read(snakemake.input.estimates), snakemake.params.foot_pathway)
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
