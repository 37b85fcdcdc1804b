"""Join estimates and uncertainty budgets of all walking trials."""

import job

job.start(snakemake)

from tepsipe.io.budget_table import read_budgets, write_budgets
from tepsipe.io.estimates import read_estimates, write_estimates

rows = [row for path in snakemake.input.estimates for row in read_estimates(path)]
write_estimates(snakemake.output.table, rows)
budgets = [row for path in snakemake.input.budgets for row in read_budgets(path)]
write_budgets(snakemake.output.uncertainty, budgets)
