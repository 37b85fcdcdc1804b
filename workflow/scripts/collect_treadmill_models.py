"""Gather the scores of all treadmill models."""

import job

job.start(snakemake)

from tepsipe.treadmill.calibration import read_scores, write_scores

tables = [read_scores(path) for path in snakemake.input.scores]
belts = [belt for belt, rows in zip(snakemake.params.belts, tables, strict=False) for _ in rows]
write_scores(snakemake.output.table, [row for rows in tables for row in rows], belts)
