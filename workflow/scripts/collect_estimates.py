"""Join the estimates of all trials into one table, and their uncertainty budgets into another."""

import job

job.start(snakemake)

from tepsipe.io.budget_table import read_budgets, write_budgets
from tepsipe.io.estimates import read_estimates, write_estimates

rows = [row for path in snakemake.input.estimates for row in read_estimates(path)]
labels = {
    column: [cells[row.experiment][row.condition] for row in rows]
    for column, cells in snakemake.params.labels.items()
}
write_estimates(snakemake.output.table, rows, labels)
write_budgets(
    snakemake.output.uncertainty, (row for path in snakemake.input.budgets for row in read_budgets(path))
)
