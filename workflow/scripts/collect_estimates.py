"""Join the estimates of all trials into one table."""

import job

job.start(snakemake)

from tepsipe.io.estimates import read_estimates, write_estimates

write_estimates(
    snakemake.output.table,
    [row for path in snakemake.input.estimates for row in read_estimates(path)],
)
