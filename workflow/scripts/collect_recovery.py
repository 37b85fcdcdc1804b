"""Join the comparisons with the truth in the order of the table of all estimates."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES, RECOVERIES
from tepsipe.reporting.recovery import in_order

rows, estimates = RECOVERIES.read(*snakemake.input.rows), ESTIMATES.read(snakemake.input.estimates)
RECOVERIES.write(snakemake.output.table, in_order(rows, estimates))
