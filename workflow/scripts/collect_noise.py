"""Collect the noise study, and arrange thesis Table 4-4."""

import job

job.start(snakemake)

from tepsipe.experiments.noise.rows import NOISE_ROWS
from tepsipe.reporting.noise_table import table_4_4
from tepsipe.reporting.thesis_tables import TABLE_COLUMNS, write_table

params = snakemake.params
rows = NOISE_ROWS.read(*snakemake.input.noise)
swept = [row for row in rows if row.stiffness_Nm_per_rad == params.swept_Nm_per_rad]
NOISE_ROWS.write(snakemake.output.noise, [row for row in swept if row.noise_on != "none"])
table = table_4_4(rows, params.reported, list(params.averaged), float(params.table_snr_db))
write_table(snakemake.output.table, table, list(TABLE_COLUMNS))
