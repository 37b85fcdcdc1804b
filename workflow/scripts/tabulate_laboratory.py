"""List the mechanisms, the drawn and the inferred constants of the virtual laboratory."""

import job

job.start(snakemake)

from tepsipe.reporting.laboratory import LABORATORY_ROWS, laboratory_rows

params = snakemake.params
LABORATORY_ROWS.write(snakemake.output.table, laboratory_rows(params.truth, params.experiments))
