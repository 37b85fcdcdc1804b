"""Compare estimates with the virtual laboratory's truth."""

import job

job.start(snakemake)

from tepsipe.io.estimates import read_estimates
from tepsipe.reporting.recovery import compare_with_truth, write_recovery

rows = compare_with_truth(
    read_estimates(snakemake.input.estimates),
    snakemake.params.truth,
    snakemake.params.made,
    snakemake.params.tasks,
)
write_recovery(snakemake.output.table, rows)
