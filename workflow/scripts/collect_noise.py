"""Collect the noise study, and arrange thesis Table 4-4."""

import job

job.start(snakemake)

from pathlib import Path

import yaml

from tepsipe.experiments.noise.rows import read_noise, write_noise
from tepsipe.reporting.noise_table import TABLE_COLUMNS, table_4_4
from tepsipe.reporting.thesis_tables import write_table

noise, reported = snakemake.params.noise, {}
if snakemake.input.reported:
    content = yaml.safe_load(Path(snakemake.input.reported).read_text(encoding="utf-8"))
    reported = content["tables"].get("table_4_4", {})
rows = [row for path in snakemake.input.noise for row in read_noise(path)]
swept = noise["joint"]["stiffness_Nm_per_rad"][0]
write_noise(
    snakemake.output.noise,
    [row for row in rows if row.stiffness_Nm_per_rad == swept and row.noise_on != "none"],
)
table = table_4_4(rows, reported, list(snakemake.params.averaged), float(noise["table_snr_db"]))
write_table(snakemake.output.table, table, list(TABLE_COLUMNS))
