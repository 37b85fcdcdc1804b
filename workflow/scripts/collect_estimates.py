"""Join all estimates, flagged by faults of their rig, into one table, and budgets into another."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.rig import RIG_FLAGS, flag_rig
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES

rows = flag_rig(ESTIMATES.read(*snakemake.input.estimates), RIG_FLAGS.read(*snakemake.input.rig))
labels = {
    column: [cells[row.experiment][row.condition] for row in rows]
    for column, cells in snakemake.params.labels.items()
}
ESTIMATES.write(snakemake.output.table, rows, further=labels)
CONTRIBUTIONS.write(snakemake.output.uncertainty, CONTRIBUTIONS.read(*snakemake.input.budgets))
