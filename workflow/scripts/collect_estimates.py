"""Join the estimates of all trials into one table, and their uncertainty budgets into another."""

import job

job.start(snakemake)

from tepsipe.io.budget_table import CONTRIBUTIONS
from tepsipe.io.estimates import ESTIMATES

rows = ESTIMATES.read(*snakemake.input.estimates)
labels = {
    column: [cells[row.experiment][row.condition] for row in rows]
    for column, cells in snakemake.params.labels.items()
}
ESTIMATES.write(snakemake.output.table, rows, further=labels)
CONTRIBUTIONS.write(snakemake.output.uncertainty, CONTRIBUTIONS.read(*snakemake.input.budgets))
