"""Join estimates and uncertainty budgets of all walking trials."""

import job

job.start(snakemake)

from tepsipe.io.budget_table import CONTRIBUTIONS
from tepsipe.io.estimates import ESTIMATES

rows = ESTIMATES.read(*snakemake.input.estimates)
ESTIMATES.write(snakemake.output.table, rows)
budgets = CONTRIBUTIONS.read(*snakemake.input.budgets)
CONTRIBUTIONS.write(snakemake.output.uncertainty, budgets)
