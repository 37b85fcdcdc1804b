"""Join all estimates, flagged by faults of their rig, into one table, and budgets into another."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.rig import flag_rig
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import read_facts

facts = {
    condition: read_facts(path)
    for condition, path in zip(snakemake.params.conditions, snakemake.input.fits, strict=True)
}
rows = flag_rig(ESTIMATES.read(*snakemake.input.estimates), facts)
labels = {
    column: [cells[row.experiment][row.condition] for row in rows]
    for column, cells in snakemake.params.labels.items()
}
ESTIMATES.write(snakemake.output.table, rows, further=labels)
CONTRIBUTIONS.write(snakemake.output.uncertainty, CONTRIBUTIONS.read(*snakemake.input.budgets))
