"""Gather the scores of all treadmill models."""

import job

job.start(snakemake)

from tepsipe.treadmill.calibration import read_scores, write_scores

write_scores(snakemake.output.table, [row for path in snakemake.input.scores for row in read_scores(path)])
