"""Join all estimates, flagged by faults of their rig, into one table, answers and budgets into others."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.rig import RIG_FLAGS, flag_rig
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.reporting.answers import ANSWERS, answers

given, params, target = snakemake.input, snakemake.params, snakemake.output


def labels(rows):
    """Columns of what the trial sheet names of the rows: participant, belt."""
    named = params.labels.items()
    return {column: [cells[row.experiment][row.condition] for row in rows] for column, cells in named}


rows = flag_rig(ESTIMATES.read(*given.estimates), RIG_FLAGS.read(*given.rig))
ESTIMATES.write(target.table, rows, further=labels(rows))
found = answers(rows, params.asked)
ANSWERS.write(target.answers, found, further=labels(found))
CONTRIBUTIONS.write(target.uncertainty, CONTRIBUTIONS.read(*given.budgets))
