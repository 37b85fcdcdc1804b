"""Gather the scores of all treadmill models."""

import job

job.start(snakemake)

from tepsipe.treadmill.calibration import MODEL_SCORES

tables = [MODEL_SCORES.read(path) for path in snakemake.input.scores]
rows = [row for table in tables for row in table]
belts = [belt for belt, table in zip(snakemake.params.belts, tables, strict=False) for _ in table]
MODEL_SCORES.write(snakemake.output.table, rows, further={"belt": belts} if belts else {})
